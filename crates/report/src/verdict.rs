//! The figures a run is judged by.

use latency::{Recorder, Summary};
use messages::{RobotState, SourceKind, SourceStatus};
use serde::{Deserialize, Serialize};

use crate::intervention::{Interventions, interventions};
use crate::spans::{Rung, Span, rung_spans};
use crate::{RunRecord, Segment, Shadow, commanders, finite::finite};

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The goal was reached, nobody was touched as far as the source knows: see [`Verdict::collisions`].
    Reached,
    /// Nobody was touched as far as the source knows, but the goal was not reached.
    NotReached,
    /// Somebody was touched.
    Collision,
    /// The source said nothing about the truth.
    Unknown,
}

/// Share of the run's time on each rung, 0 to 1; together 1, or all 0 in an empty run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct TimeShares {
    /// See [`Rung::Filtered`].
    pub filtered: f64,
    /// See [`Rung::Relaxed`].
    pub relaxed: f64,
    /// See [`Rung::Braking`].
    pub braking: f64,
    /// See [`Rung::Stopped`].
    pub stopped: f64,
    /// See [`Rung::Silent`].
    pub silent: f64,
}

impl TimeShares {
    fn of(spans: &[Span]) -> Self {
        let mut shares = Self::default();
        let total_s: f64 = spans.iter().map(Span::length_s).sum();
        if total_s > 0.0 {
            for span in spans {
                *shares.share_mut(span.rung) += span.length_s() / total_s;
            }
        }
        shares
    }

    /// Share of one rung, 0 to 1.
    pub const fn share(&self, rung: Rung) -> f64 {
        match rung {
            Rung::Filtered => self.filtered,
            Rung::Relaxed => self.relaxed,
            Rung::Braking => self.braking,
            Rung::Stopped => self.stopped,
            Rung::Silent => self.silent,
        }
    }

    const fn share_mut(&mut self, rung: Rung) -> &mut f64 {
        match rung {
            Rung::Filtered => &mut self.filtered,
            Rung::Relaxed => &mut self.relaxed,
            Rung::Braking => &mut self.braking,
            Rung::Stopped => &mut self.stopped,
            Rung::Silent => &mut self.silent,
        }
    }
}

/// Figures of one run. `None` (JSON `null`) means unknown, or never finite: no obstacle was ever near.
///
/// `Display` gives the text for the terminal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// How it ended.
    pub outcome: Outcome,
    /// Whether the robot came within its goal's tolerance, as the source says.
    pub reached: Option<bool>,
    /// Contacts between robot and people, as the source says; unknown on a live robot.
    pub collisions: Option<u32>,
    /// Smallest true distance between the discs of robot and people, as the source says, m.
    pub min_clearance_m: Option<f64>,
    /// Distance to the goal at the end, as the source says, m.
    pub goal_distance_m: Option<f64>,
    /// Time from the start to the goal, s; `None` if it was not reached.
    pub time_to_goal_s: Option<f64>,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Length of the robot's path, m: as the source says, else from the robot states.
    pub path_length_m: Option<f64>,
    /// Smallest composite value h, m.
    pub min_h_m: Option<f64>,
    /// Smallest distance between the discs as the filter believed it, buffer and growth by age included, m.
    pub min_sdf_m: Option<f64>,
    /// Largest slack that the CBF-QP needed, m/s.
    pub max_slack_mps: f64,
    /// Cycles in which no admissible control satisfied the condition.
    pub infeasible_cycles: u64,
    /// When the filter changed the nominal command because of an obstacle.
    pub interventions: Interventions,
    /// Share of time on each rung.
    pub time_shares: TimeShares,
    /// When the run began, stack clock, ns: the first filter cycle.
    #[serde(default)]
    pub start_ns: u64,
    /// Which nominal controllers commanded, one after the other, and when.
    #[serde(default)]
    pub commanders: Vec<Segment>,
    /// What the filter would have done, where it only watched. Everything else then tells how the robot fared without it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shadow: Option<Shadow>,
    /// Sensor messages that the source handed on.
    pub accepted_inputs: Option<u64>,
    /// Sensor messages that the source refused, each for a logged reason.
    pub refused_inputs: Option<u64>,
    /// Latency per hop, and whether the filter kept its period.
    pub latency: Summary,
}

