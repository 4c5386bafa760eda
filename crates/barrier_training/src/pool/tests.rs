//! The pool depends on target, settings and seed alone, and holds what the settings ask for.

use super::*;
use crate::closed_form::{ClosedForm, ClosedFormSampler};
use crate::panel::{LANES, at};
use crate::residual_grid::ResidualGrid;
use crate::strata::Strata;
use crate::tests_support::settings;
use reachability::{Axis, Grid};
use settings::{Encoding, SampleSettings};

fn grid() -> ResidualGrid {
    let square = Axis::bounded(-3.0, 3.0, 16);
    let axes = [square, square, Axis::periodic(-3.0, 3.0, 12), Axis::bounded(0.0, 1.5, 4)];
    let grid = Grid::new(axes).unwrap();
    let states = (0..grid.node_count()).map(|node| grid.state(node));
    let value: Vec<f32> = states.map(|z| (failure_function(&z, 0.7) - 0.5) as f32).collect();
    ResidualGrid::new(grid, &value, 0.7).unwrap()
}

fn draw(settings: &TrainingSettings) -> Pool {
    Pool::draw(&Strata::of(&grid(), &settings.samples, settings.encoding), settings)
}

fn samples(count: usize) -> SampleSettings {
    SampleSettings { count, ..SampleSettings::default() }
}

#[test]
fn is_the_same_for_any_number_of_threads_and_differs_by_seed() {
    let bits = |threads, seed| {
        let settings = TrainingSettings { seed, samples: samples(1 << 16), ..settings() };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let samples = pool.install(|| draw(&settings)).samples;
        samples.iter().flat_map(|l| l.0.map(f32::to_bits)).collect::<Vec<_>>()
    };
    let first = bits(1, 5);
    assert_eq!(first, bits(4, 5));
    assert_ne!(first, bits(1, 6));
    let block = SAMPLE_BLOCK * LANES;
    assert_ne!(first[..block], first[block..2 * block], "every block draws samples of its own");
}

#[test]
fn targets_carry_the_margin_and_raw_states_alone_reach_beyond_the_seam() {
    let samples = SampleSettings { seam_overlap: 0.6, ..samples(8192) };
    let raw = TrainingSettings { margin_m: 0.05, samples, ..settings() };
    let pool = draw(&raw);
    assert!((pool.mean_target_m() - 0.55).abs() < 1e-5);
    let (mut beyond, mut total) = (0, 0);
    for panel in pool.samples.chunks_exact(groups(SAMPLE_ROWS)) {
        for i in 0..PANEL {
            assert!((at(panel, TARGET_ROW, i) - 0.55).abs() < 1e-5);
            assert!(at(panel, 0, i).abs() <= 3.0 && at(panel, 1, i).abs() <= 3.0);
            assert!((0.0..=1.5).contains(&at(panel, 3, i)));
            let angle = at(panel, 2, i).abs();
            assert!(angle <= 3.0 + 0.6 + 0.25 + 1e-5, "{angle}");
            beyond += usize::from(angle > 3.0);
            total += 1;
        }
    }
    // Three of 15 places lie at or beyond an end: -3 itself is shown at +3, 2.5 at -3.5, -2.5 at 3.5.
    assert!(beyond * 20 > total && beyond * 4 < total, "{beyond} of {total}");

    let pool = draw(&TrainingSettings { encoding: Encoding::HeadingCosSin, ..raw });
    for panel in pool.samples.chunks_exact(groups(SAMPLE_ROWS)) {
        for i in 0..PANEL {
            assert!((at(panel, 2, i).hypot(at(panel, 3, i)) - 1.0).abs() < 1e-6);
        }
    }
}

/// Nearest approach of a body that cannot accelerate: scales as [`ClosedForm`] asks.
fn coasting(z: &[f64; 4]) -> f64 {
    let speed = z[2] * z[2] + z[3] * z[3];
    let time = (-(z[0] * z[2] + z[1] * z[3]) / speed).max(0.0);
    (z[0] + time * z[2]).hypot(z[1] + time * z[3]) - 0.7
}

#[test]
fn samples_of_a_closed_form_lie_at_its_values_and_by_the_shares_asked_for() {
    let target = ClosedForm::new(Box::new(coasting), 0.7, [-4.0, -4.0, -2.0, -2.0], [4.0, 4.0, 2.0, 2.0]);
    let settings = TrainingSettings { samples: samples(1 << 14), ..settings() };
    let sampler = ClosedFormSampler { target: &target, settings: settings.samples };
    let pool = Pool::draw(&sampler, &settings);
    let (mut near, mut inside) = (0.0, 0.0);
    for panel in pool.samples.chunks_exact(groups(SAMPLE_ROWS)) {
        for i in 0..PANEL {
            let z: [f64; 4] = core::array::from_fn(|k| f64::from(at(panel, k, i)));
            let residual = failure_function(&z, 0.7) - coasting(&z);
            assert!((f64::from(at(panel, TARGET_ROW, i)) - residual).abs() < 1e-4, "{z:?}");
            let outside = failure_function(&z, 0.7) > 0.0;
            near += f64::from(u8::from(outside && coasting(&z).abs() < 0.4));
            inside += f64::from(u8::from(!outside));
        }
    }
    let count = (pool.blocks() * BLOCK) as f64;
    assert!(near / count > 0.35 && (inside / count - 0.05).abs() < 0.01, "{near} and {inside} of {count}");
    let mut rng = Pcg64::new(3, 0);
    for _ in 0..1000 {
        let z = sampler.near_zero_level([-0.1, 0.2], &mut rng);
        assert!((-0.1..0.2).contains(&coasting(&z)) && failure_function(&z, 0.7) > 0.0);
    }
}
