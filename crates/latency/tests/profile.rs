//! Figures of whole made-up runs: counts conserved, start-up told apart, files read back.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod made_up;

use base64::Engine as _;
use std::time::Duration;

use hdrhistogram::Histogram;
use hdrhistogram::serialization::Deserializer;
use hdrhistogram::serialization::interval_log::{IntervalLogIterator, LogEntry};
use latency::{
    Hop, Latencies, PROFILE_FORMAT, ProfileFigures, Quantity, ReadProfileError, RepeatFigures, Statistic,
    write_hlog,
};
use made_up::{CYCLES_PER_FRAME, PERIOD_NS, Plan, profile, run};
use messages::{ProcessId, Trigger};

fn loop_of(figures: &RepeatFigures, process: ProcessId) -> &latency::LoopFigures {
    figures.loops.iter().find(|of| of.process == process).unwrap()
}

#[test]
fn every_cycle_is_counted_once_by_timer_or_by_input() {
    let run = run(&Plan::quiet(1_200, 1));
    let figures = RepeatFigures::of(PERIOD_NS, &run, 0);
    let frames = 1_200 / CYCLES_PER_FRAME;
    assert_eq!((figures.counts.cycles, figures.counts.event_cycles), (1_200 + frames, frames));
    let filter = loop_of(&figures, ProcessId::Filter);
    assert_eq!((filter.cycles, filter.event_cycles), (1_200 + frames, frames));
    assert_eq!(filter.lateness.count(), 1_200, "an event has no lateness");
    assert_eq!(filter.duration.count(), 1_200 + frames);
    assert_eq!((filter.minor_faults, filter.voluntary_switches), (3, 1_200 + frames));
    let estimator = loop_of(&figures, ProcessId::Estimator);
    assert_eq!((estimator.cycles, estimator.event_cycles, estimator.lateness.count()), (frames, frames, 0));
    let cpu_ns: u64 = run
        .cycles
        .iter()
        .filter(|cycle| cycle.process == ProcessId::Nominal.code())
        .map(|cycle| cycle.cpu_ns)
        .sum();
    assert_eq!(loop_of(&figures, ProcessId::Nominal).cpu_ns, cpu_ns);
    assert_eq!(figures.start_up, latency::StartUp::default());
}

#[test]
fn lateness_of_a_loop_counts_from_the_oldest_due_time_it_skipped() {
    let run = run(&Plan { overslept: 400, ..Plan::quiet(1_000, 2) });
    let figures = RepeatFigures::of(PERIOD_NS, &run, 0);
    let filter = loop_of(&figures, ProcessId::Filter);
    assert_eq!((filter.skipped, figures.counts.skipped, figures.counts.deadline_misses), (3, 3, 3));
    let of_commands = figures.hops.iter().find(|of| of.hop == Hop::FilterLateness).unwrap();
    let (by_cycles, by_commands) = (filter.lateness.summary(), of_commands.latencies.summary());
    assert_eq!(by_cycles, by_commands, "cycle records and commands tell the same");
    assert!(by_cycles.max_ns > 3 * PERIOD_NS + PERIOD_NS / 4, "{}", by_cycles.max_ns);
}

#[test]
fn gaps_and_restarts_of_records_are_told_for_each_process() {
    let mut run = run(&Plan::quiet(1_000, 3));
    let mut kept = 0;
    run.cycles.retain(|cycle| {
        if cycle.process == ProcessId::Filter.code() && (100..107).contains(&cycle.sequence) {
            return false;
        }
        kept += 1;
        true
    });
    for cycle in run.cycles.iter_mut().filter(|cycle| cycle.process == ProcessId::Nominal.code()) {
        if cycle.sequence > 150 {
            cycle.sequence -= 150;
        }
    }
    let figures = RepeatFigures::of(PERIOD_NS, &run, 0);
    let filter = loop_of(&figures, ProcessId::Filter);
    assert_eq!((filter.lost_records, filter.restarts), (7, 0));
    let span = run.safe_commands.last().unwrap().sequence;
    assert_eq!(filter.cycles + filter.lost_records, span, "what is lost and what is there is all");
    let nominal = loop_of(&figures, ProcessId::Nominal);
    assert_eq!((nominal.lost_records, nominal.restarts), (0, 1));
    assert_eq!(figures.loops.iter().map(|of| of.cycles).sum::<u64>(), kept);
    let longest = filter.lateness.summary().max_ns;
    assert!(longest < PERIOD_NS, "a gap in the record is no lateness: {longest}");
}

