//! Which worlds are run through: random ones by seed, or those of a file.

use std::path::Path;

use crowd_sim::{ScenarioFileError, read_scenarios};
use perception_bridge::{SimulationError, simulated_scenario};
use settings::Settings;

use crate::hash::short_hash;

/// One world.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// Its name, unique among those of equal crowd size.
    pub name: String,
    /// Number of people.
    pub people: u32,
    /// Seed of everything random in it.
    pub seed: u64,
    /// What a file says; drawn as the settings say if absent.
    world: Option<crowd_sim::Scenario>,
}

impl Scenario {
    /// The random scenario of `seed` with `people` people, drawn as the settings' `[simulation]` says.
    pub fn random(seed: u64, people: u32) -> Self {
        Self { name: format!("seed-{seed:05}"), people, seed, world: None }
    }

    /// Random scenarios of `count` consecutive seeds from `first_seed`, for each crowd size. The same seed gives every
    /// size the same first people.
    pub fn random_set(first_seed: u64, count: u64, people: &[u32]) -> Vec<Self> {
        people
            .iter()
            .flat_map(|&people| (0..count).map(move |index| Self::random(first_seed + index, people)))
            .collect()
    }

    /// Every scenario of a file, in its order. `docs/scenarios.md` describes the format.
    ///
    /// # Errors
    /// [`ScenarioFileError`] if the file cannot be read or says something that cannot be run.
    pub fn from_file(path: &Path) -> Result<Vec<Self>, ScenarioFileError> {
        let worlds = read_scenarios(path)?.into_iter();
        Ok(worlds
            .map(|world| Self {
                name: world.name.clone(),
                people: world.people.len() as u32,
                seed: world.seed,
                world: Some(world),
            })
            .collect())
    }

    /// `settings` with this scenario's seed and number of people.
    #[must_use]
    pub(crate) fn applied_to(&self, settings: &Settings) -> Settings {
        let mut settings = settings.clone();
        settings.simulation.seed = self.seed;
        settings.simulation.people = self.people as usize;
        settings
    }

    /// Everybody's start under `settings`, to which this scenario [was applied](Self::applied_to).
    pub(crate) fn world(&self, settings: &Settings) -> Result<crowd_sim::Scenario, SimulationError> {
        match &self.world {
            Some(world) => Ok(world.clone()),
            None => simulated_scenario(settings),
        }
    }

    /// What tells this scenario from another of the same name. Random ones also depend on the settings.
    pub(crate) fn hash(&self) -> String {
        let world = self.world.as_ref().map(serde_json::to_string).transpose().unwrap_or_default();
        short_hash(format!("{} {} {} {world:?}", self.name, self.people, self.seed).as_bytes())
    }
}
