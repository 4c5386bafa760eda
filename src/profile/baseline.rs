//! What a profile is held against: an earlier one, and budgets. Refused before anything runs where it can be.

use std::fs::File;
use std::io::BufReader;

use anyhow::Context;
use latency::{Across, Conditions, Limit, ProfileFigures};

use crate::cli::ProfileArgs;

/// The earlier profile, if one is named.
pub(super) struct Baseline {
    pub(super) figures: ProfileFigures,
    pub(super) across: Across,
}

/// Reads the baseline and refuses one of other conditions than `conditions`, unless differences may be marked.
pub(super) fn read(args: &ProfileArgs, conditions: &Conditions) -> anyhow::Result<Option<Baseline>> {
    let Some(path) = &args.baseline else {
        let growth = args.budget.iter().find(|budget| matches!(budget.limit, Limit::Growth { .. }));
        anyhow::ensure!(
            growth.is_none(),
            "budget {} compares with a baseline; give one with --baseline",
            growth.map_or("", |budget| &budget.text)
        );
        return Ok(None);
    };
    let open =
        || -> anyhow::Result<ProfileFigures> { Ok(ProfileFigures::read(BufReader::new(File::open(path)?))?) };
    let figures =
        open().with_context(|| format!("cannot use the baseline {} (--baseline)", path.display()))?;
    let differences = figures.conditions.differences(conditions);
    if !args.across && !differences.is_empty() {
        let listed: Vec<String> = differences.iter().map(ToString::to_string).collect();
        anyhow::bail!(
            "the baseline {} was measured under other conditions ({}); measure it anew, or compare all the same with --across",
            path.display(),
            listed.join("; ")
        );
    }
    Ok(Some(Baseline { figures, across: if args.across { Across::Mark } else { Across::Refuse } }))
}
