//! The condition's loss and gradient against a plain double-precision network, and against scalar code.

use super::*;
use crate::network::{Shape, initial};
use crate::worst_case::game;
use dynamics::{InputBox, UnicyclePair};
use pulp::Arch;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const RADIUS_M: f64 = 0.7;
const ALPHA: f64 = 4.0;
const MARGIN: f64 = 0.3;
const KNEE: f64 = 0.8;

fn pair() -> Box<dyn WorstCase> {
    game(UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    })
}

/// The residual written down once more, in `f64`, one state at a time.
fn residual(encoding: Encoding, parameters: &[f64], state: &[f64; 4]) -> f64 {
    let shape = Shape::of(encoding);
    let [x, y, heading, speed] = *state;
    let mut a = match encoding {
        Encoding::Raw => vec![x, y, heading, speed],
        Encoding::HeadingCosSin => vec![x, y, heading.cos(), heading.sin(), speed],
        Encoding::Position => vec![x, y],
    };
    for layer in 0..LAYERS {
        let (input, output) = (shape.input(layer), shape.output(layer));
        let z: Vec<f64> = (0..output)
            .map(|j| {
                let row = &parameters[shape.offset(layer) + j * input..][..input];
                parameters[shape.bias_offset(layer) + j] + row.iter().zip(&a).map(|(w, x)| w * x).sum::<f64>()
            })
            .collect();
        a = if layer + 1 == LAYERS { z } else { z.iter().map(|z| z.sin()).collect() };
    }
    a[0].exp().ln_1p()
}

/// `C` at one state, the gradient by differences.
fn condition(encoding: Encoding, parameters: &[f64], z: &[f64; 4]) -> f64 {
    let h = |z: &[f64; 4]| z[0].hypot(z[1]) - RADIUS_M - residual(encoding, parameters, z);
    let gradient: [f64; 4] = core::array::from_fn(|k| {
        let (mut above, mut below) = (*z, *z);
        above[k] += 1e-5;
        below[k] -= 1e-5;
        (h(&above) - h(&below)) / 2e-5
    });
    let flow = pair().flow(z, &gradient);
    (0..4).map(|k| gradient[k] * flow[k]).sum::<f64>() + ALPHA * h(z)
}

fn reference_loss(encoding: Encoding, parameters: &[f64], states: &[[f32; 4]]) -> f64 {
    let part = |z: &[f32; 4]| {
        let short = (MARGIN - condition(encoding, parameters, &z.map(f64::from))).max(0.0);
        if short < KNEE { 0.5 * short * short } else { KNEE * (short - 0.5 * KNEE) }
    };
    states.iter().map(part).sum::<f64>() / CONDITION_BLOCK as f64
}

struct Case {
    parameters: Vec<f32>,
    states: Vec<[f32; 4]>,
}

fn case(encoding: Encoding) -> Case {
    let mut rng = Pcg64::seed_from_u64(5);
    let parameters = initial(&mut rng, Shape::of(encoding), 0.5, 0.6);
    let mut component = |low: f32, high: f32| rng.random_range(low..high);
    let states = (0..CONDITION_BLOCK)
        .map(|_| [component(-2.5, 2.5), component(-2.5, 2.5), component(-3.0, 3.0), component(0.0, 1.5)])
        .collect();
    Case { parameters, states }
}

fn run(arch: Arch, encoding: Encoding, case: &Case) -> Share {
    let shape = Shape::of(encoding);
    let (mut packed, mut workspace) = (Packed::new(shape), Workspace::new());
    let mut share = Share::new(shape.parameters());
    packed.fill(&case.parameters);
    let pair = pair();
    let loss = ConditionLoss {
        game: &*pair,
        failure_radius_m: RADIUS_M,
        alpha_per_s: ALPHA as f32,
        margin_mps: MARGIN as f32,
        knee_mps: KNEE as f32,
        scale: 1.0 / CONDITION_BLOCK as f32,
    };
    let (packed, states) = (&packed, &case.states[..]);
    arch.dispatch(BlockCondition {
        packed,
        encoding,
        states,
        loss,
        workspace: &mut workspace,
        share: &mut share,
    });
    share
}

#[test]
fn loss_and_gradient_agree_with_central_differences_in_double_precision() {
    for encoding in [Encoding::Raw, Encoding::HeadingCosSin, Encoding::Position] {
        let case = case(encoding);
        let result = run(Arch::new(), encoding, &case);
        let mut parameters: Vec<f64> = case.parameters.iter().map(|&p| f64::from(p)).collect();
        let expected = reference_loss(encoding, &parameters, &case.states);
        assert!(expected > 0.1, "the states violate the condition");
        assert!((result.loss - expected).abs() < 1e-4 * expected, "{}, not {expected}", result.loss);
        // Every layer, weights and biases: the indices step through all of them.
        let step = 1e-5;
        let last = parameters.len() - 1;
        for index in (0..last).step_by(97).chain([last]) {
            let kept = parameters[index];
            let mut at = |value: f64| {
                parameters[index] = value;
                reference_loss(encoding, &parameters, &case.states)
            };
            let (above, below) = (at(kept + step), at(kept - step));
            parameters[index] = kept;
            let expected = (above - below) / (2.0 * step);
            let found = f64::from(result.gradient[index]);
            let bound = 3e-4 * (1.0 + expected.abs());
            assert!((found - expected).abs() < bound, "{encoding:?} {index}: {found}, not {expected}");
        }
    }
}

#[test]
fn gradient_has_the_same_bits_on_every_instruction_set() {
    let case = case(Encoding::HeadingCosSin);
    let [fast, scalar] = [Arch::new(), Arch::Scalar].map(|arch| run(arch, Encoding::HeadingCosSin, &case));
    assert_eq!(fast.loss.to_bits(), scalar.loss.to_bits());
    assert_eq!(fast.gradient, scalar.gradient);
    assert!(fast.gradient.iter().all(|g| g.is_finite()) && fast.gradient.iter().any(|&g| g != 0.0));
}
