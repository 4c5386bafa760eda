//! Process 4: the barrier, its quadratic program and the limits of trust.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::EMBEDDED_PREFIX;
use crate::error::{Checked, non_negative, positive, positive_ms, require};
use crate::filter_options::{self, Composition, ObstacleInput, SoftminOffset, is_default};
use crate::{AnticipationSettings, JointSettings, RobotKind};

/// Which evaluation kernel computes the barrier.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum KernelChoice {
    /// The fastest this processor runs.
    Auto,
    /// Runs everywhere; the same bytes on every machine.
    Portable,
    /// x86-64 with AVX2 and FMA.
    Avx2Fma,
    /// x86-64 with AVX-512F; the same bytes as with AVX2 and FMA.
    Avx512,
}

/// What begins a cycle of the filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FilterTrigger {
    /// Its period alone: cycles at fixed due times.
    Timer,
    /// New obstacles, and one period after the last cycle where none come.
    Event,
    /// Fixed due times, and new obstacles in between, at most once between two due times.
    Both,
}

/// What perception says an obstacle is, as `[filter.class_models]` names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ClassName {
    /// A person on foot.
    Pedestrian,
    /// A person on a bicycle or scooter.
    Cyclist,
    /// Something that does not move.
    Static,
    /// Another robot or vehicle.
    Vehicle,
}

/// Settings of `cbf_filter`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterSettings {
    /// Model file, relative to the settings file, or `embedded:NAME`.
    pub model: String,
    /// SHA-256 the model must have, as `cncbf inspect` shows it; absent means any that fits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model_sha256: Option<String>,
    /// Filter period, ms.
    pub period_ms: u64,
    /// What begins a cycle.
    pub trigger: FilterTrigger,
    /// Linear class-κ gain: α(h) = k·h with this k, 1/s.
    pub alpha_per_s: f64,
    /// Smoothing β of the softmin, 1/m.
    pub beta_per_m: f64,
    /// Weight of the squared slack in the CBF-QP; the squared control correction has weight 1.
    pub slack_weight: f64,
    /// Slack up to this counts as met, m/s.
    pub slack_tolerance_mps: f64,
    /// Buffer added to every radius, m (the paper's hardware experiments use one).
    pub sdf_buffer_m: f64,
    /// Obstacles whose centre is farther than this are left out, m; absent means all are taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensing_range_m: Option<f64>,
    /// Motion the obstacle model does not explain: a radius grows by this times the age of its measurement, m/s.
    pub unexplained_motion_mps: f64,
    /// Oldest robot state that may be used, ms.
    pub robot_state_max_age_ms: u64,
    /// Longest silence of the estimator, ms.
    pub estimator_max_silence_ms: u64,
    /// Longest silence of perception, ms.
    pub detections_max_age_ms: u64,
    /// Longest silence of the nominal controller, ms.
    pub nominal_max_silence_ms: u64,
    /// A stamp this far ahead of the stack clock is refused, ms.
    pub future_tolerance_ms: u64,
    /// Evaluation kernel.
    pub kernel: KernelChoice,
    /// What is taken for the obstacles' own inputs; the estimate if absent.
    #[serde(default, skip_serializing_if = "is_default")]
    pub obstacle_input: ObstacleInput,
    /// How several barriers become conditions; one composite if absent.
    #[serde(default, skip_serializing_if = "is_default")]
    pub composition: Composition,
    /// What becomes of the softmin's offset; it stays if absent.
    #[serde(default, skip_serializing_if = "is_default")]
    pub softmin_offset: SoftminOffset,
    /// Time over which an obstacle that comes into sight begins to count, s; it counts at once if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appearance_ramp_s: Option<f64>,
    /// Speed along each axis that a double-integrator robot does not exceed, m/s: controls beyond it are left out. No limit if
    /// absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_max_speed_mps: Option<f64>,
    /// Models for obstacles of a class, written like `model`; a class that is absent, and `unknown`, take `model`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub class_models: BTreeMap<ClassName, String>,
    /// People treated jointly and ahead of time; not at all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<JointSettings>,
    /// A way through the crowd looked for ahead; not at all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub anticipation: Option<AnticipationSettings>,
}

impl FilterSettings {
    /// Resolves relative model paths against `folder`.
    pub(crate) fn resolve(&mut self, folder: &Path) {
        for model in std::iter::once(&mut self.model).chain(self.class_models.values_mut()) {
            if !model.is_empty() && !model.starts_with(EMBEDDED_PREFIX) {
                *model = folder.join(&*model).to_string_lossy().into_owned();
            }
        }
    }

