//! A live stack: four processes and the recorder, started, watched and stopped.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use launcher::{Child, Event, Launcher, Plan, RestartPolicy, StopReport};
use messages::{ProcessId, Reason, SafeCommand, SafetyStatus, SourceStatus};
use node_runtime::{Clock, Domain, Node, RealClock, Shutdown, Subscriber, members};
use perception_bridge::Playback;
use settings::{ControllerKind, Settings};

use crate::cli::Source;
use crate::common::{remove_if_there, someone_watches};
use crate::progress::Bar;

/// How often the launcher looks at its children and at what they say.
const WATCH_PERIOD: Duration = Duration::from_millis(20);
/// How long children may take to end by themselves.
const STOP_TIMEOUT: Duration = Duration::from_secs(3);
/// Between two looks at children that start or stop.
const START_STOP_POLL: Duration = Duration::from_millis(2);
/// How long the recorder may take until it listens, ns. Other work on the machine may keep it waiting.
const RECORDER_PATIENCE_NS: u64 = 10_000_000_000;
/// How long the source may take until it is heard of, ns.
const SOURCE_PATIENCE_NS: u64 = 30_000_000_000;
/// How long a stack runs on after its goal is reached, so that the stop is in the record, ns.
const AFTERMATH_NS: u64 = 700_000_000;
/// Between two lines of progress where nobody watches a status line, ns.
const REPORT_PERIOD_NS: u64 = 5_000_000_000;

/// The processes whose words are recorded, in the order in which they are stopped.
pub(crate) const SPEAKERS: [ProcessId; 4] =
    [ProcessId::Filter, ProcessId::Nominal, ProcessId::Estimator, ProcessId::Bridge];

/// What a live stack is made of.
pub(crate) struct SessionPlan<'a> {
    /// Settings, as the children will read them.
    pub(crate) settings: &'a Settings,
    /// Name of the stack.
    pub(crate) instance: &'a str,
    /// Where the bridge takes the world from.
    pub(crate) source: &'a Source,
    /// Whether a recording's robot is replaced by a simulated one.
    pub(crate) closed_loop: bool,
    /// Whether the filter only watches.
    pub(crate) shadow: bool,
    /// How fast and how often a recording is played.
    pub(crate) playback: Playback,
    /// Variables added to the environment of every process.
    pub(crate) env: Vec<(OsString, OsString)>,
    /// What stands before each line of progress.
    pub(crate) heading: String,
    /// File to record into.
    pub(crate) recording: PathBuf,
    /// Folder for settings and logs.
    pub(crate) folder: &'a Path,
    /// Longest duration, s.
    pub(crate) duration_s: Option<f64>,
}

/// How a live stack ended.
pub(crate) struct SessionEnd {
    /// Unplanned exits of children while it ran.
    pub(crate) crashes: usize,
    /// Whether a person or a signal ended it.
    pub(crate) interrupted: bool,
}

/// What a watcher of a stack is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Moment {
    /// It runs.
    Running,
    /// It still runs, and will be stopped next.
    Ending,
}

/// Starts the stack, watches it to its end, stops it. The record has the first command of the filter and its last.
pub(crate) fn run_stack(
    plan: &SessionPlan<'_>,
    look: &mut dyn FnMut(&Launcher, Moment) -> anyhow::Result<()>,
) -> anyhow::Result<SessionEnd> {
    let shutdown = Shutdown::install()?;
    refuse_second_stack(plan.instance)?;
    let node = Node::open(plan.instance, ProcessId::Launcher)?;
    let mut watch = Watch {
        commands: node.subscriber::<SafeCommand>()?,
        status: node.subscriber::<SourceStatus>()?,
        command: None,
        source: None,
        heading: &plan.heading,
        bar: Bar::status(),
        give_up_ns: RealClock.now_ns() + SOURCE_PATIENCE_NS,
        began_ns: None,
        reported_ns: RealClock.now_ns(),
        ends_at_goal: plan.closed_loop || *plan.source == Source::Sim,
        reached_ns: None,
    };
    let mut launcher = start(plan)?;
    let mut crashes = 0;
    let interrupted = loop {
        std::thread::sleep(WATCH_PERIOD);
        for event in launcher.poll() {
            crashes += note(&event, plan.folder, watch.somebody_commands())?;
        }
        if shutdown.requested() {
            break true;
        }
        if watch.look(RealClock.now_ns(), plan.duration_s) {
            break false;
        }
        look(&launcher, Moment::Running)?;
    };
    look(&launcher, Moment::Ending)?;
    watch.bar.finish();
    // Our own node must be gone before the launcher looks for what is left over.
    drop(watch);
    drop(node);
    let stopped = stop(launcher);
    tracing::info!(?stopped, "stack stopped");
    Ok(SessionEnd { crashes, interrupted })
}

