//! One run as JSON trace events, which <https://ui.perfetto.dev> and Chrome's tracing page open.
//!
//! Every process is one track group with two tracks: its cycles, from their records, and the stage of the path from sensor to
//! command that the ledger stamps. Arrows follow each frame of detections through its stages. The group "sensor to command"
//! holds every hop of every frame as its own span, and a counter for the lateness of each loop lies beside its process.
//! Times are µs since the first event.

mod event;

use std::io::{self, Write};

use messages::{Cycle, Ledger, ProcessId, SafeCommand, Trigger};

use crate::loops::LoopFollower;
use crate::{Hop, RunMessages};
use event::{Detail, Event, Kind, PATH_GROUP, Track};

/// Writes the trace of one run. Stages and hops whose stamps never came have no place in time and are left out.
///
/// # Errors
/// What the writer fails with.
pub fn chrome_trace(run: &RunMessages, mut writer: impl Write) -> io::Result<()> {
    let mut events = Vec::new();
    cycles(run, &mut events);
    path(run, &mut events);
    // Nested spans that begin together must come longest first.
    events.sort_by_key(|event| (event.at_ns, core::cmp::Reverse(event.length_ns())));
    let start_ns = events.first().map_or(0, |event| event.at_ns);

    writer.write_all(b"{\"displayTimeUnit\":\"ns\",\"traceEvents\":[")?;
    let mut separator: &[u8] = b"\n";
    for value in event::names() {
        writer.write_all(separator)?;
        serde_json::to_writer(&mut writer, &value)?;
        separator = b",\n";
    }
    for event in &events {
        writer.write_all(separator)?;
        serde_json::to_writer(&mut writer, &event.json(start_ns))?;
    }
    writer.write_all(b"\n]}\n")?;
    writer.flush()
}

/// Every cycle as a span, and its lateness as a counter.
fn cycles<'a>(run: &'a RunMessages, events: &mut Vec<Event<'a>>) {
    for &process in ProcessId::ALL {
        let mut own: Vec<&Cycle> =
            run.cycles.iter().filter(|cycle| cycle.process == process.code()).collect();
        own.sort_by_key(|cycle| cycle.woke_ns);
        let mut follower = LoopFollower::default();
        for cycle in own {
            follower.follow(cycle);
            let lateness =
                follower.lateness_ns(cycle).map(|(due_ns, woke_ns)| woke_ns.saturating_sub(due_ns));
            let name = match Trigger::try_from(cycle.trigger) {
                Ok(Trigger::Timer) => "cycle by timer",
                Ok(Trigger::Event) => "cycle by input",
                Err(_) => "cycle",
            };
            let length_ns = cycle.done_ns.saturating_sub(cycle.woke_ns);
            events.push(Event {
                name,
                at_ns: cycle.woke_ns,
                track: Track::Cycles(process),
                kind: Kind::Span { length_ns },
                detail: Detail::Cycle { cycle, lateness_ns: lateness },
            });
            if let Some(lateness_ns) = lateness {
                events.push(Event {
                    name: "lateness",
                    at_ns: cycle.woke_ns,
                    track: Track::Cycles(process),
                    kind: Kind::Counter,
                    detail: Detail::Microseconds(lateness_ns),
                });
            }
        }
    }
}

/// The stages and hops that ledgers tell; those of detections and nominal commands once, where they were first used.
fn path<'a>(run: &'a RunMessages, events: &mut Vec<Event<'a>>) {
    let (mut seen_detections_ns, mut seen_nominal_ns) = (0, 0);
    for (frame, command) in (1..).zip(&run.safe_commands) {
        let ledger = &command.ledger;
        stage(
            ProcessId::Filter,
            "compute",
            ledger.filter_woke_ns,
            ledger.filter_computed_ns,
            command,
            events,
        );
        stage(
            ProcessId::Filter,
            "hand over",
            ledger.filter_computed_ns,
            ledger.filter_published_ns,
            command,
            events,
        );
        if ledger.detections_ingress_ns != seen_detections_ns && ledger.detections_ingress_ns != 0 {
            seen_detections_ns = ledger.detections_ingress_ns;
            detections(ledger, command, frame, events);
        }
        if ledger.nominal_published_ns != seen_nominal_ns && ledger.nominal_published_ns != 0 {
            seen_nominal_ns = ledger.nominal_published_ns;
            let (from_ns, to_ns) = (ledger.nominal_received_ns, ledger.nominal_published_ns);
            stage(ProcessId::Nominal, "plan", from_ns, to_ns, command, events);
            for hop in Hop::OF_NOMINAL {
                hop_span(hop, ledger, frame, events);
            }
        }
    }
}

/// One frame of detections from the bridge to the first command that used it: stages, hops, and the arrows between stages.
fn detections<'a>(ledger: &'a Ledger, command: &'a SafeCommand, frame: u64, events: &mut Vec<Event<'a>>) {
    let stages = [
        (ProcessId::Bridge, "take in", ledger.detections_ingress_ns, ledger.detections_published_ns),
        (ProcessId::Estimator, "estimate", ledger.estimator_received_ns, ledger.estimator_published_ns),
    ];
    let mut arrows = Vec::with_capacity(3);
    for (process, name, from_ns, to_ns) in stages {
        if stage(process, name, from_ns, to_ns, command, events) {
            arrows.push((process, from_ns));
        }
    }
    arrows.push((ProcessId::Filter, ledger.filter_woke_ns));
    if arrows.len() > 1 {
        let last = arrows.len() - 1;
        for (index, (process, at_ns)) in arrows.into_iter().enumerate() {
            let kind = match index {
                0 => Kind::ArrowBegins { id: frame },
                index if index == last => Kind::ArrowEnds { id: frame },
                _ => Kind::ArrowPasses { id: frame },
            };
            let track = Track::Stages(process);
            events.push(Event { name: "detections", at_ns, track, kind, detail: Detail::None });
        }
    }
    for hop in Hop::OF_DETECTIONS {
        hop_span(hop, ledger, frame, events);
    }
}

/// One stage as a span. Returns whether its stamps make one.
fn stage<'a>(
    process: ProcessId,
    name: &'static str,
    from_ns: u64,
    to_ns: u64,
    command: &'a SafeCommand,
    events: &mut Vec<Event<'a>>,
) -> bool {
    let sound = from_ns != 0 && to_ns >= from_ns;
    if sound {
        events.push(Event {
            name,
            at_ns: from_ns,
            track: Track::Stages(process),
            kind: Kind::Span { length_ns: to_ns - from_ns },
            detail: Detail::Command(command),
        });
    }
    sound
}

/// One hop of one frame as a span of its own, which may overlap others.
fn hop_span(hop: Hop, ledger: &Ledger, frame: u64, events: &mut Vec<Event<'_>>) {
    if let Some(stretch) = hop.stretch(ledger).filter(|stretch| stretch.end_ns >= stretch.start_ns) {
        // Frames are counted from 1, hops fewer than 16.
        let id = frame * 16 + hop.index() as u64;
        for (at_ns, kind) in
            [(stretch.start_ns, Kind::HopBegins { id }), (stretch.end_ns, Kind::HopEnds { id })]
        {
            let (name, track) = (hop.label(), Track::Path(PATH_GROUP));
            events.push(Event { name, at_ns, track, kind, detail: Detail::None });
        }
    }
}
