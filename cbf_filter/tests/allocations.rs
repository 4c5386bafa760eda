//! A cycle allocates nothing, on any rung of the ladder.

mod scene;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use messages::SafetyStatus;
use scene::{MS, START_NS, Scene, filter, person};

/// The system's allocator, counting.
struct Counting;

thread_local! {
    /// Allocations of this thread: the test harness allocates on its own thread whenever it likes.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on unchanged to the system's allocator.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn no_cycle_allocates_whether_filtered_relaxed_braking_or_recovering() {
    let mut filter = filter();
    let mut seen = [0_usize; 5];
    let mut now_ns = START_NS;
    for round in 0..2_000_u64 {
        now_ns += 4 * MS;
        let close = [
            person(1, [0.75, 0.0], [-1.2, 0.0], now_ns),
            person(2, [0.4, 0.8], [-0.3, -1.2], now_ns),
            person(3, [0.4, -0.8], [-0.3, 1.2], now_ns),
        ];
        let far: Vec<_> =
            (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 4.0], [0.0, -0.3], now_ns)).collect();
        let mut scene = match round / 400 {
            0 | 3 => Scene::fresh(&far, now_ns),
            1 => Scene::fresh(&close, now_ns),
            2 => Scene::fresh(&far, START_NS),
            _ => Scene::fresh(&[], now_ns),
        };
        if round % 97 == 0 {
            scene.robot_state = None;
        }
        let before = ALLOCATIONS.get();
        let command = scene.step(&mut filter, now_ns);
        let allocations = ALLOCATIONS.get() - before;
        assert_eq!(allocations, 0, "round {round}, status {}", command.status);
        seen[command.status as usize] += 1;
    }
    for status in SafetyStatus::ALL {
        assert!(seen[status.code() as usize] > 0, "{status} never came up: {seen:?}");
    }
}
