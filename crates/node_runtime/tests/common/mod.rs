//! What the tests of ports share: a message, and patience.

use std::time::Duration;

use messages::{Goal, Stamp};
use node_runtime::{Clock, RealClock};

/// Longest time anything here may take before the test calls it lost.
#[allow(dead_code)] // not every test binary waits
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A goal that tells its sequence number in every field that can.
pub(crate) fn goal(sequence: u64) -> Goal {
    let stamp = Stamp { sequence, source_ns: 11, valid_at_ns: 12, ingress_ns: 13, published_ns: 14 };
    Goal { stamp, position_in_odom_m: [1.5, sequence as f64], heading_rad: -0.75 }
}

/// Repeats `attempt` until it yields something.
#[allow(dead_code)] // not every test binary waits
pub(crate) fn eventually<T>(what: &str, mut attempt: impl FnMut() -> Option<T>) -> T {
    let start_ns = RealClock.now_ns();
    loop {
        if let Some(value) = attempt() {
            return value;
        }
        assert!(RealClock.now_ns() - start_ns < PATIENCE.as_nanos() as u64, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
