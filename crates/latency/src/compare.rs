//! Two profiles side by side: what changed, and how sure that is.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::bootstrap::{self, CONFIDENCE, FEWEST_REPEATS};
use crate::{Difference, Latencies, ProfileFigures, Quantity, Statistic};

/// Whether profiles measured under different conditions may be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Across {
    /// Refuse: the change would not be the code's.
    Refuse,
    /// Compare, and list the differences with the result.
    Mark,
}

/// Why two profiles were not compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the baseline was measured under other conditions ({}); measure it anew, or compare all the same with --across", listed(.differences))]
pub struct CompareError {
    /// What differs.
    pub differences: Vec<Difference>,
}

fn listed(differences: &[Difference]) -> String {
    differences.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Change of one figure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// Which figure.
    pub statistic: Statistic,
    /// The baseline's, ns.
    pub old_ns: u64,
    /// The new one's, ns.
    pub new_ns: u64,
    /// Bounds of new − old, ns; nothing where repeats are too few.
    pub difference_ns: Option<[f64; 2]>,
    /// Bounds of new / old − 1; nothing where repeats are too few or an old figure is zero.
    pub ratio: Option<[f64; 2]>,
}

impl Change {
    /// New / old − 1; nothing where the old figure is zero.
    pub fn share(&self) -> Option<f64> {
        (self.old_ns > 0).then(|| self.new_ns as f64 / self.old_ns as f64 - 1.0)
    }

    /// Whether the interval excludes that nothing changed.
    pub fn is_sure(&self) -> bool {
        self.difference_ns.is_some_and(|[low, high]| low > 0.0 || high < 0.0)
    }
}

/// Changes of one quantity that both profiles measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct QuantityChange {
    /// Which quantity.
    pub quantity: Quantity,
    /// Its figures, in the order of [`Statistic::ALL`].
    pub changes: Vec<Change>,
}

/// Two profiles side by side. `Display` gives the table for the terminal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    /// In what the conditions differ; empty where the comparison is sound.
    pub differences: Vec<Difference>,
    /// Repeats of the baseline.
    pub old_repeats: usize,
    /// Repeats of the new profile.
    pub new_repeats: usize,
    /// Every quantity that both measured.
    pub quantities: Vec<QuantityChange>,
}

/// Compares `new` with the baseline `old`. The change of a figure is that of the pooled figures; its interval comes from a
/// bootstrap over repeats (2,000 resamples, 95 %, fixed seed) and is absent below three repeats on either side.
///
/// # Errors
/// [`CompareError`] if conditions differ and `across` is [`Across::Refuse`].
pub fn compare(
    old: &ProfileFigures,
    new: &ProfileFigures,
    across: Across,
) -> Result<Comparison, CompareError> {
    let mut differences = old.conditions.differences(&new.conditions);
    differences.extend(rights_difference(old, new));
    match across {
        Across::Refuse if !differences.is_empty() => return Err(CompareError { differences }),
        Across::Refuse | Across::Mark => {}
    }
    Ok(Comparison {
        differences,
        old_repeats: old.repeats.len(),
        new_repeats: new.repeats.len(),
        quantities: Quantity::all().filter_map(|quantity| change_of(quantity, old, new)).collect(),
    })
}

fn or(otherwise: &str, text: String) -> String {
    if text.is_empty() { otherwise.to_owned() } else { text }
}

/// Rights that the kernel granted decide latencies as much as the machine does.
fn rights_difference(old: &ProfileFigures, new: &ProfileFigures) -> Option<Difference> {
    let granted = |figures: &ProfileFigures| {
        let mut all: Vec<String> = figures
            .repeats
            .iter()
            .flat_map(|repeat| &repeat.rights)
            .map(|rights| format!("{} {}", rights.process, or("nothing", rights.granted.join("+"))))
            .collect();
        all.sort_unstable();
        all.dedup();
        or("unknown", all.join(", "))
    };
    let (old, new) = (granted(old), granted(new));
    (old != new).then(|| Difference { what: "granted rights".to_owned(), old, new })
}

fn change_of(quantity: Quantity, old: &ProfileFigures, new: &ProfileFigures) -> Option<QuantityChange> {
    let pooled = |figures| quantity.pooled(figures).map(Latencies::summary);
    let (then, now) = (pooled(&old.pooled)?, pooled(&new.pooled)?);
    let repeats = |figures| of_repeats(quantity, figures);
    let intervals = bootstrap::intervals(&repeats(old), &repeats(new));
    let changes: Option<Vec<Change>> = Statistic::ALL
        .into_iter()
        .enumerate()
        .map(|(index, statistic)| {
            let interval = intervals.map(|intervals| intervals[index]);
            Some(Change {
                statistic,
                old_ns: then.statistic_ns(statistic)?,
                new_ns: now.statistic_ns(statistic)?,
                difference_ns: interval.map(|interval| interval.difference_ns),
                ratio: interval.and_then(|interval| interval.ratio),
            })
        })
        .collect();
    changes.map(|changes| QuantityChange { quantity, changes })
}

fn of_repeats(quantity: Quantity, figures: &ProfileFigures) -> Vec<&Latencies> {
    figures.repeats.iter().filter_map(|repeat| quantity.latencies(&repeat.hops, &repeat.loops)).collect()
}

impl Comparison {
    /// The change of one figure; nothing where a profile did not measure it.
    pub fn change(&self, quantity: Quantity, statistic: Statistic) -> Option<&Change> {
        let of = self.quantities.iter().find(|change| change.quantity == quantity)?;
        of.changes.iter().find(|change| change.statistic == statistic)
    }

    /// Whether repeats suffice for intervals.
    pub const fn has_intervals(&self) -> bool {
        self.old_repeats >= FEWEST_REPEATS && self.new_repeats >= FEWEST_REPEATS
    }
}

/// The figures that tables show.
pub const SHOWN: [Statistic; 4] = [Statistic::P50, Statistic::P99, Statistic::P99_9, Statistic::Max];

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.differences.is_empty() {
            writeln!(f, "Not comparable without reserve, measured under other conditions:")?;
            for difference in &self.differences {
                writeln!(f, "  {difference}")?;
            }
        }
        write!(f, "{:<26}", "µs now, change")?;
        SHOWN.iter().try_for_each(|statistic| write!(f, "  {:<27}", statistic.label()))?;
        for quantity in &self.quantities {
            write!(f, "\n{:<26}", quantity.quantity)?;
            for change in quantity.changes.iter().filter(|change| SHOWN.contains(&change.statistic)) {
                write!(f, "  {:<27}", change.to_string())?;
            }
        }
        if self.has_intervals() {
            write!(
                f,
                "\nIn brackets {:.0} % intervals of the change in percent, by bootstrap over {} and {} repeats; * where it excludes zero. \
                 From few repeats they are too narrow rather than too wide, and what changed on the machine between the two profiles is not in them.",
                100.0 * CONFIDENCE,
                self.old_repeats,
                self.new_repeats
            )
        } else {
            write!(
                f,
                "\nNo intervals can be given: {} and {} repeats, at least {FEWEST_REPEATS} of each are needed.",
                self.old_repeats, self.new_repeats
            )
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.1}", self.new_ns as f64 / 1e3)?;
        if let Some(share) = self.share() {
            write!(f, " {:+.1} %", 100.0 * share)?;
        }
        if let Some([low, high]) = self.ratio {
            write!(f, " [{:+.0},{:+.0}]", 100.0 * low, 100.0 * high)?;
        }
        if self.is_sure() { f.write_str("*") } else { Ok(()) }
    }
}
