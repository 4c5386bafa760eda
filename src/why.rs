//! `cncbf why`: one moment of a recording, explained.

use std::path::Path;

use anyhow::Context;
use recording::McapReader;
use settings::Settings;

use crate::cli::WhyArgs;
use crate::outcome::read_record;

/// Explains what the filter did at the given time, and because of which obstacle.
pub(crate) fn why(args: &WhyArgs) -> anyhow::Result<bool> {
    let record = read_record(&args.file, &settings_of(&args.file)?, args.file.display().to_string())?;
    let explanation = report::explain(&record, args.time_s)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&explanation)?);
    } else {
        if record.shadow {
            println!("Shadow: the filter only watched, and nothing of what it wanted was sent to the robot.");
        }
        println!("{explanation}");
    }
    Ok(true)
}

/// The settings a recording of this program carries.
fn settings_of(file: &Path) -> anyhow::Result<Settings> {
    let reader = McapReader::open(file)?;
    let text = reader.summary().metadata.get("cncbf").and_then(|notes| notes.get("settings")).with_context(
        || {
            format!(
                "{} was not made by this program: it holds no safe commands to explain; replay it first",
                file.display()
            )
        },
    )?;
    Ok(Settings::parse(text, file, Path::new("."))?)
}
