//! The certificate of a shipped model on a piece of its box, against states drawn from it.

use std::ops::ControlFlow;
use std::path::Path;

use barrier::{Kernel, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use verification::Game;
use verification::affine::{AffineRecord, AffineSettings, Outcome, StateBox, certify};

const ALPHA_PER_S: f64 = 4.0;

#[test]
fn no_state_drawn_from_the_region_is_below_what_was_proven() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/ground_robot_paper.safetensors");
    let model = Model::load(&file).unwrap();
    let region = StateBox { min: [0.3, 1.05, -0.95, 0.93], max: [0.36, 1.15, -0.89, 0.97] };
    let settings = AffineSettings::new(region, ALPHA_PER_S, 0.01);
    let record =
        certify(&model, Kernel::detect(), &settings, None, &mut |_| ControlFlow::Continue(())).unwrap();
    let proven = record.proven_epsilon_mps.unwrap();
    if record.outcome == Outcome::Refuted {
        assert!(proven <= 0.05 - record.worst.unwrap().condition_mps);
    }
    assert_eq!(record.undecided_share, 0.0);

    let game = Game::of(model.metadata()).unwrap();
    let mut barrier = RelativeBarrier::new(&model, Kernel::detect()).unwrap();
    let mut rng = Pcg64::seed_from_u64(1);
    let radius_m = model.metadata().failure_radius_m;
    let draw = |_| {
        let z = core::array::from_fn(|i| rng.random_range(region.min[i]..=region.max[i]));
        RelativeObstacle { z, radius_m }
    };
    let obstacles: Vec<RelativeObstacle> = (0..50_000).map(draw).collect();
    let mut samples = vec![RelativeSample::default(); obstacles.len()];
    barrier.evaluate(&obstacles, &mut samples);
    let mut lowest = f64::INFINITY;
    let mut inside = 0;
    for (obstacle, sample) in obstacles.iter().zip(&samples) {
        if sample.h_bar >= 0.0 && sample.sdf > 0.0 {
            inside += 1;
            let condition = game.hamiltonian(&obstacle.z, &sample.gradient) + ALPHA_PER_S * sample.h_bar;
            lowest = lowest.min(condition);
        }
    }
    assert!(inside > 1_000, "only {inside} states lie in the safe set; choose the region anew");
    assert!(lowest >= -proven - 1e-4, "{lowest} is below the proven -{proven}");
    assert!(lowest <= 0.05 - proven || proven == 0.01, "proven {proven}, but nothing is below {lowest}");

    let text = serde_json::to_string(&record).unwrap();
    assert!(serde_json::from_str::<AffineRecord>(&text).is_ok());
}
