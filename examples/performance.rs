//! Percentiles of the pure steps, as JSON, in rounds that a judge can take turns with.
//!
//! ```text
//! cargo run --release --example performance [ROUNDS]
//! ```
//!
//! Each round runs every case for a while, so that a neighbour's noise meets them all alike. Without `ROUNDS` one round
//! follows each line on standard input and is answered by `done`; the first line of the output then holds the scenes, for
//! judges that do the same work. At the end of the input comes a line with all figures. Every call counts: nothing is
//! filtered away. `tests/judges/performance.py` drives this program.
#![allow(clippy::unwrap_used)] // a measurement may panic

#[path = "../benches/scenes/mod.rs"]
mod scenes;

use std::hint::black_box;
use std::io::{BufRead, Write};

use hdrhistogram::Histogram;
use node_runtime::{Clock, RealClock};
use scenes::{BarrierStep, Drive, ESTIMATORS, EstimatorStep, FilterStep, NetworkStep, QpStep, Ros2Coding};
use serde_json::{Value, json};
use settings::{EstimatorKind, KernelChoice};

const PEOPLE: [usize; 5] = [1, 5, 15, 20, 64];
/// Calls of a microsecond step in one round.
const CALLS: usize = 400;
/// Calls in a row under one reading of the clock, where one call is shorter than the reading.
const BATCH: usize = 64;
const PS_PER_NS: u64 = 1_000;
/// 10 s in ps: no call lasts longer.
const LONGEST_PS: u64 = 10_000_000_000_000;

/// Durations of one kind of call, in ps so that batches of the shortest calls keep their digits.
struct Case {
    name: String,
    durations_ps: Histogram<u64>,
    round: Round,
}

/// Runs a case for a while and records every duration.
type Round = Box<dyn FnMut(&mut Histogram<u64>)>;

impl Case {
    fn new(name: impl Into<String>, round: impl FnMut(&mut Histogram<u64>) + 'static) -> Self {
        let durations_ps = Histogram::new_with_bounds(1, LONGEST_PS, 3).unwrap();
        Self { name: name.into(), durations_ps, round: Box::new(round) }
    }

    /// A step that is timed call by call.
    fn of_calls<R>(name: impl Into<String>, mut step: impl FnMut() -> R + 'static) -> Self {
        Self::new(name, move |durations_ps| {
            for _ in 0..CALLS {
                durations_ps.saturating_record(timed_ps(&mut step));
            }
        })
    }

    /// A step so short that only many of them can be timed: percentiles are of the means of batches.
    fn of_batches<R>(name: impl Into<String>, mut step: impl FnMut() -> R + 'static) -> Self {
        Self::new(name, move |durations_ps| {
            for _ in 0..CALLS {
                let batch_ps = timed_ps(|| {
                    for _ in 0..BATCH {
                        black_box(step());
                    }
                });
                durations_ps.saturating_record(batch_ps / BATCH as u64);
            }
        })
    }

    fn figures(&self) -> Value {
        let us = |ps: u64| ps as f64 * 1e-6;
        let quantile = |share: f64| us(self.durations_ps.value_at_quantile(share));
        json!({
            "calls": self.durations_ps.len(),
            "min_us": us(self.durations_ps.min()),
            "p50_us": quantile(0.5),
            "p90_us": quantile(0.9),
            "p99_us": quantile(0.99),
            "p999_us": quantile(0.999),
            "max_us": us(self.durations_ps.max()),
        })
    }
}

fn timed_ps<R>(call: impl FnOnce() -> R) -> u64 {
    let began_ns = RealClock.now_ns();
    black_box(call());
    (RealClock.now_ns() - began_ns) * PS_PER_NS
}

fn cases() -> Vec<Case> {
    let mut cases = vec![Case::of_calls("clock", || ())];
    for people in PEOPLE {
        let mut filter = FilterStep::new(people, KernelChoice::Auto);
        cases.push(Case::of_calls(format!("filter_step/{people}"), move || filter.step()));
    }
    for kernel in barrier::Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        for people in PEOPLE {
            let mut network = NetworkStep::new(people, kernel);
            cases.push(Case::of_calls(format!("network/{kernel}/{people}"), move || network.step()));
        }
    }
    let mut barrier = BarrierStep::new(20, barrier::Kernel::detect());
    cases.push(Case::of_calls("composite/20", move || barrier.step()));
    let mut qp = QpStep::new();
    cases.push(Case::of_batches("qp", move || qp.step()));
    cases.push(mpc_case());
    for estimator in ESTIMATORS {
        for (people, named) in [(20, true), (64, true), (20, false), (64, false)] {
            cases.push(estimator_case(estimator, people, named));
        }
    }
    let mut odometry = Ros2Coding::odometry();
    cases.push(Case::of_calls("encode/odometry", move || odometry.encode()));
    let odometry = Ros2Coding::odometry();
    cases.push(Case::of_calls("decode/odometry", move || odometry.decode()));
    let mut detections = Ros2Coding::detections(20);
    cases.push(Case::of_calls("encode/detections/20", move || detections.encode()));
    let detections = Ros2Coding::detections(20);
    cases.push(Case::of_calls("decode/detections/20", move || detections.decode()));
    cases
}

