//! iceoryx2's own tool looks at a running stack and finds names and types that make sense to a person.
//!
//! Needs the crate iceoryx2-cli of the version in Cargo.lock: `iox2` on the path, or its file in `CNCBF_IOX2`. Where there is none,
//! the test says so and ends.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "stack/command.rs"]
mod command;
#[path = "stack/witness.rs"]
mod witness;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use command::{Said, at, cncbf, count, scratch};
use messages::{Message, NominalCommand, RobotState, SafeCommand};
use node_runtime::{ScopedDomain, members};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use witness::Witness;

/// How long the stack drives before the tool looks, ns.
const DRIVE_NS: u64 = 1_000_000_000;

/// The tool, working in a folder whose configuration names the domain of a stack.
struct Tool {
    program: PathBuf,
    folder: PathBuf,
}

impl Tool {
    fn find(folder: &Path) -> Option<Self> {
        let program = std::env::var_os("CNCBF_IOX2").map_or_else(|| "iox2".into(), PathBuf::from);
        let tool = Self { program, folder: folder.to_owned() };
        let version = tool.command(&["--version"]).output().ok().filter(|output| output.status.success());
        let version = version.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
        if version.as_ref().is_some_and(|version| version.contains(" 0.10.")) {
            return Some(tool);
        }
        println!(
            "skipped: no `iox2` 0.10 here, but {version:?} (cargo install iceoryx2-cli --version ^0.10)"
        );
        None
    }

    /// The tool finds its subcommands on the path.
    fn command(&self, arguments: &[&str]) -> Command {
        let own = self.program.parent().map(|folder| folder.as_os_str().to_owned()).unwrap_or_default();
        let rest = std::env::var_os("PATH").unwrap_or_default();
        let path = [own, rest].join(&OsString::from(":"));
        let mut command = Command::new(&self.program);
        command.args(arguments).current_dir(&self.folder).env("PATH", path).stdin(Stdio::null());
        command
    }

    /// What it says.
    fn says(&self, arguments: &[&str]) -> Said {
        let said = Said::by(self.command(arguments), &[]);
        assert_eq!(said.code, 0, "{arguments:?}: {said:?}");
        said
    }

    /// What it says as JSON.
    fn tells(&self, arguments: &[&str]) -> Value {
        self.says(&[arguments, &["--format", "JSON"]].concat()).json()
    }
}

/// Asserts that `service` is described as that of `T`.
fn assert_described<T: Message>(tool: &Tool) {
    let name = format!("cncbf/{}", T::SERVICE);
    let details = tool.tells(&["service", "details", &name]);
    let payload = at(&details, "/pattern/PublishSubscribe/message_type_details/payload");
    assert_eq!(at(&details, "/service_name"), name.as_str());
    assert_eq!(at(payload, "/type_name"), T::TYPE_NAME);
    assert_eq!(count(payload, "/size"), size_of::<T>() as u64);
}

#[test]
fn the_tool_of_iceoryx2_shows_a_running_stack() {
    let folder = scratch("iox2_tool");
    let Some(tool) = Tool::find(&folder) else { return };
    let domain = ScopedDomain::new();
    std::fs::create_dir_all(folder.join("config")).unwrap();
    let configuration = format!("[global]\nprefix = '{}'\n", domain.prefix());
    std::fs::write(folder.join("config/iceoryx2.toml"), configuration).unwrap();
    let mut witness = Witness::join(&domain, "cncbf");
    let mut run = cncbf(&domain, &folder)
        .args(["run", "--people", "2", "--report", "report"])
        .spawn()
        .expect("the command starts");
    let since_ns = witness.watch_until_it_drives(0);
    witness.watch_until_a_cycle_after(since_ns + DRIVE_NS);
    drop(witness);

    let nodes = tool.says(&["node", "list"]).out;
    for process in ["bridge", "estimator", "nominal", "filter", "recorder", "launcher"] {
        assert!(nodes.contains(&format!("\"cncbf/{process}\"")), "no {process} in {nodes}");
    }
    let services = tool.says(&["service", "list"]).out;
    for member in members(&domain).expect("a readable domain") {
        assert!(member.name.starts_with("cncbf/"), "{member:?}");
    }
    for service in ["robot_state", "goal", "detections", "obstacles", "nominal_command", "safe_command"] {
        assert!(services.contains(&format!("PublishSubscribe(\"cncbf/{service}\")")), "{services}");
    }
    assert!(services.contains("Event(\"cncbf/wake/filter\")"), "{services}");
    assert_described::<RobotState>(&tool);
    assert_described::<NominalCommand>(&tool);
    assert_described::<SafeCommand>(&tool);
    let hz = tool.says(&["service", "hz", "--timeout", "2", "cncbf/safe_command"]).out;
    println!("{hz}");
    assert!(hz.contains("rate_hz"), "{hz}");

    kill_process(Pid::from_child(&run), Signal::INT).expect("a running stack");
    run.wait().unwrap();
}
