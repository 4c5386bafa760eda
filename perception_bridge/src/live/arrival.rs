//! When something arrived, and what a stamp on the date's clock means on the stack's.

use messages::Reason;
use node_runtime::{Clock, RealClock};
use recording::ros2::Time;
use rustix::time::{ClockId, clock_gettime};

use crate::plausible::plausible;

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

    /// When a message with this stamp, which arrived now, was measured. One without a stamp holds when it arrives.
    ///
    /// # Errors
    /// [`Reason::FutureStamp`] and [`Reason::MalformedInput`] for a stamp of another clock, or one made before the date was set.
    pub(super) fn measured(self, stamp: &Time) -> Result<Measured, Reason> {
        let Some(stamp_ns) = stamp.to_ns() else {
            return Ok(Measured { valid_at_ns: self.stack_ns, source_ns: self.wall_ns });
        };
        plausible(self.wall_ns, stamp_ns)?;
        // Both are near the arrival, so their difference fits.
        let ahead_ns = stamp_ns.cast_signed() - self.wall_ns.cast_signed();
        Ok(Measured { valid_at_ns: self.stack_ns.saturating_add_signed(ahead_ns), source_ns: stamp_ns })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000_000;
    const NOW: Arrival = Arrival { stack_ns: 50 * S, wall_ns: 1_700_000_000 * S };

    #[test]
    fn a_stamp_moves_to_the_stack_clock_with_its_age() {
        let measured = NOW.measured(&Time::from_ns(NOW.wall_ns - S / 10)).expect("an honest stamp");
        assert_eq!(measured, Measured { valid_at_ns: 50 * S - S / 10, source_ns: NOW.wall_ns - S / 10 });
        let unstamped = NOW.measured(&Time::default()).expect("allowed");
        assert_eq!(unstamped, Measured { valid_at_ns: 50 * S, source_ns: NOW.wall_ns });
    }

    #[test]
    fn stamps_of_other_clocks_are_refused() {
        let of = |stamp_ns: u64| NOW.measured(&Time::from_ns(stamp_ns));
        assert_eq!(of(NOW.wall_ns + S), Err(Reason::FutureStamp));
        assert_eq!(of(NOW.wall_ns - 11 * S), Err(Reason::MalformedInput));
        assert_eq!(of(1_234 * S), Err(Reason::MalformedInput), "simulated time");
    }

    #[test]
    fn both_clocks_are_read() {
        let arrival = Arrival::now();
        assert!(arrival.stack_ns <= RealClock.now_ns() && arrival.wall_ns > 1_600_000_000 * S);
    }
}
