//! Process 2: how velocities come from positions.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, non_negative, positive, positive_ms, require};

/// Where velocities come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EstimatorKind {
    /// The paper's backward difference of positions.
    BackwardDifference,
    /// The velocity that perception measured; differences where a detection carries none.
    Provided,
    /// A Kalman filter of constant velocity. Needs `[estimator.noise]` and `[estimator.kalman]`.
    Kalman,
    /// Interacting multiple models: calm walk, lively walk and, if wanted, a manoeuvre. Needs `[estimator.noise]` and
    /// `[estimator.imm]`.
    Imm,
}

/// Settings of `obstacle_estimator`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimatorSettings {
    /// Where velocities come from.
    pub kind: EstimatorKind,
    /// Longest time without detections before the estimator gives a sign of life, ms.
    pub heartbeat_ms: u64,
    /// How long an unseen obstacle is predicted before it is dropped, ms.
    pub coast_ms: u64,
    /// An implied speed above this is a jump, not a motion: the track starts anew, m/s.
    pub teleport_speed_mps: f64,
    /// Two sightings farther apart than this give no velocity, ms. The Kalman filters, which know how uncertain a long
    /// gap leaves them, begin anew after `coast_ms` instead.
    pub max_difference_interval_ms: u64,
    /// Below this speed the heading is kept and its rate is zero, m/s.
    pub heading_hold_speed_mps: f64,
    /// Speed rates beyond this are clipped: differences of noisy positions are no accelerations, m/s².
    pub max_speed_rate_mps2: f64,
    /// Turn rates beyond this are clipped, rad/s.
    pub max_heading_rate_radps: f64,
    /// Farthest an anonymous detection may lie from a predicted track to be taken for it, m. The Kalman filters ask in
    /// addition that it lie within the ellipse that holds 99 % of sightings.
    pub association_gate_m: f64,
    /// How uncertain sightings are, and what is made of it; the Kalman filters need it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseSettings>,
    /// The motion that `kind = "kalman"` expects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kalman: Option<KalmanSettings>,
    /// The motions that `kind = "imm"` expects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imm: Option<ImmSettings>,
}

/// How uncertain sightings are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseSettings {
    /// Standard deviation of a measured position along each axis, m, or what is believed of it until it is learnt. Taken where
    /// a detection carries no covariance, or one that cannot be.
    pub position_sd_m: f64,
    /// Standard deviation of the velocity of somebody just met along each axis, about zero, m/s.
    pub initial_speed_sd_mps: f64,
    /// How many standard deviations of the position, at the time of publication and along the worst direction, are added to
    /// the radius; 0 leaves the radius as perceived.
    pub radius_sds: f64,
    /// Learn `position_sd_m` from the sightings themselves; absent means that it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learned: Option<LearnedNoiseSettings>,
}

/// How the noise of positions is learnt from the positions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnedNoiseSettings {
    /// No less is believed, m.
    pub least_sd_m: f64,
    /// No more is believed, m.
    pub most_sd_m: f64,
    /// Differences of positions go before the models while their own standard deviation along each axis, as learnt, is no
    /// more than this, m/s; 0 means never.
    pub difference_sd_mps: f64,
}

/// A walk of constant velocity, disturbed by an acceleration that is constant from sighting to sighting.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KalmanSettings {
    /// Standard deviation of that acceleration along each axis, m/s².
    pub acceleration_sd_mps2: f64,
}

/// Two walks of constant velocity, a calm and a lively one, and optionally a manoeuvre; nobody knows who follows which.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImmSettings {
    /// Standard deviation of the acceleration of the calm walk along each axis, m/s².
    pub calm_acceleration_sd_mps2: f64,
    /// The same of the lively walk, m/s².
    pub lively_acceleration_sd_mps2: f64,
    /// How long a motion lasts on average before another one is taken up, s.
    pub mean_stay_s: f64,
    /// A third motion, whose acceleration lasts and is estimated; absent means two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub manoeuvre: Option<ManoeuvreSettings>,
}

/// A motion under an acceleration that decays and is renewed at random (Singer's model).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManoeuvreSettings {
    /// Standard deviation of the acceleration along each axis, m/s².
    pub acceleration_sd_mps2: f64,
    /// Time constant with which it is forgotten, s.
    pub time_constant_s: f64,
}

