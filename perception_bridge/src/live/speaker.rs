//! The thread that tells a ROS 2 graph how the stack is: the filter's state, `/diagnostics`, and scenes for the painter.
//!
//! It hears the stack as a recorder does, through ports of its own, so that the bridge's loop has no part in it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use messages::{Health, Obstacles, ProcessId, SafeCommand};
use node_runtime::{Node, NodeError, Subscriber};
use recording::ros2::{DiagnosticArray, DiagnosticStatus, FilterState, Float64, Header};
use settings::{ControllerKind, Ros2Settings, Settings};

use super::arrival::Arrival;
use super::board::SinkBoard;
use super::diagnostics::{Diagnostics, Facts, REPORT_SILENCE_NS};
use super::error::RosError;
use super::filter_state::filter_state;
use super::graph::Graph;
use super::hand_over::Counters;
use super::outlet::Outlet;
use super::painter::{Painter, Scene, ZeroLevelOf};
use super::timebase::RosTime;
use super::watch::Watch;

/// Between two looks at the stack: the highest rate of the filter's state.
const PERIOD: Duration = Duration::from_millis(20);
/// Between two looks at the graph, ns.
const WATCH_PERIOD_NS: u64 = 250_000_000;
/// Between two looks at what `/diagnostics` should say, ns.
const DIAGNOSE_PERIOD_NS: u64 = 100_000_000;
/// Longest time between two messages on `/diagnostics`, ns; what has changed is said at once.
const REPEAT_PERIOD_NS: u64 = 1_000_000_000;
/// Between two pictures, ns.
const PAINT_PERIOD_NS: u64 = 200_000_000;
/// Where every ROS 2 robot has it, whatever the namespace.
const DIAGNOSTICS_TOPIC: &str = "/diagnostics";

