//! What a model is compared with: a solved grid, or a closed form where there is one.
//!
//! Not here: how either is computed (`reachability`).

use barrier::{DynamicsKind, ModelMetadata};
use dynamics::InputBox;
use reachability::ValueFunction;
use reachability::closed_form::DoubleIntegratorValue;

use crate::error::VerificationError;

/// A value function taken for true.
pub trait TrueValue: Sync {
    /// Returns `V(z)`, m; nothing where the truth does not reach.
    fn value_m(&self, z: &[f64; 4]) -> Option<f64>;

    /// Says in a line what the truth is and how exact.
    fn description(&self) -> String;

    /// Refuses a truth for another game than the model's: pair, true boxes, radius.
    ///
    /// # Errors
    /// * [`VerificationError::AnotherGame`].
    fn check_fits(&self, metadata: &ModelMetadata) -> Result<(), VerificationError>;
}

impl TrueValue for ValueFunction {
    fn value_m(&self, z: &[f64; 4]) -> Option<f64> {
        self.interpolate(z)
    }

    fn description(&self) -> String {
        let count = self.grid().axes().each_ref().map(|axis| axis.count.to_string()).join("x");
        let metadata = self.metadata();
        format!(
            "grid {count}, {:.1} s, linear between nodes, values {}",
            metadata.horizon_s,
            metadata.value_sha256.get(..12).unwrap_or_default()
        )
    }

    fn check_fits(&self, metadata: &ModelMetadata) -> Result<(), VerificationError> {
        let problem = &self.metadata().problem;
        let differ = |what, reference: String, model: String| {
            Err(VerificationError::AnotherGame { what, reference, model })
        };
        if problem.dynamics != metadata.dynamics.to_string() {
            return differ("pair", problem.dynamics.clone(), metadata.dynamics.to_string());
        }
        let (control, limits) = (&metadata.control, &problem.control);
        if !(close(&limits.min, &control.min) && close(&limits.max, &control.max)) {
            return differ("control box", format!("{limits:?}"), format!("{control:?}"));
        }
        let (disturbance, limits) = (&metadata.disturbance, &problem.disturbance);
        if !(close(&limits.min, &disturbance.min) && close(&limits.max, &disturbance.max)) {
            return differ("disturbance box", format!("{limits:?}"), format!("{disturbance:?}"));
        }
        if !close(&[problem.failure_radius_m], &[metadata.failure_radius_m]) {
            let metres = |radius: f64| format!("{radius} m");
            return differ("radius", metres(problem.failure_radius_m), metres(metadata.failure_radius_m));
        }
        Ok(())
    }
}

/// The closed form of the double-integrator pair for the game of one model.
#[derive(Debug, Clone)]
pub struct ClosedForm {
    value: DoubleIntegratorValue,
    metadata: ModelMetadata,
}

impl ClosedForm {
    /// Returns the closed form of the model's own game.
    ///
    /// # Errors
    /// * [`VerificationError::NoClosedForm`] for another pair than double integrators, or boxes it does not cover.
    /// * [`VerificationError::Disturbance`] for a disturbance box that does not fit the pair.
    pub fn of(metadata: &ModelMetadata) -> Result<Self, VerificationError> {
        let none = VerificationError::NoClosedForm { dynamics: metadata.dynamics };
        if metadata.dynamics != DynamicsKind::DoubleIntegratorPair {
            return Err(none);
        }
        let crate::Game::DoubleIntegrator(pair) = crate::Game::of(metadata)? else { return Err(none) };
        let disturbance: InputBox<2> = pair.disturbance;
        let value = DoubleIntegratorValue::new(&pair.control, &disturbance, metadata.failure_radius_m)
            .map_err(|_| none)?;
        Ok(Self { value, metadata: metadata.clone() })
    }
}

impl TrueValue for ClosedForm {
    fn value_m(&self, z: &[f64; 4]) -> Option<f64> {
        Some(self.value.value_m(z))
    }

    fn description(&self) -> String {
        "closed form of the double-integrator pair, no horizon".to_owned()
    }

    fn check_fits(&self, metadata: &ModelMetadata) -> Result<(), VerificationError> {
        let own = &self.metadata;
        let same = own.dynamics == metadata.dynamics
            && own.control == metadata.control
            && own.disturbance == metadata.disturbance
            && own.failure_radius_m == metadata.failure_radius_m;
        if same {
            Ok(())
        } else {
            let words = |metadata: &ModelMetadata| {
                format!("{}, R = {} m", metadata.dynamics, metadata.failure_radius_m)
            };
            Err(VerificationError::AnotherGame {
                what: "game",
                reference: words(own),
                model: words(metadata),
            })
        }
    }
}

/// Bounds this close are one bound written twice.
const TOLERANCE: f64 = 1e-9;

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= TOLERANCE)
}
