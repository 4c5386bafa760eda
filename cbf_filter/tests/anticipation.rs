//! The anticipation as an option of the filter: when its way is wished for, what the command then says, and that it costs no memory.

mod scene;

use allocation_counter::measure;
use bytemuck::Zeroable;
use cbf_filter::{Inputs, SafetyFilter, load_model};
use messages::{Goal, Reason, SafeCommand, SafetyStatus};
use node_runtime::Tick;
use scene::{MS, START_NS, Scene, person, settings, stamp};
use settings::AnticipationSettings;

fn filter() -> SafetyFilter {
    let mut settings = settings();
    settings.filter.anticipation = Some(AnticipationSettings {
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
    });
    let model = load_model(&settings.filter.model).expect("shipped model");
    SafetyFilter::new(&settings, &model).expect("shipped model fits shipped settings")
}

/// The filter of the same settings without the table.
fn plain() -> SafetyFilter {
    let mut settings = settings();
    settings.filter.anticipation = None;
    let model = load_model(&settings.filter.model).expect("shipped model");
    SafetyFilter::new(&settings, &model).expect("shipped model fits shipped settings")
}

fn goal(position_in_odom_m: [f64; 2]) -> Goal {
    Goal { stamp: stamp(START_NS), position_in_odom_m, ..Goal::zeroed() }
}

fn step(filter: &mut SafetyFilter, scene: &Scene, goal: Option<&Goal>, now_ns: u64) -> SafeCommand {
    let inputs = Inputs {
        robot_state: scene.robot_state.as_ref(),
        obstacles: scene.obstacles.as_ref(),
        nominal: scene.nominal.as_ref(),
        goal,
    };
    filter.step(&inputs, Tick::timer(now_ns, now_ns))
}

fn verdict(command: &SafeCommand) -> (SafetyStatus, Reason) {
    let status = SafetyStatus::try_from(command.status).expect("a known status");
    (status, Reason::try_from(command.reason).expect("a known reason"))
}

/// Somebody comes along the way, far enough for the barrier to be content.
fn far_ahead() -> Scene {
    Scene::fresh(&[person(1, [5.0, 0.1], [-1.0, 0.0], START_NS)], START_NS)
}

fn boxed_in() -> Scene {
    let people = [
        person(1, [0.75, 0.0], [-1.2, 0.0], START_NS),
        person(2, [0.4, 0.8], [-0.3, -1.2], START_NS),
        person(3, [0.4, -0.8], [-0.3, 1.2], START_NS),
    ];
    Scene::fresh(&people, START_NS)
}

#[test]
fn somebody_on_the_way_is_evaded_before_the_barrier_asks_and_the_nominal_command_stays_on_record() {
    let (scene, goal) = (far_ahead(), goal([12.0, 0.0]));
    let without = step(&mut plain(), &scene, Some(&goal), START_NS);
    let with = step(&mut filter(), &scene, Some(&goal), START_NS);
    assert_eq!(without.control, without.nominal, "the barrier is content");
    assert_eq!(with.nominal, without.nominal);
    assert_ne!(with.control, with.nominal);
    assert_eq!(verdict(&with), (SafetyStatus::Filtered, Reason::None));
    assert_eq!((with.h_m, with.slack_mps), (without.h_m, 0.0));
}

#[test]
fn without_a_usable_goal_or_with_a_free_way_the_command_is_the_plain_filters_bit_for_bit() {
    let same = |scene: Scene, goal: Option<&Goal>| {
        let without = step(&mut plain(), &scene, goal, START_NS);
        let with = step(&mut filter(), &scene, goal, START_NS);
        assert_eq!(bytemuck::bytes_of(&with), bytemuck::bytes_of(&without));
    };
    same(far_ahead(), None);
    same(far_ahead(), Some(&goal([f64::NAN, 0.0])));
    same(boxed_in(), None);
    let free = Scene::fresh(&[person(7, [4.0, 9.0], [0.6, 0.0], START_NS)], START_NS);
    same(free, Some(&goal([12.0, 0.0])));
}

#[test]
fn where_no_control_meets_the_condition_the_way_ahead_is_taken_and_says_what_that_costs_the_row() {
    let goal = goal([12.0, 0.0]);
    let command = step(&mut filter(), &boxed_in(), Some(&goal), START_NS);
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
    let goal = goal([12.0, 0.0]);
    for scene in [far_ahead, boxed_in] {
        let mut scene = scene();
        scene.nominal.as_mut().expect("fresh").controller = messages::Controller::Upstream.code();
        let without = step(&mut plain(), &scene, Some(&goal), START_NS);
        let with = step(&mut filter(), &scene, Some(&goal), START_NS);
        assert_eq!(bytemuck::bytes_of(&with), bytemuck::bytes_of(&without));
    }
}

#[test]
fn a_wish_to_stop_is_never_overruled() {
    let mut scene = far_ahead();
    let nominal = scene.nominal.as_mut().expect("fresh");
    nominal.intent = messages::Intent::Stop.code();
    let command = step(&mut filter(), &scene, Some(&goal([12.0, 0.0])), START_NS);
    assert_eq!(verdict(&command).1, Reason::StopRequested);
    assert!(command.control[0] < 0.8, "{command:?}");
}

#[test]
fn between_two_searches_the_manoeuvre_goes_on_and_a_clock_that_stands_still_does_no_harm() {
    let (scene, goal) = (far_ahead(), goal([12.0, 0.0]));
    let mut filter = filter();
    let first = step(&mut filter, &scene, Some(&goal), START_NS);
    let held = step(&mut filter, &scene, Some(&goal), START_NS + 4 * MS);
    assert_eq!(first.control, held.control);
    let again = step(&mut filter, &scene, Some(&goal), START_NS + 4 * MS);
    assert_eq!(first.control, again.control);
}

#[test]
fn no_cycle_allocates_whether_it_searches_or_holds() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let crowd: Vec<_> =
        (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 1.0], [0.0, -0.3], START_NS)).collect();
    let (boxed_in, crowd, goal) = (boxed_in(), Scene::fresh(&crowd, START_NS), goal([12.0, 0.0]));
    let mut filter = filter();
    for round in 0..30_u64 {
        let allocations = measure(|| {
            for scene in [&boxed_in, &crowd] {
                step(&mut filter, scene, Some(&goal), START_NS + round * MS);
            }
        });
        assert_eq!(allocations.count_total, 0, "round {round}");
    }
}
