//! Budgets as people state them: `end_to_end.p99<=1ms`, `filter_compute.p50<=+10%`, `deadline_misses<=0`.

use core::fmt;
use core::str::FromStr;

use crate::{Quantity, Statistic};

/// A counter over all repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counter {
    /// Due times of the filter that passed without a cycle, and cycles later than a period.
    DeadlineMisses,
    /// Commands missing from the record.
    LostCommands,
    /// Cycle records missing, of all processes.
    LostRecords,
    /// Restarts of all processes.
    Restarts,
    /// Page faults of all loops that needed no disk.
    MinorFaults,
    /// Page faults of all loops that waited for the disk.
    MajorFaults,
    /// How often loops were pushed off their processors.
    InvoluntarySwitches,
    /// Resident memory of the whole stack in the repeat that needed most, bytes.
    Resident,
}

impl Counter {
    /// Every counter.
    pub const ALL: [Self; 8] = [
        Self::DeadlineMisses,
        Self::LostCommands,
        Self::LostRecords,
        Self::Restarts,
        Self::MinorFaults,
        Self::MajorFaults,
        Self::InvoluntarySwitches,
        Self::Resident,
    ];

    /// Name in budgets.
    pub const fn key(self) -> &'static str {
        match self {
            Self::DeadlineMisses => "deadline_misses",
            Self::LostCommands => "lost_commands",
            Self::LostRecords => "lost_records",
            Self::Restarts => "restarts",
            Self::MinorFaults => "minor_faults",
            Self::MajorFaults => "major_faults",
            Self::InvoluntarySwitches => "involuntary_switches",
            Self::Resident => "resident",
        }
    }
}

/// What a budget limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// A figure of a quantity, ns.
    Time {
        /// Of what.
        quantity: Quantity,
        /// Which figure.
        statistic: Statistic,
        /// Largest value allowed, ns.
        most_ns: u64,
    },
    /// A figure's growth over the baseline.
    Growth {
        /// Of what.
        quantity: Quantity,
        /// Which figure.
        statistic: Statistic,
        /// Largest new / old − 1 allowed; negative demands that it shrank.
        most: f64,
    },
    /// A counter.
    Count {
        /// Which counter.
        counter: Counter,
        /// Largest value allowed; bytes for memory.
        most: u64,
    },
}

/// One budget with the text it was stated in.
#[derive(Debug, Clone, PartialEq)]
pub struct Budget {
    /// As stated.
    pub text: String,
    /// What it limits.
    pub limit: Limit,
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.text)
    }
}

/// Why a text states no budget.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BudgetError {
    /// No comparison in it.
    #[error(
        "{text:?} is no budget; write it like end_to_end.p99<=1ms, end_to_end.p99<=+10% or deadline_misses<=0"
    )]
    NoLimit {
        /// As stated.
        text: String,
    },
    /// Nothing is called that.
    #[error(
        "nothing is called {name:?}; times: {}; counts: {}",
        Quantity::all().map(|quantity| quantity.to_string()).collect::<Vec<_>>().join(", "),
        Counter::ALL.map(Counter::key).join(", ")
    )]
    UnknownName {
        /// What was written.
        name: String,
    },
    /// No such figure.
    #[error("there is no figure {statistic:?}; use one of {}", Statistic::ALL.map(Statistic::label).join(", "))]
    UnknownStatistic {
        /// What was written.
        statistic: String,
    },
    /// The limit has no or another unit.
    #[error("{value:?} is no limit for {name}; {expected}")]
    BadValue {
        /// What is limited.
        name: String,
        /// What was written.
        value: String,
        /// What would do.
        expected: &'static str,
    },
}

const TIME_EXPECTED: &str = "write a time (ns, us, ms, s) or a growth over the baseline, like +10%";
const COUNT_EXPECTED: &str = "write a whole number";
const BYTES_EXPECTED: &str = "write a size (kB, MB, GB)";

impl FromStr for Budget {
    type Err = BudgetError;

