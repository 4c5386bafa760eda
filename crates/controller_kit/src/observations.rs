//! What the bench saw of a candidate: the material that the rules judge.

use messages::{Intent, NominalCommand, RobotState};

/// What a stretch of the script is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Until the candidate speaks.
    Waiting,
    /// On the way to a goal, everything in order.
    Driving,
    /// Around a goal that was reached.
    AtGoal,
    /// No robot states.
    NoStates,
    /// Robot states are there again.
    Again,
    /// Robot states hold a NaN.
    NotANumber,
    /// The candidate has been asked to end.
    Ending,
}

/// One stretch of the script.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stretch {
    /// What it is about.
    pub(crate) phase: Phase,
    /// Beginning, ns.
    pub(crate) start_ns: u64,
    /// End, ns.
    pub(crate) end_ns: u64,
}

/// One nominal command as it arrived.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heard {
    /// The command.
    pub(crate) command: NominalCommand,
    /// When the bench took it, ns.
    pub(crate) received_ns: u64,
    /// During what.
    pub(crate) phase: Phase,
}

impl Heard {
    /// Whether it asks the robot to drive.
    pub(crate) fn drives(&self) -> bool {
        Intent::try_from(self.command.intent) == Ok(Intent::Drive)
    }

    /// Whether it asks the robot to halt.
    pub(crate) fn stops(&self) -> bool {
        Intent::try_from(self.command.intent) == Ok(Intent::Stop)
    }

    /// Whether its control is made of numbers.
    pub(crate) fn is_finite(&self) -> bool {
        self.command.control.iter().all(|value| value.is_finite())
    }
}

/// How a try to drive somewhere ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Attempt {
    /// Whether it succeeded.
    pub(crate) succeeded: bool,
    /// How long it took, or was waited for, s.
    pub(crate) took_s: f64,
    /// Distance to the goal at the end, m.
    pub(crate) distance_m: f64,
}

/// How the candidate ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Farewell {
    /// Time from SIGTERM to the end, ns.
    pub(crate) after_ns: u64,
    /// Exit status in words; `None` if it had to be killed.
    pub(crate) status: Option<String>,
    /// Whether the exit code was 0.
    pub(crate) is_clean: bool,
    /// Whether the place of the nominal controller was free afterwards.
    pub(crate) place_is_free: bool,
}

/// Everything that was seen.
#[derive(Debug, Default)]
pub(crate) struct Observations {
    /// When the candidate was started, ns.
    pub(crate) started_ns: u64,
    /// Every command, in the order of arrival.
    pub(crate) heard: Vec<Heard>,
    /// Every robot state that was sent, in order.
    pub(crate) sent: Vec<RobotState>,
    /// The script as it went.
    pub(crate) stretches: Vec<Stretch>,
    /// Whether the goal had to be said again before the candidate spoke.
    pub(crate) goal_repeated: bool,
    /// The way to the first goal.
    pub(crate) first_goal: Option<Attempt>,
    /// Time from the arrival until it asked for a halt and went on doing so, s; `None` if it did not.
    pub(crate) halted_after_s: Option<f64>,
    /// Turning to a new goal from a standstill, and while driving.
    pub(crate) turns: Vec<Attempt>,
    /// When it spoke again after states had returned, s; `None` if it did not.
    pub(crate) resumed_after_s: Option<f64>,
    /// The same after states that were not numbers.
    pub(crate) recovered_after_s: Option<f64>,
    /// Exit status in words if it ended although nobody had asked it to, and during what.
    pub(crate) ended_early: Option<(String, Phase)>,
    /// How it ended when asked.
    pub(crate) farewell: Option<Farewell>,
}

impl Observations {
    /// Commands that were heard during `phase`.
    pub(crate) fn during(&self, phase: Phase) -> impl Iterator<Item = &Heard> {
        self.heard.iter().filter(move |heard| heard.phase == phase)
    }

    /// Stretches of `phase`.
    pub(crate) fn stretches_of(&self, phase: Phase) -> impl Iterator<Item = &Stretch> {
        self.stretches.iter().filter(move |stretch| stretch.phase == phase)
    }
}
