//! The anticipation as an option of the filter: when its way is wished for, what the command then says, and that it costs no memory.

mod scene;

use allocation_counter::measure;
use bytemuck::Zeroable;
use cbf_filter::SafetyFilter;
use messages::{Goal, Reason, SafetyStatus};
use scene::{MS, START_NS, Scene, boxed_in, filter_with, person, settings, stamp, verdict};
use settings::AnticipationSettings;

const GOAL_M: [f64; 2] = [12.0, 0.0];

fn filter() -> SafetyFilter {
    let ahead = AnticipationSettings {
        horizon_s: 3.0,
        moments: 24,
        period_ms: 20,
        clearance_m: 0.8,
        clearance_growth_mps: 0.3,
        risk_weight: 20.0,
        turn_share: 0.05,
        trust_s: 1.0,
        negligible_risk_s: 0.02,
        cruise_speed_mps: 1.0,
        robot_max_speed_mps: None,
    };
    filter_with(|filter| filter.anticipation = Some(ahead.clone()))
}

/// The filter of the same settings without the table.
fn plain() -> SafetyFilter {
    filter_with(|filter| filter.anticipation = None)
}

/// `scene` with a goal in `odom`, m.
fn bound_for(position_in_odom_m: [f64; 2], mut scene: Scene) -> Scene {
    scene.goal = Some(Goal { stamp: stamp(START_NS), position_in_odom_m, ..Goal::zeroed() });
    scene
}

/// Somebody comes along the way, far enough for the barrier to be content.
fn far_ahead() -> Scene {
    Scene::fresh(&[person(1, [5.0, 0.1], [-1.0, 0.0], START_NS)], START_NS)
}

#[test]
fn somebody_on_the_way_is_evaded_before_the_barrier_asks_and_the_nominal_command_stays_on_record() {
    let scene = bound_for(GOAL_M, far_ahead());
    let without = scene.step(&mut plain(), START_NS);
    let with = scene.step(&mut filter(), START_NS);
    assert_eq!(without.control, without.nominal, "the barrier is content");
    assert_eq!(with.nominal, without.nominal);
    assert_ne!(with.control, with.nominal);
    assert_eq!(verdict(&with), (SafetyStatus::Filtered, Reason::None));
    assert_eq!((with.h_m, with.slack_mps), (without.h_m, 0.0));
}

#[test]
fn without_a_usable_goal_or_with_a_free_way_the_command_is_the_plain_filters_bit_for_bit() {
    let same = |scene: Scene| {
        let without = scene.step(&mut plain(), START_NS);
        let with = scene.step(&mut filter(), START_NS);
        assert_eq!(bytemuck::bytes_of(&with), bytemuck::bytes_of(&without));
    };
    same(far_ahead());
    same(bound_for([f64::NAN, 0.0], far_ahead()));
    same(boxed_in());
    let free = Scene::fresh(&[person(7, [4.0, 9.0], [0.6, 0.0], START_NS)], START_NS);
    same(bound_for(GOAL_M, free));
}

#[test]
fn where_no_control_meets_the_condition_the_way_ahead_is_taken_and_says_what_that_costs_the_row() {
    let command = bound_for(GOAL_M, boxed_in()).step(&mut filter(), START_NS);
    assert_eq!(verdict(&command), (SafetyStatus::Relaxed, Reason::JointEscape));
    assert!(command.hard_margin_mps < 0.0);
    let [a, b] = command.lg_h;
    let [v, w] = command.control;
    let held = command.drift_mps + a * v + b * w + command.alpha_per_s * command.h_m;
    assert!((command.slack_mps + held.min(0.0)).abs() < 1e-12, "{held} {command:?}");
    let settings = settings();
    for (axis, value) in command.control.into_iter().enumerate() {
        let range = settings.robot.control_min[axis]..=settings.robot.control_max[axis];
        assert!(range.contains(&value), "{command:?}");
    }
}

#[test]
fn a_planner_upstream_has_a_goal_of_its_own_and_is_taken_at_its_word() {
    for scene in [far_ahead, boxed_in] {
        let mut scene = bound_for(GOAL_M, scene());
        scene.nominal.as_mut().expect("fresh").controller = messages::Controller::Upstream.code();
        let without = scene.step(&mut plain(), START_NS);
        let with = scene.step(&mut filter(), START_NS);
        assert_eq!(bytemuck::bytes_of(&with), bytemuck::bytes_of(&without));
    }
}

#[test]
fn a_wish_to_stop_is_never_overruled() {
    let mut scene = bound_for(GOAL_M, far_ahead());
    let nominal = scene.nominal.as_mut().expect("fresh");
    nominal.intent = messages::Intent::Stop.code();
    let command = scene.step(&mut filter(), START_NS);
    assert_eq!(verdict(&command).1, Reason::StopRequested);
    assert!(command.control[0] < 0.8, "{command:?}");
}

#[test]
fn between_two_searches_the_manoeuvre_goes_on_and_a_clock_that_stands_still_does_no_harm() {
    let scene = bound_for(GOAL_M, far_ahead());
    let mut filter = filter();
    let first = scene.step(&mut filter, START_NS);
    let held = scene.step(&mut filter, START_NS + 4 * MS);
    assert_eq!(first.control, held.control);
    let again = scene.step(&mut filter, START_NS + 4 * MS);
    assert_eq!(first.control, again.control);
}

#[test]
fn no_cycle_allocates_whether_it_searches_or_holds() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let crowd: Vec<_> =
        (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 1.0], [0.0, -0.3], START_NS)).collect();
    let boxed_in = bound_for(GOAL_M, boxed_in());
    let crowd = bound_for(GOAL_M, Scene::fresh(&crowd, START_NS));
    let mut filter = filter();
    for round in 0..30_u64 {
        let allocations = measure(|| {
            for scene in [&boxed_in, &crowd] {
                scene.step(&mut filter, START_NS + round * MS);
            }
        });
        assert_eq!(allocations.count_total, 0, "round {round}");
    }
}
