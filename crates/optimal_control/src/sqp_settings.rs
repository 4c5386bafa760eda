//! What a person chooses of an SQP problem, and the check that it makes sense.

/// Diagonal weights of `J = Σ_{k<N} (x_k−r)ᵀQ(x_k−r) + u_kᵀR u_k + (x_N−r)ᵀQ_N(x_N−r)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuadraticWeights<const NX: usize, const NU: usize> {
    /// Diagonal of `Q`, 1 per state unit squared, each ≥ 0.
    pub stage_state: [f64; NX],
    /// Diagonal of `Q_N`, each ≥ 0.
    pub terminal_state: [f64; NX],
    /// Diagonal of `R`, 1 per input unit squared, each > 0, which keeps every QP strictly convex in the controls.
    pub control: [f64; NU],
}

/// An optimal control problem without its start and its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SqpSettings<const NX: usize, const NU: usize> {
    /// Steps `N` of the horizon.
    pub horizon_steps: usize,
    /// The cost.
    pub weights: QuadraticWeights<NX, NU>,
    /// Lower end of the input box.
    pub control_min: [f64; NU],
    /// Upper end of the input box, above the lower one in each component.
    pub control_max: [f64; NU],
    /// QPs solved at most per call. 1 is the real-time iteration.
    pub iteration_limit: u32,
    /// A QP step that changes no control by more than this ends the search as converged, in input units.
    pub step_tolerance: f64,
}

/// Why an [`crate::Sqp`] cannot be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SqpSetupError {
    /// No steps at all.
    #[error("the horizon has no steps; give at least one")]
    EmptyHorizon,
    /// Nothing would ever be solved.
    #[error("iteration_limit is 0; give at least one")]
    NoIterations,
    /// A tolerance or a step length that is not a positive number.
    #[error("{quantity} is {value}; it must be finite and above zero")]
    NotPositive {
        /// Its name.
        quantity: &'static str,
        /// What was given.
        value: f64,
    },
    /// A weight that is not a number of the right sign.
    #[error("{weight}[{index}] is {value}; state weights must be finite and >= 0, control weights > 0")]
    Weight {
        /// Which diagonal.
        weight: &'static str,
        /// Which entry.
        index: usize,
        /// What was given.
        value: f64,
    },
    /// An input interval without interior.
    #[error("control {index} lies in [{min}, {max}]; both ends must be finite and min below max")]
    ControlBox {
        /// Which input.
        index: usize,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// The QP solver refused its own set-up.
    #[error("the QP solver refused the problem: {reason}")]
    Qp {
        /// Its words.
        reason: String,
    },
}

impl<const NX: usize, const NU: usize> SqpSettings<NX, NU> {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field found unusable.
    pub fn validate(&self) -> Result<(), SqpSetupError> {
        if self.horizon_steps == 0 {
            return Err(SqpSetupError::EmptyHorizon);
        }
        if self.iteration_limit == 0 {
            return Err(SqpSetupError::NoIterations);
        }
        require_positive("step_tolerance", self.step_tolerance)?;
        let weights = &self.weights;
        for (weight, values) in
            [("stage_state", &weights.stage_state), ("terminal_state", &weights.terminal_state)]
        {
            if let Some(index) = values.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
                return Err(SqpSetupError::Weight { weight, index, value: values[index] });
            }
        }
        if let Some(index) = weights.control.iter().position(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(SqpSetupError::Weight { weight: "control", index, value: weights.control[index] });
        }
        for index in 0..NU {
            let (min, max) = (self.control_min[index], self.control_max[index]);
            if !(min.is_finite() && max.is_finite() && min < max) {
                return Err(SqpSetupError::ControlBox { index, min, max });
            }
        }
        Ok(())
    }
}

pub(crate) fn require_positive(quantity: &'static str, value: f64) -> Result<(), SqpSetupError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(SqpSetupError::NotPositive { quantity, value })
    }
}
