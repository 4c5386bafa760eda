//! The children as operating-system processes.

use std::{
    fs::{File, OpenOptions},
    marker::PhantomData,
    os::unix::process::CommandExt,
    path::PathBuf,
    process::{Child as OsChild, Command, ExitStatus, Stdio},
    time::Duration,
};

use messages::ProcessId;
use node_runtime::{Clock, Domain, Leftover, PARENT_PID_VARIABLE, RealClock, clean_up};
use rustix::process::{Pid, Signal, kill_process};

use crate::{Child, Event, LaunchError, Plan, Supervisor, Verdict};

/// Pause between two looks at children that are stopping.
const STOP_POLL: Duration = Duration::from_millis(5);
/// Patience when a launcher is dropped without having been stopped.
const DROP_PATIENCE: Duration = Duration::from_secs(1);

/// What [`Launcher::stop`] had to do.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct StopReport {
    /// Children that did not end by themselves and were killed.
    pub killed: Vec<ProcessId>,
    /// Files in shared memory that were left behind and are gone.
    pub removed: Vec<Leftover>,
}

/// A running stack. Dropping it stops it.
///
/// It stays on the thread that made it, because the kernel tells children of the death of that thread.
#[derive(Debug)]
pub struct Launcher {
    domain: Domain,
    log_dir: Option<PathBuf>,
    children: Vec<Supervised>,
    stopped: bool,
    not_send: PhantomData<*const ()>,
}

/// A child with what is known of it.
#[derive(Debug)]
struct Supervised {
    plan: Child,
    log: Option<File>,
    supervisor: Supervisor,
    state: State,
}

#[derive(Debug)]
enum State {
    Running(OsChild),
    Waiting { restart_ns: u64 },
    Down,
}

impl Launcher {
    /// Starts every child of the plan, in order.
    ///
    /// Children get a process group of their own, so that Ctrl-C at the terminal reaches the launcher alone, which then
    /// stops them in order; standard input is empty.
    ///
    /// # Errors
    /// [`LaunchError`]; children that were started before are stopped again.
    pub fn start(plan: Plan) -> Result<Self, LaunchError> {
        if let Some(folder) = &plan.log_dir {
            std::fs::create_dir_all(folder)
                .map_err(|source| LaunchError::Log { path: folder.clone(), source })?;
        }
        let mut launcher = Self {
            domain: plan.domain,
            log_dir: plan.log_dir,
            children: Vec::new(),
            stopped: false,
            not_send: PhantomData,
        };
        for child in plan.children {
            launcher.add(child)?;
        }
        Ok(launcher)
    }

    /// Starts one more child, after those that run: one that needs them, or must not miss or delay what they do.
    ///
    /// # Errors
    /// [`LaunchError`]; the other children run on.
    pub fn add(&mut self, child: Child) -> Result<(), LaunchError> {
        if self.children.iter().any(|other| other.plan.id == child.id) {
            return Err(LaunchError::Twice { id: child.id });
        }
        let log = match &self.log_dir {
            None => None,
            Some(folder) => {
                let path = folder.join(format!("{}.log", child.id));
                let opened = OpenOptions::new().create(true).append(true).open(&path);
                Some(opened.map_err(|source| LaunchError::Log { path, source })?)
            }
        };
        let process = spawn(&child, log.as_ref(), &self.domain).map_err(|source| LaunchError::Spawn {
            id: child.id,
            program: child.program.clone(),
            source,
        })?;
        tracing::info!(id = %child.id, pid = process.id(), "started");
        let supervisor = Supervisor::new(child.restart);
        self.children.push(Supervised { plan: child, log, supervisor, state: State::Running(process) });
        Ok(())
    }

    /// Looks at every child, starts those again whose time has come, and tells what changed. Never blocks.
    ///
    /// Call it every 20 ms or so: that is how long a dead child goes unnoticed.
    pub fn poll(&mut self) -> Vec<Event> {
        let now_ns = RealClock.now_ns();
        let mut events = Vec::new();
        for child in &mut self.children {
            child.reap(now_ns, &mut events);
            child.restart_if_due(now_ns, &self.domain, &mut events);
        }
        for event in &events {
            match event {
                Event::Finished { .. } | Event::Restarted { .. } => tracing::info!("{event}"),
                Event::Failed { .. } => tracing::warn!("{event}"),
                Event::GaveUp { .. } | Event::RestartFailed { .. } => tracing::error!("{event}"),
            }
        }
        events
    }

    /// Process id of a child, while it runs.
    pub fn pid(&self, id: ProcessId) -> Option<u32> {
        self.children.iter().find(|child| child.plan.id == id).and_then(Supervised::pid)
    }

    /// Whether any child runs or is about to be started again.
    pub fn any_running(&self) -> bool {
        self.children.iter().any(|child| !matches!(child.state, State::Down))
    }

    /// Kills a child with SIGKILL, as a crash would; [`Self::poll`] then sees it. False if it does not run.
    pub fn kill(&self, id: ProcessId) -> bool {
        self.signal(id, Signal::KILL)
    }

