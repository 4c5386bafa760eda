//! The worst moments and what every process ran around them.

use core::fmt::Write as _;

use latency::RunMessages;
use messages::{Cycle, Ledger, ProcessId, SafeCommand, Trigger};

use super::ProfilePage;
use super::rows::time;
use crate::html::escaped;
use crate::plot::{Gantt, GanttBar, GanttMark};
use crate::theme::Role;

/// How many moments of each kind are shown.
const MOMENTS: usize = 5;

/// One repeat with the part of it that was measured.
pub(super) struct Measured<'a> {
    /// Counts from 1.
    repeat: usize,
    run: &'a RunMessages,
    commands: &'a [SafeCommand],
    /// When the measured time began, stack clock, ns.
    pub(super) start_ns: u64,
    period_ns: u64,
}

/// Every repeat whose messages are at hand.
pub(super) fn measured<'a>(page: &ProfilePage<'a>) -> impl Iterator<Item = Measured<'a>> {
    let period_ns = page.figures.conditions.filter_period_ns;
    page.runs.iter().zip(&page.figures.repeats).enumerate().map(move |(index, (run, repeat))| {
        let all = &run.safe_commands;
        let first = all.partition_point(|command| command.ledger.filter_woke_ns < repeat.measured_from_ns);
        let commands = &all[first..];
        let start_ns = commands.first().map_or(0, |command| command.ledger.filter_woke_ns);
        Measured { repeat: index + 1, run, commands, start_ns, period_ns }
    })
}

impl<'a> Measured<'a> {
    /// Commands that used a frame of detections first.
    fn first_uses(&self) -> impl Iterator<Item = &'a SafeCommand> {
        let mut seen_ns = 0;
        self.commands.iter().filter(move |command| {
            let ingress_ns = command.ledger.detections_ingress_ns;
            let is_new = ingress_ns != 0 && ingress_ns != seen_ns;
            seen_ns = ingress_ns;
            is_new
        })
    }

    /// `(when, how long)` of the path from detections to command, ns.
    pub(super) fn end_to_end(&self) -> Vec<(u64, u64)> {
        self.first_uses()
            .map(|command| (command.ledger.filter_woke_ns, end_to_end_ns(&command.ledger)))
            .collect()
    }

    /// `(when, how late)` of the filter's cycles by timer, ns.
    pub(super) fn lateness(&self) -> Vec<(u64, u64)> {
        let due = |command: &SafeCommand| oldest_due_ns(&command.ledger, self.period_ns);
        let of = |command: &SafeCommand| {
            let woke_ns = command.ledger.filter_woke_ns;
            Some((woke_ns, woke_ns.saturating_sub(due(command)?)))
        };
        self.commands.iter().filter_map(of).collect()
    }
}

const fn end_to_end_ns(ledger: &Ledger) -> u64 {
    ledger.filter_published_ns.saturating_sub(ledger.detections_ingress_ns)
}

/// The oldest due time a cycle of the timer answers for, ns.
fn oldest_due_ns(ledger: &Ledger, period_ns: u64) -> Option<u64> {
    let by_timer =
        Trigger::try_from(ledger.filter_trigger) == Ok(Trigger::Timer) && ledger.filter_due_ns != 0;
    by_timer.then(|| {
        ledger.filter_due_ns.saturating_sub(u64::from(ledger.filter_skipped).saturating_mul(period_ns))
    })
}

/// What the pictures of slow detections are about.
const SLOWEST: &str = "detection to command";

/// One moment worth a picture.
struct Moment<'a> {
    run: &'a RunMessages,
    repeat: usize,
    at_s: f64,
    command: &'a SafeCommand,
    /// What took so long, ns.
    length_ns: u64,
    /// When it began, ns.
    from_ns: u64,
}

/// The worst moments of both kinds as HTML; nothing without messages.
pub(super) fn sections(page: &ProfilePage<'_>) -> String {
    let repeats: Vec<Measured<'_>> = measured(page).collect();
    let slowest = worst(
        &repeats,
        |of| of.first_uses().map(|command| (command, command.ledger.detections_ingress_ns)).collect(),
        |command, from_ns| command.ledger.filter_published_ns.saturating_sub(from_ns),
    );
    let latest = worst(
        &repeats,
        |of| {
            let due = |command: &'_ SafeCommand| oldest_due_ns(&command.ledger, of.period_ns);
            of.commands.iter().filter_map(|command| Some((command, due(command)?))).collect()
        },
        |command, from_ns| command.ledger.filter_woke_ns.saturating_sub(from_ns),
    );
    let mut text = String::new();
    for (title, what, moments) in
        [("The slowest detections", SLOWEST, slowest), ("The latest cycles of the filter", "late", latest)]
    {
        if !moments.is_empty() {
            let _ = write!(text, "<h3>{title}</h3>");
            for moment in &moments {
                text.push_str(&picture(moment, what));
            }
        }
    }
    if text.is_empty() { "<p class=\"hint\">No messages are at hand.</p>".to_owned() } else { text }
}

