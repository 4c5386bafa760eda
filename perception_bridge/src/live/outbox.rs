//! From the bridge's loop to the thread that publishes: one place, and whatever is newer replaces what waits in it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Thread, park};

use crossbeam_queue::ArrayQueue;

/// Holds one value until it is taken. Putting never waits and allocates nothing.
#[derive(Debug)]
pub(super) struct Outbox<T> {
    newest: ArrayQueue<T>,
    is_closed: AtomicBool,
}

impl<T> Outbox<T> {
    /// An empty one.
    pub(super) fn new() -> Self {
        Self { newest: ArrayQueue::new(1), is_closed: AtomicBool::new(false) }
    }

    /// Puts `value` in place and wakes `taker`. False if it replaced one that had not been taken.
    pub(super) fn put(&self, value: T, taker: &Thread) -> bool {
        let replaced = self.newest.force_push(value);
        taker.unpark();
        replaced.is_none()
    }

    /// Ends [`Self::take_each`]; what waits is not taken any more.
    pub(super) fn close(&self, taker: &Thread) {
        self.is_closed.store(true, Ordering::Release);
        taker.unpark();
    }

    /// Hands each value to `take`, and sleeps while there is none, until the box is closed.
    pub(super) fn take_each(&self, mut take: impl FnMut(T)) {
        while !self.is_closed.load(Ordering::Acquire) {
            match self.newest.pop() {
                Some(value) => take(value),
                None => park(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use allocation_counter::measure;

    use super::*;

    #[test]
    fn after_a_taker_that_was_held_up_comes_the_newest_value_alone() {
        let outbox = &Outbox::new();
        let (taken, seen) = sync_channel(8);
        let (release, held_up) = sync_channel::<()>(8);
        // Looked at afterwards: the scope would wait for its taker before it let a panic through.
        let (mut waited_for_none, mut first_taken) = (Vec::new(), Vec::new());
        std::thread::scope(|scope| {
            let taker = scope.spawn(move || {
                outbox.take_each(|value| {
                    taken.send(value).expect("the test listens");
                    held_up.recv().expect("the test lets go");
                });
            });
            let taker = taker.thread();
            waited_for_none.push(outbox.put(0, taker));
            first_taken.extend(seen.recv());
            waited_for_none.extend((1..=5).map(|value| outbox.put(value, taker)));
            release.send(()).expect("a taker");
            first_taken.extend(seen.recv());
            outbox.put(6, taker);
            outbox.close(taker);
            release.send(()).expect("a taker");
        });
        assert_eq!(waited_for_none, [true, true, false, false, false, false]);
        assert_eq!(first_taken, [0, 5]);
        assert_eq!(seen.try_iter().count(), 0, "taken after the box was closed");
    }

    #[test]
    fn putting_allocates_nothing() {
        let (outbox, taker) = (Outbox::new(), std::thread::current());
        let of_putting = measure(|| {
            for value in 0..1_000 {
                assert_eq!(outbox.put(value, &taker), value == 0);
            }
        });
        assert_eq!(of_putting.count_total, 0);
    }
}
