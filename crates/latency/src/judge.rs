//! Whether budgets are kept.

use core::fmt;

use serde::Serialize;

use crate::{Budget, Comparison, Counter, Limit, ProfileFigures};

/// A budget that speaks of a baseline where there is none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("budget {budget} compares with a baseline; give one with --baseline")]
pub struct NoBaseline {
    /// The budget as stated.
    pub budget: String,
}

/// What became of a budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Within the limit.
    Kept,
    /// Beyond the limit, but within what differs from repeat to repeat: not broken, and no proof that it is kept.
    Unclear,
    /// Beyond the limit.
    Broken,
    /// Nothing was measured that it speaks of. A gate that measures nothing holds nothing: this counts as broken.
    Unmeasured,
}

/// One budget and what became of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judged {
    /// The budget as stated.
    pub budget: String,
    /// What was measured, as people read it.
    pub measured: String,
    /// What became of it.
    pub outcome: Outcome,
}

impl Judged {
    /// Whether a check must fail because of it.
    pub const fn fails(&self) -> bool {
        match self.outcome {
            Outcome::Kept | Outcome::Unclear => false,
            Outcome::Broken | Outcome::Unmeasured => true,
        }
    }
}

impl fmt::Display for Judged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let outcome = match self.outcome {
            Outcome::Kept => "kept",
            Outcome::Unclear => "unclear: beyond the limit, but within what differs between repeats",
            Outcome::Broken => "BROKEN",
            Outcome::Unmeasured => "BROKEN: nothing of it was measured",
        };
        write!(f, "budget {:<34} {:<24} {outcome}", self.budget, self.measured)
    }
}

/// Judges every budget, in their order.
///
/// A limit in time or count is held against the pooled figure of all repeats itself: it promises something to a robot,
/// whatever the cause of an excess. A growth over the baseline is broken only when even the lower end of its interval lies
/// beyond the limit, so that a check does not fail by chance; where repeats are too few for an interval the figure itself is
/// judged, and the text says so.
///
/// # Errors
/// [`NoBaseline`] if a budget speaks of growth and there is no `comparison`.
pub fn judge(
    budgets: &[Budget],
    figures: &ProfileFigures,
    comparison: Option<&Comparison>,
) -> Result<Vec<Judged>, NoBaseline> {
    budgets.iter().map(|budget| judge_one(budget, figures, comparison)).collect()
}

fn judge_one(
    budget: &Budget,
    figures: &ProfileFigures,
    comparison: Option<&Comparison>,
) -> Result<Judged, NoBaseline> {
    let within = |kept: bool| if kept { Outcome::Kept } else { Outcome::Broken };
    let nothing = || ("-".to_owned(), Outcome::Unmeasured);
    let (measured, outcome) = match budget.limit {
        Limit::Time { quantity, statistic, most_ns } => quantity
            .pooled(&figures.pooled)
            .and_then(|latencies| latencies.statistic_ns(statistic))
            .map_or_else(nothing, |found_ns| (time(found_ns), within(found_ns <= most_ns))),
        Limit::Count { counter, most } => count(counter, figures).map_or_else(nothing, |found| {
            let text = match counter {
                Counter::Resident => format!("{:.1} MB", found as f64 / 1e6),
                Counter::DeadlineMisses
                | Counter::LostCommands
                | Counter::LostRecords
                | Counter::Restarts
                | Counter::MinorFaults
                | Counter::MajorFaults
                | Counter::InvoluntarySwitches => found.to_string(),
            };
            (text, within(found <= most))
        }),
        Limit::Growth { quantity, statistic, most } => {
            let comparison = comparison.ok_or_else(|| NoBaseline { budget: budget.text.clone() })?;
            let change = comparison.change(quantity, statistic);
            change.and_then(|change| Some((change.share()?, change.ratio))).map_or_else(
                nothing,
                |(share, ratio)| match ratio {
                    Some([low, high]) => {
                        let percent = |share: f64| 100.0 * share;
                        let text =
                            format!("{:+.1} % [{:+.1}, {:+.1}]", percent(share), percent(low), percent(high));
                        let beyond = if low > most { Outcome::Broken } else { Outcome::Unclear };
                        (text, if share <= most { Outcome::Kept } else { beyond })
                    }
                    None => (format!("{:+.1} %, no interval", 100.0 * share), within(share <= most)),
                },
            )
        }
    };
    Ok(Judged { budget: budget.text.clone(), measured, outcome })
}

fn time(value_ns: u64) -> String {
    format!("{:.1} µs", value_ns as f64 / 1e3)
}

/// What a counter shows over all repeats; nothing where it was not taken. Counters of loops are absent without cycle records.
fn count(counter: Counter, figures: &ProfileFigures) -> Option<u64> {
    let pooled = &figures.pooled;
    let of_commands = |count: u64| (pooled.counts.cycles > 0).then_some(count);
    let of_loops = |pick: fn(&crate::LoopFigures) -> u64| {
        (!pooled.loops.is_empty()).then(|| pooled.loops.iter().map(pick).sum::<u64>())
    };
    match counter {
        Counter::DeadlineMisses => of_commands(pooled.counts.deadline_misses),
        Counter::LostCommands => of_commands(pooled.counts.lost_commands),
        Counter::LostRecords => of_loops(|figures| figures.lost_records),
        Counter::Restarts => of_loops(|figures| figures.restarts),
        Counter::MinorFaults => of_loops(|figures| figures.minor_faults),
        Counter::MajorFaults => of_loops(|figures| figures.major_faults),
        Counter::InvoluntarySwitches => of_loops(|figures| figures.involuntary_switches),
        Counter::Resident => figures.resident_bytes(),
    }
}
