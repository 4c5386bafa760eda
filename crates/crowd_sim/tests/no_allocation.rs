//! A step of the world allocates nothing.

use allocation_counter::measure;
use crowd_sim::{CrowdKind, Motion, Person, PlantSettings, ScenarioRequest, World};
use settings::ClassName;

#[test]
fn a_step_allocates_nothing() {
    let scenario = ScenarioRequest { count: 20, ..ScenarioRequest::demo(1) }.generate().unwrap();
    let mut world = World::new(&scenario, PlantSettings::ground_robot()).unwrap();
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let of_stepping = measure(|| {
        for _ in 0..5_000 {
            world.step(0.004, [0.8, 0.1]).unwrap();
        }
    });
    assert_eq!(of_stepping.count_total, 0);
}

#[test]
fn neither_does_one_of_a_mixed_crowd_around_a_slow_robot() {
    let mut scenario = ScenarioRequest { count: 10, ..ScenarioRequest::demo(1) }.generate().unwrap();
    let bounce = ScenarioRequest { count: 5, crowd: CrowdKind::Bounce, ..ScenarioRequest::demo(2) };
    scenario.people.extend(bounce.generate().unwrap().people);
    scenario.people.extend((0..5).map(|k| {
        let times_s: Vec<f64> = (0..100).map(|i| f64::from(k) + 0.05 * f64::from(i)).collect();
        let positions_m = times_s.iter().map(|time_s| [*time_s, 0.1 * f64::from(k)]).collect();
        Person {
            id: 1,
            radius_m: 0.3,
            class: ClassName::Pedestrian,
            motion: Motion::Track { times_s, positions_m },
        }
    }));
    scenario.people.iter_mut().zip(1..).for_each(|(person, id)| person.id = id);
    let plant = PlantSettings { delay_s: 0.1, lag_s: 0.1, ..PlantSettings::ground_robot() };
    let mut world = World::new(&scenario, plant).unwrap();
    let mut most = 0;
    let of_stepping = measure(|| {
        for k in 0..5_000 {
            world.step(0.004, [0.8, 0.001 * f64::from(k % 100)]).unwrap();
            most = most.max(world.people().len());
        }
    });
    assert_eq!((of_stepping.count_total, most), (0, 20));
}