impl Verdict {
    /// Judges a run.
    pub fn of(record: &RunRecord) -> Self {
        let spans = rung_spans(record);
        let source = record.source_status.last();
        let collisions = counted(&record.source_status, |status| u64::from(status.collisions));
        let with_barrier =
            || record.safe_commands.iter().filter(|command| Rung::of_code(command.status).has_barrier());
        let smallest = |values: &mut dyn Iterator<Item = f64>| finite(values.fold(f64::INFINITY, f64::min));
        let interventions = interventions(record, &spans);
        let reached_at = record.source_status.iter().find(|status| status.goal_reached != 0);

        Self {
            outcome: match source {
                None => Outcome::Unknown,
                Some(_) if collisions > 0 => Outcome::Collision,
                Some(status) if status.goal_reached != 0 => Outcome::Reached,
                Some(_) => Outcome::NotReached,
            },
            reached: source.map(|status| status.goal_reached != 0),
            collisions: source
                .filter(|status| status.kind != SourceKind::Ros2.code())
                .map(|_| u32::try_from(collisions).unwrap_or(u32::MAX)),
            min_clearance_m: smallest(&mut record.source_status.iter().map(|status| status.min_clearance_m)),
            goal_distance_m: source.and_then(|status| finite(status.goal_distance_m)),
            time_to_goal_s: reached_at.map(|status| record.seconds(status.published_ns).max(0.0)),
            duration_s: record.duration_s(),
            path_length_m: source
                .and_then(|status| finite(status.path_length_m))
                .or_else(|| path_length_m(&record.robot_states)),
            min_h_m: smallest(&mut with_barrier().map(|command| command.h_m)),
            min_sdf_m: smallest(&mut with_barrier().map(|command| command.sdf_m)),
            max_slack_mps: with_barrier().map(|command| command.slack_mps).fold(0.0, f64::max),
            infeasible_cycles: with_barrier().filter(|command| command.hard_margin_mps < 0.0).count() as u64,
            interventions,
            start_ns: record.start_ns(),
            commanders: commanders(&record.nominal_commands),
            shadow: record.shadow.then(|| Shadow::of(record, &interventions)),
            time_shares: TimeShares::of(&spans),
            accepted_inputs: source.map(|_| counted(&record.source_status, |status| status.accepted)),
            refused_inputs: source.map(|_| counted(&record.source_status, |status| status.refused)),
            latency: Recorder::of(record.filter_period_ns, &record.safe_commands).summary(),
        }
    }

    /// The outcome in a few words. Where the filter only watched, it says so first.
    pub fn headline(&self) -> String {
        match &self.shadow {
            Some(_) => format!("Shadow, the robot drove itself unfiltered: {}", self.outcome()),
            None => self.outcome(),
        }
    }

    fn outcome(&self) -> String {
        match self.outcome {
            Outcome::Reached => format!("Goal reached, {}", self.contacts()),
            // Nor is there one where the robot's own controller drives, which tells none.
            Outcome::NotReached if self.goal_distance_m.is_none() => {
                format!("No goal was told, {}", self.contacts())
            }
            Outcome::NotReached => format!("Goal not reached, {}", self.contacts()),
            Outcome::Collision => match self.collisions {
                Some(1) | None => "Collision".to_owned(),
                Some(count) => format!("{count} collisions"),
            },
            Outcome::Unknown => "Outcome unknown: the source reported none".to_owned(),
        }
    }

    /// What is known of contacts where none was counted. A live robot does not tell whom it touches.
    const fn contacts(&self) -> &'static str {
        match self.collisions {
            Some(_) => "nobody touched",
            None => "contacts unknown",
        }
    }

    /// Share of due times whose cycle began less than one period late, 0 to 1; `None` without due times.
    pub fn deadlines_kept(&self) -> Option<f64> {
        self.latency.counts.deadlines_kept()
    }
}

/// A counter of the source over the whole run. A source that was restarted counts from zero again, which must not hide what
/// came before.
fn counted(statuses: &[SourceStatus], counter: impl Fn(&SourceStatus) -> u64) -> u64 {
    let before_restarts = statuses.windows(2).filter(|pair| pair[1].elapsed_ns < pair[0].elapsed_ns);
    before_restarts.map(|pair| counter(&pair[0])).chain(statuses.last().map(&counter)).sum()
}

fn path_length_m(states: &[RobotState]) -> Option<f64> {
    let steps = states.windows(2).map(|pair| {
        let [from, to] = [pair[0].position_in_odom_m, pair[1].position_in_odom_m];
        (to[0] - from[0]).hypot(to[1] - from[1])
    });
    (states.len() > 1).then(|| steps.sum()).and_then(finite)
}
