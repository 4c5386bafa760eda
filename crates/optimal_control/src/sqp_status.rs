//! How a solve ended: the verdict is data, misuse is an error.

/// Why the search stopped. Every variant leaves controls within their box and states that obey the dynamics.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SqpStatus {
    /// The last QP asked for no change, promised none worth having, or described the whole step so well that another
    /// would promise none.
    Converged,
    /// The iteration limit came first. The cost, violated inequalities included, is no higher than the guess's.
    IterationLimit,
    /// Not even a short step along the QP's direction lowered the cost: optimal up to rounding, or a bad direction.
    NoDescent,
    /// A QP was not solved. What stands is the last iterate, the guess if this was the first QP.
    QpFailed,
}

/// Result of one solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SqpReport {
    /// Why the search stopped.
    pub status: SqpStatus,
    /// QPs solved.
    pub iterations: u32,
    /// Interior-point steps of all QPs together.
    pub qp_iterations: u32,
    /// `J` of the controls that stand.
    pub cost: f64,
    /// `J` of the guess.
    pub guess_cost: f64,
    /// `Σ max(0, −g)` of the controls that stand, each row in its own unit; 0 without inequalities.
    pub violation: f64,
    /// `min g` of the controls that stand: the inequalities hold where it is ≥ 0. `+∞` without any.
    pub smallest_row: f64,
}

/// Why a problem was not even tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SqpError {
    /// A NaN, an infinity, or a value whose cost overflows.
    #[error("{quantity} is not finite")]
    NonFinite {
        /// What was given.
        quantity: &'static str,
    },
}
