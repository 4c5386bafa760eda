//! Synthetic ledgers whose latencies are known.

use bytemuck::Zeroable;
use latency::{Counts, Hop, MergeError, Recorder, Summary};
use messages::{Ledger, SafeCommand, Trigger};

const PERIOD_NS: u64 = 4_000_000;

/// Cycle `sequence` of a filter that is always `10·sequence` ns late and computes for 5 µs; a new frame every 5 cycles.
fn command(sequence: u64) -> SafeCommand {
    let due_ns = 1_000_000_000 + sequence * PERIOD_NS;
    let frame_ns = 1_000_000_000 + (sequence / 5) * 5 * PERIOD_NS - 1_000_000;
    SafeCommand {
        sequence,
        ledger: Ledger {
            detections_source_ns: 77,
            detections_ingress_ns: frame_ns,
            detections_published_ns: frame_ns + 1_000,
            estimator_received_ns: frame_ns + 3_000,
            estimator_published_ns: frame_ns + 6_000,
            robot_state_source_ns: 78,
            robot_state_ingress_ns: due_ns - 500_000,
            robot_state_published_ns: due_ns - 499_000,
            nominal_received_ns: frame_ns + 10_000,
            nominal_published_ns: frame_ns + 410_000,
            filter_due_ns: due_ns,
            filter_woke_ns: due_ns + 10 * sequence,
            filter_computed_ns: due_ns + 10 * sequence + 4_000,
            filter_published_ns: due_ns + 10 * sequence + 5_000,
            ..Ledger::zeroed()
        },
        ..SafeCommand::zeroed()
    }
}

fn summary_of(commands: &[SafeCommand]) -> Summary {
    Recorder::of(PERIOD_NS, commands).summary()
}

#[test]
fn every_hop_has_the_length_it_was_given() {
    let commands: Vec<_> = (5..1_005).map(command).collect();
    let summary = summary_of(&commands);
    assert_eq!(summary.counts, Counts { cycles: 1_000, ..Counts::default() });

    for (hop, count, length_ns) in [
        (Hop::Bridge, 200, 1_000),
        (Hop::BridgeToEstimator, 200, 2_000),
        (Hop::Estimator, 200, 3_000),
        (Hop::Nominal, 200, 400_000),
        (Hop::FilterCompute, 1_000, 4_000),
        (Hop::FilterHandOver, 1_000, 1_000),
        (Hop::FilterPeriod, 999, PERIOD_NS + 10),
    ] {
        let figures = summary.hop(hop);
        assert_eq!((figures.count, figures.min_ns, figures.max_ns), (count, length_ns, length_ns), "{hop}");
        assert_eq!((figures.p50_ns, figures.p99_9_ns), (length_ns, length_ns), "{hop}");
    }
    // The first use of frame k is cycle 5k: 1 ms after the frame came in, plus that cycle's lateness.
    let first_use = |offset_ns: u64| (offset_ns + 10 * 5, offset_ns + 10 * 1_000);
    for (hop, (min_ns, max_ns)) in [
        (Hop::EstimatorToFilter, first_use(1_000_000 - 6_000)),
        (Hop::NominalToFilter, first_use(1_000_000 - 410_000)),
        (Hop::EndToEnd, first_use(1_000_000 + 5_000)),
    ] {
        let figures = summary.hop(hop);
        assert_eq!((figures.count, figures.min_ns, figures.max_ns), (200, min_ns, max_ns), "{hop}");
    }
    let robot_state = summary.hop(Hop::RobotStateToFilter);
    assert_eq!((robot_state.count, robot_state.min_ns, robot_state.max_ns), (1_000, 500_050, 510_040));
}

#[test]
fn percentiles_of_a_ramp_are_right_to_three_digits_and_extremes_exact() {
    let commands: Vec<_> = (1..=10_000).map(command).collect();
    let lateness = summary_of(&commands).hop(Hop::FilterLateness);
    assert_eq!((lateness.count, lateness.min_ns, lateness.max_ns), (10_000, 10, 100_000));
    for (found_ns, exact_ns) in [
        (lateness.p50_ns, 50_000.0),
        (lateness.p90_ns, 90_000.0),
        (lateness.p99_ns, 99_000.0),
        (lateness.p99_9_ns, 99_900.0),
        (lateness.p99_99_ns, 99_990.0),
    ] {
        assert!((found_ns as f64 / exact_ns - 1.0).abs() < 1e-3, "{found_ns} against {exact_ns}");
    }
    let curve = Recorder::of(PERIOD_NS, &commands).curve(Hop::FilterLateness);
    assert!(
        curve
            .windows(2)
            .all(|pair| pair[0].quantile <= pair[1].quantile && pair[0].value_ns <= pair[1].value_ns)
    );
    assert_eq!(curve.last().map(|point| (point.quantile, point.value_ns)), Some((1.0, 100_000)));
}

