//! From what is known of the stack to what `/diagnostics` says: one status per part, each with its details.
//!
//! Messages of statuses hold no figures, so that a status whose message changes is news. Knows neither DDS nor threads.

use std::collections::BTreeMap;
use std::fmt;

use messages::{Health, ProcessId, Reason, SafeCommand, SafetyStatus};
use recording::ros2::{Byte, DiagnosticStatus, KeyValue};

use super::board::{Direction, TopicRecord};
use super::filter_state::{reason_label, status_label};
use super::watch::{Others, Watched};
use crate::command_sink::SinkState;

/// A filter without a command for this long is silent, ns.
const FILTER_SILENCE_NS: u64 = 500_000_000;
/// A process without a report for this long is silent, ns; they come five times a second.
pub(super) const REPORT_SILENCE_NS: u64 = 1_500_000_000;
/// What counts are compared over, ns.
const WINDOW_NS: u64 = 1_000_000_000;

/// Everything known at one time.
pub(super) struct Facts<'a> {
    /// The time, stack clock, ns.
    pub(super) now_ns: u64,
    /// Newest command of the filter.
    pub(super) command: Option<&'a SafeCommand>,
    /// What the command sink does; `None` where the robot is left alone.
    pub(super) sink: Option<SinkState>,
    /// Messages that were refused or lost on the way into the stack.
    pub(super) lost: u64,
    /// Commands that newer ones replaced before they left.
    pub(super) replaced: u64,
    /// Every topic of the node.
    pub(super) topics: &'a [Watched],
    /// The topic that drives the robot.
    pub(super) command_topic: &'a str,
    /// Newest report of each process, by its code.
    pub(super) health: &'a BTreeMap<u32, Health>,
    /// Processes that a complete stack has.
    pub(super) expected: &'a [ProcessId],
}

/// Makes the statuses, remembering what counts were a window ago.
pub(super) struct Diagnostics {
    node: String,
    hardware_id: String,
    since_ns: u64,
    before: BTreeMap<String, u64>,
    now: BTreeMap<String, u64>,
    /// Changes per second of the last whole window.
    rates: BTreeMap<String, f64>,
}

/// A status before it has name and hardware.
struct Said {
    level: Byte,
    message: String,
    values: Vec<(String, String)>,
}

impl Diagnostics {
    /// Of the node with full name `node` in stack `instance`.
    pub(super) fn new(node: &str, instance: &str) -> Self {
        Self {
            node: node.trim_start_matches('/').to_owned(),
            hardware_id: instance.to_owned(),
            since_ns: 0,
            before: BTreeMap::new(),
            now: BTreeMap::new(),
            rates: BTreeMap::new(),
        }
    }

    /// What there is to say of `facts`.
    pub(super) fn statuses(&mut self, facts: &Facts<'_>) -> Vec<DiagnosticStatus> {
        self.turn_window(facts.now_ns);
        let mut parts = vec![("filter".to_owned(), self.filter(facts))];
        if let Some(sink) = facts.sink {
            parts.push(("command sink".to_owned(), self.sink(sink, facts)));
        }
        for watched in facts.topics {
            let Watched { record, others } = watched;
            match record.direction {
                Direction::In => parts.push((format!("input {}", record.topic), self.input(watched, facts))),
                Direction::Out if record.topic == facts.command_topic || others.is_faulty() => {
                    let said = self.output(watched, record.topic == facts.command_topic);
                    parts.push((format!("output {}", record.topic), said));
                }
                Direction::Out => {}
            }
        }
        for process in ProcessId::ALL {
            let health = facts.health.get(&process.code());
            if health.is_some() || facts.expected.contains(process) {
                parts.push((format!("process {process}"), self.process(*process, health, facts.now_ns)));
            }
        }
        parts.into_iter().map(|(part, said)| self.named(&part, said)).collect()
    }

    fn named(&self, part: &str, said: Said) -> DiagnosticStatus {
        DiagnosticStatus {
            level: said.level,
            name: format!("{}: {part}", self.node),
            message: said.message,
            hardware_id: self.hardware_id.clone(),
            values: said.values.into_iter().map(|(key, value)| KeyValue { key, value }).collect(),
        }
    }

    /// Begins a new window where the last one is complete.
    fn turn_window(&mut self, now_ns: u64) {
        let elapsed_ns = now_ns.saturating_sub(self.since_ns);
        if elapsed_ns < WINDOW_NS {
            return;
        }
        let seconds = elapsed_ns as f64 * 1e-9;
        self.rates = self
            .now
            .iter()
            .map(|(key, now)| {
                let before = self.before.get(key).copied().unwrap_or(0);
                (key.clone(), now.saturating_sub(before) as f64 / seconds)
            })
            .collect();
        self.before.clone_from(&self.now);
        self.since_ns = now_ns;
    }

