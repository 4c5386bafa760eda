//! The world as a whole: the common clock, independence of the crowd from the robot, and the ledger.

use crowd_sim::{
    Contact, CrowdKind, Motion, Person, PlantSettings, Rectangle, RobotLimits, Scenario, ScenarioRequest,
    StepError, World,
};
use settings::ClassName;

fn demo() -> Scenario {
    ScenarioRequest::demo(1).generate().expect("the demo fits its arena")
}

fn world(scenario: &Scenario) -> World {
    World::new(scenario, PlantSettings::ground_robot()).expect("the demo is valid")
}

#[test]
fn the_crowd_ignores_the_robot_and_the_control_period() {
    let scenario = demo();
    let (mut standing, mut driving) = (world(&scenario), world(&scenario));
    for k in 0..1000 {
        standing.step(0.01, [0.0, 0.0]).unwrap();
        for _ in 0..5 {
            driving.step(0.002, [1.0, if k % 200 < 100 { 0.2 } else { -0.2 }]).unwrap();
        }
        assert_eq!(standing.time_ns(), driving.time_ns());
        assert_eq!(standing.people(), driving.people(), "after {k} crowd periods");
    }
    assert_ne!(standing.robot(), driving.robot());
}

#[test]
fn people_move_on_straight_lines_between_the_crowds_ticks() {
    let scenario = demo();
    let mut world = world(&scenario);
    (0..50).for_each(|_| world.step(0.01, [0.0, 0.0]).unwrap());
    let before = world.people().to_vec();
    world.step(0.004, [0.0, 0.0]).unwrap();
    let between = world.people().to_vec();
    world.step(0.006, [0.0, 0.0]).unwrap();
    for ((a, m), b) in before.iter().zip(&between).zip(world.people()) {
        for k in 0..2 {
            let expected = a.position_m[k] + 0.4 * (b.position_m[k] - a.position_m[k]);
            assert!((m.position_m[k] - expected).abs() < 1e-12);
            assert!((m.velocity_mps[k] * 0.01 - (b.position_m[k] - a.position_m[k])).abs() < 1e-12);
        }
    }
}

#[test]
fn one_long_step_is_the_same_as_many_short_ones() {
    let scenario = demo();
    let (mut long, mut short) = (world(&scenario), world(&scenario));
    for _ in 0..20 {
        long.step(0.5, [0.8, 0.1]).unwrap();
        (0..50).for_each(|_| short.step(0.01, [0.8, 0.1]).unwrap());
    }
    assert_eq!(long.robot(), short.robot());
    assert_eq!(long.ledger(), short.ledger());
}

#[test]
fn time_stays_exact_over_an_hour_of_odd_steps() {
    let scenario = Scenario { people: Vec::new(), ..demo() };
    let mut world = world(&scenario);
    (0..1_000_000).for_each(|_| world.step(0.003_7, [0.0, 0.0]).unwrap());
    assert_eq!(world.time_ns(), 3_700_000_000_000);
}

#[test]
fn driving_straight_to_a_goal_is_accounted_for() {
    let scenario = Scenario { people: Vec::new(), ..demo() };
    let mut world = world(&scenario);
    assert_eq!(world.goal_distance_m(), 15.0);
    while !world.reached() {
        world.step(0.01, [1.0, 0.0]).unwrap();
    }
    // 15 m at 1 m/s, minus the tolerance of 0.3 m.
    assert!((14.69..14.72).contains(&(world.time_ns() as f64 * 1e-9)), "{} ns", world.time_ns());
    assert!((world.ledger().path_length_m() - world.time_ns() as f64 * 1e-9).abs() < 1e-9);
    assert_eq!(world.ledger().min_clearance_m(), f64::INFINITY);
    assert_eq!(world.ledger().reached_at_ns(), Some(world.time_ns()));
}

#[test]
fn running_somebody_over_is_one_collision() {
    let mut scenario = demo();
    scenario.people = vec![bouncing([9.0, 3.0], [0.0, 0.0], 1), bouncing([2.0, 0.3], [0.0, 0.0], 2)];
    let mut world = world(&scenario);
    (0..700).for_each(|_| world.step(0.01, [1.0, 0.0]).unwrap());
    assert_eq!(world.ledger().collisions(), 1);
    let Some(Contact { at_ns, person: 1 }) = world.ledger().first_contact() else { panic!("a contact") };
    // From −1.5 m at 1 m/s to where the discs of 0.7 m together touch beside each other.
    let expected_s = 3.5 - (0.7_f64 * 0.7 - 0.3 * 0.3).sqrt();
    assert!((at_ns as f64 * 1e-9 - expected_s).abs() < 0.011, "{at_ns} ns");
    assert!((world.ledger().min_clearance_m() - (0.3 - 0.7)).abs() < 1e-3);
    assert!(world.ledger().clearance_m() > 2.0);
}

