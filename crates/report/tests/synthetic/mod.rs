//! A made-up run with known figures: a unicycle drives along x through people who walk across.
//!
//! The barrier here is no barrier of the project, only smooth and simple: h_i = |p_i| − R − 0.6·(closing speed)⁺.

use bytemuck::Zeroable;
use messages::{
    ControlKind, Goal, Ledger, Obstacle, ObstacleClass, ObstacleQuality, Obstacles, Reason, RobotState,
    SafeCommand, SafetyStatus, SourceKind, SourceStatus, Stamp,
};
use report::RunRecord;

pub(crate) const PERIOD_NS: u64 = 4_000_000;
pub(crate) const START_NS: u64 = 5_000_000_000;
pub(crate) const BETA_PER_M: f64 = 4.0;
pub(crate) const ROBOT_RADIUS_M: f64 = 0.35;
pub(crate) const PERSON_RADIUS_M: f64 = 0.35;
const RADIUS_M: f64 = ROBOT_RADIUS_M + PERSON_RADIUS_M;
const ALPHA_PER_S: f64 = 1.0;
const GOAL_M: [f64; 2] = [14.0, 0.0];

/// Position and velocity of person `index` at `time_s`: a walk to and fro across the robot's way.
pub(crate) fn person(index: usize, time_s: f64) -> ([f64; 2], [f64; 2]) {
    let (phase, pace) = (1.7 * index as f64, 0.25 + 0.02 * (index % 4) as f64);
    let (sin, cos) = (pace * time_s + phase).sin_cos();
    let x = 2.0 + 1.1 * index as f64 + 0.4 * (0.5 * time_s + phase).sin();
    ([x, 4.0 * sin], [0.2 * (0.5 * time_s + phase).cos(), 4.0 * pace * cos])
}

/// The made-up h of a robot at `position` with velocity `velocity` among people at `time_s`, and who weighs most.
pub(crate) fn h_m(
    position: [f64; 2],
    velocity: [f64; 2],
    people: usize,
    time_s: f64,
) -> (f64, Option<(usize, f64)>, f64) {
    let mut sum = 0.0;
    let (mut critical, mut sdf_m): (Option<(usize, f64)>, f64) = (None, f64::INFINITY);
    for index in 0..people {
        let (place, motion) = person(index, time_s);
        let apart = [place[0] - position[0], place[1] - position[1]];
        let distance = apart[0].hypot(apart[1]).max(1e-6);
        let closing =
            -(apart[0] * (motion[0] - velocity[0]) + apart[1] * (motion[1] - velocity[1])) / distance;
        let h = distance - RADIUS_M - 0.6 * closing.max(0.0);
        sum += (-BETA_PER_M * h).exp();
        sdf_m = sdf_m.min(distance - RADIUS_M);
        if critical.is_none_or(|(_, smallest)| h < smallest) {
            critical = Some((index, h));
        }
    }
    (-sum.ln() / BETA_PER_M, critical, sdf_m)
}

fn ns(time_s: f64) -> u64 {
    START_NS + (time_s * 1e9).round() as u64
}

fn stamp(sequence: u64, at_ns: u64) -> Stamp {
    Stamp {
        sequence,
        source_ns: at_ns + 77,
        valid_at_ns: at_ns,
        ingress_ns: at_ns + 20_000,
        published_ns: at_ns + 45_000,
    }
}

fn obstacles(sequence: u64, people: usize, time_s: f64) -> Obstacles {
    let mut message = Obstacles::zeroed();
    // Perceived a moment before the cycle that uses it, which itself begins up to 0.2 ms late.
    let seen_ns = ns(time_s) - 1_000_000;
    let jitter_ns = (sequence * 7_919) % 40_000;
    message.stamp = stamp(sequence, seen_ns);
    message.bridge_published_ns = message.stamp.published_ns;
    message.received_ns = message.bridge_published_ns + 60_000 + jitter_ns;
    message.stamp.published_ns = message.received_ns + 110_000 + 2 * jitter_ns;
    message.count = people as u32;
    for index in 0..people {
        let (position_in_odom_m, velocity_in_odom_mps) = person(index, time_s);
        message.items[index] = Obstacle {
            track_id: index as u64 + 1,
            measured_at_ns: seen_ns,
            valid_at_ns: seen_ns,
            position_in_odom_m,
            velocity_in_odom_mps,
            heading_rad: velocity_in_odom_mps[1].atan2(velocity_in_odom_mps[0]),
            speed_mps: velocity_in_odom_mps[0].hypot(velocity_in_odom_mps[1]),
            radius_m: PERSON_RADIUS_M,
            class: ObstacleClass::Pedestrian.code(),
            quality: ObstacleQuality::Full.code(),
            ..Obstacle::zeroed()
        };
    }
    message
}

