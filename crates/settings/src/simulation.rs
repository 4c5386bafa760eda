//! The simulated crowd, and the simulated robot's task and actuators. How it is perceived is in `sensing`.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Checked, bounds, non_negative, positive, positive_ms, require};
use crate::{ClassesSettings, SensingSettings};

/// Slowest actuators simulated, ms.
const LONGEST_ACTUATOR_MS: f64 = 10_000.0;

/// People that walk by the social-force model and ignore the robot, and the robot's task among them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationSettings {
    /// Seed of the scenario; the same seed gives the same people on every machine.
    pub seed: u64,
    /// Number of people.
    pub people: usize,
    /// Rectangle people walk in, lower corner `[x, y]` in `odom`, m.
    pub arena_min_m: [f64; 2],
    /// Upper corner, m.
    pub arena_max_m: [f64; 2],
    /// Range of the people's desired speeds, m/s.
    pub desired_speed_mps: [f64; 2],
    /// Radius of a person, m.
    pub person_radius_m: f64,
    /// Robot's start `[x m, y m, heading rad]` in `odom`.
    pub start: [f64; 3],
    /// Robot's goal `[x m, y m, heading rad]` in `odom`.
    pub goal: [f64; 3],
    /// No person starts closer to the robot than this, m.
    pub start_clearance_m: f64,
    /// Largest acceleration of the simulated robot, m/s² (rad/s² for the yaw rate); 0 means it follows at once.
    pub acceleration_limit: f64,
    /// Step of the simulation, ms.
    pub step_ms: u64,
    /// Period of the robot state, ms; a multiple of `step_ms`.
    pub robot_state_period_ms: u64,
    /// Period of the detections, ms; a multiple of `step_ms`.
    pub detections_period_ms: u64,
    /// Standard deviation of the noise on detected positions, m.
    pub position_noise_m: f64,
    /// The run ends unsuccessfully after this, s.
    pub timeout_s: f64,
    /// A scenario of a file. It takes the place of seed, people, their classes, arena, speeds, radii, start, goal, its tolerance and timeout
    /// above; absent: people are drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenario: Option<ScenarioSettings>,
    /// Cyclists and standing things among the people drawn; pedestrians only if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub classes: Option<ClassesSettings>,
    /// How the simulated robot's actuators fall short; absent: they do at once what they are told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub actuators: Option<ActuatorSettings>,
    /// How perception falls short beyond `position_noise_m`; absent: everybody is seen, everywhere, at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensing: Option<SensingSettings>,
}

/// One scenario of a file; docs/scenarios.md describes the format.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScenarioSettings {
    /// The file; a relative path starts at the settings file's folder.
    pub file: PathBuf,
    /// Name of the scenario; absent: the first of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// Shortcomings of the simulated robot's actuators. Its acceleration is bounded by `simulation.acceleration_limit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorSettings {
    /// Time that passes before they begin to follow a command, ms; 0 if absent.
    #[serde(default)]
    pub delay_ms: f64,
    /// Time constant with which they then follow it (first order), ms; 0 if absent.
    #[serde(default)]
    pub lag_ms: f64,
}

impl ActuatorSettings {
    fn validate(&self) -> Checked {
        let bounded = |time_ms: f64| (0.0..=LONGEST_ACTUATOR_MS).contains(&time_ms);
        let requirement = "0 to 10000 ms";
        require(bounded(self.delay_ms), "simulation.actuators.delay_ms", self.delay_ms, requirement)?;
        require(bounded(self.lag_ms), "simulation.actuators.lag_ms", self.lag_ms, requirement)
    }
}

impl SimulationSettings {
    /// Resolves the scenario's file against the settings file's folder. It becomes absolute, because a stack's processes read
    /// settings that were written to another folder.
    pub(crate) fn resolve(&mut self, folder: &Path) {
        if let Some(scenario) = &mut self.scenario {
            let file = folder.join(&scenario.file);
            scenario.file = std::path::absolute(&file).unwrap_or(file);
        }
    }

