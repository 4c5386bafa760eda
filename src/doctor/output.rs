//! What `cncbf doctor` found, as text and as JSON.

use std::fmt::Write as _;

use messages::ProcessId;
use node_runtime::doctor::{Finding, Lateness, RunningProcess, Verdict, WayLateness};
use node_runtime::realtime::{Grant, Right};
use serde_json::{Value, json};

use super::graph::GraphView;

/// Everything that was found.
pub(crate) struct Examination {
    /// The machine.
    pub(crate) findings: Vec<Finding>,
    /// What the kernel grants each process of the settings.
    pub(crate) rights: [(ProcessId, Vec<Grant>); 4],
    /// The stack that runs.
    pub(crate) running: Vec<RunningProcess>,
    /// The ROS 2 graph.
    pub(crate) graph: GraphView,
    /// Ways of waiting, measured.
    pub(crate) ways: Vec<WayLateness>,
    /// The way that the settings ask for.
    pub(crate) own: WayLateness,
    /// What that means.
    pub(crate) verdict: Verdict,
}

impl Examination {
    /// For a person.
    pub(crate) fn to_text(&self, instance: &str) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text, instance);
        text
    }

    fn write(&self, text: &mut String, instance: &str) -> std::fmt::Result {
        writeln!(text, "This machine")?;
        for finding in &self.findings {
            writeln!(text, "  {:<8} {}", finding.severity.label(), finding.what)?;
            advice(text, &finding.advice)?;
        }
        writeln!(text, "\nWhat the settings ask of the kernel, tried out and given back")?;
        for (process, grants) in &self.rights {
            for grant in grants {
                let answer = if grant.granted { "granted" } else { "refused" };
                writeln!(text, "  {process:<10} {:<16} {answer}: {}", grant.what.label(), grant.got)?;
            }
            if grants.is_empty() {
                writeln!(text, "  {process:<10} nothing")?;
            }
        }
        // Processes ask for the same things, so that one line of advice serves all of them.
        let mut told = Vec::new();
        for grant in self.rights.iter().flat_map(|(_, grants)| grants).filter(|grant| !grant.granted) {
            if !told.contains(&grant.what) {
                advice(text, &format!("{}: {}", grant.what.label(), grant.advice))?;
                told.push(grant.what);
            }
        }
        self.write_running(text, instance)?;
        self.graph.write(text)?;
        writeln!(text, "\nHow late a thread wakes up, us")?;
        writeln!(
            text,
            "  {:<38} {:>6} {:>9} {:>9} {:>9} {:>9} {:>13}",
            "", "count", "p50", "p99", "p99.9", "max", "over a period"
        )?;
        for way in self.ways.iter().chain([&self.own]) {
            let Lateness { count, p50_ns, p99_ns, p999_ns, max_ns, later_than_a_period } = way.lateness;
            write!(text, "  {:<38} {count:>6}", way.name)?;
            for ns in [p50_ns, p99_ns, p999_ns, max_ns] {
                write!(text, " {:>9.1}", us(ns))?;
            }
            writeln!(text, " {later_than_a_period:>13}{}", without(&way.refused))?;
        }
        writeln!(text, "\nWhat it can hold")?;
        for sentence in &self.verdict.sentences {
            writeln!(text, "  {sentence}")?;
        }
        Ok(())
    }

    fn write_running(&self, text: &mut String, instance: &str) -> std::fmt::Result {
        if self.running.is_empty() {
            return writeln!(text, "\nNo running stack named {instance} was found");
        }
        writeln!(text, "\nThe stack {instance}, which is running")?;
        for process in &self.running {
            let missing: Vec<_> =
                process.asked.iter().filter(|right| !process.granted.contains(right)).copied().collect();
            writeln!(
                text,
                "  {:<10} pid {:<8} granted {}; refused {}; {} cycles, {} missed, at most {:.1} us late{}",
                process.process,
                process.pid,
                names(&process.granted),
                names(&missing),
                process.cycles,
                process.missed_deadlines,
                us(process.max_lateness_ns),
                if process.cycles == 0 { "; waits: another program has its place" } else { "" }
            )?;
        }
        Ok(())
    }

    /// For a program.
    pub(crate) fn to_json(&self) -> Value {
        let finding = |finding: &Finding| json!({ "severity": finding.severity.label(), "what": finding.what, "advice": finding.advice });
        let rights: serde_json::Map<_, _> = self
            .rights
            .iter()
            .map(|(process, grants)| (process.to_string(), grants.iter().map(grant_json).collect()))
            .collect();
        let running: Vec<_> = self.running.iter().map(running_json).collect();
        let ways: Vec<_> = self.ways.iter().chain([&self.own]).map(way_json).collect();
        json!({
            "findings": self.findings.iter().map(finding).collect::<Vec<_>>(),
            "rights": rights,
            "running": running,
            "ros2": self.graph.to_json(),
            "wake_up_lateness": ways,
            "held": self.verdict.held,
            "verdict": self.verdict.sentences,
        })
    }
}

fn advice(text: &mut String, advice: &str) -> std::fmt::Result {
    if advice.is_empty() { Ok(()) } else { writeln!(text, "           -> {advice}") }
}

fn without(refused: &[Grant]) -> String {
    if refused.is_empty() {
        return String::new();
    }
    let refused: Vec<_> = refused.iter().map(|grant| grant.what).collect();
    format!("  without {}", names(&refused))
}

fn names(rights: &[Right]) -> String {
    let names: Vec<_> = rights.iter().map(|right| right.label()).collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}

fn labels(rights: &[Right]) -> Vec<&'static str> {
    rights.iter().map(|right| right.label()).collect()
}

fn grant_json(grant: &Grant) -> Value {
    json!({
        "what": grant.what.label(),
        "asked": grant.asked,
        "granted": grant.granted,
        "got": grant.got,
        "advice": grant.advice,
    })
}

fn running_json(process: &RunningProcess) -> Value {
    json!({
        "process": process.process.to_string(),
        "pid": process.pid,
        "asked": labels(&process.asked),
        "granted": labels(&process.granted),
        "cycles": process.cycles,
        "missed_deadlines": process.missed_deadlines,
        "max_lateness_us": us(process.max_lateness_ns),
    })
}

fn way_json(way: &WayLateness) -> Value {
    let Lateness { count, p50_ns, p99_ns, p999_ns, max_ns, later_than_a_period } = way.lateness;
    json!({
        "way": way.name,
        "refused": way.refused.iter().map(|grant| grant.what.label()).collect::<Vec<_>>(),
        "count": count,
        "p50_us": us(p50_ns),
        "p99_us": us(p99_ns),
        "p99_9_us": us(p999_ns),
        "max_us": us(max_ns),
        "later_than_a_period": later_than_a_period,
    })
}

fn us(ns: u64) -> f64 {
    ns as f64 * 1e-3
}