impl EstimatorSettings {
    pub(crate) fn validate(&self) -> Checked {
        positive_ms("estimator.heartbeat_ms", self.heartbeat_ms)?;
        positive_ms("estimator.coast_ms", self.coast_ms)?;
        positive("estimator.teleport_speed_mps", self.teleport_speed_mps)?;
        positive_ms("estimator.max_difference_interval_ms", self.max_difference_interval_ms)?;
        non_negative("estimator.heading_hold_speed_mps", self.heading_hold_speed_mps)?;
        positive("estimator.max_speed_rate_mps2", self.max_speed_rate_mps2)?;
        positive("estimator.max_heading_rate_radps", self.max_heading_rate_radps)?;
        positive("estimator.association_gate_m", self.association_gate_m)?;
        self.noise.map_or(Ok(()), NoiseSettings::validate)?;
        self.kalman.map_or(Ok(()), KalmanSettings::validate)?;
        self.imm.map_or(Ok(()), ImmSettings::validate)?;
        match self.kind {
            EstimatorKind::BackwardDifference | EstimatorKind::Provided => Ok(()),
            EstimatorKind::Kalman => require(
                self.noise.is_some() && self.kalman.is_some(),
                "estimator.kind",
                self.kind,
                "accompanied by the tables [estimator.noise] and [estimator.kalman]",
            ),
            EstimatorKind::Imm => require(
                self.noise.is_some() && self.imm.is_some(),
                "estimator.kind",
                self.kind,
                "accompanied by the tables [estimator.noise] and [estimator.imm]",
            ),
        }
    }
}

/// Bounds between which squares and fourth powers of a noise are still numbers to compute with.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

fn plausible(key: &'static str, value: f64) -> Checked {
    require(PLAUSIBLE.contains(&value), key, value, "between 0.001 and 1000")
}

impl NoiseSettings {
    fn validate(self) -> Checked {
        plausible("estimator.noise.position_sd_m", self.position_sd_m)?;
        plausible("estimator.noise.initial_speed_sd_mps", self.initial_speed_sd_mps)?;
        non_negative("estimator.noise.radius_sds", self.radius_sds)?;
        self.learned.map_or(Ok(()), |learned| learned.validate(self.position_sd_m))
    }
}

impl LearnedNoiseSettings {
    fn validate(self, position_sd_m: f64) -> Checked {
        plausible("estimator.noise.learned.least_sd_m", self.least_sd_m)?;
        plausible("estimator.noise.learned.most_sd_m", self.most_sd_m)?;
        non_negative("estimator.noise.learned.difference_sd_mps", self.difference_sd_mps)?;
        require(
            (self.least_sd_m..=self.most_sd_m).contains(&position_sd_m),
            "estimator.noise.position_sd_m",
            position_sd_m,
            "between estimator.noise.learned.least_sd_m and most_sd_m",
        )
    }
}

impl KalmanSettings {
    fn validate(self) -> Checked {
        plausible("estimator.kalman.acceleration_sd_mps2", self.acceleration_sd_mps2)
    }
}

impl ImmSettings {
    fn validate(self) -> Checked {
        plausible("estimator.imm.calm_acceleration_sd_mps2", self.calm_acceleration_sd_mps2)?;
        plausible("estimator.imm.lively_acceleration_sd_mps2", self.lively_acceleration_sd_mps2)?;
        require(
            self.calm_acceleration_sd_mps2 < self.lively_acceleration_sd_mps2,
            "estimator.imm.calm_acceleration_sd_mps2",
            self.calm_acceleration_sd_mps2,
            "below estimator.imm.lively_acceleration_sd_mps2",
        )?;
        plausible("estimator.imm.mean_stay_s", self.mean_stay_s)?;
        let Some(manoeuvre) = self.manoeuvre else { return Ok(()) };
        plausible("estimator.imm.manoeuvre.acceleration_sd_mps2", manoeuvre.acceleration_sd_mps2)?;
        plausible("estimator.imm.manoeuvre.time_constant_s", manoeuvre.time_constant_s)
    }
}

#[cfg(test)]
mod tests {
    use crate::{EstimatorKind, Settings, SettingsError};