    fn from_str(text: &str) -> Result<Self, BudgetError> {
        let no_limit = || BudgetError::NoLimit { text: text.to_owned() };
        let (name, value) = text.split_once("<=").ok_or_else(no_limit)?;
        let (name, value) = (name.trim(), value.trim());
        let bad =
            |expected| BudgetError::BadValue { name: name.to_owned(), value: value.to_owned(), expected };
        let limit = if let Some(counter) = Counter::ALL.into_iter().find(|counter| counter.key() == name) {
            let most = match counter {
                Counter::Resident => bytes(value).ok_or_else(|| bad(BYTES_EXPECTED))?,
                Counter::DeadlineMisses
                | Counter::LostCommands
                | Counter::LostRecords
                | Counter::Restarts
                | Counter::MinorFaults
                | Counter::MajorFaults
                | Counter::InvoluntarySwitches => value.parse().map_err(|_| bad(COUNT_EXPECTED))?,
            };
            Limit::Count { counter, most }
        } else {
            let unknown = || BudgetError::UnknownName { name: name.to_owned() };
            let (key, statistic) = name.split_once('.').ok_or_else(unknown)?;
            let quantity = Quantity::of_key(key).ok_or_else(unknown)?;
            let statistic = Statistic::ALL
                .into_iter()
                .find(|candidate| candidate.label() == statistic)
                .ok_or_else(|| BudgetError::UnknownStatistic { statistic: statistic.to_owned() })?;
            match (growth(value), time_ns(value)) {
                (Some(most), _) => Limit::Growth { quantity, statistic, most },
                (None, Some(most_ns)) => Limit::Time { quantity, statistic, most_ns },
                (None, None) => return Err(bad(TIME_EXPECTED)),
            }
        };
        Ok(Self { text: text.to_owned(), limit })
    }
}

/// A growth like `+10%`, as a share. The sign is required, so that it cannot be mistaken for a share of a period.
fn growth(text: &str) -> Option<f64> {
    let number = text.strip_suffix('%')?.trim_end();
    let percent: f64 = number.starts_with(['+', '-']).then(|| number.parse().ok())??;
    percent.is_finite().then_some(percent / 100.0)
}

fn time_ns(text: &str) -> Option<u64> {
    scaled(text, &[("ns", 1.0), ("µs", 1e3), ("us", 1e3), ("ms", 1e6), ("s", 1e9)])
}

fn bytes(text: &str) -> Option<u64> {
    scaled(text, &[("kB", 1e3), ("MB", 1e6), ("GB", 1e9), ("KiB", 1_024.0), ("MiB", 1_048_576.0)])
}

/// A number that is not negative, with one of the units; the first unit that fits counts.
fn scaled(text: &str, units: &[(&str, f64)]) -> Option<u64> {
    let (number, scale) =
        units.iter().find_map(|(unit, scale)| text.strip_suffix(unit).map(|number| (number, scale)))?;
    let number: f64 = number.trim_end().parse().ok()?;
    (number.is_finite() && number >= 0.0).then(|| (number * scale).round() as u64)
}

#[cfg(test)]
mod tests {
    use messages::ProcessId;

    use super::*;
    use crate::Hop;

    #[test]
    fn every_kind_of_budget_is_read() {
        let read = |text: &str| text.parse::<Budget>().expect(text).limit;
        let (quantity, statistic) = (Quantity::Hop(Hop::EndToEnd), Statistic::P99);
        assert_eq!(read("end_to_end.p99<=1ms"), Limit::Time { quantity, statistic, most_ns: 1_000_000 });
        assert_eq!(read("end_to_end.p99 <= 1.5 us"), Limit::Time { quantity, statistic, most_ns: 1_500 });
        assert_eq!(read("end_to_end.p99<=+10%"), Limit::Growth { quantity, statistic, most: 0.1 });
        assert_eq!(read("end_to_end.p99<=-5%"), Limit::Growth { quantity, statistic, most: -0.05 });
        let (quantity, statistic) = (Quantity::LoopLateness(ProcessId::Filter), Statistic::P99_99);
        let limit = Limit::Time { quantity, statistic, most_ns: 2_000_000_000 };
        assert_eq!(read("filter_loop_lateness.p99.99<=2s"), limit);
        assert_eq!(read("deadline_misses<=0"), Limit::Count { counter: Counter::DeadlineMisses, most: 0 });
        assert_eq!(read("resident<=150MB"), Limit::Count { counter: Counter::Resident, most: 150_000_000 });
    }

    #[test]
    fn what_is_no_budget_is_refused_with_what_would_be_one() {
        for (text, hint) in [
            ("end_to_end.p99<1ms", "write it like"),
            ("end_to_end<=1ms", "end_to_end, filter_lateness"),
            ("ende.p99<=1ms", "nothing is called \"ende.p99\""),
            ("end_to_end.p98<=1ms", "p99.9"),
            ("end_to_end.p99<=1", "write a time"),
            ("end_to_end.p99<=10%", "like +10%"),
            ("end_to_end.p99<=-1ms", "write a time"),
            ("end_to_end.p99<=NaNs", "write a time"),
            ("deadline_misses<=-1", "whole number"),
            ("resident<=150", "write a size"),
        ] {
            let message = text.parse::<Budget>().expect_err(text).to_string();
            if hint == "end_to_end, filter_lateness" {
                assert!(message.contains("filter_loop_lateness"), "{text}: {message}");
            } else {
                assert!(message.contains(hint), "{text}: {message}");
            }
        }
    }

    #[test]
    fn keys_of_hops_are_those_of_their_json() {
        for hop in Hop::ALL {
            assert_eq!(serde_json::to_value(hop).expect("a name"), hop.key());
        }
    }
}
