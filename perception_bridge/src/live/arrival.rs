//! When something arrived, on both clocks of the machine.

use node_runtime::{Clock, RealClock};
use rustix::time::{ClockId, clock_gettime};

/// Readings farther apart than this are repeated: the thread was interrupted between them, ns.
const APART_NS: u64 = 20_000;
/// How often, before the last is taken as it is.
const READINGS: usize = 4;

/// One moment on both clocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Arrival {
    /// Stack clock, ns.
    pub(super) stack_ns: u64,
    /// Date, which ROS 2 stamps its messages with, ns since 1970.
    pub(super) wall_ns: u64,
}

/// When a message was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Measured {
    /// Stack clock, ns.
    pub(super) valid_at_ns: u64,
    /// The stamp itself, ns; of an unstamped message the date of its arrival.
    pub(super) source_ns: u64,
}

impl Arrival {
    /// Now. Both clocks are read together each time, so that a change of the date takes effect at once.
    pub(super) fn now() -> Self {
        let mut arrival = Self { stack_ns: 0, wall_ns: 0 };
        for _ in 0..READINGS {
            let before_ns = RealClock.now_ns();
            let date = clock_gettime(ClockId::Realtime);
            let apart_ns = RealClock.now_ns() - before_ns;
            let wall_ns = date.tv_sec.cast_unsigned() * 1_000_000_000 + date.tv_nsec.cast_unsigned();
            arrival = Self { stack_ns: before_ns + apart_ns / 2, wall_ns };
            if apart_ns <= APART_NS {
                break;
            }
        }
        arrival
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;

    #[test]
    fn both_clocks_are_read() {
        let arrival = Arrival::now();
        assert!(arrival.stack_ns <= RealClock.now_ns() && arrival.wall_ns > 1_600_000_000 * S);
    }
}
