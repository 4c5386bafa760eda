//! The crowd against an independent numpy implementation (`tests/judges/social_force_reference.py`).

use crowd_sim::{Crowd, Person, SocialForce};
use serde::Deserialize;

#[derive(Deserialize)]
struct Reference {
    dt_s: f64,
    keep_every: usize,
    goal_switches: usize,
    position_m: Vec<[f64; 2]>,
    goals_m: Vec<Vec<[f64; 2]>>,
    desired_speed_mps: Vec<f64>,
    goal_radius_m: Vec<f64>,
    positions_m: Vec<Vec<[f64; 2]>>,
    velocities_mps: Vec<Vec<[f64; 2]>>,
}

fn reference() -> Reference {
    let text = include_str!("../../../tests/data/social_force_reference.json");
    serde_json::from_str(text).expect("the stored reference is valid JSON")
}

fn people(reference: &Reference) -> Vec<Person> {
    (0..reference.position_m.len())
        .map(|i| Person {
            id: i as u64 + 1,
            position_m: reference.position_m[i],
            goals_m: reference.goals_m[i].clone(),
            goal_radius_m: reference.goal_radius_m[i],
            desired_speed_mps: reference.desired_speed_mps[i],
            radius_m: 0.35,
        })
        .collect()
}

#[test]
fn ten_people_walk_as_in_the_numpy_reference_for_ten_seconds() {
    let reference = reference();
    assert!(reference.goal_switches >= 10, "the scene exercises goal switching");
    let mut crowd = Crowd::new(SocialForce::HUNAVSIM, &people(&reference));
    let mut worst: f64 = 0.0;
    for (kept, (positions_m, velocities_mps)) in
        reference.positions_m.iter().zip(&reference.velocities_mps).enumerate()
    {
        if kept > 0 {
            (0..reference.keep_every).for_each(|_| crowd.step(reference.dt_s));
        }
        for i in 0..crowd.len() {
            for k in 0..2 {
                worst = worst.max((crowd.position_m(i)[k] - positions_m[i][k]).abs());
                worst = worst.max((crowd.velocity_mps(i)[k] - velocities_mps[i][k]).abs());
            }
        }
        assert!(worst < 1e-9, "differs by {worst:e} after {kept} kept states");
    }
    assert_eq!(reference.positions_m.len(), 101);
    println!("largest difference {worst:e}");
}