/// Refuses a stack whose name another one bears: each process would fail by itself, and the record would be the other's.
fn refuse_second_stack(instance: &str) -> anyhow::Result<()> {
    // Where they cannot be listed, opening a node tells why.
    let members = members(&Domain::from_env()?).unwrap_or_default();
    // The nominal controller is none of them: somebody else's may wait for a stack.
    let names = [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Filter]
        .map(|process| format!("{instance}/{process}"));
    if let Some(other) = members.iter().find(|member| member.alive && names.contains(&member.name)) {
        anyhow::bail!(
            "{} is already running (pid {}); end that stack, or name this one with --instance",
            other.name,
            other.pid
        );
    }
    Ok(())
}

/// Starts the recorder, and once it listens everything else, so that nobody speaks before.
fn start(plan: &SessionPlan<'_>) -> anyhow::Result<Launcher> {
    let Plan { domain, children, log_dir } = children(plan)?;
    let (recorder, others): (Vec<_>, Vec<_>) =
        children.into_iter().partition(|child| child.id == ProcessId::Recorder);
    // The recorder makes its file once it listens. Never a device, whose removal nobody would want.
    if plan.recording.is_file() {
        remove_if_there(&plan.recording)?;
    }
    let mut launcher = Launcher::start(Plan { domain, children: recorder, log_dir })?;
    let give_up_ns = RealClock.now_ns() + RECORDER_PATIENCE_NS;
    while !plan.recording.exists() {
        for event in launcher.poll() {
            note(&event, plan.folder, false)?;
        }
        anyhow::ensure!(
            RealClock.now_ns() < give_up_ns,
            "the recorder did not begin {}; its log tells why",
            plan.recording.display()
        );
        std::thread::sleep(START_STOP_POLL);
    }
    for child in others {
        launcher.add(child)?;
    }
    Ok(launcher)
}

/// Stops everything but the recorder, the filter first, so that its last command ends the record; then the recorder, which
/// has heard everything by then.
fn stop(mut launcher: Launcher) -> StopReport {
    for id in SPEAKERS {
        launcher.terminate(id);
    }
    let give_up_ns = RealClock.now_ns() + STOP_TIMEOUT.as_nanos() as u64;
    while SPEAKERS.iter().any(|id| launcher.pid(*id).is_some()) && RealClock.now_ns() < give_up_ns {
        std::thread::sleep(START_STOP_POLL);
        // Only to see who has ended. One that ends with an error now would be started again, and is stopped below.
        launcher.poll();
    }
    launcher.stop(STOP_TIMEOUT)
}

/// Counts a crash; ends the run where a process stays down, other than a nominal controller in whose place somebody else commands.
fn note(event: &Event, folder: &Path, somebody_commands: bool) -> anyhow::Result<usize> {
    match event {
        Event::Restarted { .. } => Ok(0),
        Event::Failed { .. } => Ok(1),
        // Its place is free for another one then, and the filter brakes for want of commands until that one speaks.
        Event::Finished { id: ProcessId::Nominal } => {
            tracing::warn!("the nominal controller was stopped; its place is free for another one");
            Ok(0)
        }
        Event::Finished { .. } => anyhow::bail!("{event} although nobody asked it to; start the stack again"),
        Event::GaveUp { id: ProcessId::Nominal, .. }
        | Event::RestartFailed { id: ProcessId::Nominal, .. }
            if somebody_commands =>
        {
            tracing::warn!("{event}; somebody else commands");
            Ok(0)
        }
        Event::GaveUp { .. } | Event::RestartFailed { .. } => {
            anyhow::bail!("{event}{}", last_words(folder, event.id()))
        }
    }
}

/// Where the log of a process lies, and its last line; empty if it wrote none.
fn last_words(folder: &Path, id: ProcessId) -> String {
    let log = folder.join(format!("{id}.log"));
    let text = std::fs::read(&log).unwrap_or_default();
    let text = String::from_utf8_lossy(&text);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    last.map_or_else(String::new, |last| format!(": {last} ({})", log.display()))
}

/// Writes the settings the children read and says how each of them is started.
fn children(plan: &SessionPlan<'_>) -> anyhow::Result<Plan> {
    let program = std::env::current_exe().context("cannot find this program's own file")?;
    let settings_file = plan.folder.join("settings.toml");
    std::fs::write(&settings_file, plan.settings.to_toml()?)
        .with_context(|| format!("cannot write {}", settings_file.display()))?;
    let common =
        ["--config".into(), settings_file.into_os_string(), "--instance".into(), plan.instance.into()];
    let child = |id: ProcessId, subcommand: &str, extra: Vec<std::ffi::OsString>| Child {
        id,
        program: program.clone(),
        args: [vec![subcommand.into()], extra, common.to_vec()].concat(),
        env: plan.env.clone(),
        // A recorder that began anew would overwrite what it had recorded.
        restart: if id == ProcessId::Recorder { RestartPolicy::Never } else { RestartPolicy::default() },
    };
    let mut bridge = vec!["--source".into(), plan.source.to_string().into()];
    if plan.closed_loop {
        bridge.push("--closed-loop".into());
    }
    let mut recorder = vec![plan.recording.clone().into_os_string()];
    if plan.shadow {
        bridge.push("--shadow".into());
        recorder.push("--shadow".into());
    }
    bridge.extend(["--rate".into(), plan.playback.rate().to_string().into()]);
    bridge.extend(["--passes".into(), plan.playback.passes().to_string().into()]);
    let mut children = vec![
        child(ProcessId::Recorder, "record", recorder),
        child(ProcessId::Filter, "filter", Vec::new()),
        child(ProcessId::Estimator, "estimator", Vec::new()),
        child(ProcessId::Nominal, "nominal", Vec::new()),
        child(ProcessId::Bridge, "bridge", bridge),
    ];
    if plan.settings.nominal.controller == ControllerKind::External {
        children.retain(|child| child.id != ProcessId::Nominal);
    }
    Ok(Plan { domain: Domain::from_env()?, children, log_dir: Some(plan.folder.to_owned()) })
}

