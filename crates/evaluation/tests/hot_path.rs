//! What the cycles of all four processes allocate, ports and hand-over included, while all is well, while nothing is, and
//! after it is well again.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::time::Duration;

use allocation_counter::measure;
use bytemuck::Zeroable;
use cbf_filter::shell::FilterProcess;
use messages::{
    Detection, Detections, Goal, NominalCommand, ProcessId, Reason, RobotState, SafeCommand, SafetyStatus,
    SourceKind, SourceStatus, Stamp,
};
use node_runtime::{Clock, Node, ProcessLoop, RealClock, ScopedDomain, Subscriber, Tick, Work};
use nominal_mpc::shell::NominalProcess;
use obstacle_estimator::shell::EstimatorProcess;
use perception_bridge::shell::BridgeProcess;
use perception_bridge::{BridgeEvent, SinkState, Source};
use settings::{ControllerKind, Settings};

const MS: u64 = 1_000_000;
/// Filter cycles of each phase: 2 s.
const PHASE_CYCLES: u64 = 500;
/// Cycles in which ports still connect and the estimator still learns of its tracks.
const SETTLING_CYCLES: u64 = 60;
const PEOPLE: u32 = 20;

/// What the source gives in a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Normal,
    NonFinite,
    Silent,
    Recovered,
}

/// A robot that stands still among people who walk, or whatever the phase makes of it.
struct Scripted {
    begin_ns: u64,
    given: u64,
    detections_sequence: u64,
    pending: Option<BridgeEvent>,
}

impl Scripted {
    fn new(begin_ns: u64) -> Self {
        Self { begin_ns, given: 0, detections_sequence: 0, pending: None }
    }

    fn phase(&self, now_ns: u64) -> Phase {
        match (now_ns - self.begin_ns) / (PHASE_CYCLES * 4 * MS) {
            0 => Phase::Normal,
            1 => Phase::NonFinite,
            2 => Phase::Silent,
            _ => Phase::Recovered,
        }
    }

    fn stamp(sequence: u64, now_ns: u64) -> Stamp {
        Stamp { sequence, source_ns: now_ns, valid_at_ns: now_ns, ingress_ns: now_ns, published_ns: 0 }
    }

    fn robot_state(&self, phase: Phase, now_ns: u64) -> RobotState {
        let heading_rad = if phase == Phase::NonFinite { f64::NAN } else { 0.0 };
        RobotState { stamp: Self::stamp(self.given, now_ns), heading_rad, ..RobotState::zeroed() }
    }

    fn detections(&mut self, phase: Phase, now_ns: u64) -> Detections {
        self.detections_sequence += 1;
        let mut frame = Detections::zeroed();
        frame.stamp = Self::stamp(self.detections_sequence, now_ns);
        frame.count = PEOPLE;
        let walked_m = (now_ns - self.begin_ns) as f64 * 1e-9;
        for (index, item) in frame.items.iter_mut().take(PEOPLE as usize).enumerate() {
            let y_m = if phase == Phase::NonFinite && index % 2 == 0 { f64::NAN } else { walked_m * 0.5 };
            *item = Detection {
                track_id: index as u64 + 1,
                position_in_odom_m: [2.0 + index as f64, y_m],
                radius_m: 0.35,
                ..Detection::zeroed()
            };
        }
        frame
    }
}

impl Source for Scripted {
    fn next_due_ns(&self) -> Option<u64> {
        Some(self.begin_ns + (self.given + 1) * 10 * MS)
    }

    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        if let Some(event) = self.pending.take() {
            return Some(event);
        }
        if self.next_due_ns()? > now_ns {
            return None;
        }
        self.given += 1;
        let phase = self.phase(now_ns);
        if phase == Phase::Silent {
            return None;
        }
        if self.given % 5 == 1 {
            self.pending = Some(BridgeEvent::Detections(self.detections(phase, now_ns)));
        }
        if self.given == 2 {
            let stamp = Self::stamp(1, now_ns);
            return Some(BridgeEvent::Goal(Goal {
                stamp,
                position_in_odom_m: [12.0, 1.0],
                ..Goal::zeroed()
            }));
        }
        Some(BridgeEvent::RobotState(self.robot_state(phase, now_ns)))
    }

    fn command(&mut self, _: &SafeCommand, _: u64) {}

    fn status(&self, now_ns: u64) -> SourceStatus {
        SourceStatus { published_ns: now_ns, kind: SourceKind::Simulation.code(), ..SourceStatus::zeroed() }
    }

    fn sink_state(&self) -> Option<SinkState> {
        Some(SinkState::Braking(Reason::SilentFilter)).filter(|_| self.given.is_multiple_of(7))
    }
}

