//! Two runs side by side: the same world, the same filter, two nominal controllers.

use core::fmt;
use std::collections::BTreeMap;

use messages::SafeCommand;
use serde::{Deserialize, Serialize};

use crate::display::{number, percent};
use crate::intervention::correction;
use crate::{Outcome, RunRecord, Rung, Verdict, words};

/// The rate of a command is taken over this time, ns: about the period of a nominal controller, and long against the filter's.
const RATE_STEP_NS: u64 = 50_000_000;

/// How one controller fared. `None` (JSON `null`) means unknown, or that nobody was ever near.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contender {
    /// Its name.
    pub name: String,
    /// How it ended.
    pub outcome: Outcome,
    /// Contacts between robot and people.
    pub collisions: Option<u32>,
    /// Smallest true distance between the discs of robot and people, m.
    pub min_clearance_m: Option<f64>,
    /// Smallest composite value h, m.
    pub min_h_m: Option<f64>,
    /// Smallest distance between the discs as the filter believed it, m.
    pub min_sdf_m: Option<f64>,
    /// How often the filter stepped in because of an obstacle.
    pub interventions: u64,
    /// Share of the time in which it did, 0 to 1.
    pub intervention_share: f64,
    /// Mean |u − u_nom| over the cycles in which the barrier was evaluated, Euclidean, in the units of the control.
    pub mean_correction: Option<f64>,
    /// Largest |u − u_nom|, likewise.
    pub largest_correction: f64,
    /// Share of the time in which the filter braked or kept the robot standing, 0 to 1.
    pub braking_share: f64,
    /// For which reason it did so most often, as the label of a reason code; `None` if it never did.
    pub braked_most_for: Option<String>,
    /// Length of the robot's path, m.
    pub path_length_m: Option<f64>,
    /// Time from the start to the goal, s; `None` if it was not reached.
    pub time_to_goal_s: Option<f64>,
    /// Length of the run, s.
    pub duration_s: f64,
    /// RMS of the rate of the filter's command, per component, in units of the control per second; the rate is taken over
    /// 50 ms. Smaller is smoother.
    pub smoothness_per_s: [f64; 2],
    /// Largest slack that the CBF-QP needed, m/s.
    pub max_slack_mps: f64,
    /// Cycles in which no admissible control satisfied the condition.
    pub infeasible_cycles: u64,
    /// SHA-256 over the bytes of all safe commands, hexadecimal; only in virtual time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commands_sha256: Option<String>,
}

impl Contender {
    /// Sums up a run.
    pub fn of(name: String, record: &RunRecord) -> Self {
        let verdict = Verdict::of(record);
        let with_barrier = || record.safe_commands.iter().filter(|c| Rung::of_code(c.status).has_barrier());
        let evaluated = with_barrier().count();
        Self {
            name,
            outcome: verdict.outcome,
            collisions: verdict.collisions,
            min_clearance_m: verdict.min_clearance_m,
            min_h_m: verdict.min_h_m,
            min_sdf_m: verdict.min_sdf_m,
            interventions: verdict.interventions.count,
            intervention_share: verdict.interventions.time_share,
            mean_correction: (evaluated > 0)
                .then(|| with_barrier().map(correction).sum::<f64>() / evaluated as f64),
            largest_correction: verdict.interventions.largest_correction,
            braking_share: verdict.time_shares.braking + verdict.time_shares.stopped,
            braked_most_for: braked_most_for(&record.safe_commands),
            path_length_m: verdict.path_length_m,
            time_to_goal_s: verdict.time_to_goal_s,
            duration_s: verdict.duration_s,
            smoothness_per_s: smoothness_per_s(&record.safe_commands),
            max_slack_mps: verdict.max_slack_mps,
            infeasible_cycles: verdict.infeasible_cycles,
            commands_sha256: None,
        }
    }
}

