//! What is fitted: a grid's residual or a closed form.

use crate::closed_form::{ClosedForm, ClosedFormSampler};
use crate::condition::ConditionStates;
use crate::pool::Pool;
use crate::residual_grid::ResidualGrid;
use crate::strata::Strata;
use crate::worst_case::WorstCase;
use settings::{ConditionSettings, TrainingSettings};
use sha2::{Digest, Sha256};

/// What is fitted.
#[derive(Clone, Copy)]
pub enum Target<'a> {
    /// A solved value function.
    Grid(&'a ResidualGrid),
    /// A value known in closed form.
    ClosedForm(&'a ClosedForm),
}

/// The condition a run asks for, and the game it holds in.
pub(crate) type Condition<'a> = Option<(ConditionSettings, &'a dyn WorstCase)>;

impl Target<'_> {
    /// Radius of the failure set, m.
    pub fn failure_radius_m(self) -> f64 {
        match self {
            Self::Grid(grid) => grid.failure_radius_m(),
            Self::ClosedForm(closed) => closed.failure_radius_m(),
        }
    }

    /// Draws all a run needs.
    pub(crate) fn draw<'g>(
        self,
        settings: &TrainingSettings,
        condition: Condition<'g>,
    ) -> (Pool, Option<ConditionStates<'g>>) {
        let run = (settings.seed, settings.samples.count);
        match self {
            Self::Grid(grid) => {
                let strata = Strata::of(grid, &settings.samples, settings.encoding);
                let states = condition.map(|(c, game)| ConditionStates::draw(&strata, c, game, run));
                (Pool::draw(&strata, settings), states)
            }
            Self::ClosedForm(target) => {
                let sampler = ClosedFormSampler { target, settings: settings.samples };
                let states = condition.map(|(c, game)| ConditionStates::draw(&sampler, c, game, run));
                (Pool::draw(&sampler, settings), states)
            }
        }
    }

    /// Adds all that the values depend on to `hash`.
    pub(crate) fn hash_into(self, hash: &mut Sha256) {
        hash.update(self.failure_radius_m().to_le_bytes());
        match self {
            Self::Grid(grid) => {
                for axis in grid.axes() {
                    hash.update(axis.min.to_le_bytes());
                    hash.update(axis.max.to_le_bytes());
                }
                for node in 0..grid.node_count() {
                    hash.update(grid.residual_m(node).to_le_bytes());
                }
            }
            Self::ClosedForm(closed) => closed.probe().for_each(|value| hash.update(value.to_le_bytes())),
        }
    }
}
