//! `cncbf doctor`: what on this machine would spoil real time, what the kernel grants, how punctual it is, and who is in the ROS 2
//! graph.

mod graph;
mod output;

use std::time::Duration;

use messages::ProcessId;
use node_runtime::Domain;
use node_runtime::doctor::{Finding, Severity, Way, judge, measure_ways, probe, running};
use node_runtime::realtime::{Grant, Request, try_out};
use settings::{Settings, WaitKind};

use crate::cli::DoctorArgs;
use crate::common::settings;
use crate::progress::Bar;
use graph::GraphView;
use output::Examination;

/// The processes that ask for something.
const ASKING: [ProcessId; 4] =
    [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter];

/// Looks at the machine. Success means: nothing found that makes a run miss deadlines or fail, and the filter's rate held.
pub(crate) fn doctor(args: &DoctorArgs) -> anyhow::Result<bool> {
    anyhow::ensure!(
        args.seconds.is_finite() && args.seconds > 0.0,
        "--seconds {} is no time; use a number > 0",
        args.seconds
    );
    let settings = settings(&args.process)?;
    let domain = Domain::from_env()?;
    let mut findings = probe(&domain);
    findings.push(model(&settings)?);
    let running = running(&domain, &args.process.instance)?;
    // Before anything is measured: DDS has threads of its own.
    let graph = GraphView::of(&settings);
    let rights = ASKING.map(|process| (process, rights_of(&settings, process)));

    let period = Duration::from_millis(settings.filter.period_ms);
    let mut ways = Way::standard();
    ways.push(own_way(&settings, period));
    let bar = Bar::new("wake-ups", 1000);
    let mut others = measure_ways(&ways, Duration::from_secs_f64(args.seconds), period, |share| {
        bar.set((share * 1e3) as u64, String::new);
    });
    bar.finish();
    let Some(own) = others.pop() else {
        anyhow::bail!("nothing was measured; this is a defect of the build")
    };

    let verdict = judge(&own, &others, period);
    let sound = verdict.held && findings.iter().all(|finding| finding.severity < Severity::Warning);
    let examination = Examination { findings, rights, running, graph, ways: others, own, verdict };
    if args.json {
        println!("{}", serde_json::to_string_pretty(&examination.to_json())?);
    } else {
        print!("{}", examination.to_text(&args.process.instance));
    }
    Ok(sound)
}

/// That the model loads, fits the settings and has a kernel here.
fn model(settings: &Settings) -> anyhow::Result<Finding> {
    let model = cbf_filter::load_model(&settings.filter.model)?;
    let filter = cbf_filter::SafetyFilter::new(settings, &model)?;
    Ok(Finding {
        severity: Severity::Good,
        what: format!(
            "evaluation kernel {}; model {} loads and fits",
            filter.kernel(),
            settings.filter.model
        ),
        advice: String::new(),
    })
}

/// What the kernel would grant `process`, tried out and given back.
fn rights_of(settings: &Settings, process: ProcessId) -> Vec<Grant> {
    try_out(&Request::of(settings.realtime.as_ref(), process), <[Grant]>::to_vec).unwrap_or_default()
}

/// The way that the settings ask for the filter.
fn own_way(settings: &Settings, period: Duration) -> Way {
    let entry = settings.realtime.as_ref().and_then(|realtime| realtime.filter.as_ref());
    Way {
        name: "as the settings ask for the filter".to_owned(),
        request: Request::of(settings.realtime.as_ref(), ProcessId::Filter),
        spin: match entry.map(|entry| (entry.wait, entry.spin_us)) {
            Some((WaitKind::Spin, _)) => period,
            Some((WaitKind::Listener, spin_us)) => Duration::from_micros(spin_us),
            None => Duration::ZERO,
        },
    }
}
