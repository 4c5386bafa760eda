//! The verdict of runs with known figures.

mod synthetic;

use bytemuck::Zeroable;
use messages::{Reason, SafeCommand, SafetyStatus, SourceKind, SourceStatus};
use report::{INTERVENTION_TOLERANCE, Outcome, RunRecord, Verdict};
use synthetic::{PERIOD_NS, START_NS};

/// A run of `statuses.len()` cycles, exactly on time, all at h = 1 m with u = u_nom.
fn run_of(statuses: &[SafetyStatus]) -> RunRecord {
    let mut record = synthetic::run(0.0, 0);
    record.safe_commands = statuses.iter().zip(0..).map(|(status, cycle)| command(cycle, *status)).collect();
    record
}

fn command(cycle: u64, status: SafetyStatus) -> SafeCommand {
    let mut command = SafeCommand::zeroed();
    command.sequence = cycle + 1;
    command.status = status.code();
    command.reason = Reason::None.code();
    (command.h_m, command.sdf_m, command.hard_margin_mps) = (1.0, 1.5, 2.0);
    command.ledger.filter_due_ns = START_NS + cycle * PERIOD_NS;
    command.ledger.filter_woke_ns = command.ledger.filter_due_ns;
    command.ledger.filter_published_ns = command.ledger.filter_woke_ns + 10_000;
    command
}

#[test]
fn time_is_shared_among_the_rungs_and_silence_is_one_of_them() {
    use SafetyStatus::{Braking, Filtered, Relaxed, Stopped};
    let mut record = run_of(&[Filtered, Filtered, Relaxed, Braking, Stopped, Filtered, Filtered, Filtered]);
    // The filter falls silent for 10 periods before the last command: 5 are still held, 5 are silence.
    record.safe_commands[7].ledger.filter_woke_ns += 9 * PERIOD_NS;
    let shares = Verdict::of(&record).time_shares;
    let total = 17.0;
    let expected = [(2.0 + 1.0 + 5.0 + 1.0) / total, 1.0 / total, 1.0 / total, 1.0 / total, 5.0 / total];
    let found = [shares.filtered, shares.relaxed, shares.braking, shares.stopped, shares.silent];
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{shares:?}");
    }
}

#[test]
fn interventions_are_counted_once_through_short_pauses_and_only_above_the_tolerance() {
    let mut record = run_of(&[SafetyStatus::Filtered; 1_000]);
    let mut correct = |cycles: core::ops::Range<usize>, by: f64| {
        record.safe_commands[cycles].iter_mut().for_each(|command| command.control = [by, 0.0]);
    };
    correct(100..150, 0.3);
    correct(160..200, 0.5);
    correct(400..450, INTERVENTION_TOLERANCE * 0.99);
    correct(600..650, 0.2);
    record.safe_commands[700].control = [0.0, 9.0];
    record.safe_commands[700].status = SafetyStatus::Braking.code();

    let interventions = Verdict::of(&record).interventions;
    assert_eq!((interventions.count, interventions.largest_correction), (2, 0.5));
    assert!((interventions.time_share - 0.14).abs() < 1e-9, "{interventions:?}");
}

#[test]
fn extremes_come_from_evaluated_cycles_only_and_infinity_is_unknown() {
    let mut record = run_of(&[SafetyStatus::Filtered, SafetyStatus::Relaxed, SafetyStatus::Braking]);
    record.safe_commands[0].h_m = f64::INFINITY;
    record.safe_commands[1].slack_mps = 0.25;
    record.safe_commands[1].hard_margin_mps = -0.25;
    record.safe_commands[2].h_m = -7.0;
    let verdict = Verdict::of(&record);
    assert_eq!((verdict.min_h_m, verdict.max_slack_mps, verdict.infeasible_cycles), (Some(1.0), 0.25, 1));

    record.safe_commands.truncate(1);
    assert_eq!(Verdict::of(&record).min_h_m, None);
}

