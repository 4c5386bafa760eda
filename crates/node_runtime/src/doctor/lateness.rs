//! How late this machine wakes a thread, measured.

use std::time::Duration;

use crate::{CyclicTimer, RealClock, clock::nanoseconds};

/// Wakes up every `period` for `duration` and returns how late each time was, ns, in the order of measurement.
///
/// Runs on the calling thread with the rights that it has. Periods that were slept through count too, each with the time
/// from its due time to the wake-up, so that a long stall is not one sample among many.
pub fn measure_wake_up_lateness(duration: Duration, period: Duration) -> Vec<u64> {
    let period_ns = nanoseconds(period).max(1);
    let wanted = (nanoseconds(duration) / period_ns) as usize;
    let mut lateness_ns = Vec::with_capacity(wanted);
    let mut timer = CyclicTimer::new(RealClock, period);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_one_sample_per_period() {
        let samples = measure_wake_up_lateness(Duration::from_millis(50), Duration::from_millis(2));
        assert_eq!(samples.len(), 25);
        assert!(samples.iter().any(|&lateness_ns| lateness_ns > 0));
    }
}