#[test]
fn start_up_is_told_apart_and_nothing_falls_between() {
    let plan = Plan { first_frame: 300, overslept: 60, ..Plan::quiet(1_000, 4) };
    let run = run(&plan);
    let first_ns = run.first_use_ns().unwrap();
    let all = RepeatFigures::of(PERIOD_NS, &run, 0);
    let after = RepeatFigures::of(PERIOD_NS, &run, first_ns);
    assert_eq!(after.start_up.counts.cycles + after.counts.cycles, all.counts.cycles);
    assert_eq!((after.start_up.counts.deadline_misses, after.counts.deadline_misses), (3, 0));
    assert!(after.start_up.max_lateness_ns > 3 * PERIOD_NS);
    assert_eq!((after.start_up.minor_faults, loop_of(&after, ProcessId::Filter).minor_faults), (3, 0));
    let end_to_end = |figures: &RepeatFigures| {
        figures.hops.iter().find(|of| of.hop == Hop::EndToEnd).unwrap().latencies.count()
    };
    assert_eq!(end_to_end(&after), end_to_end(&all), "every frame that was used is measured");
    assert_eq!(after.duration_ns + after.start_up.duration_ns, all.duration_ns);
}

#[test]
fn rights_and_memory_come_from_health_and_caller() {
    let run = run(&Plan::quiet(100, 5));
    let figures = RepeatFigures::of(PERIOD_NS, &run, 0);
    let nominal = figures.rights.iter().find(|rights| rights.process == ProcessId::Nominal).unwrap();
    assert_eq!(nominal.missing(), ["fifo", "memory lock"]);
    assert!(figures.rights.iter().filter(|rights| rights.missing().is_empty()).count() == 3);
    assert_eq!(figures.resident_bytes(), Some(60_000_000), "shared pages once");
}

