//! Scenarios: reproducible draws, the promises of the generator, and what validation refuses.

use crowd_sim::{GenerateError, Motion, Person, RobotLimits, Scenario, ScenarioError, ScenarioRequest};
use settings::{ClassName, ClassesSettings};

const MIXED: ClassesSettings = ClassesSettings {
    cyclist_share: 0.3,
    cyclist_speed_mps: [2.0, 4.0],
    cyclist_radius_m: 0.5,
    static_share: 0.2,
    static_radius_m: 0.25,
};

fn mixed(seed: u64, count: usize) -> Scenario {
    let request = ScenarioRequest { classes: Some(MIXED), ..ScenarioRequest::evaluation(seed, count) };
    request.generate().expect("a few people fit")
}

#[test]
fn the_same_seed_gives_the_same_people_on_every_machine() {
    let scenario = ScenarioRequest::demo(1).generate().unwrap();
    assert_eq!(scenario, ScenarioRequest::demo(1).generate().unwrap());
    assert_ne!(scenario.people, ScenarioRequest::demo(2).generate().unwrap().people);
    // Written down once; a change means that every published scenario has changed.
    let Motion::SocialForce { position_m, desired_speed_mps, .. } = scenario.people[0].motion else {
        panic!("walks by forces")
    };
    assert_eq!(
        (position_m, desired_speed_mps),
        ([1.455_516_035_216_825_3, -1.809_418_128_578_201_4], 0.733_749_567_240_483)
    );
}

#[test]
fn people_start_inside_the_arena_apart_from_each_other_and_from_the_robot() {
    for seed in 0..50 {
        let request = ScenarioRequest { count: 20, ..ScenarioRequest::demo(seed) };
        let scenario = request.generate().unwrap();
        assert_eq!(scenario.people.len(), 20);
        for (i, person) in scenario.people.iter().enumerate() {
            let Motion::SocialForce { position_m, goals_m, desired_speed_mps, .. } = &person.motion else {
                panic!("walks by forces")
            };
            assert!(request.arena.contains(*position_m));
            assert!(goals_m.len() == 3 && goals_m.iter().all(|goal| request.arena.contains(*goal)));
            assert!((0.6..=1.2).contains(desired_speed_mps));
            let distance = |to: [f64; 2]| (position_m[0] - to[0]).hypot(position_m[1] - to[1]);
            assert!(distance(request.start.position_m) >= request.clear_of_start_m);
            assert!(scenario.people[..i].iter().all(|other| distance(other.start_m()) >= 0.7));
        }
    }
}

#[test]
fn a_smaller_crowd_is_the_beginning_of_a_larger_one() {
    let few = ScenarioRequest { count: 5, ..ScenarioRequest::demo(3) }.generate().unwrap();
    let many = ScenarioRequest { count: 15, ..ScenarioRequest::demo(3) }.generate().unwrap();
    assert_eq!(few.people, many.people[..5]);
}

#[test]
fn a_mixed_crowd_has_its_shares_and_each_class_moves_in_its_way() {
    let mut counts = [0_usize; 3];
    for seed in 0..100 {
        let scenario = mixed(seed, 20);
        for (index, person) in scenario.people.iter().enumerate() {
            let from_m = |to: [f64; 2]| (person.start_m()[0] - to[0]).hypot(person.start_m()[1] - to[1]);
            let apart = |other: &Person| from_m(other.start_m()) >= other.radius_m + person.radius_m;
            assert!(scenario.people[..index].iter().all(apart) && from_m(scenario.start.position_m) >= 2.0);
            let class = match (person.class, &person.motion) {
                (ClassName::Pedestrian, Motion::SocialForce { desired_speed_mps, .. }) => {
                    assert!((0.8..=1.5).contains(desired_speed_mps) && person.radius_m == 0.35);
                    0
                }
                (ClassName::Cyclist, Motion::Bounce { velocity_mps: [x, y], .. }) => {
                    assert!((2.0..=4.0).contains(&x.hypot(*y)) && person.radius_m == 0.5);
                    1
                }
                (ClassName::Static, Motion::Bounce { velocity_mps, .. }) => {
                    assert!(*velocity_mps == [0.0, 0.0] && person.radius_m == 0.25);
                    assert!(from_m(scenario.goal_m) >= 2.0, "nothing stands on the goal");
                    2
                }
                other => panic!("{other:?}"),
            };
            counts[class] += 1;
        }
    }
    // Of 2,000 the standard deviations are 22, 20 and 18.
    for (count, expected) in counts.into_iter().zip([1_000, 600, 400]) {
        assert!(count.abs_diff(expected) < 100, "{counts:?}");
    }
}

#[test]
fn mixed_crowds_are_reproducible_and_begin_with_the_smaller_ones() {
    assert_eq!(mixed(3, 15), mixed(3, 15));
    assert_eq!(mixed(3, 5).people, mixed(3, 15).people[..5]);
    // A mixture without others is a crowd of pedestrians.
    let nobody = ClassesSettings { cyclist_share: 0.0, static_share: 0.0, ..MIXED };
    let request = ScenarioRequest { classes: Some(nobody), ..ScenarioRequest::evaluation(3, 15) };
    assert_eq!(request.generate(), ScenarioRequest::evaluation(3, 15).generate());
    let upside_down = ClassesSettings { cyclist_speed_mps: [4.0, 2.0], ..MIXED };
    let request = ScenarioRequest { classes: Some(upside_down), ..ScenarioRequest::demo(1) };
    assert!(matches!(request.generate(), Err(GenerateError::BadSpeedRange(_))));
}

