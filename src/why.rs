//! `cncbf why`: one moment of a recording, explained.

use crate::cli::WhyArgs;
use crate::common::settings_from;
use crate::outcome::read_record;

/// Explains what the filter did at the given time, and because of which obstacle.
pub(crate) fn why(args: &WhyArgs) -> anyhow::Result<bool> {
    let record = read_record(&args.file, &settings_from(None)?, args.file.display().to_string())?;
    let explanation = report::explain(&record, args.time_s)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&explanation)?);
    } else {
        println!("{explanation}");
    }
    Ok(true)
}