    pub(crate) fn validate(&self, kind: RobotKind) -> Checked {
        require(!self.model.is_empty(), "filter.model", &self.model, "a file or embedded:NAME")?;
        let named = self.class_models.values().all(|model| !model.is_empty());
        require(named, "filter.class_models", &self.class_models, "a file or embedded:NAME for each class")?;
        if let Some(hash) = &self.model_sha256 {
            let digits = hash.len() == 64 && hash.bytes().all(|digit| digit.is_ascii_hexdigit());
            require(digits, "filter.model_sha256", hash, "64 hexadecimal digits, or absent")?;
        }
        positive_ms("filter.period_ms", self.period_ms)?;
        positive("filter.alpha_per_s", self.alpha_per_s)?;
        positive("filter.beta_per_m", self.beta_per_m)?;
        positive("filter.slack_weight", self.slack_weight)?;
        non_negative("filter.slack_tolerance_mps", self.slack_tolerance_mps)?;
        non_negative("filter.sdf_buffer_m", self.sdf_buffer_m)?;
        if let Some(range) = self.sensing_range_m {
            positive("filter.sensing_range_m", range)?;
        }
        non_negative("filter.unexplained_motion_mps", self.unexplained_motion_mps)?;
        positive_ms("filter.robot_state_max_age_ms", self.robot_state_max_age_ms)?;
        positive_ms("filter.estimator_max_silence_ms", self.estimator_max_silence_ms)?;
        positive_ms("filter.detections_max_age_ms", self.detections_max_age_ms)?;
        positive_ms("filter.nominal_max_silence_ms", self.nominal_max_silence_ms)?;
        positive_ms("filter.future_tolerance_ms", self.future_tolerance_ms)?;
        filter_options::validate(self, kind)?;
        self.joint.as_ref().map_or(Ok(()), JointSettings::validate)?;
        self.anticipation.as_ref().map_or(Ok(()), AnticipationSettings::validate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Settings, SettingsError};

    const SHIPPED: &str = include_str!("../../../config/ground_robot.toml");

    /// The shipped file with lines added to `[filter]` and a table after it.
    fn parse(lines: &str, table: &str) -> Result<Settings, SettingsError> {
        let text = SHIPPED.replace("[filter]", &format!("[filter]\n{lines}"));
        Settings::parse(&format!("{text}\n{table}"), Path::new("test.toml"), Path::new("config"))
    }

    #[test]
    fn class_models_are_resolved_like_the_model_and_survive_a_round_trip() {
        let table = "[filter.class_models]\ncyclist = \"cyclist.safetensors\"\nstatic = \"embedded:static\"";
        let settings = parse("", table).unwrap();
        let models: Vec<_> = settings.filter.class_models.values().map(String::as_str).collect();
        assert_eq!(models, ["config/cyclist.safetensors", "embedded:static"]);
        let again =
            Settings::parse(&settings.to_toml().unwrap(), Path::new("test.toml"), Path::new("")).unwrap();
        assert_eq!(again, settings);
    }

    #[test]
    fn an_unknown_class_or_a_class_without_model_is_named() {
        let message = parse("", "[filter.class_models]\ndragon = \"a\"").unwrap_err().to_string();
        assert!(message.contains("dragon") && message.contains("cyclist"), "{message}");
        let message = parse("", "[filter.class_models]\ncyclist = \"\"").unwrap_err().to_string();
        assert!(message.contains("filter.class_models"), "{message}");
    }

    #[test]
    fn a_pinned_hash_has_64_hexadecimal_digits() {
        let digits = "0123456789abcdef".repeat(4);
        let settings = parse(&format!("model_sha256 = \"{digits}\""), "").unwrap();
        assert_eq!(settings.filter.model_sha256, Some(digits));
        for wrong in ["0".repeat(63), "g".repeat(64)] {
            let message = parse(&format!("model_sha256 = \"{wrong}\""), "").unwrap_err().to_string();
            assert!(message.contains("filter.model_sha256") && message.contains("64"), "{message}");
        }
    }

    #[test]
    fn every_kernel_has_its_name() {
        for (name, choice) in [
            ("auto", KernelChoice::Auto),
            ("portable", KernelChoice::Portable),
            ("avx2-fma", KernelChoice::Avx2Fma),
            ("avx512", KernelChoice::Avx512),
        ] {
            let text = SHIPPED.replace("kernel = \"auto\"", &format!("kernel = \"{name}\""));
            let settings = Settings::parse(&text, Path::new("test.toml"), Path::new("")).unwrap();
            assert_eq!(settings.filter.kernel, choice);
        }
    }
}
