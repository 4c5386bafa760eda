//! Four processes under a launcher, for tests that disturb them.

use std::path::Path;
use std::time::Duration;

use launcher::{Child, Event, Launcher, Plan, RestartPolicy, StopReport};
use messages::ProcessId;
use node_runtime::{Clock, Domain, RealClock};
use settings::Settings;

/// Longest wait for the launcher to notice a death.
const PATIENCE_NS: u64 = 20_000_000_000;
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(2);

/// A running stack.
pub(crate) struct LiveStack(Launcher);

/// When a process was killed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kill {
    /// Before the kernel was asked, ns.
    pub(crate) asked_ns: u64,
    /// When the call had returned, ns. The process did nothing more after that.
    pub(crate) done_ns: u64,
}

impl LiveStack {
    /// Starts the four processes of `settings` as stack `instance` of `domain`; `folder` takes the settings file and the
    /// logs.
    pub(crate) fn start(domain: &Domain, instance: &str, settings: &Settings, folder: &Path) -> Self {
        let file = folder.join("settings.toml");
        std::fs::write(&file, settings.to_toml().expect("settings as text")).expect("a writable file");
        let child = |(id, subcommand): (ProcessId, &str)| Child {
            id,
            program: env!("CARGO_BIN_EXE_cncbf").into(),
            args: vec![
                subcommand.into(),
                "--config".into(),
                file.clone().into(),
                "--instance".into(),
                instance.into(),
            ],
            env: Vec::new(),
            restart: RestartPolicy::default(),
        };
        let children = [
            (ProcessId::Filter, "filter"),
            (ProcessId::Estimator, "estimator"),
            (ProcessId::Nominal, "nominal"),
            (ProcessId::Bridge, "bridge"),
        ];
        let plan = Plan {
            domain: domain.clone(),
            children: children.into_iter().map(child).collect(),
            log_dir: Some(folder.to_owned()),
        };
        Self(Launcher::start(plan).expect("the stack starts"))
    }

    /// Kills a process as a crash would. It stays down until [`Self::restart`].
    pub(crate) fn kill(&self, victim: ProcessId) -> Kill {
        let asked_ns = RealClock.now_ns();
        assert!(self.0.kill(victim), "{victim} does not run");
        Kill { asked_ns, done_ns: RealClock.now_ns() }
    }

    /// Lets the launcher notice the death of `victim` and start it again. Nothing else may have happened to any process.
    /// Returns when it was started, ns.
    pub(crate) fn restart(&mut self, victim: ProcessId) -> u64 {
        let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
        let mut events = Vec::new();
        while !matches!(events.last(), Some(Event::Restarted { .. })) {
            assert!(RealClock.now_ns() < give_up_ns, "{victim} was not restarted: {events:?}");
            std::thread::sleep(LOOK);
            events.extend(self.0.poll());
        }
        assert!(events.iter().all(|event| event.id() == victim), "{victim} was killed, but {events:?}");
        RealClock.now_ns()
    }

    /// Asks every process to end and clears what is left in shared memory.
    pub(crate) fn stop(self, timeout: Duration) -> StopReport {
        self.0.stop(timeout)
    }
}