/// The longest of `all`, longest first.
fn worst<'a>(
    repeats: &[Measured<'a>],
    all: impl Fn(&Measured<'a>) -> Vec<(&'a SafeCommand, u64)>,
    length_ns: impl Fn(&SafeCommand, u64) -> u64,
) -> Vec<Moment<'a>> {
    let mut moments: Vec<Moment<'a>> = repeats
        .iter()
        .flat_map(|of| {
            all(of).into_iter().map(|(command, from_ns)| Moment {
                run: of.run,
                repeat: of.repeat,
                at_s: command.ledger.filter_woke_ns.saturating_sub(of.start_ns) as f64 / 1e9,
                command,
                length_ns: length_ns(command, from_ns),
                from_ns,
            })
        })
        .collect();
    moments.sort_by_key(|moment| core::cmp::Reverse(moment.length_ns));
    moments.truncate(MOMENTS);
    moments
}

fn picture(moment: &Moment<'_>, what: &str) -> String {
    let ledger = &moment.command.ledger;
    let (from_ns, to_ns) = (moment.from_ns, ledger.filter_published_ns.max(moment.from_ns + 1));
    let room_ns = ((to_ns - from_ns) / 8).max(50_000);
    let window_ns = (from_ns.saturating_sub(room_ns), to_ns + room_ns);
    let mut around: Vec<&Cycle> = moment
        .run
        .cycles
        .iter()
        .filter(|cycle| cycle.done_ns >= window_ns.0 && cycle.woke_ns <= window_ns.1)
        .collect();
    around.sort_by_key(|cycle| cycle.woke_ns);

    let has_row = |process: ProcessId| {
        process == ProcessId::Filter || moment.run.cycles.iter().any(|cycle| cycle.process == process.code())
    };
    let rows: Vec<ProcessId> = ROWS.into_iter().filter(|&process| has_row(process)).collect();
    let shown = |bar: &GanttBar| bar.to_ns >= window_ns.0 && bar.from_ns <= window_ns.1;
    let stages = stage_bars(&rows, ledger, &around).filter(shown);
    let gantt = Gantt {
        rows: rows.iter().map(|process| process.label()).collect(),
        window_ns,
        zero_ns: from_ns,
        bars: around.iter().filter_map(|cycle| cycle_bar(&rows, cycle)).chain(stages).collect(),
        marks: marks(moment),
    };
    format!(
        "<figure class=\"moment\"><figcaption><b>{}</b> {what}<span>repeat {}, after {:.3} s, command {}{}{}</span></figcaption>{}</figure>",
        time(moment.length_ns),
        moment.repeat,
        moment.at_s,
        moment.command.sequence,
        if what == SLOWEST { breakdown(ledger) } else { String::new() },
        escaped(&disturbances(&around)),
        gantt.draw()
    )
}

/// The processes of a picture, from top to bottom; those without cycle records are left out.
const ROWS: [ProcessId; 5] =
    [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter, ProcessId::Recorder];

fn row_of(rows: &[ProcessId], process: ProcessId) -> Option<usize> {
    rows.iter().position(|&row| row == process)
}

fn cycle_bar(rows: &[ProcessId], cycle: &Cycle) -> Option<GanttBar> {
    let process = ProcessId::try_from(cycle.process).ok()?;
    let disturbed = cycle.involuntary_switches + cycle.minor_faults + cycle.major_faults > 0;
    let (by, role) = match Trigger::try_from(cycle.trigger) {
        Ok(Trigger::Timer) => ("timer", Role::Blue),
        Ok(Trigger::Event) => ("an input", Role::Orange),
        Err(_) => ("?", Role::Grey),
    };
    Some(GanttBar {
        row: row_of(rows, process)?,
        from_ns: cycle.woke_ns,
        to_ns: cycle.done_ns,
        role: if disturbed { Role::Red } else { role },
        inner: false,
        hint: format!(
            "{process}: cycle {} begun by {by}, {}, CPU {}, processor {}, {} skipped, {} page faults, {} from disk, gave up {} times, \
             pushed off {} times",
            cycle.sequence,
            time(cycle.done_ns.saturating_sub(cycle.woke_ns)),
            time(cycle.cpu_ns),
            cycle.processor,
            cycle.skipped,
            cycle.minor_faults,
            cycle.major_faults,
            cycle.voluntary_switches,
            cycle.involuntary_switches
        ),
    })
}