/// The robot's state while the run is being made up.
struct Robot {
    position: [f64; 2],
    heading: f64,
    speed: f64,
}

/// A run of `duration_s` seconds at 250 Hz among `people` people.
pub(crate) fn run(duration_s: f64, people: usize) -> RunRecord {
    let mut record = RunRecord {
        title: "cncbf run --config <synthetic> & \"quotes\"".to_owned(),
        settings: "[filter]\nalpha_per_s = 4.0 # </script> {{data}}".to_owned(),
        model: "synthetic.safetensors, no network behind it".to_owned(),
        robot_radius_m: ROBOT_RADIUS_M,
        filter_period_ns: PERIOD_NS,
        beta_per_m: BETA_PER_M,
        shadow: false,
        nominal_commands: Vec::new(),
        safe_commands: Vec::new(),
        robot_states: Vec::new(),
        obstacles: Vec::new(),
        goals: vec![Goal { stamp: stamp(1, START_NS), position_in_odom_m: GOAL_M, heading_rad: 0.0 }],
        source_status: Vec::new(),
    };
    let mut robot = Robot { position: [0.0, 0.0], heading: 0.0, speed: 0.0 };
    let (mut clearance_m, mut min_clearance_m, mut path_length_m) = (f64::INFINITY, f64::INFINITY, 0.0);
    let mut collisions = 0;
    let cycles = (duration_s * 1e9) as u64 / PERIOD_NS;
    for cycle in 0..cycles {
        let time_s = cycle as f64 * PERIOD_NS as f64 * 1e-9;
        if cycle % 13 == 0 {
            record.obstacles.push(obstacles(record.obstacles.len() as u64 + 1, people, time_s));
        }
        if cycle % 3 == 0 {
            record.robot_states.push(RobotState {
                stamp: stamp(record.robot_states.len() as u64 + 1, ns(time_s) - 400_000),
                position_in_odom_m: robot.position,
                heading_rad: robot.heading,
                velocity_in_base_mps: [robot.speed, 0.0],
                yaw_rate_radps: 0.0,
            });
        }
        let command = step(&record, &mut robot, cycle, people, time_s);
        record.safe_commands.push(command);
        let was_clear = clearance_m > 0.0;
        for index in 0..people {
            let (place, _) = person(index, time_s);
            let gap = (place[0] - robot.position[0]).hypot(place[1] - robot.position[1]) - RADIUS_M;
            clearance_m = if index == 0 { gap } else { f64::min(clearance_m, gap) };
        }
        collisions += u32::from(was_clear && clearance_m <= 0.0);
        min_clearance_m = min_clearance_m.min(clearance_m);
        path_length_m += robot.speed * PERIOD_NS as f64 * 1e-9;
        if cycle % 25 == 0 || cycle + 1 == cycles {
            let goal_distance_m = (GOAL_M[0] - robot.position[0]).hypot(GOAL_M[1] - robot.position[1]);
            record.source_status.push(SourceStatus {
                published_ns: ns(time_s),
                elapsed_ns: (time_s * 1e9) as u64,
                accepted: cycle / 3 + cycle / 13,
                min_clearance_m,
                clearance_m,
                path_length_m,
                goal_distance_m,
                collisions,
                goal_reached: u32::from(goal_distance_m < 0.3),
                kind: SourceKind::Simulation.code(),
                ..SourceStatus::zeroed()
            });
        }
    }
    record
}

