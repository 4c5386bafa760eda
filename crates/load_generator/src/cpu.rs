//! Processors kept busy: integer arithmetic that needs no memory.

use std::hint::black_box;

use crate::workers::{Share, on_each};
use crate::{Done, LoadError, processors};

/// Steps of one round; well below a millisecond.
const STEPS: u32 = 100_000;

pub(crate) fn run(stop: &(impl Fn() -> bool + Sync)) -> Result<Done, LoadError> {
    on_each(&processors::allowed(), 0, || {
        let mut share = Share::default();
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        loop {
            for _ in 0..STEPS {
                // A chain of dependent steps, which the compiler cannot shorten.
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
            }
            state = black_box(state);
            share.iterations += 1;
            if stop() {
                return share;
            }
        }
    })
}