/// The reason of most commands that brake or keep the robot standing.
fn braked_most_for(commands: &[SafeCommand]) -> Option<String> {
    let mut counts = BTreeMap::<u32, u64>::new();
    for command in commands {
        if matches!(Rung::of_code(command.status), Rung::Braking | Rung::Stopped) {
            *counts.entry(command.reason).or_default() += 1;
        }
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map(|(reason, _)| words::reason_label(reason))
}

/// RMS of (u(t + 50 ms) − u(t)) / 50 ms over a run, per component.
fn smoothness_per_s(commands: &[SafeCommand]) -> [f64; 2] {
    let Some(first) = commands.first() else { return [0.0; 2] };
    let (mut due_ns, mut last) = (first.ledger.filter_woke_ns, first.control);
    let (mut sums, mut steps) = ([0.0; 2], 0_u64);
    for command in commands {
        // Nothing moved while the filter was silent: such a gap is one step.
        if command.ledger.filter_woke_ns >= due_ns + RATE_STEP_NS {
            for k in 0..2 {
                sums[k] += ((command.control[k] - last[k]) / (RATE_STEP_NS as f64 * 1e-9)).powi(2);
            }
            (due_ns, last) = (command.ledger.filter_woke_ns, command.control);
            steps += 1;
        }
    }
    sums.map(|sum: f64| (sum / steps.max(1) as f64).sqrt())
}

/// Two contenders in the same world. `Display` gives the table for the terminal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// Where they drove.
    pub on: String,
    /// `lockstep` or `real time`.
    pub mode: String,
    /// The first of them.
    pub first: Contender,
    /// The second.
    pub second: Contender,
    /// Whether both got the same bytes from the filter; only in virtual time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub identical: Option<bool>,
}

impl Comparison {
    /// Puts two runs beside each other.
    pub fn new(on: String, mode: &str, first: Contender, second: Contender) -> Self {
        let identical = first.commands_sha256.as_ref().zip(second.commands_sha256.as_ref());
        let identical = identical.map(|(first, second)| first == second);
        Self { on, mode: mode.to_owned(), first, second, identical }
    }
}

/// A figure as text, and the difference between two of them where both are numbers.
struct Row {
    name: &'static str,
    values: [String; 2],
    difference: String,
}

impl Row {
    fn words(name: &'static str, values: [String; 2]) -> Self {
        Self { name, values, difference: String::new() }
    }

    fn numbers(name: &'static str, values: [Option<f64>; 2], digits: usize) -> Self {
        let difference = match values {
            [Some(first), Some(second)] => format!("{:+.digits$}", second - first),
            [None, _] | [_, None] => String::new(),
        };
        let values = values.map(|value| value.map_or_else(|| "-".to_owned(), |value| number(value, digits)));
        Self { name, values, difference }
    }

    fn shares(name: &'static str, shares: [f64; 2]) -> Self {
        let difference = format!("{:+.1} %", 100.0 * (shares[1] - shares[0]));
        Self { name, values: shares.map(percent), difference }
    }
}

