//! The stretches of the path from sensor to command that are measured.

use messages::Ledger;
use serde::{Deserialize, Serialize};

/// One measured stretch between two stamps of a [`Ledger`].
///
/// The stretches of detections, robot states and nominal commands are counted once for each of these messages, in the
/// first safe command that used it; those of the filter are counted in every cycle, lateness and period in those of its
/// timer: a cycle that an input began has no due time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Hop {
    /// Detections: first seen by the bridge → published by it.
    Bridge,
    /// Detections: published by the bridge → taken by the estimator.
    BridgeToEstimator,
    /// Obstacles: detections taken by the estimator → obstacles published.
    Estimator,
    /// Obstacles: published → a filter cycle began that used them first.
    EstimatorToFilter,
    /// Robot state: first seen by the bridge → a filter cycle began that used it first.
    RobotStateToFilter,
    /// Nominal command: robot state taken by the controller → command published.
    Nominal,
    /// Nominal command: published → a filter cycle began that used it first.
    NominalToFilter,
    /// Filter: oldest due time not served → cycle of the timer began.
    FilterLateness,
    /// Filter: cycle began → safe command computed.
    FilterCompute,
    /// Filter: safe command computed → handed over.
    FilterHandOver,
    /// Filter: one cycle of the timer began → the next one began, where no command in between is missing.
    FilterPeriod,
    /// Detections first seen by the bridge → first safe command that used them handed over.
    EndToEnd,
}

/// A pair of stamps, ns.
pub(crate) struct Stretch {
    pub(crate) start_ns: u64,
    pub(crate) end_ns: u64,
}

impl Hop {
    /// Every hop, in the order of the path.
    pub const ALL: [Self; 12] = [
        Self::Bridge,
        Self::BridgeToEstimator,
        Self::Estimator,
        Self::EstimatorToFilter,
        Self::RobotStateToFilter,
        Self::Nominal,
        Self::NominalToFilter,
        Self::FilterLateness,
        Self::FilterCompute,
        Self::FilterHandOver,
        Self::FilterPeriod,
        Self::EndToEnd,
    ];

    /// The hops measured once for each frame of detections.
    pub(crate) const OF_DETECTIONS: [Self; 5] =
        [Self::Bridge, Self::BridgeToEstimator, Self::Estimator, Self::EstimatorToFilter, Self::EndToEnd];

    /// The hops measured once for each nominal command.
    pub(crate) const OF_NOMINAL: [Self; 2] = [Self::Nominal, Self::NominalToFilter];

    /// The hops measured in every cycle from its own ledger.
    pub(crate) const OF_CYCLE: [Self; 2] = [Self::FilterCompute, Self::FilterHandOver];

    /// Position in [`Hop::ALL`].
    pub(crate) const fn index(self) -> usize {
        self as usize
    }

    /// Name in files and budgets.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Bridge => "bridge",
            Self::BridgeToEstimator => "bridge_to_estimator",
            Self::Estimator => "estimator",
            Self::EstimatorToFilter => "estimator_to_filter",
            Self::RobotStateToFilter => "robot_state_to_filter",
            Self::Nominal => "nominal",
            Self::NominalToFilter => "nominal_to_filter",
            Self::FilterLateness => "filter_lateness",
            Self::FilterCompute => "filter_compute",
            Self::FilterHandOver => "filter_hand_over",
            Self::FilterPeriod => "filter_period",
            Self::EndToEnd => "end_to_end",
        }
    }

    /// Name in tables and figures.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Bridge => "bridge",
            Self::BridgeToEstimator => "bridge > estimator",
            Self::Estimator => "estimator",
            Self::EstimatorToFilter => "estimator > filter",
            Self::RobotStateToFilter => "robot state > filter",
            Self::Nominal => "nominal",
            Self::NominalToFilter => "nominal > filter",
            Self::FilterLateness => "filter lateness",
            Self::FilterCompute => "filter compute",
            Self::FilterHandOver => "filter hand-over",
            Self::FilterPeriod => "filter period",
            Self::EndToEnd => "end to end",
        }
    }

    /// What lies between the two stamps, in one line.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Bridge => "detections first seen by the bridge to published by it",
            Self::BridgeToEstimator => "detections published to taken by the estimator",
            Self::Estimator => "detections taken to obstacles published",
            Self::EstimatorToFilter => "obstacles published to the first filter cycle that used them",
            Self::RobotStateToFilter => "robot state first seen to the first filter cycle that used it",
            Self::Nominal => "robot state taken by the controller to nominal command published",
            Self::NominalToFilter => "nominal command published to the first filter cycle that used it",
            Self::FilterLateness => "filter cycle due (the oldest due time not served) to begun by the timer",
            Self::FilterCompute => "filter cycle begun to command computed",
            Self::FilterHandOver => "command computed to handed over",
            Self::FilterPeriod => "one filter cycle of the timer begun to the next begun",
            Self::EndToEnd => "detections first seen to the first command that used them handed over",
        }
    }

    /// The two stamps in `ledger`; nothing where one of them was never set, or where the ledger alone does not tell.
    pub(crate) fn stretch(self, ledger: &Ledger) -> Option<Stretch> {
        let (start_ns, end_ns) = match self {
            Self::Bridge => (ledger.detections_ingress_ns, ledger.detections_published_ns),
            Self::BridgeToEstimator => (ledger.detections_published_ns, ledger.estimator_received_ns),
            Self::Estimator => (ledger.estimator_received_ns, ledger.estimator_published_ns),
            Self::EstimatorToFilter => {
                (ledger.estimator_published_ns, taken_ns(ledger, ledger.estimator_published_ns))
            }
            Self::RobotStateToFilter => {
                (ledger.robot_state_ingress_ns, taken_ns(ledger, ledger.robot_state_ingress_ns))
            }
            Self::Nominal => (ledger.nominal_received_ns, ledger.nominal_published_ns),
            Self::NominalToFilter => {
                (ledger.nominal_published_ns, taken_ns(ledger, ledger.nominal_published_ns))
            }
            Self::FilterCompute => (ledger.filter_woke_ns, ledger.filter_computed_ns),
            Self::FilterHandOver => (ledger.filter_computed_ns, ledger.filter_published_ns),
            Self::FilterLateness | Self::FilterPeriod => return None,
            Self::EndToEnd => (ledger.detections_ingress_ns, ledger.filter_published_ns),
        };
        (start_ns != 0 && end_ns != 0).then_some(Stretch { start_ns, end_ns })
    }
}

/// When the filter took an input that was sent at `sent_ns`: as its cycle began, or later where the input arrived just then,
/// which costs it no waiting. An input sent after the command was computed is a broken stamp, and left to show as such.
fn taken_ns(ledger: &Ledger, sent_ns: u64) -> u64 {
    if sent_ns <= ledger.filter_computed_ns {
        ledger.filter_woke_ns.max(sent_ns)
    } else {
        ledger.filter_woke_ns
    }
}

impl core::fmt::Display for Hop {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.pad(self.label())
    }
}
