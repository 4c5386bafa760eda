//! One run of a profile: the stack beside its load, and what its record holds.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Context;
use latency::RunMessages;
use load_generator::{LoadKind, LoadReport};
use messages::{Cycle, Detections, Health, Message, ProcessId, SafeCommand};
use perception_bridge::Playback;
use recording::{ReadWireError, read_wire};
use serde::Serialize;
use settings::Settings;

use super::load::Load;
use super::memory::MemoryWatch;
use crate::cli::Source;
use crate::session::{SPEAKERS, SessionPlan, run_stack};

/// What every repeat is told.
pub(super) struct RepeatPlan<'a> {
    pub(super) settings: &'a Settings,
    pub(super) instance: &'a str,
    pub(super) source: Source,
    pub(super) closed_loop: bool,
    pub(super) playback: Playback,
    pub(super) duration_s: Option<f64>,
    pub(super) load: Option<LoadKind>,
    /// Folder of the whole profile.
    pub(super) folder: &'a Path,
}

/// What became of a run besides its timing.
#[derive(Debug, Clone, Serialize)]
pub(super) struct RepeatNotes {
    /// The recording of the run.
    pub(super) recording: PathBuf,
    /// Frames of detections that the bridge published, as far as they were recorded.
    pub(super) frames_published: u64,
    /// Those of them on which a safe command rests.
    pub(super) frames_used: u64,
    /// Those between the first and the last used one on which none rests: newer ones overtook them.
    pub(super) frames_overtaken: u64,
    /// Processes that ended without a last word on record that counts its last recorded cycle: what they did at the end is
    /// unknown.
    pub(super) ends_unknown: Vec<&'static str>,
    /// Processes that ended unasked.
    pub(super) crashes: usize,
    /// Whether somebody ended the run early.
    pub(super) interrupted: bool,
    /// What the load generator did.
    pub(super) load: Option<LoadReport>,
}

/// Runs the stack once; `number` counts from 1 up to `of`.
pub(super) fn run(plan: &RepeatPlan<'_>, number: u32, of: u32) -> anyhow::Result<(RunMessages, RepeatNotes)> {
    let folder = plan.folder.join(format!("repeat_{number}"));
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let recording = folder.join("run.mcap");
    let mut load = plan.load.map(|kind| Load::start(kind, &folder)).transpose()?;
    let mut memory = MemoryWatch::default();
    let session = SessionPlan {
        settings: plan.settings,
        instance: plan.instance,
        source: &plan.source,
        closed_loop: plan.closed_loop,
        shadow: false,
        playback: plan.playback,
        env: Vec::new(),
        heading: format!("repeat {number} of {of}: "),
        recording: recording.clone(),
        folder: &folder,
        duration_s: plan.duration_s,
    };
    let end = run_stack(&session, &mut |launcher, moment| {
        memory.look(launcher, moment);
        load.as_mut().map_or(Ok(()), Load::ensure_it_runs)
    })?;
    let load = load.map(Load::stop).transpose()?;
    let run = RunMessages {
        safe_commands: said::<SafeCommand>(&recording)?,
        cycles: said::<Cycle>(&recording)?,
        health: said::<Health>(&recording)?,
        resident: memory.largest(),
    };
    let frames = said::<Detections>(&recording)?;
    let ingress_ns: Vec<u64> = frames.iter().map(|frame| frame.stamp.ingress_ns).collect();
    let used: BTreeSet<u64> = run.safe_commands.iter().map(|c| c.ledger.detections_ingress_ns).collect();
    let is_used = |ingress_ns: &&u64| used.contains(*ingress_ns);
    let last_ns = used.last().copied().unwrap_or(0);
    let from_first = ingress_ns.iter().skip_while(|ns| !is_used(ns));
    let overtaken = from_first.filter(|ns| **ns < last_ns && !is_used(ns));
    let notes = RepeatNotes {
        recording,
        frames_published: ingress_ns.len() as u64,
        frames_used: ingress_ns.iter().filter(is_used).count() as u64,
        frames_overtaken: overtaken.count() as u64,
        ends_unknown: ends_unknown(&run),
        crashes: end.crashes,
        interrupted: end.interrupted,
        load,
    };
    Ok((run, notes))
}

/// Every message of one kind; none where nobody said any, as in a run that ended early.
fn said<T: Message>(recording: &Path) -> anyhow::Result<Vec<T>> {
    match read_wire::<T>(recording) {
        Ok(stamped) => Ok(stamped.into_iter().map(|(_, message)| message).collect()),
        Err(ReadWireError::NoChannel { .. }) => Ok(Vec::new()),
        Err(error) => {
            Err(error).with_context(|| format!("cannot read {} from {}", T::SERVICE, recording.display()))
        }
    }
}

/// Processes of which the record lacks the end. Each says how many cycles it ran when it has ended, hence after the last one.
fn ends_unknown(run: &RunMessages) -> Vec<&'static str> {
    let knows_end = |process: &ProcessId| {
        let cycles = run.cycles.iter().filter(|cycle| cycle.process == process.code());
        let words = run.health.iter().filter(|health| health.process == process.code());
        match (cycles.max_by_key(|cycle| cycle.woke_ns), words.max_by_key(|health| health.published_ns)) {
            (Some(cycle), Some(word)) => word.published_ns >= cycle.done_ns && word.cycles == cycle.sequence,
            _ => false,
        }
    };
    SPEAKERS.iter().filter(|process| !knows_end(process)).map(|process| process.label()).collect()
}
