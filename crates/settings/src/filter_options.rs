//! Optional keys of `[filter]`: each answers one known weakness of the composite as published. Absent, nothing changes.
//!
//! What each does and what it was measured to do is in `docs/filter_options.md`. Not here: people treated jointly (`joint`).

use serde::{Deserialize, Serialize};

use crate::error::{Checked, positive, require};
use crate::{FilterSettings, RobotKind};

/// What is taken for the obstacle's own input, as part of `ȯ`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ObstacleInput {
    /// The estimate: turn rate and speed rate, or accelerations.
    #[default]
    Measured,
    /// Of all inputs within the model's bounds the one that lowers the barrier most; the estimate is not used.
    WorstCase,
}

/// How the barriers of several obstacles become conditions on one control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Composition {
    /// One condition on the softmin of all.
    #[default]
    Composite,
    /// One condition and one slack for each; the largest slack is minimised first.
    Rows,
    /// The softmin's condition and those of the two smallest, solved like `rows`.
    CompositeAndPairs,
}

/// What becomes of the softmin's distance below the smallest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SoftminOffset {
    /// It stays, as published.
    #[default]
    Keep,
    /// What there is of it is added: `h` is the smallest value.
    Remove,
    /// Its bound `ln(M)/β` for `M` obstacles is added: `h` may exceed the smallest value by up to that.
    RemoveBound,
}

/// Whether a setting is the one that a file need not name.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Refuses options that are out of range or have no meaning together or for this kind of robot.
pub(crate) fn validate(filter: &FilterSettings, kind: RobotKind) -> Checked {
    let softmin = match filter.composition {
        Composition::Composite | Composition::CompositeAndPairs => true,
        Composition::Rows => filter.softmin_offset == SoftminOffset::Keep,
    };
    require(
        softmin,
        "filter.softmin_offset",
        filter.softmin_offset,
        "absent with composition = \"rows\", which has no softmin",
    )?;
    if let Some(ramp_s) = filter.appearance_ramp_s {
        positive("filter.appearance_ramp_s", ramp_s)?;
    }
    match (filter.robot_max_speed_mps, kind) {
        (Some(speed_mps), RobotKind::DoubleIntegrator) => positive("filter.robot_max_speed_mps", speed_mps),
        (Some(speed_mps), RobotKind::Unicycle) => require(
            false,
            "filter.robot_max_speed_mps",
            speed_mps,
            "absent for a unicycle, whose speed is a control: set robot.control_max",
        ),
        (None, _) => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::{Settings, SettingsError};

    const GROUND: &str = include_str!("../../../config/ground_robot_paper.toml");
    const QUADROTOR: &str = include_str!("../../../config/quadrotor_paper.toml");

    fn parse(shipped: &str, lines: &str) -> Result<Settings, SettingsError> {
        let text = shipped.replacen("[filter]", &format!("[filter]\n{lines}"), 1);
        Settings::parse(&text, Path::new("test.toml"), Path::new("."))
    }

    #[test]
    fn a_file_without_options_has_none_and_writes_none() {
        for shipped in [GROUND, QUADROTOR] {
            let settings = parse(shipped, "").unwrap();
            let filter = &settings.filter;
            assert_eq!(filter.obstacle_input, ObstacleInput::Measured);
            assert_eq!(filter.composition, Composition::Composite);
            assert_eq!(filter.softmin_offset, SoftminOffset::Keep);
            assert_eq!((filter.appearance_ramp_s, filter.robot_max_speed_mps), (None, None));
            let text = settings.to_toml().unwrap();
            for key in ["obstacle_input", "composition", "softmin_offset", "appearance_ramp_s", "robot_max"] {
                assert!(!text.contains(key), "{key}");
            }
        }
    }

    #[test]
    fn every_option_has_its_names_and_survives_a_round_trip() {
        for lines in [
            "obstacle_input = \"worst_case\"",
            "composition = \"rows\"",
            "composition = \"composite_and_pairs\"\nsoftmin_offset = \"remove_bound\"",
            "softmin_offset = \"remove\"",
            "appearance_ramp_s = 0.5\nrobot_max_speed_mps = 2.0",
        ] {
            let settings = parse(QUADROTOR, lines).unwrap();
            assert_ne!(settings, parse(QUADROTOR, "").unwrap(), "{lines}");
            let text = settings.to_toml().unwrap();
            assert_eq!(Settings::parse(&text, Path::new("again.toml"), Path::new(".")).unwrap(), settings);
        }
    }

    #[test]
    fn what_has_no_meaning_is_refused_by_name() {
        for (shipped, lines, key) in [
            (GROUND, "composition = \"rows\"\nsoftmin_offset = \"remove\"", "filter.softmin_offset"),
            (GROUND, "appearance_ramp_s = 0.0", "filter.appearance_ramp_s"),
            (GROUND, "robot_max_speed_mps = 2.0", "filter.robot_max_speed_mps"),
            (QUADROTOR, "robot_max_speed_mps = -2.0", "filter.robot_max_speed_mps"),
            (QUADROTOR, "obstacle_input = \"best_case\"", "worst_case"),
            (QUADROTOR, "composition = \"sum\"", "composite_and_pairs"),
        ] {
            let refusal = parse(shipped, lines).unwrap_err().to_string();
            assert!(refusal.contains(key), "{lines}: {refusal}");
        }
    }
}
