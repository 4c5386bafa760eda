//! `[filter.anticipation]`: a way through the crowd, looked for before anybody is near.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, positive_ms, require};

/// Most moments: beyond, a search takes longer than the filter's period.
const MOST_MOMENTS: usize = 64;

/// Settings of the anticipation. A table `[filter.anticipation]` turns it on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnticipationSettings {
    /// How far it looks ahead, s.
    pub horizon_s: f64,
    /// At how many moments of the horizon, at most 64; rounded up to a multiple of eight.
    pub moments: usize,
    /// Time between two searches, ms; in between the manoeuvre goes on.
    pub period_ms: u64,
    /// Signed distance from which on a person is no risk now, m.
    pub clearance_m: f64,
    /// How that distance grows with the time ahead, m/s.
    pub clearance_growth_mps: f64,
    /// Seconds of way that one second in contact is worth.
    pub risk_weight: f64,
    /// Weight of everybody's turning round to the robot, all together, where their going on has weight 1 each.
    pub turn_share: f64,
    /// Time after which a prediction of people counts 1/e, s.
    pub trust_s: f64,
    /// The nominal controller is left alone where its own way has less than this risk, s.
    pub negligible_risk_s: f64,
    /// Speed at which the way to the goal is made, m/s: the nominal controller's own.
    pub cruise_speed_mps: f64,
    /// Speed along each axis that a double integrator's manoeuvres do not exceed, m/s; twice the cruising speed if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_max_speed_mps: Option<f64>,
}

impl AnticipationSettings {
    pub(crate) fn validate(&self) -> Checked {
        positive("filter.anticipation.horizon_s", self.horizon_s)?;
        let moments = (1..=MOST_MOMENTS).contains(&self.moments);
        require(moments, "filter.anticipation.moments", self.moments, "1 to 64")?;
        positive_ms("filter.anticipation.period_ms", self.period_ms)?;
        positive("filter.anticipation.clearance_m", self.clearance_m)?;
        non_negative("filter.anticipation.clearance_growth_mps", self.clearance_growth_mps)?;
        non_negative("filter.anticipation.risk_weight", self.risk_weight)?;
        non_negative("filter.anticipation.turn_share", self.turn_share)?;
        positive("filter.anticipation.trust_s", self.trust_s)?;
        non_negative("filter.anticipation.negligible_risk_s", self.negligible_risk_s)?;
        positive("filter.anticipation.cruise_speed_mps", self.cruise_speed_mps)?;
        match self.robot_max_speed_mps {
            Some(speed_mps) => positive("filter.anticipation.robot_max_speed_mps", speed_mps),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Settings, SettingsError};

    const PUBLISHED: &str = include_str!("../../../config/quadrotor_paper.toml");
    const TABLE: &str = "[filter.anticipation]\nhorizon_s = 4.0\nmoments = 32\nperiod_ms = 20\nclearance_m = 0.5\n\
        clearance_growth_mps = 0.15\nrisk_weight = 20.0\nturn_share = 0.05\ntrust_s = 2.0\nnegligible_risk_s = 0.02\n\
        cruise_speed_mps = 1.8\n";

    fn parse(table: &str) -> Result<Settings, SettingsError> {
        Settings::parse(&format!("{PUBLISHED}\n{table}"), Path::new("test.toml"), Path::new("."))
    }

    #[test]
    fn the_table_is_optional_and_survives_a_round_trip() {
        assert_eq!(parse("").unwrap().filter.anticipation, None);
        let settings = parse(TABLE).unwrap();
        assert_eq!(settings.filter.anticipation.as_ref().unwrap().robot_max_speed_mps, None);
        let again = Settings::parse(&settings.to_toml().unwrap(), Path::new("again.toml"), Path::new("."));
        assert_eq!(again.unwrap(), settings);
    }

    #[test]
    fn what_cannot_be_looked_at_is_refused_by_name() {
        for (good, bad, key) in [
            ("horizon_s = 4.0", "horizon_s = 0.0", "horizon_s"),
            ("moments = 32", "moments = 65", "moments"),
            ("period_ms = 20", "period_ms = 0", "period_ms"),
            ("clearance_m = 0.5", "clearance_m = 0.0", "clearance_m"),
            ("growth_mps = 0.15", "growth_mps = -0.1", "clearance_growth_mps"),
            ("risk_weight = 20.0", "risk_weight = -1.0", "risk_weight"),
            ("turn_share = 0.05", "turn_share = -0.05", "turn_share"),
            ("trust_s = 2.0", "trust_s = 0.0", "trust_s"),
            ("risk_s = 0.02", "risk_s = -0.02", "negligible_risk_s"),
            ("cruise_speed_mps = 1.8", "cruise_speed_mps = 0.0", "cruise_speed_mps"),
            ("= 1.8", "= 1.8\nrobot_max_speed_mps = 0.0", "robot_max_speed_mps"),
        ] {
            let refusal = parse(&TABLE.replace(good, bad)).unwrap_err().to_string();
            assert!(refusal.contains(&format!("filter.anticipation.{key}")), "{refusal}");
        }
    }
}
