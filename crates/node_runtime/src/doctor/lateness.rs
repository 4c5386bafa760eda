//! How late this machine wakes a thread, measured.

use std::time::Duration;

use crate::{Pacer, Waiting, clock::nanoseconds};

/// Wakes up every `period` for `duration` and returns how late each time was, ns, in the order of measurement; at least one.
///
/// Runs on the calling thread with the rights that it has, awake `spin` before each due time. Periods that were slept through
/// count too, each with the time from its due time to the wake-up, so that a long stall is not one sample among many.
pub fn measure_wake_up_lateness(duration: Duration, period: Duration, spin: Duration) -> Vec<u64> {
    let period_ns = nanoseconds(period).max(1);
    let wanted = ((nanoseconds(duration) / period_ns) as usize).max(1);
    let mut lateness_ns = Vec::with_capacity(wanted);
    let mut timer = Pacer::every(period, Waiting::Sleep { spin });
    while lateness_ns.len() < wanted {
        let tick = timer.wait();
        for missed in (0..=tick.skipped).rev() {
            if lateness_ns.len() < wanted {
                lateness_ns.push(tick.lateness_ns() + missed * period_ns);
            }
        }
    }
    lateness_ns
}

/// Lateness of many wake-ups. Quantiles are nearest ranks: values that were measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Lateness {
    /// Wake-ups.
    pub count: usize,
    /// Median, ns.
    pub p50_ns: u64,
    /// 99 of 100 were at most this late, ns.
    pub p99_ns: u64,
    /// 999 of 1000 were at most this late, ns; the maximum where fewer were measured.
    pub p999_ns: u64,
    /// The worst, ns. Never filtered.
    pub max_ns: u64,
    /// How many were later than a whole period.
    pub later_than_a_period: usize,
}

impl Lateness {
    /// Sums up `samples_ns`; sorts them.
    pub fn of(samples_ns: &mut [u64], period: Duration) -> Self {
        samples_ns.sort_unstable();
        let count = samples_ns.len();
        let at = |per_mille: usize| {
            let rank = (count * per_mille).div_ceil(1000);
            samples_ns.get(rank.saturating_sub(1)).copied().unwrap_or(0)
        };
        let period_ns = nanoseconds(period);
        Self {
            count,
            p50_ns: at(500),
            p99_ns: at(990),
            p999_ns: at(999),
            max_ns: at(1000),
            later_than_a_period: samples_ns.iter().filter(|&&late_ns| late_ns > period_ns).count(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(2);

    #[test]
    fn there_is_one_sample_per_period() {
        let samples = measure_wake_up_lateness(Duration::from_millis(50), PERIOD, Duration::ZERO);
        assert_eq!(samples.len(), 25);
        assert!(samples.iter().any(|&lateness_ns| lateness_ns > 0));
        assert_eq!(measure_wake_up_lateness(Duration::ZERO, PERIOD, Duration::ZERO).len(), 1);
    }

    #[test]
    fn quantiles_are_nearest_ranks_and_the_worst_is_kept() {
        let mut samples: Vec<u64> = (1..=1000).rev().map(|rank| rank * 3_000).collect();
        let lateness = Lateness::of(&mut samples, PERIOD);
        let expected = Lateness {
            count: 1000,
            p50_ns: 1_500_000,
            p99_ns: 2_970_000,
            p999_ns: 2_997_000,
            max_ns: 3_000_000,
            later_than_a_period: 334,
        };
        assert_eq!(lateness, expected);
        assert_eq!(Lateness::of(&mut [7], PERIOD).p50_ns, 7);
        assert_eq!(Lateness::of(&mut [], PERIOD), Lateness::default());
    }
}
