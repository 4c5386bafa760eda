//! `[filter.joint]`: people treated jointly and ahead of time.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, require};

/// Most moments and levels: beyond, a cycle takes longer than its period.
const MOST_MOMENTS: usize = 64;
const MOST_LEVELS: usize = 17;

/// When the joint look-ahead decides in place of the CBF-QP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointUse {
    /// Whenever no manoeuvre would keep clear of everybody after the QP's control.
    Gatekeeper,
    /// Whenever no admissible control meets the composite's condition.
    Infeasible,
    /// In either case.
    Either,
}

/// Settings of the joint look-ahead. A table `[filter.joint]` turns it on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSettings {
    /// When it decides.
    pub when: JointUse,
    /// How far it looks ahead, s.
    pub horizon_s: f64,
    /// At how many moments of the horizon, at most 64; rounded up to a multiple of eight.
    pub moments: usize,
    /// Controls per component in its grid, 2 to 17.
    pub levels: usize,
    /// Part of the modelled disturbance that people are granted, 0 to 1.
    pub disturbance_share: f64,
    /// Clearance that a manoeuvre must keep, m.
    pub margin_m: f64,
    /// Time after which a manoeuvre of two parts goes over to its second, s.
    pub switch_s: f64,
    /// Speed along each axis that a double-integrator robot does not exceed, m/s; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_max_speed_mps: Option<f64>,
}

impl JointSettings {
    pub(crate) fn validate(&self) -> Checked {
        positive("filter.joint.horizon_s", self.horizon_s)?;
        let moments = (1..=MOST_MOMENTS).contains(&self.moments);
        require(moments, "filter.joint.moments", self.moments, "1 to 64")?;
        let levels = (2..=MOST_LEVELS).contains(&self.levels);
        require(levels, "filter.joint.levels", self.levels, "2 to 17")?;
        let share = (0.0..=1.0).contains(&self.disturbance_share);
        require(share, "filter.joint.disturbance_share", self.disturbance_share, "0 to 1")?;
        non_negative("filter.joint.margin_m", self.margin_m)?;
        positive("filter.joint.switch_s", self.switch_s)?;
        match self.robot_max_speed_mps {
            Some(speed_mps) => positive("filter.joint.robot_max_speed_mps", speed_mps),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{JointUse, Settings, SettingsError};

    const SHIPPED: &str = include_str!("../../../config/quadrotor.toml");
    const TABLE: &str = "[filter.joint]\nwhen = \"either\"\nhorizon_s = 2.0\nmoments = 16\nlevels = 9\n\
        disturbance_share = 0.5\nmargin_m = 0.05\nswitch_s = 0.5\n";

    fn parse(table: &str) -> Result<Settings, SettingsError> {
        Settings::parse(&format!("{SHIPPED}\n{table}"), Path::new("test.toml"), Path::new("."))
    }

    #[test]
    fn the_table_is_optional_and_survives_a_round_trip() {
        assert_eq!(parse("").unwrap().filter.joint, None);
        let settings = parse(TABLE).unwrap();
        let joint = settings.filter.joint.as_ref().unwrap();
        assert_eq!((joint.when, joint.robot_max_speed_mps), (JointUse::Either, None));
        let again = Settings::parse(&settings.to_toml().unwrap(), Path::new("again.toml"), Path::new("."));
        assert_eq!(again.unwrap(), settings);
    }

    #[test]
    fn what_cannot_be_looked_at_is_refused_by_name() {
        for (good, bad, key) in [
            ("horizon_s = 2.0", "horizon_s = 0.0", "filter.joint.horizon_s"),
            ("moments = 16", "moments = 65", "filter.joint.moments"),
            ("levels = 9", "levels = 1", "filter.joint.levels"),
            ("disturbance_share = 0.5", "disturbance_share = 1.5", "filter.joint.disturbance_share"),
            ("margin_m = 0.05", "margin_m = -0.1", "filter.joint.margin_m"),
            (
                "switch_s = 0.5",
                "switch_s = 0.5\nrobot_max_speed_mps = -1.0",
                "filter.joint.robot_max_speed_mps",
            ),
        ] {
            let refusal = parse(&TABLE.replace(good, bad)).unwrap_err().to_string();
            assert!(refusal.contains(key), "{refusal}");
        }
        assert!(parse(&TABLE.replace("either", "always")).is_err());
    }
}