/// The running thread; ends when dropped.
pub(super) struct Speaker {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// What the rest of the source shares with the speaker.
pub(super) struct Shared {
    /// What the command sink does; `None` where the robot is left alone.
    pub(super) sink: Option<Arc<SinkBoard>>,
    /// What was lost on the way.
    pub(super) counters: Arc<Counters>,
    /// What messages are stamped with.
    pub(super) time: RosTime,
}

impl Speaker {
    /// Opens the topics and starts the thread for stack `instance`. Every other topic of the node must be open by now.
    pub(super) fn start(
        graph: &mut Graph,
        settings: &Settings,
        instance: &str,
        shared: Shared,
        zero_level: Option<ZeroLevelOf>,
    ) -> Result<Self, RosError> {
        let ros2 = settings.source.ros2.clone().unwrap_or_else(Ros2Settings::customary);
        let node = ros2.absolute(&ros2.node_name);
        let own = |name: &str| format!("{node}/{name}");
        let [state, h, sdf, markers] = ["filter_state", "h", "sdf", "markers"].map(own);
        let outlets = Outlets {
            diagnostics: graph.publish(DIAGNOSTICS_TOPIC)?,
            state: graph.publish(&state)?,
            h: graph.publish(&h)?,
            sdf: graph.publish(&sdf)?,
        };
        let frame = settings.source.odom_frame.clone();
        let painter = if ros2.markers.unwrap_or(true) {
            Some(Painter::start(graph.publish(&markers)?, zero_level)?)
        } else {
            None
        };
        let mut expected = vec![ProcessId::Bridge, ProcessId::Estimator, ProcessId::Filter];
        if settings.nominal.controller != ControllerKind::External {
            expected.push(ProcessId::Nominal);
        }
        let telling = Telling {
            outlets,
            painter,
            frame,
            instance: instance.to_owned(),
            expected,
            command_topic: ros2.absolute(&ros2.command_topic),
            diagnostics: Diagnostics::new(&node, instance),
            watch: Watch::new(graph.participant(), graph.records(), ros2.absolute(&ros2.command_topic)),
            shared,
        };
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, span) = (Arc::clone(&stop), tracing::Span::current());
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-say".to_owned())
            .spawn(move || span.in_scope(|| telling.run(&stopped)))
            .map_err(|error| RosError::Thread { cause: error.to_string() })?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Speaker {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Where it speaks.
struct Outlets {
    diagnostics: Outlet<DiagnosticArray>,
    state: Outlet<FilterState>,
    h: Outlet<Float64>,
    sdf: Outlet<Float64>,
}

/// What the thread owns.
struct Telling {
    outlets: Outlets,
    painter: Option<Painter>,
    frame: String,
    instance: String,
    expected: Vec<ProcessId>,
    command_topic: String,
    diagnostics: Diagnostics,
    watch: Watch,
    shared: Shared,
}

/// What the thread hears of the stack. Ports before the node they belong to.
struct Ears {
    commands: Subscriber<SafeCommand>,
    obstacles: Subscriber<Obstacles>,
    health: Subscriber<Health>,
    _node: Node,
}

/// The newest of what was heard.
#[derive(Default)]
struct Heard {
    command: Option<SafeCommand>,
    obstacles: Option<Box<Obstacles>>,
    health: BTreeMap<u32, Health>,
}

/// When something was last done, stack clock, ns.
#[derive(Default)]
struct Done {
    watched_ns: u64,
    diagnosed_ns: u64,
    said_ns: u64,
    painted_ns: u64,
}

impl Ears {
    fn open(instance: &str) -> Result<Self, NodeError> {
        let node = Node::open(instance, ProcessId::Bridge)?;
        Ok(Self {
            commands: node.subscriber()?,
            obstacles: node.subscriber()?,
            health: node.subscriber_all()?,
            _node: node,
        })
    }

    /// Takes what is new; whether there is a new command.
    fn hear(&mut self, heard: &mut Heard) -> bool {
        let command = self.commands.newest();
        heard.command = command.or(heard.command);
        if let Some(obstacles) = self.obstacles.newest() {
            heard.obstacles = Some(Box::new(obstacles));
        }
        self.health.drain(|health| note(&mut heard.health, health));
        command.is_some()
    }
}

impl Telling {
    fn run(mut self, stop: &AtomicBool) {
        // What the graph is like is worth saying even where the stack cannot be heard.
        let mut ears = Ears::open(&self.instance)
            .inspect_err(|error| tracing::warn!(%error, "the filter's state will not be told to ROS 2"))
            .ok();
        let (mut heard, mut done, mut said) = (Heard::default(), Done::default(), Vec::new());
        while !stop.load(Ordering::Acquire) {
            let now = Arrival::now();
            let is_new = ears.as_mut().is_some_and(|ears| ears.hear(&mut heard));
            if is_new && let Some(command) = &heard.command {
                self.tell_state(command, now);
            }
            if is_due(&mut done.watched_ns, now, WATCH_PERIOD_NS) {
                self.watch.look();
            }
            if is_due(&mut done.diagnosed_ns, now, DIAGNOSE_PERIOD_NS) {
                self.diagnose(&heard, now, &mut done, &mut said);
            }
            if self.is_painting() && is_due(&mut done.painted_ns, now, PAINT_PERIOD_NS) {
                self.paint(&heard, now);
            }
            std::thread::sleep(PERIOD);
        }
    }

    /// What does not leave is counted by its outlet.
    fn tell_state(&self, command: &SafeCommand, now: Arrival) {
        let header = self.header(command.ledger.filter_woke_ns, now);
        let _ = self.outlets.state.publish(filter_state(command, header));
        let _ = self.outlets.h.publish(Float64 { data: command.h_m });
        let _ = self.outlets.sdf.publish(Float64 { data: command.sdf_m });
    }

    /// Says what has changed at once, and everything from time to time.
    fn diagnose(&mut self, heard: &Heard, now: Arrival, done: &mut Done, said: &mut Vec<DiagnosticStatus>) {
        let status = self.diagnostics.statuses(&Facts {
            now_ns: now.stack_ns,
            command: heard.command.as_ref(),
            sink: self.shared.sink.as_ref().map(|sink| sink.read()),
            lost: self.shared.counters.lost_inputs(),
            replaced: self.shared.counters.replaced_commands(),
            topics: self.watch.topics(),
            command_topic: &self.command_topic,
            health: &heard.health,
            expected: &self.expected,
        });
        let gist = |status: &DiagnosticStatus| (status.level.0, status.name.clone(), status.message.clone());
        let has_changed = !status.iter().map(gist).eq(said.iter().map(gist));
        if has_changed || now.stack_ns.saturating_sub(done.said_ns) >= REPEAT_PERIOD_NS {
            done.said_ns = now.stack_ns;
            said.clone_from(&status);
            let stamp = self.shared.time.at(now.stack_ns, now);
            let header = Header { stamp, frame_id: String::new() };
            let _ = self.outlets.diagnostics.publish(DiagnosticArray { header, status });
        }
    }

    /// Whether anybody looks at pictures.
    fn is_painting(&self) -> bool {
        let seen = |painter: &Painter| {
            let is_it = |record| Arc::ptr_eq(record, painter.record());
            self.watch.topics().iter().any(|topic| is_it(&topic.record) && topic.others.matched > 0)
        };
        self.painter.as_ref().is_some_and(seen)
    }

    fn paint(&self, heard: &Heard, now: Arrival) {
        let (Some(painter), Some(command), Some(obstacles)) =
            (&self.painter, &heard.command, &heard.obstacles)
        else {
            return;
        };
        let header = self.header(command.ledger.filter_woke_ns, now);
        painter.give(Scene { header, command: *command, obstacles: obstacles.clone() });
    }

    /// A header for what held at `time_ns` of the stack clock, by the clock that the graph stamps with.
    fn header(&self, time_ns: u64, now: Arrival) -> Header {
        Header { stamp: self.shared.time.at(time_ns, now), frame_id: self.frame.clone() }
    }
}

/// Keeps a report, unless it is of one who waits for the place of another one that runs.
fn note(reports: &mut BTreeMap<u32, Health>, report: &Health) {
    let runs = |known: &Health| {
        let age_ns = report.published_ns.saturating_sub(known.published_ns);
        known.pid != report.pid && known.cycles > 0 && age_ns <= REPORT_SILENCE_NS
    };
    if report.cycles > 0 || !reports.get(&report.process).is_some_and(runs) {
        reports.insert(report.process, *report);
    }
}

/// Whether `period_ns` have passed since it was last done; then it is done now.
fn is_due(done_ns: &mut u64, now: Arrival, period_ns: u64) -> bool {
    let due = now.stack_ns.saturating_sub(*done_ns) >= period_ns;
    if due {
        *done_ns = now.stack_ns;
    }
    due
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn who_waits_is_told_of_where_nobody_runs_in_that_place() {
        let report = |pid: u32, cycles: u64, published_ns: u64| Health {
            pid,
            cycles,
            published_ns,
            ..Health::zeroed()
        };
        let mut reports = BTreeMap::new();
        let mut shown = |of: &Health| {
            note(&mut reports, of);
            reports[&0].pid
        };
        assert_eq!(shown(&report(1, 0, 10)), 1);
        assert_eq!(shown(&report(2, 5, 20)), 2);
        assert_eq!(shown(&report(1, 0, 30)), 2);
        assert_eq!(shown(&report(2, 7, 50)), 2);
        assert_eq!(shown(&report(1, 0, 51 + REPORT_SILENCE_NS)), 1, "the other one is gone");
    }
}
