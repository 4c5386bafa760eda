//! Whether a model fits a robot: dynamics, bounds, radius, speed, and whether it is the one meant.
//!
//! Not here: what a robot's settings say (`settings`), and the refusal (`cbf_filter`).

use dynamics::InputBox;

use crate::metadata::{Bounds, DynamicsKind};
use crate::model::Model;

/// What a robot needs a model to have been made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Expected {
    /// Pair of dynamics.
    pub dynamics: DynamicsKind,
    /// Box of the robot's control.
    pub control: InputBox<2>,
    /// Box of the obstacles' disturbance.
    pub disturbance: Bounds,
    /// Radius of the failure function, m; `None` where each obstacle brings its own, which is exact (see
    /// [`crate::RelativeBarrier`]).
    pub failure_radius_m: Option<f64>,
}

/// In what a model differs from what the robot needs.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelMismatch {
    /// Another pair of dynamics.
    #[error("the model is for `{model}`, the robot needs `{expected}`; choose its model or set `dynamics`")]
    Dynamics {
        /// Of the model.
        model: DynamicsKind,
        /// Of the robot.
        expected: DynamicsKind,
    },
    /// A box of controls that the robot does not have, or not wholly.
    #[error(
        "the model's control box is {model:?}, the robot's {expected:?} lacks a part of it; solve and train for the robot's"
    )]
    Control {
        /// Of the model.
        model: InputBox<2>,
        /// Of the robot.
        expected: InputBox<2>,
    },
    /// Another box of disturbances.
    #[error(
        "the model's disturbance box is {model:?}, configured {expected:?}; solve and train for the latter"
    )]
    Disturbance {
        /// Of the model.
        model: Bounds,
        /// As configured.
        expected: Bounds,
    },
    /// Another radius.
    #[error("the model's failure radius is {model_m} m, configured {expected_m} m; make the two agree")]
    Radius {
        /// Of the model, m.
        model_m: f64,
        /// As configured, m.
        expected_m: f64,
    },
    /// Another model than the one pinned.
    #[error(
        "the model has SHA-256 {model}, pinned is {expected}; give the model meant, or pin this one once you trust it"
    )]
    Hash {
        /// Of the model.
        model: String,
        /// As pinned.
        expected: String,
    },
    /// Obstacles may move faster than the model knows.
    #[error(
        "obstacles may reach {expected_mps} m/s, the model covers {model_mps} m/s; lower `obstacle.max_speed_mps` or \
         solve and train on a wider speed axis"
    )]
    Speed {
        /// Covered by the model, m/s.
        model_mps: f64,
        /// As configured, m/s.
        expected_mps: f64,
    },
    /// The disc of contact, buffer included, reaches the edge of the trained domain.
    #[error(
        "contact counts from {radius_m} m on, buffer included, and the model knows {reach_m} m around the robot; lower \
         `filter.sdf_buffer_m` or solve and train on a larger grid"
    )]
    Reach {
        /// Distance from the robot to the nearest edge of the trained domain, m.
        reach_m: f64,
        /// Distance of the centres that counts as contact, m.
        radius_m: f64,
    },
}