    /// Asks a child to stop with SIGTERM; one that then ends with exit code 0 is not started again. False if it does not
    /// run.
    pub fn terminate(&self, id: ProcessId) -> bool {
        self.signal(id, Signal::TERM)
    }

    fn signal(&self, id: ProcessId, signal: Signal) -> bool {
        self.children.iter().find(|child| child.plan.id == id).is_some_and(|child| child.signal(signal))
    }

    /// Stops every child: SIGTERM to all, SIGKILL to those that still run after `timeout`. Then removes what is left of
    /// the stack in shared memory, unless somebody else still lives in the domain.
    pub fn stop(mut self, timeout: Duration) -> StopReport {
        self.stop_in_place(timeout)
    }

    fn stop_in_place(&mut self, timeout: Duration) -> StopReport {
        self.stopped = true;
        let mut report = StopReport::default();
        for child in &mut self.children {
            match child.state {
                State::Running(_) => {
                    child.signal(Signal::TERM);
                }
                State::Waiting { .. } | State::Down => child.state = State::Down,
            }
        }
        let give_up_ns = RealClock.now_ns().saturating_add(timeout.as_nanos() as u64);
        while self.children.iter_mut().any(|child| child.exit_status().is_none()) {
            if RealClock.now_ns() >= give_up_ns {
                for child in &mut self.children {
                    if child.kill_and_wait() {
                        report.killed.push(child.plan.id);
                    }
                }
                break;
            }
            std::thread::sleep(STOP_POLL);
        }
        match clean_up(&self.domain) {
            Ok(removed) => report.removed = removed,
            Err(error) => tracing::warn!(%error, "shared memory could not be cleared"),
        }
        if !report.killed.is_empty() {
            tracing::warn!(killed = ?report.killed, ?timeout, "some processes did not stop by themselves");
        }
        report
    }
}

impl Drop for Launcher {
    fn drop(&mut self) {
        if !self.stopped {
            self.stop_in_place(DROP_PATIENCE);
        }
    }
}

impl Supervised {
    fn pid(&self) -> Option<u32> {
        match &self.state {
            State::Running(process) => Some(process.id()),
            State::Waiting { .. } | State::Down => None,
        }
    }

    fn signal(&self, signal: Signal) -> bool {
        match &self.state {
            // Not reaped yet, hence the process id is still this child's.
            State::Running(process) => kill_process(Pid::from_child(process), signal).is_ok(),
            State::Waiting { .. } | State::Down => false,
        }
    }

    /// How it ended, or `None` while it runs. A child that cannot be watched any more counts as ended.
    fn exit_status(&mut self) -> Option<ExitStatus> {
        let State::Running(process) = &mut self.state else {
            return Some(ExitStatus::default());
        };
        match process.try_wait() {
            Ok(status) => status,
            Err(error) => {
                tracing::error!(id = %self.plan.id, %error, "lost sight of a child");
                Some(ExitStatus::default())
            }
        }
    }

    fn reap(&mut self, now_ns: u64, events: &mut Vec<Event>) {
        if !matches!(self.state, State::Running(_)) {
            return;
        }
        let Some(status) = self.exit_status() else { return };
        let id = self.plan.id;
        match self.supervisor.on_exit(now_ns, status.success()) {
            Verdict::Finished => {
                self.state = State::Down;
                events.push(Event::Finished { id });
            }
            Verdict::RestartAt(restart_ns) => {
                self.state = State::Waiting { restart_ns };
                let restart_in = Duration::from_nanos(restart_ns.saturating_sub(now_ns));
                events.push(Event::Failed { id, status, restart_in });
            }
            Verdict::GiveUp => {
                self.state = State::Down;
                events.push(Event::GaveUp { id, status });
            }
        }
    }

    fn restart_if_due(&mut self, now_ns: u64, domain: &Domain, events: &mut Vec<Event>) {
        let id = self.plan.id;
        match self.state {
            State::Waiting { restart_ns } if restart_ns <= now_ns => {
                match spawn(&self.plan, self.log.as_ref(), domain) {
                    Ok(process) => {
                        events.push(Event::Restarted { id, pid: process.id() });
                        self.state = State::Running(process);
                    }
                    Err(error) => {
                        events.push(Event::RestartFailed { id, error: error.to_string() });
                        self.state = State::Down;
                    }
                }
            }
            State::Waiting { .. } | State::Running(_) | State::Down => {}
        }
    }

    /// Kills it if it still runs, and says whether it did.
    fn kill_and_wait(&mut self) -> bool {
        let runs = self.exit_status().is_none();
        if let State::Running(process) = &mut self.state
            && runs
        {
            // Both fail only for a process that is gone.
            let _ = process.kill();
            let _ = process.wait();
        }
        self.state = State::Down;
        runs
    }
}

fn spawn(child: &Child, log: Option<&File>, domain: &Domain) -> std::io::Result<OsChild> {
    let mut command = Command::new(&child.program);
    command
        .args(&child.args)
        .env(Domain::VARIABLE, domain.prefix())
        .env(PARENT_PID_VARIABLE, std::process::id().to_string())
        .envs(child.env.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .process_group(0);
    if let Some(log) = log {
        command.stdout(log.try_clone()?).stderr(log.try_clone()?);
    }
    command.spawn()
}
