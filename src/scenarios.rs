//! `cncbf scenarios`: recordings in, a file of scenarios out.

use std::path::Path;

use anyhow::Context;
use crowd_sim::{Scenario, write_scenarios};
use perception_bridge::{RecordedCrowd, scenarios_of_recording};

use crate::cli::ScenariosArgs;

/// Longest part of a file's name that enters the names of its scenarios.
const LONGEST_STEM: usize = 48;

/// Cuts scenarios out of every recording and writes them to one file. Success means: it is written.
pub(crate) fn scenarios(args: &ScenariosArgs) -> anyhow::Result<bool> {
    let settings = crate::common::settings_from(args.config.as_deref())?;
    crate::common::refuse_unwritable(&args.out, "--out")?;
    let request = RecordedCrowd {
        every_s: args.every,
        way_m: args.way,
        crossing_s: args.crossing,
        time_limit_s: args.time_limit,
        ..RecordedCrowd::EVERY_5_S
    };
    let mut all: Vec<Scenario> = Vec::new();
    for recording in &args.recordings {
        let cut = scenarios_of_recording(recording, &prefix(recording), &settings, &request)
            .with_context(|| format!("no scenarios of {}", recording.display()))?;
        let people: usize = cut.iter().map(|scenario| scenario.people.len()).sum();
        println!("{}: {} scenarios, {people} tracks", recording.display(), cut.len());
        all.extend(cut);
    }
    write_scenarios(&args.out, &all)?;
    println!("wrote {}", args.out.display());
    Ok(true)
}

/// The recording's name as far as it can stand in the name of a scenario.
fn prefix(recording: &Path) -> String {
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.') { c } else { '-' };
    stem.chars().take(LONGEST_STEM).map(plain).collect()
}
