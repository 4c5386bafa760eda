//! `cncbf profile`: a recording through the stack, several times, and the truth about where time goes.
//!
//! Lives here: the order of things. The figures are `latency`'s, the page is `report`'s.

mod baseline;
mod choices;
mod load;
mod machine;
mod memory;
mod output;
mod pace;
mod repeat;

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter};
use std::path::Path;

use anyhow::Context;
use latency::{
    Conditions, Judged, ProfileFigures, RecordingIdentity, RepeatFigures, RunMessages, chrome_trace, compare,
    judge,
};
use perception_bridge::{McapSource, Playback};
use settings::Settings;
use sha2::{Digest, Sha256};

use crate::cli::{ProfileArgs, Source};
use crate::common::{refuse_unwritable, settings};
use crate::run_folder;
use repeat::{RepeatNotes, RepeatPlan};

pub(crate) use load::load_generator;

/// A repeated recording is longer by this than the duration asked for, s: it is heard of some time after it has begun.
const MARGIN_S: f64 = 1.0;

/// Processes of a stack, each of which takes a core where it spins.
const PROCESSES: u32 = 4;

/// Profiles. Success means: no process crashed, nobody interrupted, every budget kept.
pub(crate) fn profile(args: &ProfileArgs) -> anyhow::Result<bool> {
    let transport = choices::transport(args.transport)?.to_string();
    let mut settings = settings(&args.process)?;
    choices::apply(args, &mut settings);
    // A model that does not fit is refused here, before the processes refuse it one by one.
    let model = cbf_filter::load_model(&settings.filter.model)?;
    cbf_filter::SafetyFilter::new(&settings, &model)?;
    let (playback, recording) = playback(args, &settings)?;
    if let Some(trace) = &args.trace {
        refuse_unwritable(trace, "--trace")?;
    }
    let conditions = conditions(args, &settings, recording, transport)?;
    let baseline = baseline::read(args, &conditions)?;

    let folder = run_folder::create(args.report.as_deref())?;
    let cautions = cautions(&conditions, playback);
    for caution in &cautions {
        eprintln!("note: {caution}");
    }
    let length_s = args.duration.unwrap_or(conditions.recording.duration_s / playback.rate());
    eprintln!(
        "note: {} of {length_s:.1} s, load {}; interrupt it (Ctrl-C) to keep what was measured until then",
        counted(args.repeat.into(), "run"),
        conditions.load
    );
    let plan = RepeatPlan {
        settings: &settings,
        instance: &args.process.instance,
        source: Source::Mcap(args.file.clone()),
        closed_loop: args.closed_loop,
        playback,
        duration_s: args.duration,
        load: args.load.kind(),
        folder: &folder,
    };
    let Runs { repeats, notes, runs, cut_off } = run_all(&plan, args.repeat, conditions.filter_period_ns)?;
    let figures = ProfileFigures::new(conditions, repeats);
    let comparison = baseline.as_ref().map(|baseline| compare(&baseline.figures, &figures, baseline.across));
    // Written before a refusal is told: the figures are sound, whatever they cannot be compared with.
    let comparable = comparison.as_ref().and_then(|comparison| comparison.as_ref().ok());
    let judged = judge(&args.budget, &figures, comparable);
    let mut remarks = pace::remarks(&figures, &notes);
    if let Some(number) = cut_off {
        remarks.push(format!(
            "repeat {number}: interrupted before a command used detections; not in the figures"
        ));
    }
    let outcome = output::Outcome {
        figures: &figures,
        passes: playback.passes(),
        notes: &notes,
        cautions,
        remarks,
        comparison: comparable,
        judged: judged.as_deref().unwrap_or_default(),
    };
    outcome.write(&folder, &runs)?;
    if let (Some(trace), Some(last)) = (&args.trace, runs.last()) {
        let file = File::create(trace).with_context(|| format!("cannot write {}", trace.display()))?;
        chrome_trace(last, BufWriter::new(file))?;
    }
    outcome.print(args, &folder)?;
    if let Some(comparison) = comparison {
        comparison?;
    }
    let whole = notes.iter().all(|note| note.crashes == 0 && !note.interrupted);
    Ok(whole && cut_off.is_none() && !judged?.iter().any(Judged::fails))
}

/// Everything that was run.
struct Runs {
    repeats: Vec<RepeatFigures>,
    notes: Vec<RepeatNotes>,
    /// What was said in each, for timelines and the trace.
    runs: Vec<RunMessages>,
    /// The repeat, counted from 1, that somebody interrupted before anything of it could be measured.
    cut_off: Option<u32>,
}

fn run_all(plan: &RepeatPlan<'_>, repeats: u32, filter_period_ns: u64) -> anyhow::Result<Runs> {
    let mut runs = Runs { repeats: Vec::new(), notes: Vec::new(), runs: Vec::new(), cut_off: None };
    for number in 1..=repeats {
        let (run, notes) = repeat::run(plan, number, repeats)?;
        // Before it, processes start, connect, and touch their memory for the first time; counted apart.
        let Some(measured_from_ns) = run.first_use_ns() else {
            // What earlier repeats measured is sound.
            if notes.interrupted && !runs.runs.is_empty() {
                runs.cut_off = Some(number);
                break;
            }
            anyhow::bail!(nothing_measured(number, &notes));
        };
        runs.repeats.push(RepeatFigures::of(filter_period_ns, &run, measured_from_ns));
        let interrupted = notes.interrupted;
        runs.notes.push(notes);
        runs.runs.push(run);
        if interrupted {
            break;
        }
    }
    Ok(runs)
}

