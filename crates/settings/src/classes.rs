//! What the drawn crowd is made of besides pedestrians: cyclists, and things that stand.

use serde::{Deserialize, Serialize};

use crate::error::{Checked, bounds, positive, require};

/// Makes some of the drawn people of the simulated crowd something else. Each is drawn on its own from the scenario's seed, so
/// that shares hold on average and a larger crowd begins with the smaller one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassesSettings {
    /// Share of cyclists, 0 to 1. They ride straight on at constant speed and turn at the arena's edges only.
    pub cyclist_share: f64,
    /// Range of their speeds, drawn uniformly, m/s.
    pub cyclist_speed_mps: [f64; 2],
    /// Radius of the disc that stands for a cyclist, m.
    pub cyclist_radius_m: f64,
    /// Share of things that stand still, 0 to 1; none stands nearer to the robot's goal than `start_clearance_m`.
    pub static_share: f64,
    /// Radius of the disc that stands for such a thing, m.
    pub static_radius_m: f64,
}

impl ClassesSettings {
    pub(crate) fn validate(&self) -> Checked {
        let is_share = |share: f64| (0.0..=1.0).contains(&share);
        let (cyclists, things) = (self.cyclist_share, self.static_share);
        require(is_share(cyclists), "simulation.classes.cyclist_share", cyclists, "0 to 1")?;
        let is_rest = is_share(things) && cyclists + things <= 1.0;
        require(
            is_rest,
            "simulation.classes.static_share",
            things,
            "0 to 1, and with cyclist_share at most 1",
        )?;
        let [slowest, fastest] = self.cyclist_speed_mps;
        positive("simulation.classes.cyclist_speed_mps", slowest)?;
        bounds("simulation.classes.cyclist_speed_mps", &[slowest], &[fastest])?;
        positive("simulation.classes.cyclist_radius_m", self.cyclist_radius_m)?;
        positive("simulation.classes.static_radius_m", self.static_radius_m)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::{Settings, SettingsError};

    const SHIPPED: &str = include_str!("../../../config/ground_robot.toml");
    const MIXED: &str = "cyclist_share = 0.2\ncyclist_speed_mps = [2.0, 4.0]\ncyclist_radius_m = 0.5\n\
                         static_share = 0.2\nstatic_radius_m = 0.35\n";

    fn with(table: &str) -> Result<Settings, SettingsError> {
        let text = SHIPPED.replacen("[estimator]", &format!("[simulation.classes]\n{table}\n[estimator]"), 1);
        Settings::parse(&text, Path::new("test.toml"), Path::new("config"))
    }

    #[test]
    fn a_mixture_survives_a_round_trip_and_is_absent_unless_asked_for() {
        let settings = with(MIXED).expect("valid");
        let classes = settings.simulation.classes.expect("given");
        assert_eq!((classes.cyclist_share, classes.cyclist_speed_mps), (0.2, [2.0, 4.0]));
        let text = settings.to_toml().expect("has a TOML form");
        let again = Settings::parse(&text, Path::new("test.toml"), Path::new("")).expect("its own output");
        assert_eq!(again, settings);
        let plain = Settings::parse(SHIPPED, Path::new("test.toml"), Path::new("")).expect("shipped");
        assert!(plain.simulation.classes.is_none());
        assert!(!plain.to_toml().expect("has a TOML form").contains("classes"));
    }

    #[test]
    fn what_is_no_mixture_is_refused_by_name() {
        for (key, from, to) in [
            ("cyclist_share", "cyclist_share = 0.2", "cyclist_share = 1.2"),
            ("cyclist_share", "cyclist_share = 0.2", "cyclist_share = nan"),
            ("static_share", "static_share = 0.2", "static_share = 0.9"),
            ("static_share", "static_share = 0.2", "static_share = -0.1"),
            ("cyclist_speed_mps", "[2.0, 4.0]", "[4.0, 2.0]"),
            ("cyclist_speed_mps", "[2.0, 4.0]", "[0.0, 2.0]"),
            ("cyclist_radius_m", "cyclist_radius_m = 0.5", "cyclist_radius_m = 0.0"),
            ("static_radius_m", "static_radius_m = 0.35", "static_radius_m = -1.0"),
        ] {
            let error = with(&MIXED.replacen(from, to, 1)).expect_err(key).to_string();
            assert!(error.contains(&format!("simulation.classes.{key}")), "{error}");
        }
        let error = with(&MIXED.replacen("static_share = 0.2\n", "", 1)).expect_err("incomplete").to_string();
        assert!(error.contains("static_share"), "{error}");
    }
}