    /// Notes a count and returns how fast it grew over the last window, 1/s.
    fn rate(&mut self, key: String, count: u64) -> f64 {
        let rate = self.rates.get(&key).copied().unwrap_or(0.0);
        self.now.insert(key, count);
        rate
    }

    fn filter(&mut self, facts: &Facts<'_>) -> Said {
        let Some(command) = facts.command else {
            return Said::new(DiagnosticStatus::STALE, "nothing heard of the filter yet");
        };
        let age_ns = facts.now_ns.saturating_sub(command.ledger.filter_published_ns);
        let (level, message) = if age_ns > FILTER_SILENCE_NS {
            (DiagnosticStatus::STALE, "silent; the command sink brakes by itself".to_owned())
        } else {
            rung(command.status, command.reason)
        };
        let rate = self.rate("filter".to_owned(), command.sequence);
        let [[u, v], [u_nom, v_nom]] = [command.control, command.nominal];
        Said { level, message, values: Vec::new() }
            .with("status", &status_label(command.status))
            .with("reason", &reason_label(command.reason))
            .with("rate_hz", &format!("{rate:.0}"))
            .with("h_m", &format!("{:.3}", command.h_m))
            .with("sdf_m", &format!("{:.3}", command.sdf_m))
            .with("intervention", &format!("{:.3}", (u - u_nom).hypot(v - v_nom)))
            .with("slack_mps", &format!("{:.3}", command.slack_mps))
            .with("obstacles", &command.obstacle_count)
            .with("critical_track_id", &command.critical_track_id)
            .with("age_ms", &format!("{:.1}", ms(age_ns)))
    }

    fn sink(&mut self, sink: SinkState, facts: &Facts<'_>) -> Said {
        let lost = self.rate("lost".to_owned(), facts.lost);
        let replaced = self.rate("replaced".to_owned(), facts.replaced);
        // One now and then is what replacing is for.
        let sent = self.rates.get(&format!("messages {}", facts.command_topic)).copied().unwrap_or(0.0);
        let said = match sink {
            SinkState::Following if lost > 0.0 => {
                Said::new(DiagnosticStatus::WARN, "follows the filter; messages are refused or lost")
            }
            SinkState::Following if replaced > sent => Said::new(
                DiagnosticStatus::WARN,
                "follows the filter; most commands are late and replaced by newer ones",
            ),
            SinkState::Following => Said::new(DiagnosticStatus::OK, "follows the filter"),
            SinkState::Waiting => {
                Said::new(DiagnosticStatus::WARN, "keeps the robot standing until the filter speaks")
            }
            SinkState::Braking(reason) => {
                Said::new(DiagnosticStatus::ERROR, format!("brakes by itself: {reason}"))
            }
        };
        said.with("refused_or_lost", &facts.lost).with("replaced_commands", &facts.replaced)
    }

    fn input(&mut self, watched: &Watched, facts: &Facts<'_>) -> Said {
        let Watched { record, others } = watched;
        let rate = self.rate(format!("messages {}", record.topic), record.messages());
        let mut worst: Option<(Reason, f64)> = None;
        let mut refusals = Vec::new();
        for (reason, count) in record.refusals() {
            let rate = self.rate(format!("{reason} {}", record.topic), count);
            if rate > worst.map_or(0.0, |(_, rate)| rate) {
                worst = Some((reason, rate));
            }
            refusals.push((format!("refused_{reason}"), count.to_string()));
        }
        let (level, message) = input_verdict(record, others, rate, worst);
        let age = record.age_ns(facts.now_ns).map_or_else(String::new, |ns| format!("{:.0}", ms(ns)));
        let mut said = Said { level, message, values: Vec::new() }
            .with("type", &record.expected)
            .with("rate_hz", &format!("{rate:.1}"))
            .with("age_ms", &age)
            .with("messages", &record.messages())
            .with("publishers", &others.matched)
            .with("silent", &record.is_silent());
        said.values.extend(refusals);
        said.faults(others)
    }

    fn output(&mut self, watched: &Watched, is_command: bool) -> Said {
        let Watched { record, others } = watched;
        let rate = self.rate(format!("messages {}", record.topic), record.messages());
        let unsent: u64 = record.refusals().map(|(_, count)| count).sum();
        let failing = self.rate(format!("unsent {}", record.topic), unsent) > 0.0;
        let (level, message) = if is_command && others.rivals > 0 {
            (DiagnosticStatus::ERROR, "somebody else commands the robot, too, past the filter".to_owned())
        } else if failing {
            (DiagnosticStatus::ERROR, "messages do not leave".to_owned())
        } else if let Some((level, message)) = fault(others, "subscriber", "expects", record.expected) {
            (level, message)
        } else if is_command && others.matched == 0 {
            (DiagnosticStatus::WARN, "no subscriber".to_owned())
        } else {
            (DiagnosticStatus::OK, "published".to_owned())
        };
        Said { level, message, values: Vec::new() }
            .with("type", &record.expected)
            .with("rate_hz", &format!("{rate:.1}"))
            .with("messages", &record.messages())
            .with("subscribers", &others.matched)
            .with("other_publishers", &others.rivals)
            .with("unsent", &unsent)
            .faults(others)
    }