#[test]
fn a_single_outlier_stays_in_the_maximum() {
    let mut commands: Vec<_> = (1..=5_000).map(command).collect();
    commands[2_500].ledger.filter_computed_ns = commands[2_500].ledger.filter_woke_ns + 7_200_000_000_001;
    let compute = summary_of(&commands).hop(Hop::FilterCompute);
    assert!(compute.p99_9_ns.abs_diff(4_000) <= 4, "{}", compute.p99_9_ns);
    assert_eq!(compute.max_ns, 7_200_000_000_001);
}

#[test]
fn losses_restarts_repetitions_and_misses_are_counted() {
    let mut commands: Vec<_> = (1..=3).map(command).collect();
    commands.extend([command(7), command(7), command(8)]);
    let mut late = command(9);
    late.ledger.filter_woke_ns = late.ledger.filter_due_ns + PERIOD_NS + 1;
    late.ledger.filter_published_ns = late.ledger.filter_woke_ns + 5_000;
    let mut restarted = command(10);
    restarted.sequence = 1;
    commands.extend([late, restarted]);

    let summary = summary_of(&commands);
    let found = summary.counts;
    assert_eq!((found.cycles, found.lost_commands, found.restarts, found.deadline_misses), (7, 3, 1, 1));
    assert_eq!(summary.hop(Hop::FilterPeriod).count, 4, "1-2, 2-3, 7-8, 8-9");
}

#[test]
fn due_times_that_a_late_timer_skipped_are_missed_and_their_lateness_counts() {
    let mut commands: Vec<_> = (1..=5).map(command).collect();
    // The timer woke 2.5 periods late and took its newest due time: two passed without a cycle.
    let mut after_sleep = command(8);
    after_sleep.sequence = 6;
    after_sleep.ledger.filter_skipped = 2;
    after_sleep.ledger.filter_woke_ns = after_sleep.ledger.filter_due_ns + PERIOD_NS / 2;
    let mut next = command(9);
    next.sequence = 7;
    commands.extend([after_sleep, next]);
    let summary = summary_of(&commands);
    let found = summary.counts;
    assert_eq!((found.cycles, found.skipped, found.deadline_misses, found.lost_commands), (7, 2, 2, 0));
    assert_eq!(found.deadlines_kept(), Some(7.0 / 9.0), "nine due times, two without a cycle");
    assert_eq!(summary.hop(Hop::FilterLateness).max_ns, 5 * PERIOD_NS / 2);
    assert_eq!(summary.hop(Hop::FilterPeriod).max_ns, 7 * PERIOD_NS / 2 - 10 * 5, "cycle 5 to the late one");
}

#[test]
fn a_cycle_that_an_input_began_has_neither_lateness_nor_period() {
    let mut commands: Vec<_> = (1..=3).map(command).collect();
    let mut event = command(3);
    event.sequence = 4;
    event.ledger.filter_trigger = Trigger::Event.code();
    event.ledger.filter_woke_ns += 1_000_000;
    event.ledger.filter_due_ns = event.ledger.filter_woke_ns;
    event.ledger.filter_computed_ns = event.ledger.filter_woke_ns + 4_000;
    let mut after = command(4);
    after.sequence = 5;
    commands.extend([event, after]);
    let summary = summary_of(&commands);
    let found = summary.counts;
    assert_eq!((found.cycles, found.event_cycles, found.deadline_misses), (5, 1, 0));
    assert_eq!(summary.hop(Hop::FilterCompute).count, 5);
    let lateness = summary.hop(Hop::FilterLateness);
    assert_eq!((lateness.count, lateness.min_ns), (4, 10), "an event's zero is no lateness");
    let period = summary.hop(Hop::FilterPeriod);
    assert_eq!((period.count, period.min_ns, period.max_ns), (3, PERIOD_NS + 10, PERIOD_NS + 10));
}

