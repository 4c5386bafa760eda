//! Playing any source allocates nothing once it is open.
//!
//! The counting allocator replaces the one of this whole test program, hence a file of its own with a single test.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use perception_bridge::{SourceChoice, open_source};
use settings::Settings;

const MS: u64 = 1_000_000;

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: every call is handed on unchanged to the system's allocator, which upholds the contract.
#[allow(unsafe_code, reason = "an allocator is unsafe to implement")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's obligations are those of `System.alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: `pointer` came from `System.alloc` with this layout.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn playing_allocates_nothing() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let settings = Settings::load(&repository.join("config/ground_robot.toml")).unwrap();
    let file = repository.join("tests/data/mcap_rosbags_reference.mcap");
    let mcap = |closed_loop| SourceChoice::Mcap { file: file.clone(), closed_loop };
    for choice in [SourceChoice::Simulation, mcap(false), mcap(true)] {
        let mut source = open_source(&settings, &choice).unwrap();
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        assert!(before > 0, "the allocator counts");
        let mut events = 0;
        for tick in 0..2_000 {
            let now_ns = 1_000 * MS + tick * MS;
            while source.poll(now_ns).is_some() {
                events += 1;
            }
            source.status(now_ns);
        }
        assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0, "{choice:?}");
        assert!(events > 20, "{choice:?}");
    }
}
