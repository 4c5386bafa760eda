//! Scenarios: reproducible draws, the promises of the generator, and what validation refuses.

use crowd_sim::{GenerateError, Scenario, ScenarioError, ScenarioRequest};

#[test]
fn the_same_seed_gives_the_same_people_on_every_machine() {
    let scenario = ScenarioRequest::demo(1).generate().unwrap();
    assert_eq!(scenario, ScenarioRequest::demo(1).generate().unwrap());
    assert_ne!(scenario.people, ScenarioRequest::demo(2).generate().unwrap().people);
    // Written down once; a change means that every published scenario has changed.
    let first = &scenario.people[0];
    assert_eq!(
        (first.position_m, first.desired_speed_mps),
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
            assert!(request.arena.contains(person.position_m));
            assert!(
                person.goals_m.len() == 3 && person.goals_m.iter().all(|goal| request.arena.contains(*goal))
            );
            assert!((0.6..=1.2).contains(&person.desired_speed_mps));
            let distance = |to: [f64; 2]| (person.position_m[0] - to[0]).hypot(person.position_m[1] - to[1]);
            assert!(distance(request.start.position_m) >= request.clear_of_start_m);
            assert!(scenario.people[..i].iter().all(|other| distance(other.position_m) >= 0.7));
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
fn a_full_arena_is_reported_instead_of_drawing_forever() {
    let request = ScenarioRequest { count: 1_000, ..ScenarioRequest::demo(1) };
    assert!(matches!(request.generate(), Err(GenerateError::NoRoom { placed: 50.., count: 1_000, .. })));
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
    scenario.people[0].goals_m[1][0] = f64::NAN;
    assert!(scenario.validate().unwrap_err().to_string().contains("people[0].goals_m"));
}

#[test]
fn a_person_without_goals_is_refused() {
    let mut scenario = demo();
    scenario.people[4].goals_m.clear();
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