/// What the launcher sees of its stack.
struct Watch<'a> {
    heading: &'a str,
    commands: Subscriber<SafeCommand>,
    status: Subscriber<SourceStatus>,
    command: Option<SafeCommand>,
    source: Option<SourceStatus>,
    bar: Bar,
    /// A source that was not heard of until then counts as playing.
    give_up_ns: u64,
    /// When the source was first heard of: a duration does not count the time that processes take to start.
    began_ns: Option<u64>,
    reported_ns: u64,
    /// Whether reaching the goal ends the stack: not where a recorded robot drives on.
    ends_at_goal: bool,
    reached_ns: Option<u64>,
}

impl Watch<'_> {
    /// Whether the filter heard a nominal controller just now.
    fn somebody_commands(&self) -> bool {
        let unheard = [Reason::NoNominalCommand.code(), Reason::StaleNominalCommand.code()];
        self.command.is_some_and(|command| !unheard.contains(&command.reason))
    }

    /// Takes news and shows them. Returns whether the stack has nothing left to do.
    fn look(&mut self, now_ns: u64, duration_s: Option<f64>) -> bool {
        self.command = self.commands.newest().or(self.command);
        self.source = self.status.newest().or(self.source);
        if let Some(source) = &self.source {
            self.began_ns.get_or_insert(now_ns);
            self.bar.set(source.elapsed_ns, || line(self.heading, source, duration_s, self.command.as_ref()));
            if !someone_watches() && now_ns - self.reported_ns >= REPORT_PERIOD_NS {
                self.reported_ns = now_ns;
                eprintln!("{}", line(self.heading, source, duration_s, self.command.as_ref()));
            }
            if source.goal_reached != 0 && self.ends_at_goal {
                self.reached_ns.get_or_insert(now_ns);
            }
            if source.finished != 0 {
                return true;
            }
        }
        let elapsed_s = now_ns.saturating_sub(self.began_ns.unwrap_or(self.give_up_ns)) as f64 * 1e-9;
        duration_s.is_some_and(|limit_s| elapsed_s >= limit_s)
            || self.reached_ns.is_some_and(|reached_ns| now_ns - reached_ns >= AFTERMATH_NS)
    }
}

/// One line that tells how it goes; `duration_s` is the user's limit.
fn line(
    heading: &str,
    source: &SourceStatus,
    duration_s: Option<f64>,
    command: Option<&SafeCommand>,
) -> String {
    let seconds = source.elapsed_ns as f64 * 1e-9;
    let filter = command.map_or_else(
        || "no command yet".to_owned(),
        |command| {
            let status = SafetyStatus::try_from(command.status).map_or("?", SafetyStatus::label);
            let reason = Reason::try_from(command.reason).map_or("?", Reason::label);
            format!(
                "h {:.2} m, u [{:.2}, {:+.2}], {status} ({reason})",
                command.h_m, command.control[0], command.control[1]
            )
        },
    );
    // A live graph has no end of its own and does not know the truth.
    let limit_s = Some(source.total_ns as f64 * 1e-9)
        .filter(|total_s| *total_s > 0.0)
        .into_iter()
        .chain(duration_s)
        .reduce(f64::min);
    let of_at_most = limit_s.map_or_else(String::new, |limit_s| format!(" of at most {limit_s:.0}"));
    let clearance = if source.clearance_m.is_finite() {
        format!(", clearance {:.2} m", source.clearance_m)
    } else {
        String::new()
    };
    format!("{heading}{seconds:.1}{of_at_most} s, goal {:.1} m{clearance}, {filter}", source.goal_distance_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_that_stays_down_is_quoted() {
        let folder = tempfile::tempdir().expect("a folder");
        assert_eq!(last_words(folder.path(), ProcessId::Bridge), "", "it wrote nothing");
        let log = folder.path().join("bridge.log");
        std::fs::write(&log, "a line\nerror: ROS_DOMAIN_ID\n\n").expect("written");
        let words = last_words(folder.path(), ProcessId::Bridge);
        assert_eq!(words, format!(": error: ROS_DOMAIN_ID ({})", log.display()));
    }
}
