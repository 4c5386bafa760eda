//! The crowd against an independent numpy implementation (`tests/judges/social_force_reference.py`).

use crowd_sim::{Crowd, Motion, Person, Rectangle, SocialForce};
use serde::Deserialize;
use settings::ClassName;

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
            radius_m: 0.35,
            class: ClassName::Pedestrian,
            motion: Motion::SocialForce {
                position_m: reference.position_m[i],
                velocity_mps: [0.0, 0.0],
                goals_m: reference.goals_m[i].clone(),
                goal_radius_m: reference.goal_radius_m[i],
                desired_speed_mps: reference.desired_speed_mps[i],
            },
        })
        .collect()
}

#[test]
fn ten_people_walk_as_in_the_numpy_reference_for_ten_seconds() {
    let reference = reference();
    assert!(reference.goal_switches >= 10, "the scene exercises goal switching");
    let arena = Rectangle { x_m: [0.0, 9.0], y_m: [-4.0, 4.0] };
    let mut crowd = Crowd::new(SocialForce::HUNAVSIM, arena, &people(&reference));
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

#[derive(Deserialize)]
struct Mixed {
    dt_s: f64,
    keep_every: usize,
    arena_m: [[f64; 2]; 2],
    position_m: Vec<[f64; 2]>,
    goals_m: Vec<Vec<[f64; 2]>>,
    desired_speed_mps: Vec<f64>,
    goal_radius_m: Vec<f64>,
    bounce_position_m: Vec<[f64; 2]>,
    bounce_velocity_mps: Vec<[f64; 2]>,
    tracks: Vec<RecordedTrack>,
    positions_m: Vec<Vec<[f64; 2]>>,
    velocities_mps: Vec<Vec<[f64; 2]>>,
    present: Vec<Vec<bool>>,
}

#[derive(Deserialize)]
struct RecordedTrack {
    times_s: Vec<f64>,
    positions_m: Vec<[f64; 2]>,
}

impl Mixed {
    fn people(&self) -> Vec<Person> {
        let walk = (0..self.position_m.len()).map(|i| Motion::SocialForce {
            position_m: self.position_m[i],
            velocity_mps: [0.0, 0.0],
            goals_m: self.goals_m[i].clone(),
            goal_radius_m: self.goal_radius_m[i],
            desired_speed_mps: self.desired_speed_mps[i],
        });
        let bounce = self.bounce_position_m.iter().zip(&self.bounce_velocity_mps);
        let bounce = bounce.map(|(&position_m, &velocity_mps)| Motion::Bounce { position_m, velocity_mps });
        let tracks = self.tracks.iter().map(|track| Motion::Track {
            times_s: track.times_s.clone(),
            positions_m: track.positions_m.clone(),
        });
        let everybody = walk.chain(bounce).chain(tracks);
        everybody
            .zip(1..)
            .map(|(motion, id)| Person { id, radius_m: 0.35, class: ClassName::Pedestrian, motion })
            .collect()
    }
}

#[test]
fn a_mixed_crowd_moves_as_in_the_numpy_reference() {
    let text = include_str!("../../../tests/data/mixed_crowd_reference.json");
    let reference: Mixed = serde_json::from_str(text).expect("the stored reference is valid JSON");
    let [low, high] = reference.arena_m;
    let arena = Rectangle { x_m: [low[0], high[0]], y_m: [low[1], high[1]] };
    let mut crowd = Crowd::new(SocialForce::HUNAVSIM, arena, &reference.people());
    let (mut worst, mut came, mut went): (f64, usize, usize) = (0.0, 0, 0);
    for (kept, present) in reference.present.iter().enumerate() {
        if kept > 0 {
            (0..reference.keep_every).for_each(|_| crowd.step(reference.dt_s));
            let before = &reference.present[kept - 1];
            came += before.iter().zip(present).filter(|(before, now)| !**before && **now).count();
            went += before.iter().zip(present).filter(|(before, now)| **before && !**now).count();
        }
        for i in 0..crowd.len() {
            assert_eq!(crowd.is_present(i), present[i], "person {i} at state {kept}");
            for k in (0..2).filter(|_| present[i]) {
                worst = worst.max((crowd.position_m(i)[k] - reference.positions_m[kept][i][k]).abs());
                worst = worst.max((crowd.velocity_mps(i)[k] - reference.velocities_mps[kept][i][k]).abs());
            }
        }
        assert!(worst < 1e-9, "differs by {worst:e} after {kept} kept states");
    }
    assert_eq!((reference.present.len(), came, went), (101, 2, 2));
    println!("largest difference {worst:e}");
}
