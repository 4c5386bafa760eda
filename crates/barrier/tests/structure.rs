//! Properties that hold by construction: `h̄ ≤ ℓ`, the softmin's bounds, the radius shift, continuity at the
//! border of the trained domain, and what happens without obstacles or with bad ones.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{
    CompositeBarrier, CompositeError, CompositeSample, CompositeSetupError, Kernel, RelativeBarrier,
    RelativeObstacle, RelativeSample,
};
use common::rng;
use dynamics::RobotObstaclePair;
use rand::RngExt;

const BETA: f64 = 4.0;

fn sample(barrier: &mut RelativeBarrier, z: [f64; 4], radius_m: f64) -> RelativeSample {
    let mut out = [RelativeSample::default()];
    barrier.evaluate(&[RelativeObstacle { z, radius_m }], &mut out);
    out[0]
}

#[test]
fn the_relative_barrier_never_exceeds_the_failure_function() {
    let mut barrier = RelativeBarrier::new(&common::ground_robot_model(1), Kernel::detect()).unwrap();
    let mut rng = rng(2);
    let mut within = |bound: f64| rng.random_range(-bound..bound);
    // Twice the trained domain, so that a good part lies outside.
    let obstacles: Vec<_> = (0..100_000)
        .map(|_| RelativeObstacle {
            z: [within(12.0), within(12.0), within(7.0), within(3.0)],
            radius_m: 0.7 + within(0.3),
        })
        .collect();
    let mut samples = vec![RelativeSample::default(); obstacles.len()];
    barrier.evaluate(&obstacles, &mut samples);
    assert!(samples.iter().all(|sample| sample.h_bar <= sample.sdf));
    let outside = samples.iter().filter(|sample| sample.outside_domain).count();
    assert!((80_000..95_000).contains(&outside), "{outside}");
}

#[test]
fn the_composite_lies_between_the_minimum_and_its_offset() {
    let (model, pair, mut rng) = (common::ground_robot_model(3), common::unicycle_pair(), rng(4));
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    for _ in 0..2_000 {
        let count = rng.random_range(1..=64);
        let people = common::people(&mut rng, count, 8.0);
        let x = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-3.0..3.0)];
        let CompositeSample::Constrained(sample) = composite.evaluate(&pair, &x, &people).unwrap() else {
            panic!("there are people")
        };
        let values = composite.values();
        let min = values.iter().map(|value| value.h_bar).fold(f64::INFINITY, f64::min);
        assert!(sample.h <= min + 1e-12 && sample.h >= min - (count as f64).ln() / BETA - 1e-12);
        assert_eq!(values[sample.critical].h_bar, min);
        assert_eq!(sample.sdf, values.iter().map(|value| value.sdf).fold(f64::INFINITY, f64::min));
        assert!((composite.weights().iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(composite.h_at(&pair, &x, &people).unwrap(), sample.h);
    }
}

#[test]
fn another_radius_shifts_the_value_and_nothing_else() {
    let mut barrier = RelativeBarrier::new(&common::ground_robot_model(5), Kernel::detect()).unwrap();
    let z = [2.0, -1.0, 2.5, 1.1];
    let (small, large) = (sample(&mut barrier, z, 0.5), sample(&mut barrier, z, 1.25));
    assert!((small.h_bar - large.h_bar - 0.75).abs() < 1e-12);
    assert_eq!(small.gradient, large.gradient);
}

#[test]
fn the_border_of_the_trained_domain_leaves_no_step() {
    let mut barrier = RelativeBarrier::new(&common::ground_robot_model(6), Kernel::detect()).unwrap();
    let mut rng = rng(7);
    for _ in 0..2_000 {
        let mut z = [6.0, 6.0, 3.0, 1.5].map(|bound: f64| rng.random_range(-bound..bound));
        z[3] = z[3].abs();
        let axis = [0, 1, 3][rng.random_range(0..3)];
        let border = if axis == 3 { 1.5 } else { 6.0 };
        let mut at = |offset: f64| {
            let mut moved = z;
            moved[axis] = border + offset;
            sample(&mut barrier, moved, 0.7)
        };
        let (inside, outside) = (at(-1e-6), at(1e-6));
        assert!(!inside.outside_domain && outside.outside_domain);
        assert!((inside.h_bar - outside.h_bar).abs() < 5e-5, "{inside:?} {outside:?}");
    }
}

#[test]
fn far_outside_the_value_grows_with_the_distance_and_the_gradient_is_that_of_the_failure_function() {
    let mut barrier = RelativeBarrier::new(&common::ground_robot_model(8), Kernel::detect()).unwrap();
    let (near, far) =
        (sample(&mut barrier, [8.0, 0.0, 1.0, 1.0], 0.7), sample(&mut barrier, [20.0, 0.0, 1.0, 1.0], 0.7));
    assert!((far.h_bar - near.h_bar - 12.0).abs() < 1e-9);
    assert_eq!(far.gradient[0], 1.0);
}

