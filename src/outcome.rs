//! What came of a run: its record read back from the recording, its verdict, report and picture.

use std::io::Write;
use std::path::Path;

use anyhow::Context;
use barrier::Model;
use cbf_filter::{SafetyFilter, load_model};
use messages::{Goal, NominalCommand, Obstacles, RobotState, SafeCommand, SourceStatus};
use recording::{McapReader, ReadWireError, SHADOW_KEY, read_wire};
use report::{BarrierGrid, Moment, RunRecord, ZeroLevel};
use settings::Settings;

/// Half width of the window in which the zero level is drawn, m, and its points a side.
const WINDOW_M: f64 = 6.0;
const WINDOW_SIDE: usize = 61;

/// Reads a recording back as the record of a run.
pub(crate) fn read_record(file: &Path, settings: &Settings, title: String) -> anyhow::Result<RunRecord> {
    let model = load_model(&settings.filter.model)?;
    let notes = McapReader::open(file)?.summary().metadata.get("cncbf").cloned().unwrap_or_default();
    Ok(RunRecord {
        shadow: notes.contains_key(SHADOW_KEY),
        nominal_commands: messages_if_any::<NominalCommand>(file)?,
        safe_commands: messages_of::<SafeCommand>(file)?,
        robot_states: messages_of::<RobotState>(file)?,
        obstacles: messages_of::<Obstacles>(file)?,
        goals: messages_if_any::<Goal>(file)?,
        source_status: messages_of::<SourceStatus>(file)?,
        ..empty_record(settings, &model, title)?
    })
}

/// A record that holds no messages yet.
pub(crate) fn empty_record(settings: &Settings, model: &Model, title: String) -> anyhow::Result<RunRecord> {
    Ok(RunRecord {
        title,
        settings: settings.to_toml()?,
        model: describe(&settings.filter.model, model),
        robot_radius_m: settings.robot.radius_m,
        filter_period_ns: settings.filter.period_ms * 1_000_000,
        beta_per_m: settings.filter.beta_per_m,
        shadow: false,
        nominal_commands: Vec::new(),
        safe_commands: Vec::new(),
        robot_states: Vec::new(),
        obstacles: Vec::new(),
        goals: Vec::new(),
        source_status: Vec::new(),
    })
}

/// Writes `report.html` and `birds_eye.svg` into `folder`.
pub(crate) fn write_report(record: &RunRecord, settings: &Settings, folder: &Path) -> anyhow::Result<()> {
    let zero_levels = zero_levels(record, settings)?;
    let page = report::html(record, &zero_levels)?;
    std::fs::write(folder.join("report.html"), page).context("cannot write the report")?;
    let picture_time_s = liveliest_moment_s(record);
    let nearest =
        zero_levels.iter().min_by_key(|level| level.time_ns.abs_diff(record.stack_time_ns(picture_time_s)));
    let picture = report::birds_eye_svg(record, picture_time_s, nearest);
    std::fs::write(folder.join("birds_eye.svg"), picture).context("cannot write the picture")
}

/// Prints figures for a person, or as JSON on standard output if asked.
pub(crate) fn print_figures<T: std::fmt::Display + serde::Serialize>(
    figures: &T,
    json: bool,
) -> anyhow::Result<()> {
    let text = if json { serde_json::to_string_pretty(figures)? } else { figures.to_string() };
    // Whoever reads may stop reading, as `head` does.
    match writeln!(std::io::stdout(), "{text}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

pub(crate) fn messages_of<T: messages::Message>(file: &Path) -> anyhow::Result<Vec<T>> {
    let stamped = read_wire::<T>(file)
        .with_context(|| format!("cannot read {} from {}", T::SERVICE, file.display()))?;
    Ok(stamped.into_iter().map(|(_, message)| message).collect())
}

/// The same of a kind that may never have been said.
fn messages_if_any<T: messages::Message>(file: &Path) -> anyhow::Result<Vec<T>> {
    match read_wire::<T>(file) {
        Err(ReadWireError::NoChannel { .. }) => Ok(Vec::new()),
        _ => messages_of(file),
    }
}

fn describe(name: &str, model: &Model) -> String {
    let metadata = model.metadata();
    format!(
        "{name}: {}, R = {} m, mean error {:.4} m, hash {}",
        metadata.dynamics, metadata.failure_radius_m, metadata.training.error_mean_m, metadata.hash
    )
}

/// The set h = 0 around the robot for each frame of the playback.
fn zero_levels(record: &RunRecord, settings: &Settings) -> anyhow::Result<Vec<ZeroLevel>> {
    let model = load_model(&settings.filter.model)?;
    let mut filter = SafetyFilter::new(settings, &model)?;
    Ok(report::trace_zero_levels(record, &mut |moment: &Moment<'_>| {
        let (command, obstacles) = (moment.command, moment.obstacles?);
        let robot_m = command.robot_position_in_odom_m;
        let now_ns = command.ledger.filter_woke_ns;
        let h_at = filter.h_around(obstacles, robot_m, command.robot_heading_rad, now_ns);
        BarrierGrid::around(robot_m, WINDOW_M, WINDOW_SIDE, h_at).ok()
    }))
}

/// The moment of the smallest barrier value: what a picture should show.
fn liveliest_moment_s(record: &RunRecord) -> f64 {
    record
        .safe_commands
        .iter()
        .filter(|command| command.h_m.is_finite() && command.obstacle_count > 0)
        .min_by(|a, b| a.h_m.total_cmp(&b.h_m))
        .map_or(record.duration_s() / 2.0, |command| record.seconds(command.ledger.filter_woke_ns))
}
