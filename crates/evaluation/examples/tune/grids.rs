//! What is tried for each method: the same number of settings for every method of a robot, the published one first. Not
//! here: how they are judged (`criterion`).

use evaluation::Robot;

/// Added to the radius that the method plans with, m. Contacts are judged as always.
const MARGINS_M: [&str; 4] = ["0.0", "0.1", "0.2", "0.3"];

type Choices = (&'static [&'static str], &'static [&'static [&'static str]]);

/// What is tried for one method: every margin with each choice of what is its own. A planner's run takes several times as
/// long as a filter's, so the methods of the ground robot get three choices each and those of the quadrotor four.
#[derive(Debug)]
pub(crate) struct Grid {
    /// The method's name.
    pub(crate) method: &'static str,
    /// The key of its margin.
    margin: &'static str,
    /// The keys of what is its own, and choices of their values; the first is the published one.
    own: Choices,
}

/// Whether the demands of a planner without a gain of its own are hard or soft, and how many steps of 0.1 s it looks ahead.
/// 10³ is below the multipliers that the published cost brings about, 10⁵ above.
const HARDNESS_AND_HORIZON: Choices =
    (&["method.violation_weight", "method.horizon_steps"], &[&["1e5", "20"], &["1e5", "10"], &["1e3", "20"]]);

const PLANNER_MARGIN: &str = "method.sight.margin_m";
const INNER_PLANNER_MARGIN: &str = "method.planner.sight.margin_m";
const FILTER_MARGIN: &str = "method.filter.sight.margin_m";

const fn cn_cbf(choices: &'static [&'static [&'static str]]) -> Grid {
    Grid {
        method: "cn_cbf",
        margin: "filter.sdf_buffer_m",
        own: (&["filter.alpha_per_s", "filter.beta_per_m"], choices),
    }
}

const GROUND: [Grid; 5] = [
    cn_cbf(&[&["4.0", "4.0"], &["2.0", "8.0"], &["4.0", "8.0"]]),
    Grid { method: "sdf_mpc", margin: PLANNER_MARGIN, own: HARDNESS_AND_HORIZON },
    Grid {
        method: "dcbf_mpc",
        margin: INNER_PLANNER_MARGIN,
        own: (&["method.gamma"], &[&["0.3"], &["0.15"], &["0.5"]]),
    },
    Grid { method: "vo_mpc", margin: PLANNER_MARGIN, own: HARDNESS_AND_HORIZON },
    Grid {
        method: "rntc_mpc",
        margin: INNER_PLANNER_MARGIN,
        own: (
            &["method.planner.violation_weight", "method.terminal_margin_m"],
            &[&["1e5", "0.0"], &["1e5", "0.1"], &["1e3", "0.0"]],
        ),
    },
];

const QUADROTOR: [Grid; 3] = [
    cn_cbf(&[&["4.0", "4.0"], &["2.0", "8.0"], &["4.0", "8.0"], &["4.0", "16.0"]]),
    Grid {
        method: "c3bf",
        margin: FILTER_MARGIN,
        own: (&["method.k_per_s"], &[&["3.0"], &["2.0"], &["6.0"], &["12.0"]]),
    },
    Grid {
        method: "ho_cbf",
        margin: FILTER_MARGIN,
        // (2, 2) is what the authors flew.
        own: (
            &["method.k1_per_s", "method.k2_per_s"],
            &[&["3.0", "2.0"], &["2.0", "2.0"], &["5.0", "4.0"], &["8.0", "6.0"]],
        ),
    },
];

/// Crowd size that settings are tried among: the middle one of the paper's, or the next above.
pub(crate) const fn people(robot: Robot) -> u32 {
    match robot {
        Robot::Ground => 10,
        Robot::Quadrotor => 15,
    }
}

/// The methods of `robot` and what is tried for them.
pub(crate) const fn grids(robot: Robot) -> &'static [Grid] {
    match robot {
        Robot::Ground => &GROUND,
        Robot::Quadrotor => &QUADROTOR,
    }
}

impl Grid {
    /// Every setting, as `section.key=value`s; the published one first.
    pub(crate) fn settings(&self) -> Vec<Vec<String>> {
        let (keys, choices) = &self.own;
        let with = |margin_m: &str, choice: &[&str]| {
            let own = keys.iter().zip(choice).map(|(key, value)| format!("{key}={value}"));
            std::iter::once(format!("{}={margin_m}", self.margin)).chain(own).collect()
        };
        choices
            .iter()
            .flat_map(|choice| MARGINS_M.iter().map(move |margin_m| (choice, margin_m)))
            .map(|(choice, margin_m)| with(margin_m, choice))
            .collect()
    }
}