    const PUBLISHED: &str = include_str!("../../../config/ground_robot_paper.toml");
    const NOISE: &str =
        "[estimator.noise]\nposition_sd_m = 0.05\ninitial_speed_sd_mps = 1.5\nradius_sds = 1.0\n";
    const LEARNED: &str = "learned = { least_sd_m = 0.001, most_sd_m = 0.5, difference_sd_mps = 0.1 }\n";
    const KALMAN: &str = "[estimator.kalman]\nacceleration_sd_mps2 = 1.0\n";
    const IMM: &str = "[estimator.imm]\ncalm_acceleration_sd_mps2 = 0.3\nlively_acceleration_sd_mps2 = 2.0\n\
        mean_stay_s = 1.7\nmanoeuvre = { acceleration_sd_mps2 = 2.0, time_constant_s = 0.5 }\n";

    /// The published file with another estimator and tables at its end.
    fn parse(kind: &str, tables: &str) -> Result<Settings, SettingsError> {
        let text = PUBLISHED.replace("kind = \"backward_difference\"", &format!("kind = \"{kind}\""));
        Settings::parse(&format!("{text}\n{tables}"), "test.toml".as_ref(), "".as_ref())
    }

    #[test]
    fn filters_are_read_and_written_back() {
        for (kind, tables) in [
            ("kalman", format!("{NOISE}{KALMAN}")),
            ("imm", format!("{NOISE}{IMM}")),
            ("imm", format!("{NOISE}{LEARNED}{IMM}")),
        ] {
            let settings = parse(kind, &tables).unwrap();
            let again =
                Settings::parse(&settings.to_toml().unwrap(), "again.toml".as_ref(), "".as_ref()).unwrap();
            assert_eq!(settings, again);
        }
        assert_eq!(parse("imm", &format!("{NOISE}{IMM}")).unwrap().estimator.kind, EstimatorKind::Imm);
    }

    #[test]
    fn what_does_not_filter_needs_no_tables_and_writes_none() {
        let settings = parse("backward_difference", "").unwrap();
        assert!(!settings.to_toml().unwrap().contains("estimator.noise"));
    }

    #[test]
    fn a_missing_table_and_every_value_out_of_range_is_refused_by_name() {
        for (kind, tables, expected) in [
            ("kalman", String::new(), "[estimator.noise] and [estimator.kalman]"),
            ("kalman", NOISE.to_owned(), "[estimator.noise] and [estimator.kalman]"),
            ("imm", format!("{NOISE}{KALMAN}"), "[estimator.noise] and [estimator.imm]"),
            ("imm", IMM.to_owned(), "[estimator.noise] and [estimator.imm]"),
            ("kalman", format!("{NOISE}{KALMAN}").replace("0.05", "0.0"), "estimator.noise.position_sd_m"),
            ("kalman", format!("{NOISE}{KALMAN}").replace("1.5", "nan"), "initial_speed_sd_mps"),
            (
                "kalman",
                format!("{NOISE}{KALMAN}").replace("radius_sds = 1.0", "radius_sds = -1.0"),
                "radius_sds",
            ),
            ("kalman", format!("{NOISE}{KALMAN}").replace("mps2 = 1.0", "mps2 = 1e9"), "estimator.kalman"),
            ("imm", format!("{NOISE}{IMM}").replace("0.3", "3.0"), "below estimator.imm.lively"),
            ("imm", format!("{NOISE}{IMM}").replace("1.7", "0.0"), "estimator.imm.mean_stay_s"),
            (
                "imm",
                format!("{NOISE}{IMM}").replace("time_constant_s = 0.5", "time_constant_s = inf"),
                "time_constant_s",
            ),
            (
                "imm",
                format!("{NOISE}{LEARNED}{IMM}").replace("least_sd_m = 0.001", "least_sd_m = 0.06"),
                "between estimator.noise.learned.least_sd_m and most_sd_m",
            ),
            ("imm", format!("{NOISE}{LEARNED}{IMM}").replace("0.001", "0.0"), "learned.least_sd_m"),
            (
                "imm",
                format!("{NOISE}{LEARNED}{IMM}").replace("most_sd_m = 0.5", "most_sd_m = nan"),
                "most_sd_m",
            ),
            (
                "imm",
                format!("{NOISE}{LEARNED}{IMM}").replace("mps = 0.1 }", "mps = -0.1 }"),
                "difference_sd_mps",
            ),
        ] {
            let refusal = parse(kind, &tables).unwrap_err().to_string();
            assert!(refusal.contains(expected), "{refusal}");
        }
    }
}
