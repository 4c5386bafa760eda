//! The composite's row against central differences of an independent `f64` composite, in robot state and time.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{BarrierObstacle, CompositeBarrier, CompositeSample, Kernel, Model};
use common::{central_differences, reference_composite, rng};
use dynamics::RobotObstaclePair;
use rand::RngExt;

const BETA: f64 = 4.0;

/// Largest error of `h`, `L_g h`, `drift` and `∂h/∂t` at one robot state.
fn errors<const NX: usize, P: RobotObstaclePair<NX>>(
    models: &[&Model],
    kernel: Kernel,
    pair: &P,
    x: &[f64; NX],
    obstacles: &[BarrierObstacle],
) -> [f64; 2] {
    let mut composite = CompositeBarrier::new(models[0], kernel, BETA).unwrap();
    for (index, model) in models.iter().enumerate().skip(1) {
        assert_eq!(composite.add_model(model), Ok(index));
    }
    let weights: Vec<_> = models.iter().map(|model| model.weights()).collect();
    let CompositeSample::Constrained(sample) = composite.evaluate(pair, x, obstacles).unwrap() else {
        panic!("there are obstacles")
    };
    assert_eq!(sample.outside_domain, 0, "the judge knows the inside only");

    let h = |x: &[f64; NX]| reference_composite(&weights, BETA, pair, x, obstacles);
    let dh_dx = central_differences(x, h);
    let [dh_dt] = central_differences(&[0.0], |[t]| {
        let moved: Vec<_> = obstacles
            .iter()
            .map(|obstacle| BarrierObstacle {
                state: std::array::from_fn(|k| obstacle.state[k] + t * obstacle.rate[k]),
                ..*obstacle
            })
            .collect();
        reference_composite(&weights, BETA, pair, x, &moved)
    });
    let (f, g) = (pair.robot_drift(x), pair.robot_control_jacobian(x));
    let along = |direction: &dyn Fn(usize) -> f64| (0..NX).map(|j| dh_dx[j] * direction(j)).sum::<f64>();

    let by_state = [
        (sample.lg_h[0] - along(&|j| g[j][0])).abs(),
        (sample.lg_h[1] - along(&|j| g[j][1])).abs(),
        (sample.drift - along(&|j| f[j]) - dh_dt).abs(),
        (sample.dh_dt - dh_dt).abs(),
    ];
    [(sample.h - h(x)).abs(), by_state.into_iter().fold(0.0, f64::max)]
}

#[test]
fn the_unicycle_s_row_agrees_with_central_differences_to_1e_4() {
    let (model, pair, mut rng) = (common::ground_robot_model(1), common::unicycle_pair(), rng(2));
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut worst = [0.0_f64; 2];
        for count in [1, 2, 5, 20, 64] {
            for _ in 0..8 {
                let people = common::people(&mut rng, count, 3.5);
                // Headings of the robot near zero keep the relative heading off the seam at ±π.
                let x = [0.0; 3].map(|_: f64| rng.random_range(-0.14..0.14));
                let found = errors(&[&model], kernel, &pair, &x, &people);
                worst = [worst[0].max(found[0]), worst[1].max(found[1])];
            }
        }
        println!("unicycle, {kernel}: h {:.1e}, derivatives {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-5 && worst[1] < 1e-4, "{kernel}: {worst:?}");
    }
}

#[test]
fn the_shipped_model_s_row_agrees_with_central_differences_to_1e_4() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/ground_robot_paper.safetensors");
    let model = Model::load(std::path::Path::new(path)).unwrap();
    let (pair, mut rng) = (common::unicycle_pair(), rng(5));
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut worst = [0.0_f64; 2];
        for count in [1, 2, 5, 20, 64] {
            for _ in 0..40 {
                let people = common::people(&mut rng, count, 3.5);
                let x = [0.0; 3].map(|_: f64| rng.random_range(-0.14..0.14));
                let found = errors(&[&model], kernel, &pair, &x, &people);
                worst = [worst[0].max(found[0]), worst[1].max(found[1])];
            }
        }
        println!("shipped model, {kernel}: h {:.1e}, derivatives {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-5 && worst[1] < 1e-4, "{kernel}: {worst:?}");
    }
}

#[test]
fn the_row_of_a_mixed_scene_agrees_with_central_differences_to_1e_4() {
    let [person, cyclist, pillar] =
        [common::ground_robot_model(6), common::cyclist_model(7), common::static_model(8)];
    let (pair, mut rng) = (common::unicycle_pair(), rng(9));
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut worst = [0.0_f64; 2];
        for count in [3, 7, 20, 64] {
            for _ in 0..8 {
                let mut obstacles = common::people(&mut rng, count, 3.5);
                for (index, obstacle) in obstacles.iter_mut().enumerate() {
                    obstacle.model = index * 7 % 3;
                    if obstacle.model == 1 {
                        obstacle.state[3] *= 3.0;
                    }
                }
                let x = [0.0; 3].map(|_: f64| rng.random_range(-0.14..0.14));
                let found = errors(&[&person, &cyclist, &pillar], kernel, &pair, &x, &obstacles);
                worst = [worst[0].max(found[0]), worst[1].max(found[1])];
            }
        }
        println!("mixed, {kernel}: h {:.1e}, derivatives {:.1e}", worst[0], worst[1]);
        assert!(worst[0] < 1e-5 && worst[1] < 1e-4, "{kernel}: {worst:?}");
    }
}

#[test]
fn the_double_integrator_s_row_agrees_with_central_differences_to_1e_4() {
    let (model, pair, mut rng) = (common::quadrotor_model(3), common::double_integrator_pair(), rng(4));
    let mut worst = [0.0_f64; 2];
    for _ in 0..40 {
        let mut within = |bound: f64| rng.random_range(-bound..bound);
        let obstacles: Vec<_> = (0..10)
            .map(|_| {
                let (vx, vy) = (within(1.0), within(1.0));
                BarrierObstacle {
                    state: [within(3.0), within(3.0), vx, vy],
                    rate: [vx, vy, within(1.0), within(1.0)],
                    radius_m: 0.7,
                    model: 0,
                }
            })
            .collect();
        let x = [within(0.5), within(0.5), within(2.0), within(2.0)];
        let found = errors(&[&model], Kernel::detect(), &pair, &x, &obstacles);
        worst = [worst[0].max(found[0]), worst[1].max(found[1])];
    }
    println!("double integrator: h {:.1e}, derivatives {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-5 && worst[1] < 1e-4, "{worst:?}");
}
