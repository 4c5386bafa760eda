//! A step of the world allocates nothing.

use allocation_counter::measure;
use crowd_sim::{PlantSettings, ScenarioRequest, World};

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
