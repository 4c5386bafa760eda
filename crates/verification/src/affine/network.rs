//! The residual network on boxes: value and directional derivatives as Taylor models, gradient at the centres.
//!
//! Derivatives go forward through the layers beside the value. Backwards they would pass every layer's radius through
//! all absolute weights once more: measured on the published quadrotor network, radii a hundred times larger.

#![allow(clippy::inline_always)] // see `form`

use barrier::{InputEncoding, NetworkWeights};
use pulp::Simd;

use super::form::{AXES, Form};
use super::layer::{Layer, Panel, WIDEST};

/// Layers with a sine behind them.
const HIDDEN: usize = 6;

/// The network laid out for boxes.
pub(crate) struct BoxNetwork {
    encoding: InputEncoding,
    layers: Vec<Layer>,
}

/// What a pass needs room for; one per thread, reused for every group of boxes.
pub(crate) struct Workspace<S: Simd> {
    activation: Panel<S>,
    sum: Panel<S>,
    /// Cosines of every hidden layer's sums: its derivative.
    slopes: [Panel<S>; HIDDEN],
    output_slope: Form<S>,
    /// Cosine and sine of the heading where the encoding takes them.
    heading: [Form<S>; 2],
}

impl<S: Simd> Workspace<S> {
    /// Room for one group.
    #[inline(always)]
    pub(crate) fn new(simd: S) -> Self {
        let zero = Form::constant(simd, simd.splat_f64s(0.0));
        Self {
            activation: Panel::new(simd),
            sum: Panel::new(simd),
            slopes: core::array::from_fn(|_| Panel::new(simd)),
            output_slope: zero,
            heading: [zero; 2],
        }
    }
}

impl BoxNetwork {
    /// Lays the parameters out.
    pub(crate) fn new(weights: &NetworkWeights) -> Self {
        Self { encoding: weights.encoding(), layers: weights.layers().iter().map(Layer::new).collect() }
    }

    /// Largest possible absolute sum before any sine, for states with components up to `most`.
    pub(crate) fn largest_sum(&self, most: &[f64; AXES]) -> f64 {
        let inputs = match self.encoding {
            InputEncoding::Raw => most.to_vec(),
            InputEncoding::HeadingCosSin => vec![most[0], most[1], 1.0, 1.0, most[3]],
            InputEncoding::Position => most[..2].to_vec(),
        };
        let first = self.layers[0].most(&inputs);
        self.layers[1..].iter().map(|layer| layer.most(&[1.0; WIDEST])).fold(first, f64::max)
    }

    /// How strongly each state component drives the first layer: root mean square weight per unit.
    pub(crate) fn input_gains(&self) -> [f64; AXES] {
        let gain = |input| self.layers[0].gain(input);
        match self.encoding {
            InputEncoding::Raw => core::array::from_fn(gain),
            InputEncoding::HeadingCosSin => [gain(0), gain(1), gain(2).hypot(gain(3)), gain(4)],
            InputEncoding::Position => [gain(0), gain(1), 0.0, 0.0],
        }
    }

    /// Returns the residual `r` for boxes `z` and keeps what the derivatives need.
    #[inline(always)]
    pub(crate) fn residual<S: Simd>(&self, simd: S, z: &[Form<S>; AXES], work: &mut Workspace<S>) -> Form<S> {
        match self.encoding {
            InputEncoding::Raw => {
                for (input, form) in z.iter().enumerate() {
                    work.activation.set(input, form);
                }
            }
            InputEncoding::HeadingCosSin => {
                let (sin, cos) = z[2].sin_cos(simd);
                work.heading = [cos, sin];
                for (input, form) in [z[0], z[1], cos, sin, z[3]].iter().enumerate() {
                    work.activation.set(input, form);
                }
            }
            InputEncoding::Position => {
                work.activation.set(0, &z[0]);
                work.activation.set(1, &z[1]);
            }
        }
        for (layer, slopes) in self.layers.iter().zip(&mut work.slopes) {
            layer.apply(simd, true, &work.activation, &mut work.sum);
            for neuron in 0..layer.outputs {
                let (sin, cos) = work.sum.get(neuron).sin_cos(simd);
                work.activation.set(neuron, &sin);
                slopes.set(neuron, &cos);
            }
        }
        self.layers[HIDDEN].apply(simd, true, &work.activation, &mut work.sum);
        let (residual, slope) = work.sum.get(0).softplus(simd);
        work.output_slope = slope;
        residual
    }

    /// Returns `∇r` at the centres of the boxes last given to [`BoxNetwork::residual`], plain numbers up to rounding.
    #[inline(always)]
    pub(crate) fn gradient_at_centre<S: Simd>(&self, simd: S, work: &Workspace<S>) -> [S::f64s; AXES] {
        let zero = simd.splat_f64s(0.0);
        let (mut lambda, mut mu) = ([zero; WIDEST], [zero; WIDEST]);
        mu[0] = work.output_slope.centre;
        self.layers[HIDDEN].apply_transposed(simd, &mu, &mut lambda);
        for (layer, slopes) in self.layers[..HIDDEN].iter().zip(&work.slopes).rev() {
            for neuron in 0..WIDEST {
                mu[neuron] = simd.mul_f64s(lambda[neuron], slopes.centre(neuron));
            }
            layer.apply_transposed(simd, &mu, &mut lambda);
        }
        match self.encoding {
            InputEncoding::Raw => [lambda[0], lambda[1], lambda[2], lambda[3]],
            InputEncoding::HeadingCosSin => {
                let [cos, sin] = work.heading.map(|form| form.centre);
                let by_sin = simd.mul_f64s(lambda[3], cos);
                let by_heading = simd.sub_f64s(by_sin, simd.mul_f64s(lambda[2], sin));
                [lambda[0], lambda[1], by_heading, lambda[4]]
            }
            InputEncoding::Position => [lambda[0], lambda[1], zero, zero],
        }
    }

    /// Returns `∇r · direction` on the boxes last given to [`BoxNetwork::residual`].
    #[inline(always)]
    pub(crate) fn derivative<S: Simd>(
        &self,
        simd: S,
        direction: &[Form<S>; AXES],
        work: &mut Workspace<S>,
    ) -> Form<S> {
        match self.encoding {
            InputEncoding::Raw => {
                for (input, form) in direction.iter().enumerate() {
                    work.activation.set(input, form);
                }
            }
            InputEncoding::HeadingCosSin => {
                let [cos, sin] = work.heading;
                let of_sin = cos.times(simd, &direction[2]);
                let zero = Form::constant(simd, simd.splat_f64s(0.0));
                let of_cos = zero.minus(simd, &sin.times(simd, &direction[2]));
                let inputs = [direction[0], direction[1], of_cos, of_sin, direction[3]];
                for (input, form) in inputs.iter().enumerate() {
                    work.activation.set(input, form);
                }
            }
            InputEncoding::Position => {
                work.activation.set(0, &direction[0]);
                work.activation.set(1, &direction[1]);
            }
        }
        for (layer, slopes) in self.layers.iter().zip(&work.slopes) {
            layer.apply(simd, false, &work.activation, &mut work.sum);
            for neuron in 0..layer.outputs {
                let product = work.sum.get(neuron).times(simd, &slopes.get(neuron));
                work.activation.set(neuron, &product);
            }
        }
        self.layers[HIDDEN].apply(simd, false, &work.activation, &mut work.sum);
        work.sum.get(0).times(simd, &work.output_slope)
    }
}
