//! What can go wrong, one enum per operation.

/// Why a grid cannot be a target.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// A radius that is no radius.
    #[error("the failure radius is {failure_radius_m} m; it must be finite and positive")]
    Radius {
        /// The radius, m.
        failure_radius_m: f64,
    },
    /// Values and nodes do not match.
    #[error("{values} values for a grid of {nodes} nodes; solve the value function again")]
    Count {
        /// Nodes of the grid.
        nodes: usize,
        /// Values given.
        values: usize,
    },
    /// NaN or infinity.
    #[error("the value at node {node} is not finite; solve the value function again")]
    NotFinite {
        /// Node.
        node: usize,
    },
    /// `V ≤ ℓ` does not hold, so there is no residual to fit.
    #[error(
        "V exceeds the failure function by {excess_m} m at node {node}; was it solved for another radius?"
    )]
    AboveFailureFunction {
        /// Node.
        node: usize,
        /// By how much, m.
        excess_m: f64,
    },
}

/// Why a training run gave no network.
#[derive(Debug, thiserror::Error)]
pub enum TrainError {
    /// A setting outside its range.
    #[error(transparent)]
    Settings(#[from] settings::SettingsError),
    /// The progress callback asked to stop.
    #[error("training was stopped in epoch {epoch}; start it again to get a model")]
    Stopped {
        /// Last finished epoch, from 1.
        epoch: u64,
    },
    /// Loss or weights left the finite numbers, or the loss ended at twice its lowest.
    #[error("the loss grew instead of falling by epoch {epoch}; lower `learning_rate`")]
    Diverged {
        /// Epoch, from 1.
        epoch: u64,
    },
    /// The settings ask for the barrier condition, and no game was given.
    #[error(
        "the settings have a table `offline.training.condition`, which needs the input boxes; give a game"
    )]
    NoGame,
    /// The checkpoint cannot be used or written.
    #[error(transparent)]
    Checkpoint(#[from] crate::checkpoint::CheckpointError),
}