/// What this command's own inputs went through.
///
/// A stage that rests on an input of an earlier cycle, as an estimate that is carried forward does, is drawn from where the
/// cycle began that ended it: in between its process worked on nothing.
fn stage_bars(rows: &[ProcessId], ledger: &Ledger, around: &[&Cycle]) -> impl Iterator<Item = GanttBar> {
    let stages = [
        (
            ProcessId::Bridge,
            "takes detections in",
            ledger.detections_ingress_ns,
            ledger.detections_published_ns,
        ),
        (ProcessId::Estimator, "estimates", ledger.estimator_received_ns, ledger.estimator_published_ns),
        (ProcessId::Nominal, "plans", ledger.nominal_received_ns, ledger.nominal_published_ns),
        (ProcessId::Filter, "computes", ledger.filter_woke_ns, ledger.filter_computed_ns),
        (ProcessId::Filter, "hands over", ledger.filter_computed_ns, ledger.filter_published_ns),
    ];
    let begun_ns = |process: ProcessId, at_ns: u64| {
        let own = around.iter().filter(|cycle| cycle.process == process.code());
        own.filter(|cycle| (cycle.woke_ns..=cycle.done_ns).contains(&at_ns)).map(|cycle| cycle.woke_ns).max()
    };
    stages.into_iter().filter(|&(_, _, from_ns, to_ns)| from_ns != 0 && to_ns >= from_ns).filter_map(
        move |(process, what, from_ns, to_ns)| {
            let from_ns = from_ns.max(begun_ns(process, to_ns).unwrap_or(from_ns));
            let hint = format!("{process} {what}: {}", time(to_ns - from_ns));
            Some(GanttBar { row: row_of(rows, process)?, from_ns, to_ns, role: Role::Ink, inner: true, hint })
        },
    )
}

fn marks(moment: &Moment<'_>) -> Vec<GanttMark> {
    let ledger = &moment.command.ledger;
    let mut marks = vec![GanttMark { at_ns: ledger.filter_published_ns, role: Role::Green, name: "command" }];
    if ledger.detections_ingress_ns != 0 {
        let at_ns = ledger.detections_ingress_ns;
        marks.push(GanttMark { at_ns, role: Role::Purple, name: "detections" });
    }
    if Trigger::try_from(ledger.filter_trigger) == Ok(Trigger::Timer) {
        let at_ns = if ledger.filter_skipped > 0 { moment.from_ns } else { ledger.filter_due_ns };
        marks.push(GanttMark { at_ns, role: Role::Grey, name: "due" });
    }
    marks
}

/// Where the time between detections and command went.
fn breakdown(ledger: &Ledger) -> String {
    let steps = [
        ("bridge", ledger.detections_ingress_ns, ledger.detections_published_ns),
        ("to estimator", ledger.detections_published_ns, ledger.estimator_received_ns),
        ("estimator", ledger.estimator_received_ns, ledger.estimator_published_ns),
        ("to filter", ledger.estimator_published_ns, ledger.filter_woke_ns),
        ("compute", ledger.filter_woke_ns, ledger.filter_computed_ns),
        ("hand over", ledger.filter_computed_ns, ledger.filter_published_ns),
    ];
    steps.iter().filter(|&&(_, from_ns, to_ns)| from_ns != 0 && to_ns >= from_ns).fold(
        String::new(),
        |mut text, &(name, from_ns, to_ns)| {
            let _ = write!(text, " · {name} {}", time(to_ns - from_ns));
            text
        },
    )
}

/// Who was pushed off or faulted meanwhile.
fn disturbances(around: &[&Cycle]) -> String {
    let mut text = String::new();
    for process in ROWS {
        let own = || around.iter().filter(|cycle| cycle.process == process.code());
        let pushed: u32 = own().map(|cycle| cycle.involuntary_switches).sum();
        let faults: u32 = own().map(|cycle| cycle.minor_faults + cycle.major_faults).sum();
        if pushed > 0 {
            let _ = write!(text, " · {process} pushed off ×{pushed}");
        }
        if faults > 0 {
            let _ = write!(text, " · {process} page faults ×{faults}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn a_process_that_carried_an_old_input_forward_is_not_drawn_as_busy_in_between() {
        let ledger = Ledger {
            estimator_received_ns: 1_000,
            estimator_published_ns: 900_000,
            filter_woke_ns: 950_000,
            filter_computed_ns: 960_000,
            ..Ledger::zeroed()
        };
        let cycle = |process: ProcessId, woke_ns, done_ns| Cycle {
            process: process.code(),
            woke_ns,
            done_ns,
            ..Cycle::zeroed()
        };
        let around = [
            cycle(ProcessId::Estimator, 500, 2_000),
            cycle(ProcessId::Estimator, 890_000, 910_000),
            cycle(ProcessId::Bridge, 880_000, 990_000),
        ];
        let bars: Vec<GanttBar> = stage_bars(&ROWS, &ledger, &around.each_ref()).collect();
        let estimates = bars.iter().find(|bar| bar.hint.contains("estimates")).unwrap();
        assert_eq!((estimates.from_ns, estimates.to_ns), (890_000, 900_000));
        let unknown: Vec<GanttBar> = stage_bars(&ROWS, &ledger, &[]).collect();
        assert_eq!(unknown[0].from_ns, 1_000, "without cycle records the ledger is all there is");
    }
}