/// One process in this thread.
struct Process<W> {
    cycles: ProcessLoop,
    work: W,
}

impl<W: Work> Process<W> {
    fn new(node: &Node, work: W) -> Self {
        Self { cycles: ProcessLoop::new(node).unwrap(), work }
    }

    /// Allocations of one cycle that begins now.
    fn allocations(&mut self) -> u64 {
        let tick = Tick::event(RealClock.now_ns());
        measure(|| self.cycles.cycle(&mut self.work, &tick)).count_total
    }
}

/// Runs the stack through all phases and checks each cycle's allocations, of which `of_solver` belong to one nominal command;
/// all of `statuses` must have come up.
fn no_cycle_allocates(
    controller: ControllerKind,
    of_solver: fn(&NominalCommand) -> u64,
    statuses: &[SafetyStatus],
) {
    let text = include_str!("../../../config/ground_robot.toml");
    let mut settings = Settings::parse(text, "x".as_ref(), ".".as_ref()).unwrap();
    settings.nominal.controller = controller;
    let domain = ScopedDomain::new();
    let nodes = [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter]
        .map(|process| Node::open_in(&domain, "hot", process).unwrap());
    let [bridge_node, estimator_node, nominal_node, filter_node] = &nodes;
    let observer = Node::open_in(&domain, "hot", ProcessId::Recorder).unwrap();
    let mut commands: Subscriber<NominalCommand> = observer.subscriber_all().unwrap();
    let mut safe_commands: Subscriber<SafeCommand> = observer.subscriber_all().unwrap();

    let source = Box::new(Scripted::new(RealClock.now_ns()));
    let mut bridge = Process::new(bridge_node, BridgeProcess::open(source, bridge_node).unwrap());
    let mut estimator =
        Process::new(estimator_node, EstimatorProcess::open(&settings, estimator_node).unwrap());
    let mut nominal = Process::new(nominal_node, NominalProcess::open(&settings, nominal_node).unwrap());
    let mut filter = Process::new(filter_node, FilterProcess::open(&settings, filter_node).unwrap());

    let mut seen = [0_usize; 5];
    for cycle in 0..4 * PHASE_CYCLES {
        let mut counts = [bridge.allocations(), estimator.allocations(), 0, filter.allocations()];
        if cycle % 12 == 0 {
            counts[2] = nominal.allocations();
            commands.drain(|command| counts[2] -= of_solver(command).min(counts[2]));
        }
        safe_commands.drain(|command| seen[command.status as usize] += 1);
        if cycle >= SETTLING_CYCLES {
            assert_eq!(counts, [0; 4], "bridge, estimator, nominal, filter in cycle {cycle}");
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    for status in statuses {
        assert!(seen[status.code() as usize] > 10, "{status} hardly came up: {seen:?}");
    }
}

#[test]
fn no_cycle_of_any_process_allocates() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    no_cycle_allocates(ControllerKind::Hold, |_| 0, &[SafetyStatus::Stopped]);
}

#[test]
fn the_mpc_allocates_inside_clarabel_alone() {
    // A hash table of Clarabel's own timers for every QP.
    let statuses = [SafetyStatus::Filtered, SafetyStatus::Braking, SafetyStatus::Stopped];
    no_cycle_allocates(ControllerKind::Mpc, |command| u64::from(command.effort), &statuses);
}
