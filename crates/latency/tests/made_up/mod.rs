//! Made-up runs of the whole stack with known counts: what four processes would record.
#![allow(dead_code, reason = "each test uses its part")]

use bytemuck::Zeroable;
use latency::{Conditions, Machine, ProfileFigures, RecordingIdentity, RepeatFigures, Resident, RunMessages};
use messages::{Cycle, Health, Ledger, ProcessId, RealtimeFlags, SafeCommand, SafetyStatus, Trigger};

pub(crate) const PERIOD_NS: u64 = 4_000_000;
/// Cycles of the filter between two frames of detections: 20 Hz.
pub(crate) const CYCLES_PER_FRAME: u64 = 12;
const START_NS: u64 = 90_000_000_000;

/// What one run is like.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    /// Cycles of the filter's timer.
    pub(crate) cycles: u64,
    /// Stretches every computation and hop, 1.0 is normal.
    pub(crate) slowness: f64,
    /// Changes the noise.
    pub(crate) seed: u64,
    /// First cycle that has detections.
    pub(crate) first_frame: u64,
    /// Cycle before which the filter sleeps 3.25 periods too long; none where zero.
    pub(crate) overslept: u64,
}

impl Plan {
    pub(crate) const fn quiet(cycles: u64, seed: u64) -> Self {
        Self { cycles, slowness: 1.0, seed, first_frame: 0, overslept: 0 }
    }
}

/// Noise in 0..1, the same everywhere.
fn noise(seed: u64, index: u64) -> f64 {
    let mut x = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ index.wrapping_mul(0xD1B5_4A32_D192_ED03);
    x ^= x >> 29;
    x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x ^= x >> 32;
    (x >> 11) as f64 / (1_u64 << 53) as f64
}

/// A length that is mostly near `typical_ns`, with a long tail.
fn length_ns(plan: &Plan, index: u64, kind: u64, typical_ns: f64) -> u64 {
    let draw = noise(plan.seed.wrapping_add(kind * 7_919), index);
    let tail = if draw > 0.995 { 12.0 * noise(plan.seed, index + 1) } else { 0.0 };
    (plan.slowness * typical_ns * (0.8 + 0.4 * draw + tail)) as u64
}

/// The run, with an event cycle of the filter wherever a frame arrives.
pub(crate) fn run(plan: &Plan) -> RunMessages {
    let mut out = RunMessages { health: health(), resident: resident(), ..RunMessages::default() };
    let mut newest = Ledger::zeroed();
    let (mut frame, mut sequence, mut skipped) = (0, 0, 0);
    for index in 0..plan.cycles {
        let due_ns = START_NS + index * PERIOD_NS;
        if plan.overslept > 0 && (plan.overslept..plan.overslept + 3).contains(&index) {
            skipped += 1;
        } else {
            let overslept = plan.overslept > 0 && index == plan.overslept + 3;
            let late_ns = length_ns(plan, index, 1, 50_000.0) + if overslept { PERIOD_NS / 4 } else { 0 };
            let tick = Ledger {
                filter_due_ns: due_ns,
                filter_woke_ns: due_ns + late_ns,
                filter_trigger: Trigger::Timer.code(),
                filter_skipped: if overslept { skipped } else { 0 },
                ..newest
            };
            sequence += 1;
            filter(plan, index, sequence, tick, &mut out);
        }
        if index % 5 == 2 {
            nominal(plan, index, due_ns + 1_300_000, &mut newest, &mut out);
        }
        if index % CYCLES_PER_FRAME == 5 && index >= plan.first_frame {
            frame += 1;
            let woke_ns = detections(plan, frame, due_ns + 2_000_000, &mut newest, &mut out);
            let event = Ledger {
                filter_due_ns: woke_ns,
                filter_woke_ns: woke_ns,
                filter_trigger: Trigger::Event.code(),
                ..newest
            };
            sequence += 1;
            filter(plan, index + 1_000_000, sequence, event, &mut out);
        }
    }
    out
}

/// A frame through bridge and estimator; returns when the filter can begin.
fn detections(plan: &Plan, frame: u64, ingress_ns: u64, newest: &mut Ledger, out: &mut RunMessages) -> u64 {
    newest.detections_source_ns = 7 + frame;
    newest.detections_ingress_ns = ingress_ns;
    newest.detections_published_ns = ingress_ns + length_ns(plan, frame, 2, 15_000.0);
    newest.estimator_received_ns = newest.detections_published_ns + length_ns(plan, frame, 3, 55_000.0);
    newest.estimator_published_ns = newest.estimator_received_ns + length_ns(plan, frame, 4, 12_000.0);
    newest.robot_state_ingress_ns = ingress_ns;
    newest.robot_state_published_ns = newest.detections_published_ns;
    let bridge = (ingress_ns - 4_000, newest.detections_published_ns + 3_000);
    out.cycles.push(cycle(ProcessId::Bridge, frame, Trigger::Timer, ingress_ns - 90_000, bridge));
    let estimator = (newest.estimator_received_ns - 2_000, newest.estimator_published_ns + 3_000);
    out.cycles.push(cycle(ProcessId::Estimator, frame, Trigger::Event, 0, estimator));
    newest.estimator_published_ns + length_ns(plan, frame, 5, 58_000.0)
}

