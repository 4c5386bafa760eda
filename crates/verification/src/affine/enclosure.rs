//! The CBF condition on boxes, several boxes at once: what the search asks for every box.
//!
//! ```text
//! C(z) = max_u min_d ∇h̄(z)·ζ(z, u, d) + α h̄(z),   h̄ = ℓ − r,   ∇h̄·ζ = ∇ℓ·ζ − ∂r/∂ζ
//! ```

#![allow(clippy::inline_always)] // see `form`

use barrier::{FailureFunction, Model};
use pulp::{Arch, Simd, WithSimd};

use super::elementary::MOST_LANES;
use super::form::{AXES, Form, PRODUCTS};
use super::game::{Game, ObstacleChoice};
use super::network::{BoxNetwork, Workspace};
use super::quadratic::Quadratic;
use super::rounding::{ROUNDING, WIDEN};

/// A box of relative states by centre and half-widths, units as the pair in `dynamics` states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CentredBox {
    pub(crate) centre: [f64; AXES],
    pub(crate) half_width: [f64; AXES],
}

/// What is known about one box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Enclosure {
    /// `ℓ` is nowhere above, m.
    pub(crate) failure_upper_m: f64,
    /// `h̄`.
    pub(crate) barrier: Quadratic,
    /// A lower bound of `C` for each end of each choice of the obstacle; `C` is above the least of them.
    pub(crate) conditions: [Quadratic; ENDS],
    /// How many of them are in use.
    pub(crate) condition_count: usize,
}

/// Most combinations of the obstacle's ends.
const ENDS: usize = 4;
const NOTHING: Quadratic =
    Quadratic { centre: 0.0, linear: [0.0; AXES], quadratic: [0.0; PRODUCTS], radius: f64::INFINITY };

impl Enclosure {
    const NOTHING: Self = Self {
        failure_upper_m: f64::INFINITY,
        barrier: NOTHING,
        conditions: [NOTHING; ENDS],
        condition_count: 1,
    };

    /// Returns a number that `C` is nowhere below on the part of the box where `h̄ ≥ 0`, and the Taylor model whose bound
    /// that is; no number where nothing is known.
    pub(crate) fn condition_lower(&self) -> (f64, Quadratic) {
        let bounds = self.conditions[..self.condition_count].iter();
        let mut bounds = bounds.map(|condition| condition.lower_bound_where(&self.barrier));
        let mut lowest = (f64::NAN, NOTHING);
        if let Some(first) = bounds.next() {
            lowest = first;
        }
        for bound in bounds {
            // What is no number proves nothing, so it is the lowest of all.
            if bound.0.is_nan() || bound.0 < lowest.0 {
                lowest = bound;
            }
        }
        lowest
    }

    /// Returns `C` at the centre, exact up to rounding.
    pub(crate) fn condition_at_centre(&self) -> f64 {
        self.conditions[..self.condition_count].iter().map(|c| c.centre).fold(f64::INFINITY, f64::min)
    }
}

/// Model, game and `α`, laid out for boxes.
pub(crate) struct BoxCondition {
    network: BoxNetwork,
    game: Game,
    choices: Vec<ObstacleChoice>,
    alpha_per_s: f64,
    failure: FailureFunction,
}

impl BoxCondition {
    /// Prepares `model` with its true boxes and its own radius.
    pub(crate) fn new(model: &Model, alpha_per_s: f64) -> Self {
        let game = Game::new(model.metadata());
        Self {
            network: BoxNetwork::new(model.weights()),
            choices: game.choices(),
            game,
            alpha_per_s,
            failure: FailureFunction { radius_m: model.metadata().failure_radius_m },
        }
    }

    /// The network.
    pub(crate) fn network(&self) -> &BoxNetwork {
        &self.network
    }

    /// `R`, m.
    pub(crate) fn failure_radius_m(&self) -> f64 {
        self.failure.radius_m
    }

    /// Encloses every box, in order, on the widest vectors of this processor.
    pub(crate) fn enclose(&self, boxes: &[CentredBox]) -> Vec<Enclosure> {
        self.enclose_on(Arch::new(), boxes)
    }

    /// As [`BoxCondition::enclose`] on a chosen instruction set.
    pub(crate) fn enclose_on(&self, arch: Arch, boxes: &[CentredBox]) -> Vec<Enclosure> {
        let mut enclosures = vec![Enclosure::NOTHING; boxes.len()];
        arch.dispatch(Task { condition: self, boxes, enclosures: &mut enclosures });
        enclosures
    }