impl Comparison {
    fn rows(&self) -> Vec<Row> {
        let both = [&self.first, &self.second];
        let some = |get: fn(&Contender) -> f64| both.map(|one| Some(get(one)));
        let maybe = |get: fn(&Contender) -> Option<f64>| both.map(get);
        vec![
            Row::words("outcome", both.map(|one| outcome(one.outcome).to_owned())),
            Row::numbers("collisions", maybe(|one| one.collisions.map(f64::from)), 0),
            Row::numbers("smallest clearance, m", maybe(|one| one.min_clearance_m), 3),
            Row::numbers("smallest h, m", maybe(|one| one.min_h_m), 3),
            Row::numbers("smallest SDF, m", maybe(|one| one.min_sdf_m), 3),
            Row::numbers("interventions", some(|one| one.interventions as f64), 0),
            Row::shares("  share of the time", both.map(|one| one.intervention_share)),
            Row::numbers("  mean |u - u_nom|", maybe(|one| one.mean_correction), 4),
            Row::numbers("  largest |u - u_nom|", some(|one| one.largest_correction), 3),
            Row::shares("braking or standing", both.map(|one| one.braking_share)),
            Row::words(
                "  most often for",
                both.map(|one| one.braked_most_for.clone().unwrap_or_else(|| "-".to_owned())),
            ),
            Row::numbers("path length, m", maybe(|one| one.path_length_m), 2),
            Row::numbers("time to goal, s", maybe(|one| one.time_to_goal_s), 2),
            Row::numbers("duration, s", some(|one| one.duration_s), 2),
            Row::numbers("smoothness, 1st control/s", some(|one| one.smoothness_per_s[0]), 3),
            Row::numbers("smoothness, 2nd control/s", some(|one| one.smoothness_per_s[1]), 3),
            Row::numbers("largest slack, m/s", some(|one| one.max_slack_mps), 4),
            Row::numbers("infeasible cycles", some(|one| one.infeasible_cycles as f64), 0),
        ]
    }
}

const fn outcome(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Reached => "reached",
        Outcome::NotReached => "not reached",
        Outcome::Collision => "collision",
        Outcome::Unknown => "unknown",
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const WIDEST: usize = 28;
        let cut = |name: &str| name.chars().take(WIDEST).collect::<String>();
        let [first, second] = [cut(&self.first.name), cut(&self.second.name)];
        let width = first.chars().count().max(second.chars().count()).max(12);
        writeln!(f, "on {} ({})", self.on, self.mode)?;
        writeln!(f, "{:<27}{first:>width$}  {second:>width$}  {:>12}", "", "difference")?;
        for Row { name, values: [first, second], difference } in self.rows() {
            let line = format!("{name:<27}{first:>width$}  {second:>width$}  {difference:>12}");
            writeln!(f, "{}", line.trim_end())?;
        }
        let told = match self.identical {
            Some(true) => "the filter gave both the same commands, byte for byte",
            Some(false) => "smoothness: RMS of the rate of the filter's command, taken over 50 ms",
            None => {
                "smoothness: RMS of the rate of the filter's command, taken over 50 ms; real time differs from run to run"
            }
        };
        write!(f, "{told}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{Reason, SafetyStatus};

    fn command(woke_ns: u64, speed_mps: f64) -> SafeCommand {
        let mut command = SafeCommand { control: [speed_mps, 0.0], ..SafeCommand::zeroed() };
        command.ledger.filter_woke_ns = woke_ns;
        command
    }

    #[test]
    fn who_is_braked_learns_the_commonest_reason() {
        let of = |status: SafetyStatus, reason: Reason| SafeCommand {
            status: status.code(),
            reason: reason.code(),
            ..SafeCommand::zeroed()
        };
        let filtered = of(SafetyStatus::Filtered, Reason::None);
        assert_eq!(braked_most_for(&[filtered; 3]), None);
        let commands = [
            filtered,
            of(SafetyStatus::Stopped, Reason::WrongControlKind),
            of(SafetyStatus::Braking, Reason::WrongControlKind),
            of(SafetyStatus::Stopped, Reason::NoGoal),
        ];
        assert_eq!(braked_most_for(&commands).as_deref(), Some("wrong_control_kind"));
    }

    #[test]
    fn a_ramp_has_its_slope_for_a_smoothness_whatever_the_filters_rate() {
        for period_ns in [1_000_000, 10_000_000] {
            let ramp: Vec<_> = (0..2_000_000_000 / period_ns)
                .map(|cycle| command(cycle * period_ns, (cycle * period_ns) as f64 * 1e-9 * 0.3))
                .collect();
            let [first, second] = smoothness_per_s(&ramp);
            assert!((first - 0.3).abs() < 1e-9 && second == 0.0, "{first}");
        }
        assert_eq!(smoothness_per_s(&[]), [0.0; 2]);
    }
}
