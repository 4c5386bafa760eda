//! Inequalities along a trajectory as [`crate::Sqp`] sees them. No particular one: obstacles are the business of the
//! planners that avoid them.

/// One step of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepPoint<const NX: usize, const NU: usize> {
    /// `k`, from 0.
    pub step: usize,
    /// `x_k`.
    pub state: [f64; NX],
    /// `u_k`.
    pub control: [f64; NU],
    /// `x_{k+1} = f(x_k, u_k)`.
    pub next: [f64; NX],
}

/// First-order expansion of one inequality `g(x_k, u_k, x_{k+1}) ≥ 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstraintRow<const NX: usize, const NU: usize> {
    /// `g`, in its own unit.
    pub value: f64,
    /// `∂g/∂x_k`, with `x_{k+1}` held.
    pub by_state: [f64; NX],
    /// `∂g/∂u_k`, with `x_{k+1}` held.
    pub by_control: [f64; NU],
    /// `∂g/∂x_{k+1}`.
    pub by_next: [f64; NX],
}

impl<const NX: usize, const NU: usize> ConstraintRow<NX, NU> {
    /// A row that holds by `value` whatever the trajectory.
    pub fn constant(value: f64) -> Self {
        Self { value, by_state: [0.0; NX], by_control: [0.0; NU], by_next: [0.0; NX] }
    }

    /// `g` after a change of the three arguments, to first order.
    pub(crate) fn after(&self, state: Option<&[f64]>, control: &[f64], next: &[f64]) -> f64 {
        let product = |gradient: &[f64], change: &[f64]| -> f64 {
            gradient.iter().zip(change).map(|(slope, delta)| slope * delta).sum()
        };
        self.value
            + state.map_or(0.0, |state| product(&self.by_state, state))
            + product(&self.by_control, control)
            + product(&self.by_next, next)
    }
}

/// Inequalities `g_m(x_k, u_k, x_{k+1}) ≥ 0`, the same number at every step of the horizon.
///
/// Methods take `&mut self` for buffers only: the same point gives the same rows. One that does not apply at some step
/// is a [`ConstraintRow::constant`] above zero.
pub trait StageConstraints<const NX: usize, const NU: usize> {
    /// How many inequalities each step has; never changes.
    fn rows_per_step(&self) -> usize;

    /// Writes the values `g_m`, one per inequality.
    fn values(&mut self, point: &StepPoint<NX, NU>, values: &mut [f64]);

    /// Writes values and exact gradients, one per inequality.
    fn linearise(&mut self, point: &StepPoint<NX, NU>, rows: &mut [ConstraintRow<NX, NU>]);

    /// Which entries of the gradients may ever differ from zero; the QP stores only those.
    fn sparsity(&self) -> ConstraintRow<NX, NU> {
        ConstraintRow { value: 1.0, by_state: [1.0; NX], by_control: [1.0; NU], by_next: [1.0; NX] }
    }
}

/// No inequalities beside the input box.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoConstraints;

impl<const NX: usize, const NU: usize> StageConstraints<NX, NU> for NoConstraints {
    #[inline]
    fn rows_per_step(&self) -> usize {
        0
    }

    #[inline]
    fn values(&mut self, _: &StepPoint<NX, NU>, _: &mut [f64]) {}

    #[inline]
    fn linearise(&mut self, _: &StepPoint<NX, NU>, _: &mut [ConstraintRow<NX, NU>]) {}

    fn sparsity(&self) -> ConstraintRow<NX, NU> {
        ConstraintRow::constant(0.0)
    }
}