#[test]
fn the_source_decides_the_outcome_and_without_it_nothing_is_claimed() {
    let mut record = synthetic::run(20.0, 3);
    let verdict = Verdict::of(&record);
    assert_eq!(
        (verdict.outcome, verdict.reached, verdict.collisions),
        (Outcome::Reached, Some(true), Some(0))
    );
    let arrival =
        record.source_status.iter().position(|status| status.goal_reached == 1).expect("it arrives");
    assert_eq!(verdict.time_to_goal_s.map(|time_s| (10.0 * time_s).round() as usize), Some(arrival));

    if let Some(last) = record.source_status.last_mut() {
        last.collisions = 2;
    }
    assert_eq!(Verdict::of(&record).headline(), "2 collisions");
    record.source_status.truncate(3);
    assert_eq!(Verdict::of(&record).outcome, Outcome::NotReached);
    record.source_status.clear();
    let verdict = Verdict::of(&record);
    assert_eq!((verdict.outcome, verdict.reached, verdict.min_clearance_m), (Outcome::Unknown, None, None));
    assert!(
        verdict.path_length_m.is_some_and(|length_m| (13.0..14.0).contains(&length_m)),
        "from the robot states"
    );
}

#[test]
fn deadline_misses_and_lost_commands_are_told() {
    let mut record = run_of(&[SafetyStatus::Filtered; 100]);
    record.safe_commands[50].ledger.filter_woke_ns += PERIOD_NS + 1;
    record.safe_commands.remove(70);
    let verdict = Verdict::of(&record);
    assert_eq!((verdict.latency.counts.deadline_misses, verdict.latency.counts.lost_commands), (1, 1));
    assert_eq!(verdict.deadlines_kept(), Some(1.0 - 1.0 / 99.0));
    assert!(verdict.to_string().contains("1 deadline misses, 1 commands lost"), "{verdict}");
}

#[test]
fn a_restarted_source_does_not_hide_an_earlier_collision() {
    let mut record = run_of(&[SafetyStatus::Filtered; 100]);
    let last = SourceStatus::zeroed();
    let status = |elapsed_ns, collisions, min_clearance_m| SourceStatus {
        elapsed_ns,
        collisions,
        min_clearance_m,
        accepted: 10,
        ..last
    };
    record.source_status = vec![status(1, 0, 0.5), status(2, 1, -0.1), status(1, 0, 0.4), status(2, 0, 0.4)];
    let verdict = Verdict::of(&record);
    assert_eq!(
        (verdict.outcome, verdict.collisions, verdict.accepted_inputs),
        (Outcome::Collision, Some(1), Some(20))
    );
    assert_eq!(verdict.min_clearance_m, Some(-0.1));
}

#[test]
fn an_empty_run_has_a_verdict_too() {
    let verdict = Verdict::of(&synthetic::run(0.0, 0));
    assert_eq!((verdict.latency.counts.cycles, verdict.deadlines_kept(), verdict.duration_s), (0, None, 0.0));
    let json = serde_json::to_value(&verdict).expect("plain figures");
    assert!(json["min_h_m"].is_null());
    assert_eq!(serde_json::from_value::<Verdict>(json).expect("own text"), verdict);
}

#[test]
fn a_live_robot_does_not_tell_whom_it_touched() {
    let mut record = run_of(&[SafetyStatus::Filtered; 10]);
    for (kind, collisions, headline) in [
        (SourceKind::Ros2, None, "Goal reached, contacts unknown"),
        (SourceKind::Simulation, Some(0), "Goal reached, nobody touched"),
    ] {
        record.source_status =
            vec![SourceStatus { kind: kind.code(), goal_reached: 1, ..SourceStatus::zeroed() }];
        let verdict = Verdict::of(&record);
        assert_eq!((verdict.collisions, verdict.headline().as_str()), (collisions, headline));
    }
    for (goal_distance_m, headline) in
        [(f64::INFINITY, "No goal was told, contacts unknown"), (2.0, "Goal not reached, contacts unknown")]
    {
        let kind = SourceKind::Ros2.code();
        record.source_status = vec![SourceStatus { kind, goal_distance_m, ..SourceStatus::zeroed() }];
        assert_eq!(Verdict::of(&record).headline(), headline);
    }
}