fn nominal(plan: &Plan, index: u64, woke_ns: u64, newest: &mut Ledger, out: &mut RunMessages) {
    newest.nominal_received_ns = woke_ns;
    newest.nominal_published_ns = woke_ns + length_ns(plan, index, 6, 350_000.0);
    let span = (woke_ns, newest.nominal_published_ns + 2_000);
    let mut cycle = cycle(ProcessId::Nominal, index / 5 + 1, Trigger::Timer, woke_ns - 60_000, span);
    cycle.involuntary_switches = u32::from(noise(plan.seed, index) > 0.98);
    out.cycles.push(cycle);
}

fn filter(plan: &Plan, index: u64, sequence: u64, ledger: Ledger, out: &mut RunMessages) {
    let computed_ns = ledger.filter_woke_ns + length_ns(plan, index, 7, 8_000.0);
    let published_ns = computed_ns + length_ns(plan, index, 8, 1_500.0);
    let trigger = Trigger::try_from(ledger.filter_trigger).expect("made above");
    let due_ns = if trigger == Trigger::Timer { ledger.filter_due_ns } else { 0 };
    let mut cycle =
        cycle(ProcessId::Filter, sequence, trigger, due_ns, (ledger.filter_woke_ns, published_ns + 2_000));
    cycle.skipped = ledger.filter_skipped;
    cycle.minor_faults = u32::from(sequence < 4);
    out.cycles.push(cycle);
    out.safe_commands.push(SafeCommand {
        sequence,
        status: SafetyStatus::Filtered.code(),
        obstacle_count: 5,
        ledger: Ledger {
            filter_computed_ns: computed_ns,
            filter_published_ns: published_ns,
            voluntary_switches: 1,
            ..ledger
        },
        ..SafeCommand::zeroed()
    });
}

fn cycle(process: ProcessId, sequence: u64, trigger: Trigger, due_ns: u64, span_ns: (u64, u64)) -> Cycle {
    Cycle {
        sequence,
        due_ns,
        woke_ns: span_ns.0,
        done_ns: span_ns.1,
        cpu_ns: (span_ns.1 - span_ns.0) + 5_000,
        process: process.code(),
        processor: process.code() % 2,
        trigger: trigger.code(),
        voluntary_switches: 1,
        ..Cycle::zeroed()
    }
}

const PROCESSES: [ProcessId; 4] =
    [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter];

fn health() -> Vec<Health> {
    let asked = RealtimeFlags::FIFO | RealtimeFlags::MEMORY_LOCK;
    let of = |process: ProcessId| Health {
        published_ns: START_NS,
        process: process.code(),
        realtime_asked: asked,
        realtime_granted: if process == ProcessId::Nominal { 0 } else { asked },
        ..Health::zeroed()
    };
    PROCESSES.map(of).to_vec()
}

fn resident() -> Vec<Resident> {
    let of = |process: ProcessId| Resident {
        process,
        resident_bytes: 20_000_000 + 1_000_000 * u64::from(process.code()),
        proportional_bytes: 15_000_000,
        locked_bytes: 0,
    };
    PROCESSES.map(of).to_vec()
}

pub(crate) fn conditions() -> Conditions {
    Conditions {
        tool_version: "0.1.0".to_owned(),
        settings_sha256: "5e77".repeat(16),
        recording: RecordingIdentity {
            file_name: "crowd & <people>.mcap".to_owned(),
            sha256: "ab12".repeat(16),
            duration_s: 20.0,
            detections: 400,
            robot_states: 2_000,
        },
        rate: 1.0,
        duration_s: None,
        closed_loop: false,
        load: "none".to_owned(),
        wait: "listener".to_owned(),
        transport: "iceoryx2".to_owned(),
        trigger: "both".to_owned(),
        filter_period_ns: PERIOD_NS,
        machine: Machine {
            cpu_model: "Imaginary Processor 9000".to_owned(),
            cores: 2,
            kernel: "Linux 6.12.0".to_owned(),
            preempt_rt: false,
            governor: None,
            clock_source: Some("tsc".to_owned()),
            memory_bytes: 8_000_000_000,
        },
    }
}

/// One repeat per plan, measured from the first use of detections on.
pub(crate) fn profile(plans: &[Plan]) -> (ProfileFigures, Vec<RunMessages>) {
    let runs: Vec<RunMessages> = plans.iter().map(run).collect();
    let repeats = runs
        .iter()
        .map(|run| RepeatFigures::of(PERIOD_NS, run, run.first_use_ns().expect("detections in every plan")))
        .collect();
    (ProfileFigures::new(conditions(), repeats), runs)
}

/// Repeats of like runs that differ in noise.
pub(crate) fn repeats(count: u64, slowness: f64) -> ProfileFigures {
    let plans: Vec<Plan> = (1..=count).map(|seed| Plan { slowness, ..Plan::quiet(2_000, seed) }).collect();
    profile(&plans).0
}
