//! From the sensors' clock to the recorder's: header stamps rule, log times are the fallback.

use crate::plausible::plausible;

/// Clocks closer together than this are the same one; what remains is the sensors' delay, which is physics, ns.
const SAME_CLOCK_NS: i64 = 1_000_000_000;
/// What is added to a stamp to bring it onto the recorder's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ClockOffset(i64);

/// When a message holds, on the recorder's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MeasuredAt {
    /// ns.
    pub(super) time_ns: u64,
    /// Whether the log time had to be taken, since the stamp is missing or absurd.
    pub(super) is_log_time: bool,
}

impl ClockOffset {
    /// Estimates the offset from pairs of log time and stamp, ns.
    ///
    /// Two clocks differ by the typical difference; on top, each message has its own delay, of which the smallest seen is
    /// taken for none. A clock behind by less than a second cannot be told from a delay and stays as it is; one ahead is set
    /// back.
    pub(super) fn estimate(pairs: impl Iterator<Item = (u64, u64)>) -> Self {
        let mut differences: Vec<i64> =
            pairs.map(|(log_ns, stamp_ns)| difference(log_ns, stamp_ns)).collect();
        differences.sort_unstable();
        let Some(&median) = differences.get(differences.len() / 2) else { return Self(0) };
        if (0..SAME_CLOCK_NS).contains(&median) {
            return Self(0);
        }
        if (-SAME_CLOCK_NS..0).contains(&median) {
            // Nothing is measured after it was logged, so this clock runs ahead. Stamps far from the others are faults, and
            // so are up to one in twenty of the rest.
            let from =
                differences.partition_point(|difference| median.saturating_sub(*difference) >= SAME_CLOCK_NS);
            let typical = &differences[from..];
            return Self(typical.get(typical.len() / 20).map_or(0, |smallest| (*smallest).min(0)));
        }
        let smallest =
            differences.iter().find(|difference| median.saturating_sub(**difference) < SAME_CLOCK_NS);
        Self(smallest.copied().unwrap_or(median))
    }

    /// Time of measurement of a message with this stamp, if it has one.
    pub(super) fn measured_at(self, log_time_ns: u64, stamp_ns: Option<u64>) -> MeasuredAt {
        let aligned = stamp_ns.and_then(|stamp_ns| stamp_ns.checked_add_signed(self.0));
        match aligned.map(|time_ns| plausible(log_time_ns, time_ns)) {
            Some(Ok(time_ns)) => MeasuredAt { time_ns, is_log_time: false },
            Some(Err(_)) | None => MeasuredAt { time_ns: log_time_ns, is_log_time: true },
        }
    }
}

/// `a − b`, cut to what fits.
fn difference(a: u64, b: u64) -> i64 {
    i64::try_from(i128::from(a) - i128::from(b)).unwrap_or(if a > b { i64::MAX } else { i64::MIN + 1 })
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;
    const MS: u64 = 1_000_000;

    #[test]
    fn on_one_clock_the_stamp_stays_and_the_delay_shows() {
        let offset = ClockOffset::estimate((100..200).map(|s| (s * S + 30 * MS, s * S)));
        assert_eq!(offset, ClockOffset(0));
        let at = offset.measured_at(150 * S + 30 * MS, Some(150 * S));
        assert_eq!(at, MeasuredAt { time_ns: 150 * S, is_log_time: false });
    }

    #[test]
    fn two_clocks_are_aligned_by_the_shortest_delay() {
        // The sensor began at zero when the recorder showed 1,000,000 s; delays of 5 ms to 14 ms.
        let log_ns = |s: u64| (1_000_000 + s) * S + (5 + s % 10) * MS;
        let offset = ClockOffset::estimate((1..100).map(|s| (log_ns(s), s * S)));
        assert_eq!(offset.measured_at(log_ns(13), Some(13 * S)).time_ns, (1_000_013) * S + 5 * MS);
    }

    #[test]
    fn a_clock_that_runs_ahead_a_little_is_set_back_and_one_behind_is_delay() {
        // Stamps 500 ms ahead, delays of 5 ms to 14 ms; some are farther ahead, some absurd.
        let log_ns = |s: u64| s * S + (5 + s % 10) * MS;
        let ahead = |s: u64| match s % 50 {
            7 => s * S + 900 * MS,
            21..25 => u64::MAX,
            _ => s * S + 500 * MS,
        };
        let offset = ClockOffset::estimate((100..200).map(|s| (log_ns(s), ahead(s))));
        assert_eq!(offset.measured_at(log_ns(113), Some(ahead(113))).time_ns, 113 * S + 5 * MS);
        assert!(offset.measured_at(log_ns(107), Some(ahead(107))).is_log_time);
        let behind = ClockOffset::estimate((100..200).map(|s| (log_ns(s) + 500 * MS, s * S)));
        assert_eq!(behind, ClockOffset(0));
    }

    #[test]
    fn missing_and_absurd_stamps_give_way_to_the_log_time() {
        let offset = ClockOffset::estimate(std::iter::empty());
        let log_time = MeasuredAt { time_ns: 50 * S, is_log_time: true };
        for stamp_ns in [None, Some(5 * S), Some(u64::MAX), Some(1)] {
            assert_eq!(offset.measured_at(50 * S, stamp_ns), log_time);
        }
        assert!(!offset.measured_at(50 * S, Some(42 * S)).is_log_time);
    }

    #[test]
    fn nothing_is_measured_after_it_was_logged() {
        let offset = ClockOffset(0);
        assert!(!offset.measured_at(50 * S, Some(50 * S + 100 * MS)).is_log_time, "jitter of the clocks");
        let log_time = MeasuredAt { time_ns: 50 * S, is_log_time: true };
        assert_eq!(offset.measured_at(50 * S, Some(50 * S + 101 * MS)), log_time);
    }

    #[test]
    fn a_few_absurd_stamps_do_not_move_the_clock() {
        let pairs = (100..200).map(|s| (s * S + 2 * MS, if s % 10 == 0 { u64::MAX } else { s * S }));
        assert_eq!(ClockOffset::estimate(pairs), ClockOffset(0));
    }
}