/// How the recording is played so that it lasts, and what it is.
fn playback(args: &ProfileArgs, settings: &Settings) -> anyhow::Result<(Playback, RecordingIdentity)> {
    let once = Playback::new(args.rate, 1)?;
    let source = McapSource::open(&args.file, settings, args.closed_loop)?;
    let duration_s = source.length_ns() as f64 * 1e-9;
    let counts = source.counts();
    anyhow::ensure!(
        counts.people > 0,
        "{}: none of its {} frames of detections holds anybody; choose a recording with people in it",
        args.file.display(),
        counts.frames
    );
    let passes = match args.duration {
        None => once.passes(),
        Some(asked_s) => {
            anyhow::ensure!(
                asked_s.is_finite() && asked_s > 0.0,
                "--duration {asked_s} is no time; use a number of seconds > 0"
            );
            ((asked_s + MARGIN_S) * args.rate / duration_s.max(1e-3)).ceil().max(1.0) as u32
        }
    };
    let playback = Playback::new(args.rate, passes)?;
    // Refused here, before the bridge refuses it in its log.
    source.played(playback)?;
    let identity = RecordingIdentity {
        file_name: args.file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        sha256: sha256_of_file(&args.file)?,
        duration_s,
        detections: counts.frames,
        robot_states: counts.robot_states,
    };
    Ok((playback, identity))
}

fn sha256_of_file(file: &Path) -> anyhow::Result<String> {
    let digest = || -> std::io::Result<Sha256> {
        let mut reader = BufReader::new(File::open(file)?);
        let mut digest = Sha256::new();
        loop {
            let block = reader.fill_buf()?;
            if block.is_empty() {
                return Ok(digest);
            }
            digest.update(block);
            let length = block.len();
            reader.consume(length);
        }
    };
    Ok(hexadecimal(digest().with_context(|| format!("cannot read {}", file.display()))?))
}

fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().fold(String::new(), |hex, byte| hex + &format!("{byte:02x}"))
}

fn conditions(
    args: &ProfileArgs,
    settings: &Settings,
    recording: RecordingIdentity,
    transport: String,
) -> anyhow::Result<Conditions> {
    let mut digest = Sha256::new();
    digest.update(settings.to_toml()?);
    Ok(Conditions {
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        settings_sha256: hexadecimal(digest),
        recording,
        rate: args.rate,
        duration_s: args.duration,
        closed_loop: args.closed_loop,
        load: args.load.kind().map_or("none", load_generator::LoadKind::label).to_owned(),
        wait: choices::wait_label(settings).to_owned(),
        transport,
        trigger: choices::trigger_label(settings).to_owned(),
        filter_period_ns: settings.filter.period_ms * 1_000_000,
        machine: machine::machine(),
    })
}

/// Why a repeat gives no figures, and what to do.
fn nothing_measured(number: u32, notes: &RepeatNotes) -> String {
    let logs = notes.recording.parent().unwrap_or(Path::new(".")).display();
    match notes {
        RepeatNotes { interrupted: true, .. } => {
            format!("repeat {number} was interrupted before a command used detections; nothing was measured")
        }
        RepeatNotes { frames_published: 0, crashes: 0, .. } => format!(
            "repeat {number}: no detections were played; the recording begins without any, so play for longer (--duration), or \
             faster (--rate)"
        ),
        RepeatNotes { frames_published, crashes, .. } => format!(
            "repeat {number}: no safe command rests on any of {}, {} ended unexpectedly; the logs in {logs} tell why",
            counted(*frames_published, "frame"),
            counted(*crashes as u64, "process")
        ),
    }
}

/// A number of things, which are more than one thing only where they are.
fn counted(number: u64, thing: &str) -> String {
    match (number, thing) {
        (1, _) => format!("1 {thing}"),
        (_, "process") => format!("{number} processes"),
        _ => format!("{number} {thing}s"),
    }
}

/// What a reader of the figures should know, and is told before waiting for them.
fn cautions(conditions: &Conditions, playback: Playback) -> Vec<String> {
    let mut cautions = Vec::new();
    let once_s = conditions.recording.duration_s / playback.rate();
    if playback.rate() != 1.0 {
        cautions.push(format!(
            "at rate {} the filter sees other speeds than were recorded; only timing means anything",
            playback.rate()
        ));
    }
    if playback.passes() > 1 {
        cautions.push(format!(
            "the recording lasts {once_s:.1} s at this rate and is played again and again; people and robot jump back at \
             each beginning"
        ));
    }
    if conditions.wait == "spin" && conditions.machine.cores < PROCESSES {
        cautions.push(format!(
            "{PROCESSES} processes spin on {} cores: they take turns, tens of milliseconds each",
            conditions.machine.cores
        ));
    }
    cautions
}