#[test]
fn coinciding_centres_give_a_finite_row() {
    let (model, pair) = (common::ground_robot_model(9), common::unicycle_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    let person = barrier::BarrierObstacle { state: [0.0; 4], rate: [0.0; 4], radius_m: 0.7, model: 0 };
    let sample = composite.evaluate(&pair, &[0.0; 3], &[person]).unwrap();
    assert!(sample.h() <= -0.7);
    assert!(sample.row(4.0).is_some_and(|row| row.normal.iter().all(|a| a.is_finite())));
}

#[test]
fn without_obstacles_nothing_is_constrained() {
    let (model, pair) = (common::ground_robot_model(10), common::unicycle_pair());
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    let sample = composite.evaluate(&pair, &[0.0; 3], &[]).unwrap();
    assert_eq!(sample, CompositeSample::Unconstrained);
    assert_eq!((sample.h(), sample.row(4.0)), (f64::INFINITY, None));
    assert_eq!(composite.h_at(&pair, &[0.0; 3], &[]).unwrap(), f64::INFINITY);
}

#[test]
fn each_obstacle_of_a_mixed_scene_is_judged_by_its_own_model() {
    let models = [common::ground_robot_model(14), common::cyclist_model(15), common::static_model(16)];
    let (pair, mut rng) = (common::unicycle_pair(), rng(17));
    let mut composite = CompositeBarrier::new(&models[0], Kernel::detect(), BETA).unwrap();
    assert_eq!([&models[1], &models[2]].map(|model| composite.add_model(model)), [Ok(1), Ok(2)]);
    let mut alone = models.each_ref().map(|model| RelativeBarrier::new(model, Kernel::detect()).unwrap());
    for _ in 0..200 {
        let count = rng.random_range(1..=64);
        let mut obstacles = common::people(&mut rng, count, 13.0);
        for obstacle in &mut obstacles {
            obstacle.model = rng.random_range(0..3);
        }
        let x = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-3.0..3.0)];
        let h = composite.evaluate(&pair, &x, &obstacles).unwrap().h();
        for (obstacle, value) in obstacles.iter().zip(composite.values()) {
            let z = pair.relative_state(&x, &obstacle.state);
            assert_eq!(sample(&mut alone[obstacle.model], z, obstacle.radius_m), *value);
        }
        let values: Vec<_> = composite.values().iter().map(|value| value.h_bar).collect();
        assert_eq!(h, barrier::softmin(&values, BETA));
        assert_eq!(composite.h_at(&pair, &x, &obstacles).unwrap(), h);
    }
}

#[test]
fn a_model_that_was_not_added_is_refused() {
    let (model, pair, mut rng) = (common::ground_robot_model(18), common::unicycle_pair(), rng(19));
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    let mut people = common::people(&mut rng, 3, 3.0);
    people[1].model = 1;
    let refused = composite.evaluate(&pair, &[0.0; 3], &people);
    assert_eq!(refused, Err(CompositeError::UnknownModel { index: 1, model: 1 }));
}

#[test]
fn a_static_model_sees_the_same_through_the_walking_pair_and_the_static_one() {
    let (model, walking, mut rng) = (common::static_model(20), common::unicycle_pair(), rng(21));
    let still = dynamics::UnicycleStaticPair { control: walking.control };
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    for _ in 0..200 {
        let obstacles = common::people(&mut rng, 5, 7.0);
        let x = [rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0), rng.random_range(-3.0..3.0)];
        let rows = [
            composite.evaluate(&walking, &x, &obstacles).unwrap().row(4.0).unwrap(),
            composite.evaluate(&still, &x, &obstacles).unwrap().row(4.0).unwrap(),
        ];
        assert!((rows[0].offset - rows[1].offset).abs() < 1e-5, "{rows:?}");
        assert!((0..2).all(|k| (rows[0].normal[k] - rows[1].normal[k]).abs() < 1e-5), "{rows:?}");
    }
}

#[test]
fn bad_input_is_refused_and_named() {
    let (model, pair, mut rng) = (common::ground_robot_model(11), common::unicycle_pair(), rng(12));
    let mut composite = CompositeBarrier::new(&model, Kernel::detect(), BETA).unwrap();
    let mut people = common::people(&mut rng, 65, 3.0);
    let mut evaluate = |x: [f64; 3], people: &[_]| composite.evaluate(&pair, &x, people).unwrap_err();
    assert_eq!(evaluate([0.0; 3], &people), CompositeError::TooManyObstacles { given: 65 });
    assert_eq!(evaluate([0.0, f64::NAN, 0.0], &people[..3]), CompositeError::NonFiniteRobot);
    people[2].rate[3] = f64::INFINITY;
    assert_eq!(evaluate([0.0; 3], &people[..3]), CompositeError::NonFiniteObstacle { index: 2 });
    people[1].state[0] = 1e300;
    assert_eq!(evaluate([0.0; 3], &people[1..2]), CompositeError::NonFiniteResult);
}

#[test]
fn a_beta_that_is_not_positive_is_refused() {
    let model = common::ground_robot_model(13);
    for beta in [0.0, -4.0, f64::NAN] {
        let error = CompositeBarrier::new(&model, Kernel::Portable, beta).err();
        assert!(matches!(error, Some(CompositeSetupError::Beta { .. })), "{error:?}");
    }
}
