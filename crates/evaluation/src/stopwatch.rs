//! How long steps take on the machine's clock. The only thing in this crate that is not the same on every run.

use node_runtime::{Clock, RealClock};

/// Times steps while it runs.
#[derive(Debug, Clone, Default)]
pub struct Stopwatch {
    clock: Option<RealClock>,
    tick_ns: Vec<u64>,
    nominal_ns: Vec<u64>,
}

impl Stopwatch {
    pub(crate) const fn stopped() -> Self {
        Self { clock: None, tick_ns: Vec::new(), nominal_ns: Vec::new() }
    }

    pub(crate) const fn running() -> Self {
        Self { clock: Some(RealClock), tick_ns: Vec::new(), nominal_ns: Vec::new() }
    }

    /// Times one step of what stands in the filter's place.
    pub(crate) fn tick<T>(&mut self, step: impl FnOnce() -> T) -> T {
        timed(self.clock, &mut self.tick_ns, step)
    }

    /// Times one step of the nominal controller.
    pub(crate) fn nominal<T>(&mut self, step: impl FnOnce() -> T) -> T {
        timed(self.clock, &mut self.nominal_ns, step)
    }

    /// Median and 99th percentile of the filter's steps, µs; nothing if none was timed.
    pub fn tick_us(&self) -> Option<[f64; 2]> {
        percentiles_us(&self.tick_ns)
    }

    /// Median and 99th percentile of the nominal controller's steps, µs; nothing if none was timed.
    pub fn nominal_us(&self) -> Option<[f64; 2]> {
        percentiles_us(&self.nominal_ns)
    }
}

fn timed<T>(clock: Option<RealClock>, times_ns: &mut Vec<u64>, step: impl FnOnce() -> T) -> T {
    let Some(clock) = clock else { return step() };
    let began_ns = clock.now_ns();
    let result = step();
    times_ns.push(clock.now_ns() - began_ns);
    result
}

/// Nearest-rank percentiles.
fn percentiles_us(times_ns: &[u64]) -> Option<[f64; 2]> {
    let mut sorted = times_ns.to_vec();
    sorted.sort_unstable();
    let rank = |share: f64| ((share * sorted.len() as f64).ceil() as usize).max(1) - 1;
    (!sorted.is_empty()).then(|| [0.5, 0.99].map(|share| sorted[rank(share)] as f64 * 1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let times_ns: Vec<u64> = (1..=200).rev().map(|count| count * 1000).collect();
        assert_eq!(percentiles_us(&times_ns), Some([100.0, 198.0]));
        assert_eq!(percentiles_us(&[7_000]), Some([7.0, 7.0]));
        assert_eq!(percentiles_us(&[]), None);
    }

    #[test]
    fn a_stopped_watch_notes_nothing() {
        let mut watch = Stopwatch::stopped();
        assert_eq!(watch.tick(|| 3), 3);
        assert_eq!(watch.tick_us(), None);
        let mut watch = Stopwatch::running();
        watch.nominal(|| ());
        assert!(watch.nominal_us().is_some() && watch.tick_us().is_none());
    }
}