    #[inline(always)]
    fn group<S: Simd>(
        &self,
        simd: S,
        boxes: &[CentredBox],
        work: &mut Workspace<S>,
        enclosures: &mut [Enclosure],
    ) {
        let gathered = |component: &dyn Fn(&CentredBox) -> f64| {
            let mut lanes = [0.0; MOST_LANES];
            for lane in 0..S::F64_LANES {
                lanes[lane] = component(&boxes[lane.min(boxes.len() - 1)]);
            }
            simd.partial_load_f64s(&lanes[..S::F64_LANES])
        };
        let centre: [S::f64s; AXES] = core::array::from_fn(|i| gathered(&|b| b.centre[i]));
        let z: [Form<S>; AXES] =
            core::array::from_fn(|i| Form::coordinate(simd, i, centre[i], gathered(&|b| b.half_width[i])));

        let residual = self.network.residual(simd, &z, work);
        let residual_gradient = self.network.gradient_at_centre(simd, work);
        let inputs = self.inputs(simd, &centre, &residual_gradient);
        let flow = self.game.flow(simd, &z, inputs);

        let squared = z[0].times(simd, &z[0]).plus(simd, &z[1].times(simd, &z[1]));
        let (distance, inverse_distance) = squared.square_roots(simd, gathered(&least_squared_distance));
        let radius = Form::constant(simd, simd.splat_f64s(self.failure.radius_m));
        let barrier = distance.minus(simd, &radius).minus(simd, &residual);

        let towards = z[0].times(simd, &flow.unrotated[0]).plus(simd, &z[1].times(simd, &flow.unrotated[1]));
        let failure_rate = towards.times(simd, &inverse_distance);
        let residual_rate = self.network.derivative(simd, &flow.rate, work);
        let rate = failure_rate.minus(simd, &residual_rate);
        let condition = barrier.scaled_plus(simd, simd.splat_f64s(self.alpha_per_s), &rate);

        let zero = Form::constant(simd, simd.splat_f64s(0.0));
        let mut by_choice = [zero; 2];
        for (by_choice, choice) in by_choice.iter_mut().zip(&self.choices) {
            let mut direction = [zero; AXES];
            direction[choice.axis] = Form::constant(simd, simd.splat_f64s(1.0));
            // The failure function does not depend on these components.
            *by_choice = zero.minus(simd, &self.network.derivative(simd, &direction, work));
        }
        let barrier = scattered(simd, &barrier);
        let condition = scattered(simd, &condition);
        let by_choice = by_choice.map(|form| scattered(simd, &form));
        for (lane, enclosure) in enclosures.iter_mut().enumerate() {
            enclosure.failure_upper_m = farthest_m(&boxes[lane]) - self.failure.radius_m;
            enclosure.barrier = barrier[lane];
            enclosure.condition_count = 1 << self.choices.len();
            for (end, into) in enclosure.conditions[..enclosure.condition_count].iter_mut().enumerate() {
                *into = condition[lane];
                for (k, choice) in self.choices.iter().enumerate() {
                    *into = into.plus(choice.rates[(end >> k) & 1], &by_choice[k][lane]);
                }
            }
        }
    }

    /// Decides the inputs of every lane from the gradient of `h̄` at its centre.
    #[inline(always)]
    fn inputs<S: Simd>(&self, simd: S, centre: &[S::f64s; AXES], gradient: &[S::f64s; AXES]) -> [S::f64s; 2] {
        let (centre, gradient) = (lanes(simd, centre), lanes(simd, gradient));
        let mut inputs = [[0.0; MOST_LANES]; 2];
        for lane in 0..S::F64_LANES {
            let z = core::array::from_fn(|i| centre[i][lane]);
            let by_failure = self.failure.gradient(&z);
            let p = core::array::from_fn(|i| by_failure[i] - gradient[i][lane]);
            let [first, second] = self.game.inputs(&z, &p);
            (inputs[0][lane], inputs[1][lane]) = (first, second);
        }
        inputs.map(|lanes| simd.partial_load_f64s(&lanes[..S::F64_LANES]))
    }
}

struct Task<'a> {
    condition: &'a BoxCondition,
    boxes: &'a [CentredBox],
    enclosures: &'a mut [Enclosure],
}

impl WithSimd for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut work = Workspace::new(simd);
        let groups = self.boxes.chunks(S::F64_LANES).zip(self.enclosures.chunks_mut(S::F64_LANES));
        for (boxes, enclosures) in groups {
            self.condition.group(simd, boxes, &mut work, enclosures);
        }
    }
}

/// Stores vectors lane by lane.
#[inline(always)]
fn lanes<S: Simd, const N: usize>(simd: S, vectors: &[S::f64s; N]) -> [[f64; MOST_LANES]; N] {
    vectors.map(|vector| {
        let mut lanes = [0.0; MOST_LANES];
        simd.partial_store_f64s(&mut lanes[..S::F64_LANES], vector);
        lanes
    })
}

/// Takes a form apart into one Taylor model per lane.
#[inline(always)]
fn scattered<S: Simd>(simd: S, form: &Form<S>) -> [Quadratic; MOST_LANES] {
    let [centre, radius] = lanes(simd, &[form.centre, form.radius]);
    let linear = lanes(simd, &form.linear);
    let quadratic = lanes(simd, &form.quadratic);
    core::array::from_fn(|lane| Quadratic {
        centre: centre[lane],
        linear: linear.map(|of_axis| of_axis[lane]),
        quadratic: quadratic.map(|of_pair| of_pair[lane]),
        radius: radius[lane],
    })
}

/// A number that `x² + y²` is nowhere below on the box, m².
fn least_squared_distance(of: &CentredBox) -> f64 {
    let least = |i: usize| {
        let (centre, half_width) = (of.centre[i].abs(), of.half_width[i]);
        (centre - half_width - ROUNDING * (centre + half_width)).max(0.0)
    };
    (least(0) * least(0) + least(1) * least(1)) / WIDEN
}

/// A number that `√(x² + y²)` is nowhere above on the box, m.
fn farthest_m(of: &CentredBox) -> f64 {
    let most = |i: usize| of.centre[i].abs() + of.half_width[i];
    (most(0) * most(0) + most(1) * most(1)).sqrt() * WIDEN
}

#[cfg(test)]
#[path = "soundness_tests.rs"]
mod soundness_tests;
