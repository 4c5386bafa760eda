//! A filter cycle allocates nothing: a counting allocator around composite and QP. One test, so that no
//! other thread allocates meanwhile.
#![allow(clippy::unwrap_used)] // helpers of a test may panic
#![allow(unsafe_code)] // a global allocator is unsafe to write

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use barrier::{CbfQp, CompositeBarrier, Kernel};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is passed on to the system allocator as it came; counting touches no memory of it.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::SeqCst);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_cycle_of_composite_and_qp_allocates_nothing() {
    let (model, pair, mut rng) = (common::ground_robot_model(1), common::unicycle_pair(), common::rng(2));
    let people = common::people(&mut rng, 64, 5.0);
    let too_many = common::people(&mut rng, 65, 5.0);
    let qp = CbfQp::new(pair.control, 1e6).unwrap();
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut composite = CompositeBarrier::new(&model, kernel, 4.0).unwrap();
        let before = ALLOCATIONS.load(Ordering::SeqCst);
        let mut finite = true;
        // From the first cycle on: no warming up.
        for count in [0, 1, 5, 20, 64, 3] {
            let sample = composite.evaluate(&pair, &[0.1, 0.2, 0.3], &people[..count]).unwrap();
            let solution = qp.solve(&[0.8, 0.1], sample.row(4.0).as_ref()).unwrap();
            finite &= solution.u[0].is_finite();
            finite &= composite.h_at(&pair, &[0.1, 0.2, 0.3], &people[..count]).is_ok();
        }
        finite &= composite.evaluate(&pair, &[0.0; 3], &too_many).is_err();
        let after = ALLOCATIONS.load(Ordering::SeqCst);
        assert!(finite);
        assert_eq!(after - before, 0, "{kernel} touched the heap");
    }
}
