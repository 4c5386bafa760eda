//! What the filter's commands of a run add up to.

use messages::{SafeCommand, SafetyStatus};
use settings::RobotSettings;

/// Distance of u from the admissible control nearest to u_nom from which on a cycle intervened, Euclidean, in the units of the
/// control.
const INTERVENTION_TOLERANCE: f64 = 0.02;
/// Pauses shorter than this do not end an intervention, s.
const SHORTEST_PAUSE_NS: u64 = 100_000_000;

/// Running figures.
#[derive(Debug, Clone)]
pub(crate) struct Tally {
    pub(crate) cycles: u64,
    pub(crate) interventions: u64,
    pub(crate) intervening_cycles: u64,
    pub(crate) slack_cycles: u64,
    pub(crate) max_slack: f64,
    min_hard_margin: f64,
    pub(crate) braking_cycles: u64,
    intervened_ns: Option<u64>,
    control_min: [f64; 2],
    control_max: [f64; 2],
}

impl Tally {
    /// Nothing yet, of a robot with the controls of `robot`.
    pub(crate) const fn new(robot: &RobotSettings) -> Self {
        Self {
            cycles: 0,
            interventions: 0,
            intervening_cycles: 0,
            slack_cycles: 0,
            max_slack: 0.0,
            min_hard_margin: f64::INFINITY,
            braking_cycles: 0,
            intervened_ns: None,
            control_min: robot.control_min,
            control_max: robot.control_max,
        }
    }

    /// Adds one cycle.
    pub(crate) fn note(&mut self, command: &SafeCommand, now_ns: u64) {
        self.cycles += 1;
        match SafetyStatus::try_from(command.status) {
            Ok(status @ (SafetyStatus::Filtered | SafetyStatus::Relaxed)) => {
                self.slack_cycles += u64::from(status == SafetyStatus::Relaxed);
                self.max_slack = self.max_slack.max(command.slack_mps);
                self.min_hard_margin = self.min_hard_margin.min(command.hard_margin_mps);
                self.note_correction(command, now_ns);
            }
            Ok(SafetyStatus::Braking | SafetyStatus::Stopped) | Err(_) => self.braking_cycles += 1,
        }
    }

    fn note_correction(&mut self, command: &SafeCommand, now_ns: u64) {
        // A wish that the actuators cannot fulfil anyway is no matter of safety.
        let [first, second] = [0, 1].map(|index| {
            let wanted = command.nominal[index].clamp(self.control_min[index], self.control_max[index]);
            command.control[index] - wanted
        });
        if first.hypot(second) <= INTERVENTION_TOLERANCE {
            return;
        }
        self.intervening_cycles += 1;
        let before_ns = self.intervened_ns.replace(now_ns);
        if before_ns.is_none_or(|before_ns| now_ns - before_ns > SHORTEST_PAUSE_NS) {
            self.interventions += 1;
        }
    }

    /// Smallest margin, if anybody was ever in sight.
    pub(crate) fn min_hard_margin(&self) -> Option<f64> {
        self.min_hard_margin.is_finite().then_some(self.min_hard_margin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn tally() -> Tally {
        let text = include_str!("../../../config/quadrotor.toml");
        let settings = settings::Settings::parse(text, "x".as_ref(), ".".as_ref());
        Tally::new(&settings.expect("shipped settings").robot)
    }

    fn command(status: SafetyStatus, difference: f64) -> SafeCommand {
        SafeCommand {
            status: status.code(),
            control: [difference, 0.0],
            slack_mps: 0.5,
            hard_margin_mps: -0.25,
            ..SafeCommand::zeroed()
        }
    }

    #[test]
    fn short_pauses_do_not_end_an_intervention() {
        let mut tally = tally();
        for (ms, difference) in [(0, 0.5), (4, 0.0), (100, 0.5), (204, 0.0), (208, 0.5)] {
            tally.note(&command(SafetyStatus::Filtered, difference), ms * 1_000_000);
        }
        assert_eq!((tally.cycles, tally.interventions, tally.intervening_cycles), (5, 2, 3));
    }

    #[test]
    fn a_wish_beyond_the_actuators_is_no_intervention() {
        let mut tally = tally();
        let clipped = SafeCommand {
            nominal: [7.0, -9.0],
            control: [2.0, -2.0],
            ..command(SafetyStatus::Filtered, 0.0)
        };
        tally.note(&clipped, 0);
        assert_eq!(tally.interventions, 0);
        tally.note(&SafeCommand { control: [2.0, -1.9], ..clipped }, 1);
        assert_eq!(tally.interventions, 1);
    }

    #[test]
    fn braking_is_neither_slack_nor_intervention() {
        let mut tally = tally();
        tally.note(&command(SafetyStatus::Braking, 1.0), 0);
        assert_eq!((tally.braking_cycles, tally.interventions, tally.min_hard_margin()), (1, 0, None));
        tally.note(&command(SafetyStatus::Relaxed, 0.0), 1);
        assert_eq!((tally.slack_cycles, tally.max_slack), (1, 0.5));
        assert_eq!(tally.min_hard_margin(), Some(-0.25));
    }
}
