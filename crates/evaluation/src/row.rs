//! One run as one line of the table: its columns, their names and units. How it is stored is in `columns` and `table_file`.

use serde::{Deserialize, Serialize};

use crate::columns::table_row;

/// Which run a row is about. Rows are ordered and found by it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key {
    /// Robot, `ground` or `quadrotor`.
    pub robot: String,
    /// Number of people.
    pub people: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the method.
    pub method: String,
}

impl std::fmt::Display for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { robot, people, scenario, method } = self;
        write!(f, "{robot}, {method}, {people} people, scenario {scenario}")
    }
}

table_row! {
    /// One run. Everything but the last columns, which a machine's clock measured ([`Row::without_times`]), is a function of
    /// build, settings and scenario.
    ///
    /// "Full radius" means contact at the sum of both radii, which is the failure set of the filter's model; "smaller radius"
    /// means contact 5 cm further in. A run goes on after the first contact at the full radius and ends with the first at the
    /// smaller one, so both judgements come from one run. `docs/evaluation.md` defines every column.
    pub struct Row {
        /// Robot, `ground` or `quadrotor`.
        pub robot: String,
        /// Number of people.
        pub people: u32,
        /// Name of the scenario.
        pub scenario: String,
        /// Name of the method.
        pub method: String,
        /// Seed of the scenario; zero where it came from a file.
        pub seed: u64,
        /// First 16 hexadecimal digits of the SHA-256 of the method's settings.
        pub settings_hash: String,
        /// The same of the scenario.
        pub scenario_hash: String,
        /// The same of the program that ran it.
        pub build_hash: String,
        /// Kernel that evaluated barriers.
        pub kernel: String,
        /// Goal reached without contact at the full radius.
        pub success: bool,
        /// Goal reached without contact at the smaller radius.
        pub success_smaller: bool,
        /// Whether there was contact at the full radius before the goal.
        pub collision: bool,
        /// Whether there was contact at the smaller radius before the goal.
        pub collision_smaller: bool,
        /// Whether time ran out: neither the goal nor contact at the smaller radius.
        pub timeout: bool,
        /// When contact at the full radius began, s.
        pub contact_s: Option<f64>,
        /// When contact at the smaller radius began, s.
        pub contact_smaller_s: Option<f64>,
        /// Cause of the contact at the full radius, a name of [`crate::Cause`]; empty without contact.
        pub cause: String,
        /// Cause of the contact at the smaller radius.
        pub cause_smaller: String,
        /// Smallest distance between the discs of robot and people, m; negative within contact, absent without people.
        pub min_distance_m: Option<f64>,
        /// Length of the way driven, m.
        pub path_length_m: f64,
        /// Length of the run: until goal, contact at the smaller radius or timeout, s.
        pub time_s: f64,
        /// Cycles of the filter, or of what stands in its place.
        pub cycles: u64,
        /// Interventions: unbroken stretches in which u is farther than 0.02 from the admissible control nearest to u_nom, pauses
        /// below 0.1 s bridged; planners have none.
        pub interventions: u64,
        /// Share of cycles that intervened.
        pub intervention_share: f64,
        /// Cycles that needed slack.
        pub slack_cycles: u64,
        /// Largest slack, m/s (CN-CBF) or unit of the method's demands.
        pub max_slack: f64,
        /// Smallest hard-feasibility margin m(x), m/s or unit of the method's demands; absent with nobody in sight.
        pub min_hard_margin: Option<f64>,
        /// Cycles in which the robot braked because an input or the computation could not be trusted.
        pub braking_cycles: u64,
        /// Share of people's walking time with a turn rate beyond 0.35 rad/s.
        pub turn_rate_exceeded_share: f64,
        /// Share of people's walking time with an acceleration beyond 1 m/s² on an axis.
        pub acceleration_exceeded_share: f64,
        /// Share of people's walking time outside of what the settings' obstacle model allows.
        pub bounds_exceeded_share: f64,
        /// Median of the filter's computing time per tick, µs.
        pub tick_median_us: Option<f64>,
        /// 99th percentile of it, µs.
        pub tick_p99_us: Option<f64>,
        /// Median of the nominal controller's computing time per tick, µs.
        pub nominal_median_us: Option<f64>,
        /// 99th percentile of it, µs.
        pub nominal_p99_us: Option<f64>,
        /// Processor time of the run, s.
        pub cpu_s: Option<f64>,
    }
}

impl Row {
    /// Which run this is.
    pub fn key(&self) -> Key {
        Key {
            robot: self.robot.clone(),
            people: self.people,
            scenario: self.scenario.clone(),
            method: self.method.clone(),
        }
    }

    /// The row without the columns that a clock measured: equal on every run of the same build on the same kind of machine.
    #[must_use]
    pub fn without_times(self) -> Self {
        Self {
            tick_median_us: None,
            tick_p99_us: None,
            nominal_median_us: None,
            nominal_p99_us: None,
            cpu_s: None,
            ..self
        }
    }
}