#[test]
fn unusable_steps_leave_the_world_alone() {
    let scenario = demo();
    let mut world = world(&scenario);
    for dt_s in [0.0, -0.01, f64::NAN, f64::INFINITY, 1e-10, 1.5] {
        assert!(matches!(world.step(dt_s, [0.0, 0.0]), Err(StepError::BadStep { .. })), "{dt_s}");
    }
    let refused = world.step(0.01, [f64::NAN, 0.0]);
    assert!(matches!(refused, Err(StepError::NonFiniteControl { .. })));
    assert_eq!((world.time_ns(), world.robot().position_m), (0, [-1.5, 0.0]));
}

fn bouncing(position_m: [f64; 2], velocity_mps: [f64; 2], id: u64) -> Person {
    Person {
        id,
        radius_m: 0.35,
        class: ClassName::Pedestrian,
        motion: Motion::Bounce { position_m, velocity_mps },
    }
}

#[test]
fn people_on_a_track_are_there_while_it_lasts_and_at_no_moment_between_places() {
    let motion = Motion::Track {
        times_s: vec![1.0, 1.5, 2.004],
        positions_m: vec![[4.0, 0.0], [4.5, 0.0], [5.004, 0.0]],
    };
    let people = vec![Person { id: 7, radius_m: 0.3, class: ClassName::Pedestrian, motion }];
    let mut world = world(&Scenario { people, ..demo() });
    while world.time_ns() < 3_000_000_000 {
        world.step(0.002, [0.0, 0.0]).unwrap();
        let time_s = world.time_ns() as f64 * 1e-9;
        // Between the crowd's ticks, only who is there at both.
        let expected = (1.0..=2.0).contains(&time_s);
        assert_eq!(world.people().len(), usize::from(expected), "at {time_s} s");
        if let Some(person) = world.people().first() {
            assert_eq!((person.id, person.index), (7, 0));
            assert!((person.position_m[0] - (3.0 + time_s)).abs() < 1e-9 && person.velocity_mps[0] > 0.99);
            assert!((world.ledger().clearance_m() - (4.5 + time_s - 0.65)).abs() < 1e-9);
        } else {
            assert_eq!(world.ledger().clearance_m(), f64::INFINITY);
        }
    }
    assert!((world.ledger().min_clearance_m() - (5.5 - 0.65)).abs() < 1e-9);
}

#[test]
fn bouncing_people_stay_inside_at_their_speed() {
    let request = ScenarioRequest { crowd: CrowdKind::Bounce, ..ScenarioRequest::evaluation(5, 15) };
    let scenario = request.generate().unwrap();
    let speed = |[x, y]: [f64; 2]| x.hypot(y);
    let mut world = world(&scenario);
    let begin: Vec<f64> = world.people().iter().map(|person| speed(person.velocity_mps)).collect();
    assert!(begin.iter().all(|speed_mps| (0.8..=1.5).contains(speed_mps)), "{begin:?}");
    let arena = Rectangle { x_m: [-1e-9, 16.0 + 1e-9], y_m: [-5.0 - 1e-9, 5.0 + 1e-9] };
    let mut turned = 0;
    for _ in 0..6_000 {
        let before: Vec<_> = world.people().iter().map(|person| person.velocity_mps).collect();
        world.step(0.01, [0.0, 0.0]).unwrap();
        for (person, (before, begin)) in world.people().iter().zip(before.iter().zip(&begin)) {
            assert!(arena.contains(person.position_m), "{person:?}");
            assert!((speed(person.velocity_mps) - begin).abs() < 1e-12);
            turned += usize::from(person.velocity_mps != *before);
        }
    }
    assert!(turned > 50, "{turned} reflections");
}

#[test]
fn the_limits_of_a_scenario_hold_whatever_the_robot_is_told() {
    let limits = RobotLimits { input_min: [0.0, -0.1], input_max: [0.4, 0.1], axis_speed_mps: None };
    let scenario = Scenario { people: Vec::new(), robot_limits: Some(limits), ..demo() };
    let mut world = world(&scenario);
    (0..100).for_each(|_| world.step(0.01, [1.0, 0.5]).unwrap());
    assert!((world.ledger().path_length_m() - 0.4).abs() < 1e-6);
    assert!((world.robot().heading_rad - 0.1).abs() < 1e-12);
}
