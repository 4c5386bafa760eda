//! What a model file says about its model. Not here: reading and writing it (`model_file`).

use std::collections::BTreeMap;

use dynamics::InputBox;
use serde::{Deserialize, Serialize};

use crate::encoding::InputEncoding;

/// Version of the metadata this crate reads and writes.
pub const FORMAT_VERSION: u32 = 2;

/// Where a model comes from and what it holds for; the JSON under the metadata key `cncbf`.
///
/// A field that is not listed here is refused when read, so an addition raises [`FORMAT_VERSION`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelMetadata {
    /// [`FORMAT_VERSION`] of the writer.
    pub format_version: u32,
    /// Relative dynamics the value function was solved for.
    pub dynamics: DynamicsKind,
    /// How the network takes the relative state.
    pub encoding: InputEncoding,
    /// Box of the robot's control, units as the dynamics state.
    pub control: InputBox<2>,
    /// Box of the obstacle's disturbance, units as the dynamics state.
    pub disturbance: Bounds,
    /// `R` of the failure function that was solved, m (see [`crate::RelativeBarrier`] on other radii).
    pub failure_radius_m: f64,
    /// Grid of the value function; its box is the trained domain.
    pub grid: GridRecord,
    /// Settings of the solver, by name, as its program wrote them.
    pub solver: BTreeMap<String, serde_json::Value>,
    /// How the network was fitted and how well.
    pub training: TrainingRecord,
    /// What was verified about the model, by kind of check; [`crate::Model::with_verification`] writes it.
    #[serde(default)]
    pub verification: BTreeMap<String, serde_json::Value>,
    /// SHA-256 of the value file's values, hexadecimal; empty where there is none.
    pub value_sha256: String,
    /// SHA-256 over metadata and parameters, hexadecimal; set when a [`crate::Model`] is made.
    #[serde(default)]
    pub hash: String,
}

/// A pair of `dynamics`, by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DynamicsKind {
    /// [`dynamics::UnicyclePair`].
    UnicyclePair,
    /// [`dynamics::DoubleIntegratorPair`].
    DoubleIntegratorPair,
    /// [`dynamics::UnicycleStaticPair`].
    UnicycleStaticPair,
}

impl DynamicsKind {
    /// Returns whether both describe the same robot, against obstacles of whatever kind.
    pub const fn shares_robot_with(self, other: Self) -> bool {
        match self {
            Self::UnicyclePair | Self::UnicycleStaticPair => {
                matches!(other, Self::UnicyclePair | Self::UnicycleStaticPair)
            }
            Self::DoubleIntegratorPair => matches!(other, Self::DoubleIntegratorPair),
        }
    }

    /// Returns how many components the obstacle's disturbance has.
    pub const fn disturbance_count(self) -> usize {
        match self {
            Self::UnicyclePair => 1,
            Self::DoubleIntegratorPair => 2,
            Self::UnicycleStaticPair => 0,
        }
    }
}

impl std::fmt::Display for DynamicsKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::UnicyclePair => "unicycle_pair",
            Self::DoubleIntegratorPair => "double_integrator_pair",
            Self::UnicycleStaticPair => "unicycle_static_pair",
        })
    }
}

/// A box whose number of components the dynamics decide.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lower ends.
    pub min: Vec<f64>,
    /// Upper ends.
    pub max: Vec<f64>,
}

impl<const N: usize> From<&InputBox<N>> for Bounds {
    fn from(input: &InputBox<N>) -> Self {
        Self { min: input.min.to_vec(), max: input.max.to_vec() }
    }
}

/// Grid of the value function, axes in the order of the relative state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridRecord {
    /// Lower ends, m, rad or m/s.
    pub min: [f64; 4],
    /// Upper ends; on a periodic axis `max − min` is the period.
    pub max: [f64; 4],
    /// Nodes per axis.
    pub count: [usize; 4],
    /// Which axes are periodic.
    pub periodic: [bool; 4],
}

/// How the network was fitted and how well it fits, errors as network minus value function. The default: not at all.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingRecord {
    /// Passes over the samples.
    pub epochs: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Samples per epoch.
    pub samples: u64,
    /// Mean absolute error over the states outside the failure set, m.
    pub error_mean_m: f64,
    /// 99th percentile of the absolute error there, m.
    pub error_p99_m: f64,
    /// Largest absolute error there, m.
    pub error_max_m: f64,
    /// Share of the unsafe states outside the failure set (`V < 0 < ℓ`) that the network calls safe, 0 to 1.
    pub false_safe_share: f64,
    /// Share of the safe states that the network calls unsafe, 0 to 1.
    pub false_unsafe_share: f64,
    /// What else the training reports or was set to, by name.
    pub details: BTreeMap<String, serde_json::Value>,
}
