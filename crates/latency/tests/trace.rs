//! The trace, held against the Trace Event Format.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod made_up;

use std::collections::BTreeMap;

use latency::{RunMessages, chrome_trace};
use made_up::{CYCLES_PER_FRAME, Plan, run};
use messages::ProcessId;
use serde_json::Value;

fn events(run: &RunMessages) -> Vec<Value> {
    let mut bytes = Vec::new();
    chrome_trace(run, &mut bytes).unwrap();
    let trace: Value = serde_json::from_slice(&bytes).unwrap();
    assert_eq!(trace["displayTimeUnit"], "ns");
    trace["traceEvents"].as_array().unwrap().clone()
}

fn of_phase<'a>(events: &'a [Value], phase: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["ph"] == phase).collect()
}

#[test]
fn every_event_has_what_its_phase_needs_and_times_never_fall() {
    let run = run(&Plan { overslept: 100, ..Plan::quiet(600, 1) });
    let events = events(&run);
    let mut last_us = 0.0;
    for event in &events {
        assert!(event["name"].is_string() && event["pid"].is_u64() && event["tid"].is_u64(), "{event}");
        let at_us = event["ts"].as_f64().unwrap();
        assert!(at_us >= 0.0);
        match event["ph"].as_str().unwrap() {
            "M" => assert!(event["args"]["name"].is_string() || event["args"]["sort_index"].is_u64()),
            "X" => assert!(event["dur"].as_f64().unwrap() >= 0.0),
            "C" => assert!(event["args"].as_object().unwrap().values().all(Value::is_number)),
            "b" | "e" => assert!(event["id2"]["local"].is_string() && event["cat"].is_string(), "{event}"),
            "s" | "t" | "f" => assert!(event["id"].is_u64() && event["cat"].is_string(), "{event}"),
            other => panic!("phase {other} is not one we write"),
        }
        if event["ph"] != "M" {
            assert!(at_us >= last_us, "{event} after {last_us}");
            last_us = at_us;
        }
    }
    assert!(of_phase(&events, "f").iter().all(|event| event["bp"] == "e"));
}

#[test]
fn each_process_has_its_named_track_and_each_cycle_its_span() {
    let run = run(&Plan::quiet(600, 2));
    let events = events(&run);
    let names: BTreeMap<u64, String> = of_phase(&events, "M")
        .iter()
        .filter(|event| event["name"] == "process_name")
        .map(|event| (event["pid"].as_u64().unwrap(), event["args"]["name"].as_str().unwrap().to_owned()))
        .collect();
    for process in [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter] {
        assert_eq!(names[&u64::from(process.code())], process.label());
        let spans = of_phase(&events, "X")
            .iter()
            .filter(|event| event["pid"] == process.code() && event["tid"] == 10 * process.code() + 1)
            .count();
        let cycles = run.cycles.iter().filter(|cycle| cycle.process == process.code()).count();
        assert_eq!(spans, cycles, "{process}");
    }
    let first = of_phase(&events, "X")
        .into_iter()
        .find(|event| event["pid"] == ProcessId::Filter.code() && event["tid"] == 41)
        .unwrap()
        .clone();
    let filter = run.cycles.iter().find(|cycle| cycle.process == ProcessId::Filter.code()).unwrap();
    let expected_us = (filter.done_ns - filter.woke_ns) as f64 / 1e3;
    assert!((first["dur"].as_f64().unwrap() - expected_us).abs() < 1e-6, "{first}");
    let lateness_us = (filter.woke_ns - filter.due_ns) as f64 / 1e3;
    assert!((first["args"]["lateness_us"].as_f64().unwrap() - lateness_us).abs() < 1e-6, "{first}");
    assert_eq!(first["args"]["minor_faults"], 1);
}

#[test]
fn hops_open_and_close_in_pairs_and_arrows_bind_to_spans() {
    let run = run(&Plan::quiet(600, 3));
    let events = events(&run);
    let mut open: BTreeMap<String, f64> = BTreeMap::new();
    for event in events.iter().filter(|event| event["cat"] == "hop") {
        let id = event["id2"]["local"].as_str().unwrap().to_owned();
        let at_us = event["ts"].as_f64().unwrap();
        match event["ph"].as_str().unwrap() {
            "b" => assert!(open.insert(id, at_us).is_none(), "{event} opened twice"),
            _ => assert!(open.remove(&id).unwrap() <= at_us),
        }
    }
    assert!(open.is_empty());

    let frames = 600 / CYCLES_PER_FRAME;
    for phase in ["s", "t", "f"] {
        assert_eq!(of_phase(&events, phase).len() as u64, frames, "{phase}");
    }
    // An arrow hangs on the span on its track that is open at its time.
    let spans = of_phase(&events, "X");
    for arrow in ["s", "t", "f"].iter().flat_map(|phase| of_phase(&events, phase)) {
        let at_us = arrow["ts"].as_f64().unwrap();
        assert!(
            spans.iter().any(|span| {
                let from_us = span["ts"].as_f64().unwrap();
                span["pid"] == arrow["pid"]
                    && span["tid"] == arrow["tid"]
                    && from_us <= at_us
                    && at_us <= from_us + span["dur"].as_f64().unwrap()
            }),
            "{arrow} hangs in the air"
        );
    }
}

#[test]
fn a_run_without_anything_is_a_trace_without_events() {
    assert!(events(&RunMessages::default()).iter().all(|event| event["ph"] == "M"));
}
