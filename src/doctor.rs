//! `cncbf doctor`: what on this machine would spoil real time.

use std::time::Duration;

use node_runtime::Domain;
use node_runtime::doctor::{Severity, measure_wake_up_lateness, probe};
use serde::Serialize;

use crate::cli::DoctorArgs;
use crate::common::settings_from;

/// Period at which wake-ups are measured: the filter's.
const PERIOD: Duration = Duration::from_millis(4);

#[derive(Debug, Serialize)]
struct Line {
    severity: &'static str,
    what: String,
    advice: String,
}

#[derive(Debug, Serialize)]
struct Lateness {
    count: usize,
    p50_us: f64,
    p99_us: f64,
    max_us: f64,
    later_than_a_period: usize,
}

/// Looks at the machine. Success means: nothing found that makes a run miss deadlines or fail.
pub(crate) fn doctor(args: &DoctorArgs) -> anyhow::Result<bool> {
    anyhow::ensure!(
        args.seconds.is_finite() && args.seconds > 0.0,
        "--seconds {} is no time; use a number > 0",
        args.seconds
    );
    let mut findings = probe(&Domain::from_env()?);
    let settings = settings_from(None)?;
    let model = cbf_filter::load_model(&settings.filter.model)?;
    let filter = cbf_filter::SafetyFilter::new(&settings, &model)?;
    findings.push(node_runtime::doctor::Finding {
        severity: Severity::Good,
        what: format!(
            "evaluation kernel {}; model {} loads and fits",
            filter.kernel(),
            settings.filter.model
        ),
        advice: String::new(),
    });
    let lateness = lateness(args.seconds);
    let warned = findings.iter().any(|finding| finding.severity == Severity::Warning);
    let lines: Vec<_> = findings
        .into_iter()
        .map(|finding| Line {
            severity: finding.severity.label(),
            what: finding.what,
            advice: finding.advice,
        })
        .collect();
    if args.json {
        println!(
            "{}",
            serde_json::to_string_pretty(
                &serde_json::json!({ "findings": lines, "wake_up_lateness": lateness })
            )?
        );
    } else {
        for line in &lines {
            println!("{:<8} {}", line.severity, line.what);
            if !line.advice.is_empty() {
                println!("         -> {}", line.advice);
            }
        }
        println!(
            "measured {} wake-ups every 4 ms: late by p50 {:.0} us, p99 {:.0} us, at most {:.0} us; {} later than a whole period",
            lateness.count, lateness.p50_us, lateness.p99_us, lateness.max_us, lateness.later_than_a_period
        );
    }
    Ok(!warned)
}

fn lateness(seconds: f64) -> Lateness {
    let mut samples_ns = measure_wake_up_lateness(Duration::from_secs_f64(seconds), PERIOD);
    samples_ns.sort_unstable();
    let at = |share: f64| {
        let index = ((samples_ns.len() as f64 * share) as usize).min(samples_ns.len().saturating_sub(1));
        samples_ns.get(index).copied().unwrap_or(0) as f64 * 1e-3
    };
    Lateness {
        count: samples_ns.len(),
        p50_us: at(0.5),
        p99_us: at(0.99),
        max_us: at(1.0),
        later_than_a_period: samples_ns.iter().filter(|&&late| u128::from(late) > PERIOD.as_nanos()).count(),
    }
}
