//! What the filter did, told for moments that are known.

mod synthetic;

use messages::{Reason, SafetyStatus};
use report::{Constraint, ExplainError, RunRecord, Rung, explain};
use synthetic::BETA_PER_M;

/// A robot at the origin looking along +y, one person 2 m ahead of it who walks towards it at 1 m/s.
fn head_on() -> RunRecord {
    let mut record = synthetic::run(3.0, 2);
    for command in &mut record.safe_commands {
        command.ledger.filter_woke_ns = command.ledger.filter_due_ns;
        command.robot_position_in_odom_m = [0.0, 0.0];
        command.robot_heading_rad = core::f64::consts::FRAC_PI_2;
    }
    let index = 375; // at 1.5 s
    let woke_ns = record.safe_commands[index].ledger.filter_woke_ns;
    let mut seen = *record.obstacles.last().expect("obstacles");
    seen.stamp.published_ns = woke_ns - 1_000_000;
    let person = &mut seen.items[1];
    person.position_in_odom_m = [0.0, 2.1];
    person.velocity_in_odom_mps = [0.0, -1.0];
    person.speed_mps = 1.0;
    person.valid_at_ns = woke_ns - 100_000_000;
    record.obstacles.retain(|message| message.stamp.published_ns < seen.stamp.published_ns);
    record.obstacles.push(seen);
    let mut state = *record.robot_states.last().expect("states");
    state.stamp.valid_at_ns = woke_ns;
    state.heading_rad = core::f64::consts::FRAC_PI_2;
    state.velocity_in_base_mps = [0.5, 0.0];
    record.robot_states.retain(|state| state.stamp.valid_at_ns < woke_ns);
    record.robot_states.push(state);

    let command = &mut record.safe_commands[index];
    command.status = SafetyStatus::Filtered.code();
    command.reason = Reason::None.code();
    (command.h_m, command.sdf_m, command.critical_h_m) = (0.10, 1.3, 0.15);
    (command.drift_mps, command.lg_h, command.alpha_per_s) = (-0.2, [-1.0, 0.5], 4.0);
    (command.nominal, command.control) = ([1.0, 0.2], [0.3, 0.2]);
    (command.slack_mps, command.hard_margin_mps) = (0.0, 0.6);
    command.critical_track_id = 2;
    command.ledger.estimator_published_ns = seen.stamp.published_ns;
    command.ledger.detections_ingress_ns = woke_ns - 90_000_000;
    command.ledger.robot_state_ingress_ns = woke_ns - 3_500_000;
    command.ledger.nominal_published_ns = 0;
    record
}

#[test]
fn the_terms_add_up_and_the_obstacle_is_where_it_was() {
    let told = explain(&head_on(), 1.5).expect("within the run");
    assert_eq!((told.time_s, told.sequence, told.status), (1.5, 376, Rung::Filtered));
    let barrier = told.barrier.expect("filtered");
    let near =
        |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
    near(barrier.lg_h_u_mps, -0.2);
    near(barrier.alpha_h_mps, 0.4);
    near(barrier.condition_mps, 0.0);
    near(barrier.condition_nominal_mps, -0.7);
    assert_eq!(barrier.constraint, Constraint::Active);
    near(told.correction, 0.7);

    let critical = told.critical.as_ref().expect("there is one");
    assert_eq!(critical.track_id, 2);
    near(critical.share, (-BETA_PER_M * 0.05).exp());
    let place = critical.place.as_ref().expect("recorded");
    near(place.distance_m, 2.0); // 2.1 m, 0.1 s ago, at 1 m/s
    near(place.position_in_base_m[0], 2.0);
    near(place.position_in_base_m[1], 0.0);
    near(place.clearance_m, 1.3);
    near(place.closing_speed_mps.expect("robot state"), 1.5);
    assert_eq!(
        (told.ages.detections_ms, told.ages.robot_state_ms, told.ages.nominal_ms),
        (Some(90.0), Some(3.5), None)
    );
    assert!(told.before.is_some() && told.after.is_some());

    let text = told.to_string();
    for part in [
        "moved onto its boundary",
        "pedestrian ahead",
        "closing at 1.50 m/s",
        "nominal command none yet",
        "81.9 %",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}

#[test]
fn every_fate_of_the_constraint_is_told_apart() {
    let mut record = head_on();
    let fate = |record: &RunRecord| {
        explain(record, 1.5).expect("within the run").barrier.map(|terms| terms.constraint)
    };
    record.safe_commands[375].drift_mps = 5.0;
    assert_eq!(fate(&record), Some(Constraint::Inactive));
    record.safe_commands[375].status = SafetyStatus::Relaxed.code();
    assert_eq!(fate(&record), Some(Constraint::Violated));
    record.safe_commands[375].h_m = f64::INFINITY;
    assert_eq!(fate(&record), Some(Constraint::Absent));
    record.safe_commands[375].status = SafetyStatus::Braking.code();
    record.safe_commands[375].reason = Reason::SilentEstimator.code();
    assert_eq!(fate(&record), None);
    let text = explain(&record, 1.5).expect("within the run").to_string();
    assert!(text.contains("the estimator has fallen silent") && text.contains("not evaluated"), "{text}");
}

#[test]
fn json_has_null_where_a_number_would_be_infinite() {
    let record = synthetic::run(3.0, 0);
    let json = serde_json::to_value(explain(&record, 1.0).expect("within the run")).expect("serialisable");
    assert!(json["barrier"]["h_m"].is_null() && json["critical"].is_null(), "{json}");
    assert_eq!(json["barrier"]["constraint"], "absent");
    assert_eq!(json["status"], "filtered");
}

#[test]
fn times_outside_the_run_and_empty_runs_are_refused_with_the_limits() {
    let mut record = synthetic::run(3.0, 1);
    let end_s = record.duration_s();
    assert!(explain(&record, 0.0).is_ok() && explain(&record, end_s).is_ok());
    for asked_s in [-0.5, end_s + 0.1, f64::NAN, f64::INFINITY] {
        let refused = explain(&record, asked_s).expect_err("outside").to_string();
        assert!(refused.contains(&format!("{end_s:.3} s")), "{refused}");
    }
    record.safe_commands.clear();
    assert_eq!(explain(&record, 0.0), Err(ExplainError::NoCommands));
}

#[test]
fn a_code_from_a_newer_version_is_named_not_hidden() {
    let mut record = head_on();
    record.safe_commands[375].reason = 4_711;
    assert!(explain(&record, 1.5).expect("within the run").to_string().contains("4711"));
}
