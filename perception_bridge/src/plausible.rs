//! Whether a message can have been made when it says.

use messages::Reason;

/// A stamp farther than this behind the arrival, once the clocks are aligned, is no time of measurement, ns.
const ABSURD_NS: u64 = 10_000_000_000;
/// Nothing is measured after it arrived; clocks that are aligned jitter by no more than this, ns.
const AHEAD_NS: u64 = 100_000_000;

/// `time_ns` itself, if a message that arrived at `arrival_ns`, on the same clock, can have been made then.
///
/// # Errors
/// [`Reason::FutureStamp`] if it lies too far after the arrival, [`Reason::MalformedInput`] if absurdly far before.
pub(crate) fn plausible(arrival_ns: u64, time_ns: u64) -> Result<u64, Reason> {
    if time_ns.saturating_sub(arrival_ns) > AHEAD_NS {
        return Err(Reason::FutureStamp);
    }
    if arrival_ns.saturating_sub(time_ns) > ABSURD_NS {
        return Err(Reason::MalformedInput);
    }
    Ok(time_ns)
}