#[test]
fn a_profile_survives_its_file_and_other_files_are_refused() {
    let (figures, _) = profile(&[Plan::quiet(600, 6), Plan::quiet(600, 7)]);
    let mut bytes = Vec::new();
    figures.write(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    assert!(text.contains("\"format\": \"cncbf-profile/1\"") && text.contains("\"p99_99_ns\""), "{text}");
    assert!(text.len() < 200_000, "{} bytes", text.len());
    let read = ProfileFigures::read(text.as_bytes()).unwrap();
    assert_eq!(read.summary(), figures.summary());
    assert_eq!(read.conditions, figures.conditions);
    for quantity in Quantity::all() {
        let figure = |figures: &ProfileFigures, statistic| {
            quantity.pooled(&figures.pooled).map(|latencies| latencies.statistic_ns(statistic))
        };
        for statistic in Statistic::ALL {
            assert_eq!(figure(&read, statistic), figure(&figures, statistic), "{quantity}");
        }
    }
    assert_eq!(read.to_string(), figures.to_string());

    let newer = text.replace(PROFILE_FORMAT, "cncbf-profile/2");
    assert!(matches!(
        ProfileFigures::read(newer.as_bytes()),
        Err(ReadProfileError::OtherFormat { found }) if found == "cncbf-profile/2"
    ));
    let mut empty = Vec::new();
    ProfileFigures::new(figures.conditions.clone(), Vec::new()).write(&mut empty).unwrap();
    assert!(matches!(ProfileFigures::read(&empty[..]), Err(ReadProfileError::NoRepeats)));
    let cut = &text.as_bytes()[..text.len() / 2];
    assert!(matches!(ProfileFigures::read(cut), Err(ReadProfileError::NotAProfile(_))));
    assert!(matches!(ProfileFigures::read(&b"{\"verdict\": 1}"[..]), Err(ReadProfileError::NotAProfile(_))));
    let forged = text.replacen("HISTF", "HISTG", 1);
    assert!(ProfileFigures::read(forged.as_bytes()).is_err());
}

#[test]
fn the_tables_tell_what_was_measured_what_was_not_and_what_is_missing() {
    let (figures, _) = profile(&[Plan { first_frame: 300, ..Plan::quiet(900, 8) }]);
    let text = figures.to_string();
    for expected in [
        "Imaginary Processor 9000, 2 cores, Linux 6.12.0, governor none",
        "nominal was not granted fifo, memory lock",
        "p99.99",
        "filter hand-over",
        "not in these figures, start-up of repeat 1",
        "timer lateness, µs",
        "cycle duration, µs",
        "involuntary",
        "resident memory 60.0 MB",
    ] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
    assert!(figures.repeats_table().contains("repeat 1"), "{}", figures.repeats_table());
    let empty = ProfileFigures::new(made_up::conditions(), Vec::new()).to_string();
    assert!(empty.contains("No cycle records"), "{empty}");
}

#[test]
fn an_hlog_holds_every_histogram_for_other_tools() {
    let (figures, _) = profile(&[Plan::quiet(600, 9), Plan::quiet(1_200, 10)]);
    let mut bytes = Vec::new();
    write_hlog(&figures, &mut bytes).unwrap();
    let mut found = Vec::new();
    for entry in IntervalLogIterator::new(&bytes) {
        if let LogEntry::Interval(interval) = entry.unwrap() {
            let text = interval.encoded_histogram();
            let raw = base64::engine::general_purpose::STANDARD.decode(text).unwrap();
            let histogram: Histogram<u64> = Deserializer::new().deserialize(&mut raw.as_slice()).unwrap();
            found.push((interval.tag().unwrap().as_str().to_owned(), interval.start_timestamp(), histogram));
        }
    }
    let measured = Quantity::all()
        .filter(|quantity| quantity.pooled(&figures.pooled).is_some_and(|latencies| latencies.count() > 0))
        .count();
    assert_eq!(found.len(), 2 * measured);
    let pooled: Latencies = figures.hop(Hop::EndToEnd).unwrap().clone();
    let of_log: u64 = found.iter().filter(|(tag, ..)| tag == "end_to_end").map(|(.., of)| of.len()).sum();
    assert_eq!(of_log, pooled.count());
    let (_, start, second) = found.iter().rfind(|(tag, ..)| tag == "filter_compute").unwrap();
    assert!(start.abs_diff(Duration::from_nanos(figures.repeats[0].duration_ns)) <= Duration::from_millis(1));
    assert_eq!(second.len(), figures.repeats[1].counts.cycles);
}

#[test]
fn an_unknown_trigger_is_counted_without_a_due_time() {
    let mut run = run(&Plan::quiet(100, 11));
    for command in &mut run.safe_commands {
        command.ledger.filter_trigger = 77;
    }
    assert!(Trigger::try_from(77).is_err());
    let figures = RepeatFigures::of(PERIOD_NS, &run, 0);
    let lateness = figures.hops.iter().find(|of| of.hop == Hop::FilterLateness).unwrap();
    assert_eq!((lateness.latencies.count(), figures.counts.cycles > 0), (0, true));
}

#[test]
fn figures_that_contradict_their_histogram_are_refused() {
    let (figures, _) = profile(&[Plan::quiet(300, 12)]);
    let mut bytes = Vec::new();
    figures.write(&mut bytes).unwrap();
    let whole: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    for (field, value, hint) in [
        ("count", 7, "are stated"),
        ("min_ns", 1_000_000_000, "exceeds the largest"),
        ("max_ns", 0, "exceeds the largest"),
    ] {
        let mut forged = whole.clone();
        forged["repeats"][0]["hops"][0][field] = value.into();
        let refused = ProfileFigures::read(forged.to_string().as_bytes()).unwrap_err().to_string();
        assert!(refused.contains(hint), "{field}: {refused}");
    }
}
