//! Controllers of somebody else's: programs in Python and C that meet a stack in shared memory, for tests.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

use node_runtime::Domain;
use rustix::process::{Pid, Signal, kill_process};

use crate::command::Said;

/// What the Python example calls itself on the wire.
pub(crate) const PYTHON_CONTROLLER: u32 = 1000;
/// What the C example calls itself on the wire.
pub(crate) const C_CONTROLLER: u32 = 1001;
/// What a C program with the static library needs of the system.
const SYSTEM_LIBRARIES: [&str; 3] = ["-lpthread", "-ldl", "-lm"];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The interpreter of a virtual environment that holds this repository's package; `None` where none can be made, which is said.
pub(crate) fn python() -> Option<&'static Path> {
    static PYTHON: OnceLock<Option<PathBuf>> = OnceLock::new();
    PYTHON.get_or_init(|| make_venv().map_err(|why| println!("skipped: {why}")).ok()).as_deref()
}

fn run(program: &Path, arguments: &[&str]) -> Result<(), String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output();
    let output = output.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    output.status.success().then_some(()).ok_or(format!("{arguments:?}: {said}"))
}

fn make_venv() -> Result<PathBuf, String> {
    // One for each test program: they may run at the same time.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(concat!(env!("CARGO_CRATE_NAME"), "_venv"));
    let python = folder.join("bin/python");
    if !python.exists() {
        run(Path::new("python3"), &["-m", "venv", &folder.to_string_lossy()])?;
    }
    run(&python, &["-m", "pip", "install", "--quiet", "iceoryx2>=0.10,<0.11", "hatchling"])?;
    let package = repository().join("bindings/python");
    let install =
        ["-m", "pip", "install", "--quiet", "--no-build-isolation", "--no-deps", "--force-reinstall"];
    // What it needs is there, so that from here on a failure is the package's own.
    run(&python, &[&install[..], &[&package.to_string_lossy()]].concat()).expect("the package installs");
    Ok(python)
}

/// The C example, compiled; `None` where there is no C compiler, which is said.
pub(crate) fn c_program() -> Option<&'static Path> {
    static PROGRAM: OnceLock<Option<PathBuf>> = OnceLock::new();
    PROGRAM.get_or_init(compile_c).as_deref()
}

fn compile_c() -> Option<PathBuf> {
    if let Err(why) = run(Path::new("cc"), &["--version"]) {
        println!("skipped: {why}");
        return None;
    }
    // This package's tests depend on `c_ports`, so that cargo has made the library; it lies beside the test program.
    let own = std::env::current_exe().expect("a test program lies somewhere");
    let library = own.with_file_name("libcncbf.a");
    let program =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(concat!(env!("CARGO_CRATE_NAME"), "_pure_pursuit_c"));
    let folder = repository().join("bindings/c");
    let (header, source) = (format!("-I{}", folder.display()), folder.join("examples/pure_pursuit.c"));
    let [source, library, program_name] = [&source, &library, &program].map(|path| path.to_string_lossy());
    let strict = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2"];
    let files = [header.as_str(), &source, &library, "-o", &program_name];
    run(Path::new("cc"), &[&strict[..], &files, &SYSTEM_LIBRARIES].concat()).expect("the C example compiles");
    Some(program)
}

/// A program that does not outlive its test.
pub(crate) struct Guest(Option<Child>);

impl Drop for Guest {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Guest {
    /// An example of the Python package, running in `domain`.
    pub(crate) fn python(python: &Path, domain: &Domain, name: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(python);
        command.arg(repository().join("bindings/python/examples").join(name));
        Self::start(command.args(arguments), domain)
    }

    /// The compiled C example, running in `domain`.
    pub(crate) fn c(program: &Path, domain: &Domain) -> Self {
        Self::start(&mut Command::new(program), domain)
    }

    /// Any other program, running in `domain`.
    pub(crate) fn start(command: &mut Command, domain: &Domain) -> Self {
        command.env(Domain::VARIABLE, domain.prefix()).stdin(Stdio::null());
        Self(Some(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a guest starts")))
    }

    /// Sends it a signal.
    pub(crate) fn signal(&self, signal: Signal) {
        let child = self.0.as_ref().expect("a guest ends once");
        kill_process(Pid::from_child(child), signal).expect("the guest still runs");
    }

    /// Waits for its end and returns what it said.
    pub(crate) fn ended(mut self) -> Said {
        let child = self.0.take().expect("a guest ends once");
        Said::of(child.wait_with_output().expect("the guest ends"))
    }

    /// Asks it to end; it must do so without complaint.
    pub(crate) fn end(self) {
        self.signal(Signal::TERM);
        let said = self.ended();
        assert!(said.code == 0 && !said.err.contains("Traceback"), "{said:?}");
    }
}
