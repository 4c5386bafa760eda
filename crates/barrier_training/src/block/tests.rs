//! The block against a plain double-precision network, and against itself on scalar code.

use super::*;
use crate::network::{LAYERS, Shape, initial};
use pulp::Arch;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const SHAPE: Shape = Shape::of(Encoding::Raw);

/// The network written down once more, in `f64`, one sample at a time.
fn residual(parameters: &[f64], state: &[f64; 4]) -> f64 {
    let mut a = state.to_vec();
    for layer in 0..LAYERS {
        let (input, output) = (SHAPE.input(layer), SHAPE.output(layer));
        let z: Vec<f64> = (0..output)
            .map(|j| {
                let row = &parameters[SHAPE.offset(layer) + j * input..][..input];
                parameters[SHAPE.bias_offset(layer) + j] + row.iter().zip(&a).map(|(w, x)| w * x).sum::<f64>()
            })
            .collect();
        a = if layer + 1 == LAYERS { z } else { z.iter().map(|z| z.sin()).collect() };
    }
    a[0].exp().ln_1p()
}

struct Case {
    parameters: Vec<f32>,
    states: Vec<[f32; 4]>,
    samples: Vec<Lanes>,
    loss: Loss,
}

fn case() -> Case {
    let mut rng = Pcg64::seed_from_u64(11);
    let parameters = initial(&mut rng, SHAPE, 0.5, 0.4);
    let states: Vec<[f32; 4]> =
        (0..BLOCK).map(|_| core::array::from_fn(|_| rng.random_range(-3.0..3.0))).collect();
    let mut samples = vec![Lanes::ZERO; SAMPLE_BLOCK];
    for (p, panel) in samples.chunks_exact_mut(groups(SAMPLE_ROWS)).enumerate() {
        for i in 0..PANEL {
            put_inputs(panel, i, &encode(Encoding::Raw, &states[p * PANEL + i]));
            *at_mut(panel, TARGET_ROW, i) = rng.random_range(0.0..1.0);
            *at_mut(panel, OVERESTIMATE_ROW, i) = rng.random_range(1.0..3.0);
            *at_mut(panel, UNDERESTIMATE_ROW, i) = rng.random_range(0.1..1.0);
        }
    }
    Case { parameters, states, samples, loss: Loss { huber_m: 0.3, scale: 1.0 / BLOCK as f32 } }
}

fn run(arch: Arch, case: &Case) -> Share {
    let (mut packed, mut workspace, mut share) =
        (Packed::new(SHAPE), Workspace::new(), Share::new(SHAPE.parameters()));
    packed.fill(&case.parameters);
    arch.dispatch(BlockGradient {
        packed: &packed,
        samples: &case.samples,
        loss: case.loss,
        workspace: &mut workspace,
        share: &mut share,
    });
    share
}

fn reference_loss(case: &Case, parameters: &[f64]) -> f64 {
    let huber = f64::from(case.loss.huber_m);
    (0..BLOCK)
        .map(|i| {
            let panel = &case.samples[i / PANEL * groups(SAMPLE_ROWS)..];
            let value = |row| f64::from(at(panel, row, i % PANEL));
            let error = residual(parameters, &core::array::from_fn(value)) - value(TARGET_ROW);
            let weight = value(if error < 0.0 { OVERESTIMATE_ROW } else { UNDERESTIMATE_ROW });
            weight * huber * huber * ((1.0 + (error / huber).powi(2)).sqrt() - 1.0) / BLOCK as f64
        })
        .sum()
}

#[test]
fn loss_and_gradient_agree_with_central_differences_in_double_precision() {
    let case = case();
    let result = run(Arch::new(), &case);
    let mut parameters: Vec<f64> = case.parameters.iter().map(|&p| f64::from(p)).collect();
    assert!((result.loss - reference_loss(&case, &parameters)).abs() < 1e-5);
    // Every layer, weights and biases: the indices step through all of them.
    let step = 1e-5;
    for index in (0..SHAPE.parameters()).step_by(37).chain([SHAPE.parameters() - 1]) {
        let kept = parameters[index];
        parameters[index] = kept + step;
        let above = reference_loss(&case, &parameters);
        parameters[index] = kept - step;
        let below = reference_loss(&case, &parameters);
        parameters[index] = kept;
        let expected = (above - below) / (2.0 * step);
        let found = f64::from(result.gradient[index]);
        assert!(
            (found - expected).abs() < 2e-5 * (1.0 + expected.abs()),
            "parameter {index}: {found}, not {expected}"
        );
    }
}

#[test]
fn gradient_has_the_same_bits_on_every_instruction_set() {
    let case = case();
    let (fast, scalar) = (run(Arch::new(), &case), run(Arch::Scalar, &case));
    assert_eq!(fast.loss.to_bits(), scalar.loss.to_bits());
    assert_eq!(fast.gradient, scalar.gradient);
    assert!(fast.gradient.iter().all(|g| g.is_finite()) && fast.gradient.iter().any(|&g| g != 0.0));
}

#[test]
fn evaluation_and_input_gradient_agree_with_double_precision() {
    let case = case();
    let parameters: Vec<f64> = case.parameters.iter().map(|&p| f64::from(p)).collect();
    let (mut packed, mut workspace) = (Packed::new(SHAPE), Workspace::new());
    packed.fill(&case.parameters);
    // A count that fills neither a vector nor a panel.
    let states = &case.states[..77];
    let mut out = vec![(0.0, [0.0; 4]); states.len()];
    Arch::new().dispatch(BlockEvaluation {
        packed: &packed,
        encoding: Encoding::Raw,
        states,
        out: &mut out,
        workspace: &mut workspace,
    });
    for (state, (value, gradient)) in states.iter().zip(&out) {
        let state = state.map(f64::from);
        assert!((f64::from(*value) - residual(&parameters, &state)).abs() < 1e-5);
        for k in 0..4 {
            let (mut above, mut below) = (state, state);
            above[k] += 1e-5;
            below[k] -= 1e-5;
            let expected = (residual(&parameters, &above) - residual(&parameters, &below)) / 2e-5;
            assert!((f64::from(gradient[k]) - expected).abs() < 1e-4, "{gradient:?}[{k}], not {expected}");
        }
    }
}