#[test]
fn a_full_arena_is_reported_instead_of_drawing_forever() {
    let request = ScenarioRequest { count: 1_000, ..ScenarioRequest::demo(1) };
    assert!(matches!(request.generate(), Err(GenerateError::NoRoom { placed: 50.., count: 1_000, .. })));
    let request = ScenarioRequest { count: usize::MAX, ..ScenarioRequest::demo(1) };
    assert!(matches!(request.generate(), Err(GenerateError::Scenario(ScenarioError::TooMany { .. }))));
}

#[test]
fn a_speed_range_upside_down_is_refused() {
    let request = ScenarioRequest { desired_speed_mps: [1.2, 0.6], ..ScenarioRequest::demo(1) };
    assert!(matches!(request.generate(), Err(GenerateError::BadSpeedRange(_))));
}

#[test]
fn scenarios_survive_toml_bit_for_bit() {
    let scenario = ScenarioRequest::demo(9).generate().unwrap();
    let text = toml::to_string(&scenario).unwrap();
    assert_eq!(toml::from_str::<Scenario>(&text).unwrap(), scenario);
}

#[test]
fn an_unknown_key_in_a_scenario_is_refused() {
    let scenario = ScenarioRequest::demo(9).generate().unwrap();
    let text = format!("sead = 1\n{}", toml::to_string(&scenario).unwrap());
    assert!(toml::from_str::<Scenario>(&text).unwrap_err().to_string().contains("sead"));
}

fn demo() -> Scenario {
    ScenarioRequest::demo(1).generate().expect("the demo fits its arena")
}

fn goals(person: &mut Person) -> &mut Vec<[f64; 2]> {
    match &mut person.motion {
        Motion::SocialForce { goals_m, .. } => goals_m,
        Motion::Bounce { .. } | Motion::Track { .. } => panic!("walks by forces"),
    }
}

/// The refusal of the demo with the first person moving by `motion`.
fn refusal(motion: Motion) -> ScenarioError {
    let mut scenario = demo();
    scenario.people[0].motion = motion;
    scenario.validate().expect_err("cannot be run")
}

#[test]
fn a_track_needs_a_position_for_each_of_at_least_two_times() {
    for (times_s, positions_m) in
        [(vec![], vec![]), (vec![0.0], vec![[0.0; 2]]), (vec![0.0, 1.0], vec![[0.0; 2]])]
    {
        let refused = refusal(Motion::Track { times_s, positions_m });
        assert!(matches!(refused, ScenarioError::UnevenTrack { .. }), "{refused}");
    }
}

#[test]
fn the_times_of_a_track_rise() {
    let refused =
        refusal(Motion::Track { times_s: vec![0.0, 1.0, 1.0], positions_m: vec![[0.0; 2]; 3] }).to_string();
    assert!(refused.contains("people[0].motion.track.times_s[2]") && refused.contains("rise"), "{refused}");
}

#[test]
fn who_bounces_off_walls_starts_between_them() {
    let refused = refusal(Motion::Bounce { position_m: [0.0, 4.1], velocity_mps: [1.0, 0.0] }).to_string();
    assert!(refused.contains("people[0].motion.bounce.position_m") && refused.contains("arena"), "{refused}");
}

#[test]
fn nobody_is_faster_than_anything() {
    let refused = refusal(Motion::Bounce { position_m: [1.0, 0.0], velocity_mps: [1e200, 0.0] });
    assert!(matches!(refused, ScenarioError::TooLarge { .. }), "{refused}");
}

#[test]
fn a_robot_that_could_not_be_stopped_is_refused() {
    let limits = RobotLimits { input_min: [0.25, -0.8], input_max: [1.0, 0.8], axis_speed_mps: None };
    let refused = Scenario { robot_limits: Some(limits), ..demo() }.validate().unwrap_err();
    assert!(matches!(refused, ScenarioError::BadLimits { .. }), "{refused}");
}

#[test]
fn a_name_can_be_a_part_of_a_file_name() {
    for name in ["", "a b", "a:b", "../etc", "ü", &"x".repeat(65)] {
        let refused = Scenario { name: name.to_owned(), ..demo() }.validate();
        assert!(refused.is_err(), "{name}");
    }
}

#[test]
fn a_negative_radius_is_refused_by_name() {
    let mut scenario = demo();
    scenario.people[3].radius_m = -0.1;
    let message = scenario.validate().unwrap_err().to_string();
    assert!(message.contains("people[3].radius_m") && message.contains("greater than zero"), "{message}");
}

#[test]
fn a_position_that_is_not_finite_is_refused_by_name() {
    let mut scenario = demo();
    goals(&mut scenario.people[0])[1][0] = f64::NAN;
    assert!(scenario.validate().unwrap_err().to_string().contains("people[0].motion.social_force.goals_m"));
}

#[test]
fn a_person_without_goals_is_refused() {
    let mut scenario = demo();
    goals(&mut scenario.people[4]).clear();
    assert_eq!(scenario.validate(), Err(ScenarioError::NoGoals { id: 5 }));
}

#[test]
fn an_identity_taken_twice_is_refused() {
    let mut scenario = demo();
    scenario.people[4].id = 2;
    assert_eq!(scenario.validate(), Err(ScenarioError::BadId { id: 2 }));
}

#[test]
fn an_empty_arena_is_refused() {
    let mut scenario = demo();
    scenario.arena.x_m = [3.0, 3.0];
    assert!(matches!(scenario.validate(), Err(ScenarioError::EmptyArena(_))));
}
