//! The game against brute force, and its row against the one that the filter computes on board.
#![allow(clippy::unwrap_used)] // helpers of a test may panic

mod common;

use barrier::{
    BarrierObstacle, CompositeBarrier, DynamicsKind, InputEncoding, Kernel, Model, RelativeBarrier,
    RelativeObstacle, RelativeSample,
};
use common::{metadata, random_residual};
use dynamics::RobotObstaclePair;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use verification::Game;

const KINDS: [DynamicsKind; 3] =
    [DynamicsKind::UnicyclePair, DynamicsKind::DoubleIntegratorPair, DynamicsKind::UnicycleStaticPair];

/// The four corners of a box of two inputs.
fn corners(low: &[f64; 2], high: &[f64; 2]) -> [[f64; 2]; 4] {
    [*low, [low[0], high[1]], [high[0], low[1]], *high]
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (0..4).map(|i| a[i] * b[i]).sum()
}

#[test]
fn inputs_and_hamiltonian_are_the_best_of_the_corners() {
    let mut rng = Pcg64::seed_from_u64(5);
    for kind in KINDS {
        let game = Game::of(&metadata(kind)).unwrap();
        let (control, (low, high)) = (*game.control_box(), game.disturbance_ends());
        for _ in 0..200 {
            let mut draw = || -> [f64; 4] { std::array::from_fn(|_| rng.random_range(-3.0..3.0)) };
            let (z, p) = (draw(), draw());
            let rate = |u: &[f64; 2], d: &[f64; 2]| dot(&p, &game.flow(&z, u, d));
            let controls = corners(&control.min, &control.max);
            let worst_for =
                |u: &[f64; 2]| corners(&low, &high).iter().map(|d| rate(u, d)).fold(f64::INFINITY, f64::min);
            let brute = controls.iter().map(worst_for).fold(f64::NEG_INFINITY, f64::max);
            assert!((game.hamiltonian(&z, &p) - brute).abs() < 1e-12, "{kind}");
            let harmful = game.worst_control(&z, &p);
            for u in &controls {
                assert!((rate(u, &game.worst_disturbance(&z, &p)) - worst_for(u)).abs() < 1e-12, "{kind}");
                assert!(rate(&harmful, &low) <= rate(u, &low) + 1e-12, "{kind}");
            }
            assert!(control.contains(&game.pursuit(&z)), "{kind}");
        }
    }
}

#[test]
fn the_row_is_the_one_on_board() {
    let mut rng = Pcg64::seed_from_u64(6);
    for kind in [DynamicsKind::UnicyclePair, DynamicsKind::DoubleIntegratorPair] {
        let model = Model::new(random_residual(InputEncoding::Raw, 2), metadata(kind)).unwrap();
        let game = Game::of(model.metadata()).unwrap();
        let mut composite = CompositeBarrier::new(&model, Kernel::detect(), 4.0).unwrap();
        let mut relative = RelativeBarrier::new(&model, Kernel::detect()).unwrap();
        for _ in 0..100 {
            let mut within = |bound: f64| rng.random_range(-bound..bound);
            let o = [within(3.0), within(3.0), within(1.0), within(0.5).abs()];
            let (heading, d) = (within(1.0), [within(0.35), within(1.0)]);
            let (z, row) = match game {
                Game::Unicycle(pair) => {
                    let x = [0.3, -0.2, heading];
                    let rate = [o[3] * o[2].cos(), o[3] * o[2].sin(), d[0], 0.0];
                    let obstacle = BarrierObstacle { state: o, rate, radius_m: 0.7, model: 0 };
                    let sample = composite.evaluate(&pair, &x, &[obstacle]).unwrap();
                    (pair.relative_state(&x, &o), sample.row(4.0).unwrap())
                }
                Game::DoubleIntegrator(pair) => {
                    let x = [0.3, -0.2, 0.5, -0.5];
                    let obstacle =
                        BarrierObstacle { state: o, rate: [o[2], o[3], d[0], d[1]], radius_m: 0.7, model: 0 };
                    let sample = composite.evaluate(&pair, &x, &[obstacle]).unwrap();
                    (pair.relative_state(&x, &o), sample.row(4.0).unwrap())
                }
                Game::UnicycleStatic(_) => unreachable!("not among the kinds above"),
            };
            let mut sample = [RelativeSample::default()];
            relative.evaluate(&[RelativeObstacle { z, radius_m: 0.7 }], &mut sample);
            let ours = game.row(&z, sample[0].h_bar, &sample[0].gradient, &d, 4.0);
            assert!((ours.offset - row.offset).abs() < 1e-9, "{kind}: {ours:?} {row:?}");
            for k in 0..2 {
                assert!((ours.normal[k] - row.normal[k]).abs() < 1e-9, "{kind}: {ours:?} {row:?}");
            }
        }
    }
}
