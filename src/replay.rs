//! `cncbf replay`: a recording through the stack, in real time or in lockstep.

use std::collections::BTreeMap;
use std::path::PathBuf;

use messages::Reason;
use perception_bridge::{IntakeReport, McapSource, Playback, SourceChoice};
use report::Verdict;
use serde::Serialize;
use settings::{KernelChoice, Settings};

use crate::cli::{KernelName, Rate, ReplayArgs, Source};
use crate::common::settings;
use crate::lockstep::Play;
use crate::outcome::{print_figures, write_report};
use crate::run::Live;
use crate::{lockstep, run_folder};

/// What a replay measured.
#[derive(Debug, Serialize)]
struct Figures {
    file: String,
    mode: &'static str,
    intake: Intake,
    /// SHA-256 over the bytes of all safe commands; only in lockstep.
    #[serde(skip_serializing_if = "Option::is_none")]
    commands_sha256: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    kernel: Option<&'static str>,
    /// Virtual seconds per second; only in lockstep.
    #[serde(skip_serializing_if = "Option::is_none")]
    speed: Option<f64>,
    verdict: Verdict,
}

impl std::fmt::Display for Figures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} ({})", self.file, self.mode)?;
        writeln!(f, "{:<21} {}", "messages", self.intake)?;
        if let (Some(hash), Some(kernel), Some(speed)) = (&self.commands_sha256, self.kernel, self.speed) {
            writeln!(f, "{:<21} SHA-256 {hash}", "commands")?;
            writeln!(f, "{:<21} {speed:.0} times real time, kernel {kernel}", "speed")?;
        }
        write!(f, "{}", self.verdict)
    }
}

/// Replays. Success means: played to the end, and in lockstep every repetition gave the same bytes.
pub(crate) fn replay(args: &ReplayArgs) -> anyhow::Result<bool> {
    let same_file = |record: &PathBuf| matches!((record.canonicalize(), args.file.canonicalize()), (Ok(to), Ok(from)) if to == from);
    anyhow::ensure!(
        !args.record.as_ref().is_some_and(same_file),
        "--record would overwrite {}, the recording being played; name another file",
        args.file.display()
    );
    let mut settings = settings(&args.process)?;
    if let Some(controller) = args.controller {
        settings.use_controller(controller.kind())?;
    }
    if let Some(kernel) = args.kernel {
        settings.filter.kernel = match kernel {
            KernelName::Portable => KernelChoice::Portable,
            KernelName::Avx2Fma => KernelChoice::Avx2Fma,
            KernelName::Avx512 => KernelChoice::Avx512,
        };
    }
    let intake = Intake::of(McapSource::open(&args.file, &settings, args.closed_loop)?.report());
    if args.lockstep || args.rate != Rate::Times(1.0) {
        in_lockstep(args, &settings, intake)
    } else {
        in_real_time(args, &settings, &intake)
    }
}

fn in_lockstep(args: &ReplayArgs, settings: &Settings, intake: Intake) -> anyhow::Result<bool> {
    let mut first: Option<lockstep::Replayed> = None;
    for _ in 0..args.repeat {
        let plan = Play {
            source: SourceChoice::Mcap {
                file: args.file.clone(),
                closed_loop: args.closed_loop,
                playback: Playback::AS_RECORDED,
            },
            title: format!("cncbf replay --lockstep: {}", args.file.display()),
            record: args.record.as_deref().filter(|_| first.is_none()),
            rate: match args.rate {
                Rate::Times(rate) if !args.lockstep || rate != 1.0 => Some(rate),
                Rate::Times(_) | Rate::Max => None,
            },
            ends_at_goal: args.closed_loop,
            duration_s: args.duration,
        };
        let replayed = lockstep::play(&plan, settings)?;
        if let Some(first) = &first {
            if first.commands_sha256 != replayed.commands_sha256 {
                eprintln!(
                    "error: two replays of one file differ: {} and {}; a clock or a thread has leaked into a step",
                    first.commands_sha256, replayed.commands_sha256
                );
                return Ok(false);
            }
        } else {
            first = Some(replayed);
        }
    }
    let Some(replayed) = first else { return Ok(true) };
    if let Some(folder) = &args.report {
        write_report(&replayed.record, settings, &run_folder::create(Some(folder))?)?;
    }
    let figures = Figures {
        file: args.file.display().to_string(),
        mode: "lockstep",
        intake,
        commands_sha256: Some(replayed.commands_sha256),
        kernel: Some(replayed.kernel),
        speed: Some(replayed.speed),
        verdict: Verdict::of(&replayed.record),
    };
    print_figures(&figures, args.json)?;
    Ok(true)
}

fn in_real_time(args: &ReplayArgs, settings: &Settings, intake: &Intake) -> anyhow::Result<bool> {
    for _ in 0..args.repeat {
        let (verdict, end) = Live {
            settings,
            instance: &args.process.instance,
            source: &Source::Mcap(args.file.clone()),
            closed_loop: args.closed_loop,
            shadow: false,
            duration_s: args.duration,
            record: args.record.as_deref(),
            report: args.report.as_deref(),
            title: format!("cncbf replay: {}", args.file.display()),
        }
        .run()?;
        let figures = Figures {
            file: args.file.display().to_string(),
            mode: "real time",
            intake: intake.clone(),
            commands_sha256: None,
            kernel: None,
            speed: None,
            verdict,
        };
        print_figures(&figures, args.json)?;
        if end.interrupted || end.crashes > 0 {
            return Ok(false);
        }
    }
    Ok(true)
}

/// What became of the recording's messages: found = used + not needed + unreadable + refused.
#[derive(Debug, Clone, Serialize)]
struct Intake {
    found: u64,
    used: u64,
    not_needed: u64,
    unreadable: BTreeMap<&'static str, u64>,
    refused: BTreeMap<&'static str, u64>,
    refused_detections: u64,
    refused_transforms: BTreeMap<&'static str, u64>,
    restamped: u64,
    assumed_odom: u64,
    replaced_by_simulation: u64,
}

impl Intake {
    fn of(report: &IntakeReport) -> Self {
        let labelled = |reasons: &BTreeMap<Reason, u64>| {
            reasons.iter().map(|(reason, &count)| (reason.label(), count)).collect()
        };
        Self {
            found: report.found,
            used: report.used,
            not_needed: report.not_needed,
            unreadable: report
                .unreadable
                .iter()
                .filter(|&(_, count)| count > 0)
                .map(|(reason, count)| (reason.label(), count))
                .collect(),
            refused: labelled(&report.refused),
            refused_detections: report.refused_detections,
            refused_transforms: labelled(&report.refused_transforms),
            restamped: report.restamped,
            assumed_odom: report.assumed_odom,
            replaced_by_simulation: report.replaced,
        }
    }
}

impl std::fmt::Display for Intake {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} found, {} used, {} not needed", self.found, self.used, self.not_needed)?;
        for (what, reasons) in [("unreadable", &self.unreadable), ("refused", &self.refused)] {
            for (reason, count) in reasons {
                write!(f, ", {count} {what} ({reason})")?;
            }
        }
        Ok(())
    }
}
