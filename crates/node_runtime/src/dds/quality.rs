//! Which quality of service comes nearest to what the ports promise over shared memory.

use messages::{Goal, Message};
use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};

/// What a writer of `T` offers.
pub(super) fn of_writer<T: Message>(queue_length: usize) -> QosProfile {
    profile::<T>(if latched::<T>() { 1 } else { queue_length })
}

/// What a reader of `T` asks for.
pub(super) fn of_reader<T: Message>(queue_length: usize) -> QosProfile {
    profile::<T>(queue_length)
}

/// Streams are best effort: a reliable writer keeps every sample until all readers have confirmed it, so that one killed or
/// stopped reader, which DDS misses after 50 s only, would in the end stop the others. On loopback nothing is lost but by a
/// full socket, as a full queue loses its oldest. What is sent rarely is reliable and kept for late joiners.
fn profile<T: Message>(depth: usize) -> QosProfile {
    let profile = QosProfile { history: History::KeepLast { depth }, ..QosProfile::subscription_default() };
    if latched::<T>() {
        profile
            .reliability(Reliability::Reliable { when_full: WhenFull::Fail })
            .durability(Durability::TransientLocal)
    } else {
        profile
    }
}

/// Whether `T` is sent so rarely that a late joiner cannot wait for the next.
fn latched<T: Message>() -> bool {
    T::SERVICE == Goal::SERVICE
}
