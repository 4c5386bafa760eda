//! Verification of a trained relative barrier: what holds for all states, what was measured, and what was certified.
//!
//! Nothing here prints, trains or drives a robot; records of what was found are plain data that a model's metadata keeps.

pub mod affine;