/// One goal a round. Steps at the goal, which solve nothing, do not count.
fn mpc_case() -> Case {
    let mut drive = Drive::new();
    Case::new("mpc_step", move |durations_ps| {
        for _ in 0..scenes::STEPS_PER_GOAL {
            drive.arrive();
            let mut command = None;
            let duration_ps = timed_ps(|| command = Some(drive.step()));
            let command = command.unwrap();
            if command.effort > 0 {
                durations_ps.saturating_record(duration_ps);
            }
            drive.follow(&command);
        }
    })
}

fn estimator_case((kind_name, kind): (&str, EstimatorKind), people: usize, named: bool) -> Case {
    let mut estimator = EstimatorStep::new(kind, people, named);
    let name = if named { "named" } else { "anonymous" };
    Case::new(format!("estimator_step/{kind_name}/{name}/{people}"), move |durations_ps| {
        for _ in 0..CALLS {
            estimator.perceive();
            durations_ps.saturating_record(timed_ps(|| estimator.step().count));
        }
    })
}

/// What a judge needs to do the same work, and the controls this program comes to.
fn described() -> Value {
    let settings = scenes::settings();
    let added_m = settings.robot.radius_m + settings.filter.sdf_buffer_m;
    let people: Vec<_> = (0..64)
        .map(|index| {
            let person = scenes::person(index);
            let ([x, y], [vx, vy]) = (person.position_in_odom_m, person.velocity_in_odom_mps);
            json!({
                "state": [x, y, person.heading_rad, person.speed_mps],
                "rate": [vx, vy, person.heading_rate_radps, person.speed_rate_mps2],
                "radius_m": person.radius_m + added_m,
            })
        })
        .collect();
    let answers: Vec<_> = PEOPLE
        .iter()
        .map(|&people| {
            let mut filter = FilterStep::new(people, KernelChoice::Auto);
            let controls: Vec<_> = (0..scenes::VARIANTS).map(|_| filter.step().control).collect();
            json!({ "people": people, "controls": controls })
        })
        .collect();
    let mpc = &settings.nominal.mpc;
    json!({
        "kernel": FilterStep::new(1, KernelChoice::Auto).kernel().name(),
        "people": people,
        "robot_poses": (0..scenes::VARIANTS).map(scenes::robot_pose).collect::<Vec<_>>(),
        "nominal_controls": (0..scenes::VARIANTS).map(scenes::nominal_control).collect::<Vec<_>>(),
        "alpha_per_s": settings.filter.alpha_per_s,
        "beta_per_m": settings.filter.beta_per_m,
        "slack_weight": settings.filter.slack_weight,
        "control_min": settings.robot.control_min,
        "control_max": settings.robot.control_max,
        "answers": answers,
        "mpc": {
            "horizon_steps": mpc.horizon_steps, "step_s": mpc.step_s, "state_weight": mpc.state_weight,
            "terminal_weight": mpc.terminal_weight, "control_weight": mpc.control_weight,
            "period_s": scenes::PERIOD_NS as f64 * 1e-9, "steps_per_goal": scenes::STEPS_PER_GOAL,
            "goals": scenes::GOALS_IN_ODOM_M,
        },
    })
}

/// Describes the scenes, then runs a round for each line on standard input.
fn take_turns(mut round: impl FnMut()) {
    let mut answer = std::io::stdout().lock();
    writeln!(answer, "{}", described()).unwrap();
    answer.flush().unwrap();
    for _ in std::io::stdin().lock().lines() {
        round();
        writeln!(answer, "done").unwrap();
        answer.flush().unwrap();
    }
}

fn main() {
    let mut cases = cases();
    let mut round = || {
        for case in &mut cases {
            (case.round)(&mut case.durations_ps);
        }
    };
    if let Some(rounds) = std::env::args().nth(1) {
        (0..rounds.parse::<usize>().expect("ROUNDS is a whole number")).for_each(|_| round());
    } else {
        take_turns(round);
    }
    let figures: serde_json::Map<_, _> =
        cases.iter().map(|case| (case.name.clone(), case.figures())).collect();
    println!("{}", Value::Object(figures));
}
