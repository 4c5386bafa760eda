//! Fits the residual network to a value function.