#[test]
fn what_was_taken_aside_is_not_counted_again() {
    let commands: Vec<_> = (5..105).map(command).collect();
    let mut recorder = Recorder::of(PERIOD_NS, &commands[..52]);
    let before = recorder.take();
    commands[52..].iter().for_each(|command| recorder.record(command));
    let after = recorder.summary();
    assert_eq!((before.counts.cycles, after.counts.cycles, after.counts.lost_commands), (52, 48, 0));
    assert_eq!((before.hop(Hop::EndToEnd).count, after.hop(Hop::EndToEnd).count), (11, 9), "20 frames");
    assert_eq!(after.hop(Hop::FilterPeriod).count, 48, "the period across the cut is whole");
    assert_eq!(after.hop(Hop::FilterLateness).min_ns, 570);
}

#[test]
fn stamps_that_never_came_and_stretches_that_run_backwards_are_no_latencies() {
    let mut early = command(1);
    early.ledger =
        Ledger { filter_due_ns: 10, filter_woke_ns: 20, filter_published_ns: 30, ..Ledger::zeroed() };
    let mut backwards = command(2);
    backwards.ledger.detections_published_ns = backwards.ledger.detections_ingress_ns - 1;
    let summary = summary_of(&[early, backwards]);
    assert_eq!(summary.hop(Hop::Estimator).count, 1);
    assert_eq!((summary.hop(Hop::Bridge).count, summary.hop(Hop::Bridge).negative), (0, 1));
    assert!(summary.to_string().contains("(1 negative)"));
}

#[test]
fn heartbeats_of_the_estimator_do_not_count_a_frame_again() {
    let first = command(5);
    let mut second = command(6);
    second.ledger.estimator_published_ns += 50_000;
    assert_eq!(first.ledger.detections_ingress_ns, second.ledger.detections_ingress_ns);
    assert_eq!(summary_of(&[first, second]).hop(Hop::EstimatorToFilter).count, 1);
}

#[test]
fn merged_runs_equal_one_long_run() {
    let commands: Vec<_> = (5..1_005).map(command).collect();
    let whole = summary_of(&commands);
    let mut merged = Recorder::of(PERIOD_NS, &commands[..500]);
    merged.merge(&Recorder::of(PERIOD_NS, &commands[500..])).expect("same period");
    let merged = merged.summary();
    for hop in [Hop::Bridge, Hop::EndToEnd, Hop::FilterLateness, Hop::FilterCompute] {
        assert_eq!(merged.hop(hop), whole.hop(hop));
    }
    assert_eq!(merged.hop(Hop::FilterPeriod).count, whole.hop(Hop::FilterPeriod).count - 1);

    let other = Recorder::new(PERIOD_NS + 1);
    assert_eq!(
        Recorder::new(PERIOD_NS).merge(&other),
        Err(MergeError { ours_ns: PERIOD_NS, theirs_ns: PERIOD_NS + 1 })
    );
}

#[test]
fn a_summary_survives_json_and_an_empty_one_prints() {
    let summary = summary_of(&(1..=100).map(command).collect::<Vec<_>>());
    let text = serde_json::to_string(&summary).expect("plain figures");
    assert!(text.contains("\"end_to_end\"") && text.contains("\"p99_9_ns\""), "{text}");
    assert_eq!(serde_json::from_str::<Summary>(&text).expect("own text"), summary);

    let empty = Recorder::new(PERIOD_NS).summary().to_string();
    assert!(empty.contains("0 filter cycles of 4.000 ms"), "{empty}");
}

#[test]
fn an_input_that_comes_while_a_cycle_begins_waits_for_nothing() {
    let mut command = command(5);
    let woke_ns = command.ledger.filter_woke_ns;
    command.ledger.estimator_published_ns = woke_ns + 800;
    let hop = summary_of(&[command]).hop(Hop::EstimatorToFilter);
    assert_eq!((hop.count, hop.max_ns, hop.negative), (1, 0, 0));
    command.ledger.estimator_published_ns = command.ledger.filter_published_ns + 1;
    let hop = summary_of(&[command]).hop(Hop::EstimatorToFilter);
    assert_eq!((hop.count, hop.negative), (0, 1), "sent after the command that used it");
}
