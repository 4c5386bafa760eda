//! One trace event and its JSON, after the Trace Event Format of Chrome.

use messages::{Cycle, ProcessId, Reason, SafeCommand, SafetyStatus};
use serde_json::{Value, json};

/// Number of the group that holds hops: apart from every process' code, and not zero, which viewers take for the idle process.
pub(super) const PATH_GROUP: u32 = 100;

/// Where an event is drawn.
#[derive(Debug, Clone, Copy)]
pub(super) enum Track {
    /// Cycles of a process.
    Cycles(ProcessId),
    /// Stages of the path within a process.
    Stages(ProcessId),
    /// Hops between processes.
    Path(u32),
}

impl Track {
    /// `(pid, tid)` of the format: codes, not numbers of the operating system, so that a restarted process keeps its track. No
    /// track has its group's number, which would make it a main thread.
    const fn numbers(self) -> (u32, u32) {
        match self {
            Self::Cycles(process) => (process.code(), 10 * process.code() + 1),
            Self::Stages(process) => (process.code(), 10 * process.code() + 2),
            Self::Path(group) => (group, 10 * group + 1),
        }
    }
}

/// What an event is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// Complete, with a length, ns.
    Span { length_ns: u64 },
    /// A sample of a counter.
    Counter,
    /// A hop begins; spans of one id belong together.
    HopBegins { id: u64 },
    /// A hop ends.
    HopEnds { id: u64 },
    /// An arrow leaves the span around it.
    ArrowBegins { id: u64 },
    /// An arrow passes the span around it.
    ArrowPasses { id: u64 },
    /// An arrow ends in the span around it.
    ArrowEnds { id: u64 },
}

/// What a click on an event shows.
#[derive(Debug, Clone, Copy)]
pub(super) enum Detail<'a> {
    None,
    /// A counter's value, given in ns, shown in µs.
    Microseconds(u64),
    Cycle {
        cycle: &'a Cycle,
        lateness_ns: Option<u64>,
    },
    Command(&'a SafeCommand),
}

/// One event.
#[derive(Debug, Clone, Copy)]
pub(super) struct Event<'a> {
    pub(super) name: &'static str,
    /// Stack clock, ns.
    pub(super) at_ns: u64,
    pub(super) track: Track,
    pub(super) kind: Kind,
    pub(super) detail: Detail<'a>,
}

impl Event<'_> {
    /// Length of a span, ns; zero of anything else.
    pub(super) const fn length_ns(&self) -> u64 {
        match self.kind {
            Kind::Span { length_ns } => length_ns,
            Kind::Counter
            | Kind::HopBegins { .. }
            | Kind::HopEnds { .. }
            | Kind::ArrowBegins { .. }
            | Kind::ArrowPasses { .. }
            | Kind::ArrowEnds { .. } => 0,
        }
    }

    pub(super) fn json(&self, start_ns: u64) -> Value {
        let (pid, tid) = self.track.numbers();
        let at_us = microseconds(self.at_ns - start_ns);
        let mut value = json!({ "name": self.name, "pid": pid, "tid": tid, "ts": at_us });
        let mut set = |key: &str, field: Value| value[key] = field;
        match self.kind {
            Kind::Span { length_ns } => {
                set("ph", json!("X"));
                set("dur", json!(microseconds(length_ns)));
            }
            Kind::Counter => set("ph", json!("C")),
            Kind::HopBegins { id } => hop(&mut set, "b", id),
            Kind::HopEnds { id } => hop(&mut set, "e", id),
            Kind::ArrowBegins { id } => arrow(&mut set, "s", id),
            Kind::ArrowPasses { id } => arrow(&mut set, "t", id),
            Kind::ArrowEnds { id } => {
                arrow(&mut set, "f", id);
                // Binds to the span around it, not to the next one.
                set("bp", json!("e"));
            }
        }
        match self.detail {
            Detail::None => {}
            Detail::Microseconds(value_ns) => set("args", json!({ "µs": microseconds(value_ns) })),
            Detail::Cycle { cycle, lateness_ns } => set("args", cycle_json(cycle, lateness_ns)),
            Detail::Command(command) => set("args", command_json(command)),
        }
        value
    }
}

/// A hop's number holds within its group only: a global one would take it out of the group.
fn hop(set: &mut impl FnMut(&str, Value), phase: &str, id: u64) {
    set("ph", json!(phase));
    set("cat", json!("hop"));
    set("id2", json!({ "local": format!("{id:#x}") }));
}

/// An arrow's number holds across groups.
fn arrow(set: &mut impl FnMut(&str, Value), phase: &str, id: u64) {
    set("ph", json!(phase));
    set("cat", json!("path"));
    set("id", json!(id));
}

fn microseconds(value_ns: u64) -> f64 {
    value_ns as f64 / 1e3
}

fn cycle_json(cycle: &Cycle, lateness_ns: Option<u64>) -> Value {
    json!({
        "sequence": cycle.sequence,
        "lateness_us": lateness_ns.map(microseconds),
        "skipped": cycle.skipped,
        "cpu_us": microseconds(cycle.cpu_ns),
        "processor": cycle.processor,
        "minor_faults": cycle.minor_faults,
        "major_faults": cycle.major_faults,
        "voluntary_switches": cycle.voluntary_switches,
        "involuntary_switches": cycle.involuntary_switches,
    })
}

fn command_json(command: &SafeCommand) -> Value {
    json!({
        "command": command.sequence,
        "status": SafetyStatus::try_from(command.status).map_or("?", SafetyStatus::label),
        "reason": Reason::try_from(command.reason).map_or("?", Reason::label),
        "obstacles": command.obstacle_count,
    })
}

/// Metadata events that name and order groups and tracks.
pub(super) fn names() -> Vec<Value> {
    let meta = |name: &str, pid: u32, tid: u32, args: Value| json!({ "ph": "M", "name": name, "pid": pid, "tid": tid, "ts": 0, "args": args });
    let (_, path) = Track::Path(PATH_GROUP).numbers();
    let mut all = vec![
        meta("process_name", PATH_GROUP, path, json!({ "name": "sensor to command" })),
        meta("process_sort_index", PATH_GROUP, path, json!({ "sort_index": 0 })),
    ];
    for &process in ProcessId::ALL {
        let (pid, cycles) = Track::Cycles(process).numbers();
        let (_, stages) = Track::Stages(process).numbers();
        all.push(meta("process_name", pid, cycles, json!({ "name": process.label() })));
        all.push(meta("process_sort_index", pid, cycles, json!({ "sort_index": pid })));
        all.push(meta("thread_name", pid, cycles, json!({ "name": "cycles" })));
        all.push(meta("thread_name", pid, stages, json!({ "name": "stages" })));
    }
    all
}
