//! Measures how long one step of the MPC takes, in closed loop between goals on all sides.
//!
//! The processor time of the thread stands beside the time that passed: on a busy machine the latter holds the turns
//! of other programs too.
//!
//! ```text
//! cargo run --release -p nominal_mpc --example step_latency
//! ```

use std::path::Path;

use anyhow::Context;
use messages::{Goal, RobotState, Stamp};
use node_runtime::{Clock, RealClock};
use nominal_mpc::{Inputs, NominalController};
use rustix::time::{ClockId, clock_gettime};
use settings::Settings;

const STEPS: usize = 1_000;
const PERIOD_NS: u64 = 50_000_000;
/// A new goal after this many steps: 10 s.
const STEPS_PER_GOAL: usize = 200;
const GOALS_IN_ODOM_M: [[f64; 2]; 5] = [[13.0, 0.0], [-4.0, 3.0], [1.0, -6.0], [2.0, 2.0], [-9.0, -1.0]];

/// Processor time this thread has used, ns.
fn processor_ns() -> u64 {
    let used = clock_gettime(ClockId::ThreadCPUTime);
    used.tv_sec as u64 * 1_000_000_000 + used.tv_nsec as u64
}

/// Median, 99th percentile and largest of some durations, µs.
fn summary(durations_ns: &mut [u64]) -> anyhow::Result<String> {
    durations_ns.sort_unstable();
    let last = durations_ns.len().checked_sub(1).context("no step was solved")?;
    let us = |share: f64| durations_ns[(share * last as f64) as usize] as f64 * 1e-3;
    Ok(format!("p50 {:.0}, p99 {:.0}, max {:.0}", us(0.5), us(0.99), us(1.0)))
}

fn main() -> anyhow::Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/ground_robot.toml");
    let settings = Settings::load(Path::new(path))?;
    let mut controller = NominalController::new(&settings)?;
    let clock = RealClock;
    let stamp = Stamp { sequence: 1, source_ns: 0, valid_at_ns: 0, ingress_ns: 0, published_ns: 0 };
    let mut robot = RobotState {
        stamp,
        position_in_odom_m: [0.0; 2],
        heading_rad: 0.0,
        velocity_in_base_mps: [0.0; 2],
        yaw_rate_radps: 0.0,
    };
    let (mut passed_ns, mut used_ns, mut iterations) = (Vec::new(), Vec::new(), 0);
    for step in 0..STEPS {
        let now_ns = step as u64 * PERIOD_NS;
        robot.stamp.valid_at_ns = now_ns;
        let target = GOALS_IN_ODOM_M[step / STEPS_PER_GOAL % GOALS_IN_ODOM_M.len()];
        let goal = Goal { stamp, position_in_odom_m: target, heading_rad: 0.0 };
        let inputs = Inputs { robot_state: Some(&robot), robot_state_received_ns: now_ns, goal: Some(&goal) };
        let (began_ns, used_before_ns) = (clock.now_ns(), processor_ns());
        let command = controller.step(&inputs, now_ns)?;
        let (step_ns, step_used_ns) = (clock.now_ns() - began_ns, processor_ns() - used_before_ns);
        if command.effort > 0 {
            passed_ns.push(step_ns);
            used_ns.push(step_used_ns);
            iterations += command.effort;
        }
        let step_s = PERIOD_NS as f64 * 1e-9;
        let [speed, yaw_rate] = command.control;
        let (sin, cos) = robot.heading_rad.sin_cos();
        robot.position_in_odom_m[0] += step_s * speed * cos;
        robot.position_in_odom_m[1] += step_s * speed * sin;
        robot.heading_rad += step_s * yaw_rate;
    }
    let solved = passed_ns.len();
    println!(
        "{solved} of {STEPS} steps solved a plan, {:.2} QPs each",
        f64::from(iterations) / solved as f64
    );
    println!("time passed, us:    {}", summary(&mut passed_ns)?);
    println!("processor time, us: {}", summary(&mut used_ns)?);
    Ok(())
}
