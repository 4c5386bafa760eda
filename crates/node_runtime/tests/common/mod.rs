//! What the tests of ports share: a domain that vanishes with its test, a message, patience.

use std::time::Duration;

use messages::{Goal, Stamp};
use node_runtime::{Clock, Domain, RealClock, clean_up};

/// Longest time anything here may take before the test calls it lost.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

/// A domain of its own for one test. Declare it first: it is dropped last and takes every file along.
pub(crate) struct TestDomain(pub(crate) Domain);

impl TestDomain {
    pub(crate) fn new() -> Self {
        Self(Domain::isolated())
    }
}

impl Drop for TestDomain {
    fn drop(&mut self) {
        clean_up(&self.0).unwrap();
    }
}

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