impl Model {
    /// Compares what the model was made for with what the robot needs. Bounds agree within 1e-9, but the robot may have more
    /// controls than the model counts on: whichever of those keeps the CBF condition, the robot has it too.
    ///
    /// # Errors
    /// * The first [`ModelMismatch`] found.
    pub fn check_fits(&self, expected: &Expected) -> Result<(), ModelMismatch> {
        let model = self.metadata();
        if model.dynamics != expected.dynamics {
            return Err(ModelMismatch::Dynamics { model: model.dynamics, expected: expected.dynamics });
        }
        if !contains(&expected.control, &model.control) {
            return Err(ModelMismatch::Control { model: model.control, expected: expected.control });
        }
        if !close(&model.disturbance, &expected.disturbance) {
            let (model, expected) = (model.disturbance.clone(), expected.disturbance.clone());
            return Err(ModelMismatch::Disturbance { model, expected });
        }
        match expected.failure_radius_m {
            Some(expected_m) if (expected_m - model.failure_radius_m).abs() > TOLERANCE => {
                Err(ModelMismatch::Radius { model_m: model.failure_radius_m, expected_m })
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Refuses any model but the one whose hash is `sha256`, hexadecimal digits in either case.
    ///
    /// # Errors
    /// * [`ModelMismatch::Hash`].
    pub fn check_hash(&self, sha256: &str) -> Result<(), ModelMismatch> {
        let model = &self.metadata().hash;
        if model.eq_ignore_ascii_case(sha256) {
            return Ok(());
        }
        Err(ModelMismatch::Hash { model: model.clone(), expected: sha256.to_owned() })
    }

    /// Checks that the model is for the same robot as `other`, so that one composite can hold both; obstacles may differ.
    ///
    /// # Errors
    /// * [`ModelMismatch::Dynamics`], [`ModelMismatch::Control`].
    pub fn check_same_robot(&self, other: &Self) -> Result<(), ModelMismatch> {
        let (model, expected) = (self.metadata(), other.metadata());
        if !model.dynamics.shares_robot_with(expected.dynamics) {
            return Err(ModelMismatch::Dynamics { model: model.dynamics, expected: expected.dynamics });
        }
        if !close(&Bounds::from(&model.control), &Bounds::from(&expected.control)) {
            return Err(ModelMismatch::Control { model: model.control, expected: expected.control });
        }
        Ok(())
    }

    /// Returns the speed up to which obstacles lie in the trained domain, m/s; 0 for a model of static obstacles. For a
    /// double integrator it is that of a robot at rest.
    pub fn covered_speed_mps(&self) -> f64 {
        match self.metadata().dynamics {
            DynamicsKind::UnicyclePair => self.metadata().grid.max[3],
            DynamicsKind::DoubleIntegratorPair => self.reach(2).min(self.reach(3)),
            DynamicsKind::UnicycleStaticPair => 0.0,
        }
    }

    /// Distance from 0 to the nearer end of an axis of the trained domain.
    fn reach(&self, axis: usize) -> f64 {
        self.metadata().grid.max[axis].min(-self.metadata().grid.min[axis])
    }

    /// Checks that obstacles of up to `max_speed_mps` lie in the trained domain, and the disc of contact of `radius_m`
    /// (robot, obstacle and buffer) inside of it.
    ///
    /// The relative velocity of a double integrator is asked to cover a robot at rest; what its own speed adds is counted
    /// while it drives, as [`crate::RelativeSample::outside_domain`].
    ///
    /// # Errors
    /// * [`ModelMismatch::Speed`], [`ModelMismatch::Reach`].
    pub fn check_covers(&self, max_speed_mps: f64, radius_m: f64) -> Result<(), ModelMismatch> {
        let model_mps = self.covered_speed_mps();
        if max_speed_mps > model_mps + TOLERANCE {
            return Err(ModelMismatch::Speed { model_mps, expected_mps: max_speed_mps });
        }
        let reach_m = self.reach(0).min(self.reach(1));
        if radius_m >= reach_m {
            return Err(ModelMismatch::Reach { reach_m, radius_m });
        }
        Ok(())
    }
}

/// Two bounds this close are one bound written twice.
const TOLERANCE: f64 = 1e-9;

fn close(a: &Bounds, b: &Bounds) -> bool {
    let equal =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= TOLERANCE);
    equal(&a.min, &b.min) && equal(&a.max, &b.max)
}

/// Whether every control of `inner` is one of `outer`.
fn contains(outer: &InputBox<2>, inner: &InputBox<2>) -> bool {
    (0..2).all(|k| outer.min[k] <= inner.min[k] + TOLERANCE && outer.max[k] >= inner.max[k] - TOLERANCE)
}