    fn process(&mut self, process: ProcessId, health: Option<&Health>, now_ns: u64) -> Said {
        let Some(health) = health else {
            return Said::new(DiagnosticStatus::STALE, "nothing heard of it yet");
        };
        let missed = self.rate(format!("missed {process}"), health.missed_deadlines);
        let errors = self.rate(format!("errors {process}"), u64::from(health.errors));
        let rate = self.rate(format!("cycles {process}"), health.cycles);
        let (level, message) = if now_ns.saturating_sub(health.published_ns) > REPORT_SILENCE_NS {
            (DiagnosticStatus::STALE, "silent".to_owned())
        } else if health.cycles == 0 && process == ProcessId::Nominal {
            (DiagnosticStatus::WARN, "waits: another program has its place".to_owned())
        } else if errors > 0.0 {
            (DiagnosticStatus::WARN, format!("reports {}", reason_label(health.last_reason)))
        } else if missed > 0.0 {
            (DiagnosticStatus::WARN, "misses deadlines".to_owned())
        } else {
            (DiagnosticStatus::OK, "runs".to_owned())
        };
        Said { level, message, values: Vec::new() }
            .with("pid", &health.pid)
            .with("cycles_hz", &format!("{rate:.0}"))
            .with("missed_deadlines", &health.missed_deadlines)
            .with("max_lateness_us", &format!("{:.0}", health.max_lateness_ns as f64 * 1e-3))
            .with("errors", &health.errors)
            .with("last_reason", &reason_label(health.last_reason))
            .with("refused_inputs", &health.refused_inputs)
    }
}

impl Said {
    fn new(level: Byte, message: impl Into<String>) -> Self {
        Self { level, message: message.into(), values: Vec::new() }
    }

    fn with(mut self, key: &str, value: &dyn fmt::Display) -> Self {
        self.values.push((key.to_owned(), value.to_string()));
        self
    }

    fn faults(self, others: &Others) -> Self {
        self.with("wrong_types", &others.wrong_types.join(", "))
            .with("qos_misfits", &others.misfits.join("; "))
    }
}

/// Level and words of a rung of the ladder. A robot that stands because it is asked to is well.
fn rung(status: u32, reason: u32) -> (Byte, String) {
    let words = format!("{}: {}", status_label(status), reason_label(reason));
    match SafetyStatus::try_from(status) {
        Ok(SafetyStatus::Filtered) => (DiagnosticStatus::OK, status_label(status).to_owned()),
        Ok(SafetyStatus::Relaxed) => (DiagnosticStatus::WARN, words),
        Ok(SafetyStatus::Braking | SafetyStatus::Stopped) => {
            let level = if reason == Reason::StopRequested.code() {
                DiagnosticStatus::OK
            } else if [Reason::NoGoal.code(), Reason::NoNominalCommand.code()].contains(&reason) {
                DiagnosticStatus::WARN
            } else {
                DiagnosticStatus::ERROR
            };
            (level, words)
        }
        Err(_) => (DiagnosticStatus::ERROR, words),
    }
}

/// Level and words of an input, the gravest first.
fn input_verdict(
    record: &TopicRecord,
    others: &Others,
    rate: f64,
    worst: Option<(Reason, f64)>,
) -> (Byte, String) {
    if let Some(fault) = fault(others, "publisher", "speaks", record.expected) {
        fault
    } else if record.is_silent() {
        let why = if others.matched == 0 { "no publisher" } else { "publishers are there and say nothing" };
        (DiagnosticStatus::STALE, format!("silent: {why}"))
    } else if let Some((reason, refused)) = worst {
        let level = if refused >= rate { DiagnosticStatus::ERROR } else { DiagnosticStatus::WARN };
        (level, format!("messages are refused: {reason}"))
    } else if record.messages() == 0 {
        (DiagnosticStatus::OK, "nothing heard yet".to_owned())
    } else {
        (DiagnosticStatus::OK, "heard".to_owned())
    }
}

/// Level and words where others announce what does not fit: an error where nobody else is matched.
fn fault(others: &Others, who: &str, does: &str, ours: &str) -> Option<(Byte, String)> {
    let message = if !others.wrong_types.is_empty() {
        format!("a {who} {does} {}, not {ours}", others.wrong_types.join(", "))
    } else if others.misfits.is_empty() {
        return None;
    } else {
        format!("a {who}'s quality of service does not fit: {}", others.misfits.join("; "))
    };
    Some((if others.matched == 0 { DiagnosticStatus::ERROR } else { DiagnosticStatus::WARN }, message))
}

fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

#[cfg(test)]
mod tests;
