//! Mixed scenes: which model holds for an obstacle, by what perception calls it. Not here: the evaluation (`barrier`).

use barrier::{CompositeBarrier, CompositeSetupError, Model};
use messages::{Obstacle, ObstacleClass};
use settings::{ClassName, FilterSettings};

use crate::model::{FilterSetupError, load_model};

/// Up to this speed a thing counts as standing, m/s: an estimate of a thing at rest is not exactly zero.
const STANDING_MPS: f64 = 0.2;

/// Number of obstacle classes on the wire, whose codes count from 0.
const CLASSES: usize = ObstacleClass::ALL.len();

/// The composite's models by class of obstacle.
pub(crate) struct ClassModels {
    /// Index of the model, by the class's code on the wire.
    by_class: [usize; CLASSES],
    /// Speed up to which each model holds, m/s.
    covered_mps: Vec<f64>,
}

impl ClassModels {
    /// Loads the models of `filter.class_models` and adds them to `composite`, whose first model is `default`. A file named
    /// for several classes is loaded once.
    ///
    /// # Errors
    /// [`FilterSetupError`] if a file cannot be used, or a model is for another robot than `default` or leaves no room for
    /// contact at `contact_radius_m`.
    pub(crate) fn add_to(
        composite: &mut CompositeBarrier,
        settings: &FilterSettings,
        default: &Model,
        contact_radius_m: f64,
    ) -> Result<Self, FilterSetupError> {
        let mut models = Self { by_class: [0; CLASSES], covered_mps: vec![default.covered_speed_mps()] };
        let mut names = vec![settings.model.as_str()];
        for (class, name) in &settings.class_models {
            let index = if let Some(index) = names.iter().position(|known| known == name) {
                index
            } else {
                let model = load_model(name)?;
                model
                    .check_same_robot(default)
                    .and_then(|()| model.check_covers(0.0, contact_radius_m))
                    .map_err(|source| FilterSetupError::ClassMismatch { name: name.clone(), source })?;
                models.covered_mps.push(model.covered_speed_mps());
                names.push(name);
                composite.add_model(&model).map_err(CompositeSetupError::from)?
            };
            models.by_class[code(*class)] = index;
        }
        Ok(models)
    }

    /// Index of the model for `obstacle`: that of its class, or the default one if the obstacle is faster than the former
    /// covers and the latter covers more. So a thing called static that moves is not taken for one that stands.
    pub(crate) fn of(&self, obstacle: &Obstacle) -> usize {
        let index = self.by_class.get(obstacle.class as usize).copied().unwrap_or(0);
        let covered_mps = self.covered_mps[index];
        let too_fast = obstacle.speed_mps > covered_mps.max(STANDING_MPS);
        if too_fast && self.covered_mps[0] > covered_mps { 0 } else { index }
    }
}

/// The class's code on the wire.
fn code(class: ClassName) -> usize {
    let class = match class {
        ClassName::Pedestrian => ObstacleClass::Pedestrian,
        ClassName::Cyclist => ObstacleClass::Cyclist,
        ClassName::Static => ObstacleClass::Static,
        ClassName::Vehicle => ObstacleClass::Vehicle,
    };
    class.code() as usize
}
