//! Closed boxes of admissible inputs. Not here: which input is optimal (`relative`).

use serde::{Deserialize, Serialize};

/// Closed box of inputs, one interval per component, each in the unit of that component.
///
/// Serialised as `{ min = [...], max = [...] }`; reading checks the same rules as [`InputBox::new`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "Bounds", try_from = "Bounds")]
pub struct InputBox<const N: usize> {
    /// Lower ends.
    pub min: [f64; N],
    /// Upper ends, none below its lower end.
    pub max: [f64; N],
}

/// Why a pair of bounds is no box of inputs.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum InputBoxError {
    /// A bound is NaN or infinite.
    #[error("bounds of input {component} are not finite ({min} to {max}); give finite limits")]
    NonFinite {
        /// Index of the input.
        component: usize,
        /// Lower end given.
        min: f64,
        /// Upper end given.
        max: f64,
    },
    /// The lower end lies above the upper end.
    #[error("input {component} has no value between {min} and {max}; swap or widen the limits")]
    Empty {
        /// Index of the input.
        component: usize,
        /// Lower end given.
        min: f64,
        /// Upper end given.
        max: f64,
    },
    /// The number of bounds differs from the number of inputs.
    #[error("{given} bounds given for {expected} inputs; list one lower and one upper limit per input")]
    WrongLength {
        /// Inputs of the dynamics.
        expected: usize,
        /// Bounds found.
        given: usize,
    },
}

impl<const N: usize> InputBox<N> {
    /// Returns the box `min ≤ input ≤ max`; an interval may be a single point.
    ///
    /// # Errors
    /// * [`InputBoxError::NonFinite`] for a NaN or infinite bound.
    /// * [`InputBoxError::Empty`] where a lower end lies above its upper end.
    pub fn new(min: [f64; N], max: [f64; N]) -> Result<Self, InputBoxError> {
        for component in 0..N {
            let (min, max) = (min[component], max[component]);
            if !(min.is_finite() && max.is_finite()) {
                return Err(InputBoxError::NonFinite { component, min, max });
            }
            if min > max {
                return Err(InputBoxError::Empty { component, min, max });
            }
        }
        Ok(Self { min, max })
    }

    /// Returns the box with ends whose number is known at run time only, as files and settings give them.
    ///
    /// # Errors
    /// * [`InputBoxError::WrongLength`] unless both have `N` components; otherwise as [`InputBox::new`].
    pub fn from_slices(min: &[f64], max: &[f64]) -> Result<Self, InputBoxError> {
        let array = |ends: &[f64]| {
            <[f64; N]>::try_from(ends)
                .map_err(|_| InputBoxError::WrongLength { expected: N, given: ends.len() })
        };
        Self::new(array(min)?, array(max)?)
    }

    /// Returns the nearest input inside the box; a NaN component stays NaN.
    pub fn clamp(&self, input: &[f64; N]) -> [f64; N] {
        std::array::from_fn(|j| input[j].clamp(self.min[j], self.max[j]))
    }

    /// Returns whether `input` lies in the box, its faces included.
    pub fn contains(&self, input: &[f64; N]) -> bool {
        (0..N).all(|j| self.min[j] <= input[j] && input[j] <= self.max[j])
    }
}

/// The written form: `serde` knows arrays of fixed lengths only up to literals.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Bounds {
    min: Vec<f64>,
    max: Vec<f64>,
}

impl<const N: usize> From<InputBox<N>> for Bounds {
    fn from(input: InputBox<N>) -> Self {
        Self { min: input.min.to_vec(), max: input.max.to_vec() }
    }
}

impl<const N: usize> TryFrom<Bounds> for InputBox<N> {
    type Error = InputBoxError;

    fn try_from(bounds: Bounds) -> Result<Self, InputBoxError> {
        Self::from_slices(&bounds.min, &bounds.max)
    }
}