    pub(crate) fn validate(&self) -> Checked {
        bounds("simulation.arena_min_m / arena_max_m", &self.arena_min_m, &self.arena_max_m)?;
        let [slowest, fastest] = self.desired_speed_mps;
        non_negative("simulation.desired_speed_mps", slowest)?;
        positive("simulation.desired_speed_mps", fastest)?;
        require(
            slowest <= fastest,
            "simulation.desired_speed_mps",
            self.desired_speed_mps,
            "in ascending order",
        )?;
        positive("simulation.person_radius_m", self.person_radius_m)?;
        bounds("simulation.start", &self.start, &self.start)?;
        bounds("simulation.goal", &self.goal, &self.goal)?;
        non_negative("simulation.start_clearance_m", self.start_clearance_m)?;
        non_negative("simulation.acceleration_limit", self.acceleration_limit)?;
        positive_ms("simulation.step_ms", self.step_ms)?;
        let multiple = |period: u64| period > 0 && period.is_multiple_of(self.step_ms);
        let requirement = "a positive multiple of simulation.step_ms";
        let (state, detections) = (self.robot_state_period_ms, self.detections_period_ms);
        require(multiple(state), "simulation.robot_state_period_ms", state, requirement)?;
        require(multiple(detections), "simulation.detections_period_ms", detections, requirement)?;
        non_negative("simulation.position_noise_m", self.position_noise_m)?;
        positive("simulation.timeout_s", self.timeout_s)?;
        self.classes.as_ref().map_or(Ok(()), ClassesSettings::validate)?;
        self.actuators.as_ref().map_or(Ok(()), ActuatorSettings::validate)?;
        self.sensing.as_ref().map_or(Ok(()), SensingSettings::validate)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{DriftSettings, Settings, SettingsError};

    const GROUND_ROBOT: &str = include_str!("../../../config/ground_robot.toml");

    fn with(tables: &str) -> Result<Settings, SettingsError> {
        let text = GROUND_ROBOT.replacen("[estimator]", &format!("{tables}\n[estimator]"), 1);
        Settings::parse(&text, Path::new("test.toml"), Path::new("config"))
    }

    #[test]
    fn everything_is_perfect_unless_a_file_says_otherwise() {
        let simulation = with("").expect("shipped").simulation;
        assert_eq!((simulation.scenario, simulation.actuators, simulation.sensing), (None, None, None));
    }

    #[test]
    fn shortcomings_survive_a_round_trip() {
        let settings = with(
            "[simulation.scenario]\nfile = \"crowds.json\"\nname = \"busy\"\n\
             [simulation.actuators]\nlag_ms = 80.5\n\
             [simulation.sensing]\nrange_m = 8.0\nfield_of_view_deg = 120.0\nwindow_m = 4.0\ndropout = 0.1\n\
             latency_ms = 100\nocclusion = true\nhide_velocity = true\ndrift = { sigma_m = 0.05, tau_s = 0.5 }\n",
        );
        let settings = settings.expect("valid");
        let scenario = settings.simulation.scenario.as_ref().expect("named");
        assert!(scenario.file.is_absolute() && scenario.file.ends_with("config/crowds.json"), "{scenario:?}");
        let sensing = settings.simulation.sensing.as_ref().expect("given");
        assert_eq!(sensing.drift, Some(DriftSettings { sigma_m: 0.05, tau_s: 0.5 }));
        let text = settings.to_toml().expect("has a TOML form");
        let again = Settings::parse(&text, Path::new("test.toml"), Path::new("")).expect("its own output");
        assert_eq!(again, settings);
    }

    #[test]
    fn what_no_sensor_or_actuator_does_is_refused_by_name() {
        for (table, key, value) in [
            ("actuators", "delay_ms", "-1.0"),
            ("actuators", "lag_ms", "1e9"),
            ("sensing", "range_m", "0.0"),
            ("sensing", "window_m", "-4.0"),
            ("sensing", "field_of_view_deg", "361.0"),
            ("sensing", "dropout", "1.5"),
            ("sensing", "latency_ms", "5000"),
            ("sensing", "drift", "{ sigma_m = 0.1, tau_s = 0.0 }"),
            ("sensing", "drift", "{ sigma_m = -0.1, tau_s = 1.0 }"),
        ] {
            let error = with(&format!("[simulation.{table}]\n{key} = {value}\n")).expect_err(key).to_string();
            assert!(error.contains(&format!("simulation.{table}.{key}")), "{error}");
        }
        let error = with("[simulation.sensing]\nrange_cm = 3\n").expect_err("unknown").to_string();
        assert!(error.contains("range_cm"), "{error}");
    }
}