fn step(record: &RunRecord, robot: &mut Robot, cycle: u64, people: usize, time_s: f64) -> SafeCommand {
    let due_ns = START_NS + cycle * PERIOD_NS;
    // A repeatable jitter with a rare long tail, so that the percentile curves have a shape.
    let noise = (cycle.wrapping_mul(2_654_435_761) >> 7) % 1_000;
    let woke_ns = due_ns + 60_000 + noise * 120 + if noise > 997 { 1_500_000 } else { 0 };
    let (sin, cos) = robot.heading.sin_cos();
    let velocity = [robot.speed * cos, robot.speed * sin];
    let (h, critical, sdf_m) = h_m(robot.position, velocity, people, time_s);
    let goal_distance = (GOAL_M[0] - robot.position[0]).hypot(GOAL_M[1] - robot.position[1]);
    let bearing = (GOAL_M[1] - robot.position[1]).atan2(GOAL_M[0] - robot.position[0]) - robot.heading;
    let nominal = [(0.8 * goal_distance).min(1.0), (1.5 * bearing).clamp(-0.8, 0.8)];

    let probe = 1e-4;
    let ahead = [robot.position[0] + probe * cos, robot.position[1] + probe * sin];
    let (lg_h, drift_mps) = if people == 0 {
        ([0.0; 2], 0.0)
    } else {
        let slope = (h_m(ahead, velocity, people, time_s).0 - h) / probe;
        ([slope, 0.25], (h_m(robot.position, velocity, people, time_s + probe).0 - h) / probe)
    };
    let rest = drift_mps + ALPHA_PER_S * h + lg_h[1] * nominal[1];
    let speed_limit = if lg_h[0] < 0.0 { (-rest / lg_h[0]).clamp(0.0, 1.0) } else { 1.0 };
    let best = rest.min(f64::MAX) + lg_h[0].max(0.0);
    let (mut control, mut status, mut reason) =
        ([nominal[0].min(speed_limit), nominal[1]], SafetyStatus::Filtered, Reason::None);
    let slack_mps = (-best).max(0.0);
    if slack_mps > 1e-3 {
        (status, reason) = (SafetyStatus::Relaxed, Reason::SlackNeeded);
    }
    if goal_distance < 0.3 {
        (status, reason) = (SafetyStatus::Stopped, Reason::StopRequested);
        control = [0.0; 2];
    } else if (12.0..12.4).contains(&time_s) {
        (status, reason) = (SafetyStatus::Braking, Reason::StaleDetections);
        control = [robot.speed * 0.98, 0.0];
    }
    robot.speed += (control[0] - robot.speed) * 0.08;
    robot.heading += control[1] * PERIOD_NS as f64 * 1e-9;
    let travelled = robot.speed * PERIOD_NS as f64 * 1e-9;
    let before = robot.position;
    robot.position = [before[0] + travelled * cos, before[1] + travelled * sin];

    let evaluated = matches!(status, SafetyStatus::Filtered | SafetyStatus::Relaxed);
    let or_far = |value: f64| if evaluated && people > 0 { value } else { f64::INFINITY };
    let wanted_ns = due_ns - due_ns % 50_000_000 - 1_000_000;
    let (state, seen) = (record.robot_states.last(), record.obstacles.last());
    SafeCommand {
        sequence: cycle + 1,
        control,
        nominal: if evaluated { nominal } else { [0.0; 2] },
        control_kind: ControlKind::Unicycle.code(),
        status: status.code(),
        reason: reason.code(),
        obstacle_count: if evaluated { people as u32 } else { 0 },
        h_m: or_far(h),
        sdf_m: or_far(sdf_m),
        drift_mps: if evaluated { drift_mps } else { 0.0 },
        lg_h: if evaluated { lg_h } else { [0.0; 2] },
        alpha_per_s: ALPHA_PER_S,
        slack_mps: if evaluated { slack_mps } else { 0.0 },
        hard_margin_mps: or_far(best),
        critical_track_id: critical.filter(|_| evaluated).map_or(0, |(index, _)| index as u64 + 1),
        critical_h_m: critical.filter(|_| evaluated).map_or(f64::INFINITY, |(_, h)| h),
        robot_position_in_odom_m: before,
        robot_heading_rad: robot.heading,
        ledger: Ledger {
            detections_source_ns: seen.map_or(0, |message| message.stamp.source_ns),
            detections_ingress_ns: seen.map_or(0, |message| message.stamp.ingress_ns),
            detections_published_ns: seen.map_or(0, |message| message.bridge_published_ns),
            estimator_received_ns: seen.map_or(0, |message| message.received_ns),
            estimator_published_ns: seen.map_or(0, |message| message.stamp.published_ns),
            robot_state_source_ns: state.map_or(0, |message| message.stamp.source_ns),
            robot_state_ingress_ns: state.map_or(0, |message| message.stamp.ingress_ns),
            robot_state_published_ns: state.map_or(0, |message| message.stamp.published_ns),

            nominal_received_ns: wanted_ns,
            nominal_published_ns: wanted_ns + 420_000 + (wanted_ns / 1_000) % 90_000,
            filter_due_ns: due_ns,
            filter_woke_ns: woke_ns,
            filter_computed_ns: woke_ns + 8_000 + noise * 8,
            filter_published_ns: woke_ns + 9_000 + noise * 8,
            ..Ledger::zeroed()
        },
        ..SafeCommand::zeroed()
    }
}
