//! From the receiving thread to the bridge's loop: a bounded queue, a wake-up, counters.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, OnceLock};

use node_runtime::Waker;

use crate::source::BridgeEvent;

/// Places in the queue: half a second of everything at the usual rates, about 0.3 MB.
const PLACES: usize = 64;

/// What wakes the bridge, once it is known.
#[derive(Debug, Clone, Default)]
pub(super) struct WakerSlot(Arc<OnceLock<Waker>>);

impl WakerSlot {
    /// Puts it in place; only the first one counts.
    pub(super) fn fill(&self, waker: Waker) {
        let _ = self.0.set(waker);
    }
}

/// What was lost on the way, by where.
#[derive(Debug, Default)]
pub(super) struct Counters {
    refused: AtomicU64,
    dropped: AtomicU64,
    replaced: AtomicU64,
}

impl Counters {
    /// A message that made no sense.
    pub(super) fn count_refused(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    /// A command that a newer one replaced before it had left.
    pub(super) fn count_replaced_command(&self) {
        self.replaced.fetch_add(1, Ordering::Relaxed);
    }

    /// Messages that came and were refused or dropped.
    pub(super) fn lost_inputs(&self) -> u64 {
        self.refused.load(Ordering::Relaxed) + self.dropped.load(Ordering::Relaxed)
    }

    /// Commands that newer ones replaced before they had left.
    pub(super) fn replaced_commands(&self) -> u64 {
        self.replaced.load(Ordering::Relaxed)
    }
}

/// The receiving thread's end.
#[derive(Debug)]
pub(super) struct HandOver {
    events: SyncSender<BridgeEvent>,
    counters: Arc<Counters>,
    waker: WakerSlot,
}

impl HandOver {
    /// An empty queue with both of its ends.
    pub(super) fn new() -> (Self, Receiver<BridgeEvent>) {
        let (events, receiver) = sync_channel(PLACES);
        (Self { events, counters: Arc::default(), waker: WakerSlot::default() }, receiver)
    }

    pub(super) fn counters(&self) -> Arc<Counters> {
        Arc::clone(&self.counters)
    }

    pub(super) fn waker(&self) -> WakerSlot {
        self.waker.clone()
    }

    /// Hands over one event and wakes the bridge; where no place is left, it is dropped and counted.
    pub(super) fn put(&self, event: BridgeEvent) {
        if self.events.try_send(event).is_err() {
            self.counters.dropped.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(waker) = self.waker.0.get() {
            waker.wake();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use allocation_counter::measure;
    use bytemuck::Zeroable;
    use messages::RobotState;

    #[test]
    fn a_loop_that_does_not_take_costs_events_and_never_time() {
        let (hand_over, events) = HandOver::new();
        for _ in 0..PLACES + 3 {
            hand_over.put(BridgeEvent::RobotState(RobotState::zeroed()));
        }
        assert_eq!(hand_over.counters().lost_inputs(), 3);
        assert_eq!(events.try_iter().count(), PLACES);
    }

    #[test]
    fn the_queue_allocates_nothing_once_it_is_made() {
        let (hand_over, events) = HandOver::new();
        let of_passing = measure(|| {
            for _ in 0..1_000 {
                hand_over.put(BridgeEvent::RobotState(RobotState::zeroed()));
                assert!(events.try_recv().is_ok() && events.try_recv().is_err());
            }
        });
        assert_eq!(of_passing.count_total, 0);
    }
}
