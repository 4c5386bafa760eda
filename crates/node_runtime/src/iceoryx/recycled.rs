//! Shared values whose memory is used again, so that a loan costs no allocation.
//!
//! iceoryx2 puts every loaned sample into a new reference-counted cell (in [`ipc_threadsafe`](iceoryx2::service::ipc_threadsafe)
//! an `Arc` around a POSIX mutex) and drops it when the sample is sent. Here the cell of the last loan serves the next one.

// The only memory in this crate that is managed by hand; each use says why it holds.
#![allow(unsafe_code)]

use std::{
    cell::RefCell,
    fmt,
    marker::PhantomData,
    mem::MaybeUninit,
    ops::Deref,
    ptr::NonNull,
    sync::atomic::{AtomicUsize, Ordering, fence},
};

use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::arc_sync_policy::{ArcSyncPolicy, ArcSyncPolicyCreationError, LockGuard};
use parking_lot::{ReentrantMutex, ReentrantMutexGuard};

/// Memory of one small shared value. A loan needs about half of it.
type Cell = MaybeUninit<[u128; 8]>;
/// Cells that a thread keeps for its next loans; one per loan that it holds at a time is enough.
const KEPT: usize = 16;

thread_local! {
    /// Per thread, so that no thread ever waits for another one's loan.
    #[expect(clippy::vec_box, reason = "a cell is handed out by its address, and must not move with the list")]
    static CELLS: RefCell<Vec<Box<Cell>>> = RefCell::new(Vec::with_capacity(KEPT));
}

/// A value shared by counting its owners, which take turns to use it. The same thread may take it again while it has it.
pub(crate) struct Recycled<T> {
    shared: NonNull<Shared<T>>,
    /// Dropping the last owner drops the value.
    owns: PhantomData<Shared<T>>,
}

struct Shared<T> {
    owners: AtomicUsize,
    value: ReentrantMutex<T>,
}

impl<T> Shared<T> {
    /// Whether it can live in a [`Cell`]. Larger values are those of ports, which are made at start-up.
    const SMALL: bool = size_of::<Self>() <= size_of::<Cell>() && align_of::<Self>() <= align_of::<Cell>();
}

impl<T> Recycled<T> {
    fn with(value: T) -> Self {
        let shared = Shared { owners: AtomicUsize::new(1), value: ReentrantMutex::new(value) };
        let pointer = if Shared::<T>::SMALL {
            let kept = CELLS.try_with(|cells| cells.borrow_mut().pop()).ok().flatten();
            let cell = kept.unwrap_or_else(|| Box::new(Cell::uninit()));
            let pointer = NonNull::from(Box::leak(cell)).cast::<Shared<T>>();
            // SAFETY: `SMALL` says that the cell is large enough and aligned, and it belongs to nobody else.
            unsafe { pointer.write(shared) };
            pointer
        } else {
            NonNull::from(Box::leak(Box::new(shared)))
        };
        Self { shared: pointer, owns: PhantomData }
    }

    fn shared(&self) -> &Shared<T> {
        // SAFETY: written by `with` and alive as long as an owner is, which this is; only shared references are ever given
        // out before the last owner is dropped.
        unsafe { self.shared.as_ref() }
    }
}

// SAFETY: as for `Arc<ReentrantMutex<T>>`: the count is atomic, and the mutex gives the value to one thread at a time.
unsafe impl<T: Send> Send for Recycled<T> {}
// SAFETY: as above.
unsafe impl<T: Send> Sync for Recycled<T> {}

impl<T> Clone for Recycled<T> {
    fn clone(&self) -> Self {
        self.shared().owners.fetch_add(1, Ordering::Relaxed);
        Self { shared: self.shared, owns: PhantomData }
    }
}

impl<T> Drop for Recycled<T> {
    fn drop(&mut self) {
        // Release and acquire order what the other owners did before the value's end, as in `Arc`.
        if self.shared().owners.fetch_sub(1, Ordering::Release) > 1 {
            return;
        }
        fence(Ordering::Acquire);
        if !Shared::<T>::SMALL {
            // SAFETY: `with` leaked a box of this type, and the last owner is gone.
            drop(unsafe { Box::from_raw(self.shared.as_ptr()) });
            return;
        }
        // SAFETY: `with` wrote the value, and the last owner is gone.
        unsafe { self.shared.drop_in_place() };
        // SAFETY: `with` leaked a box of this type, and its content has just ended.
        let cell = unsafe { Box::from_raw(self.shared.cast::<Cell>().as_ptr()) };
        // A thread that is ending frees it instead.
        let _ = CELLS.try_with(|cells| {
            let mut cells = cells.borrow_mut();
            if cells.len() < KEPT {
                cells.push(cell);
            }
        });
    }
}

impl<T: fmt::Debug> fmt::Debug for Recycled<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_tuple("Recycled").field(&self.shared().value).finish()
    }
}

impl<T: Abandonable> Abandonable for Recycled<T> {
    unsafe fn abandon_in_place(mut this: NonNull<Self>) {
        // SAFETY: the caller's promise: valid, and not used afterwards.
        let this = unsafe { this.as_mut() };
        if this.shared().owners.load(Ordering::Acquire) > 1 {
            // SAFETY: the caller does not drop it again; the other owners keep the value.
            unsafe { std::ptr::drop_in_place(this) };
        } else {
            // SAFETY: this is the only owner, so that nobody else can reach the value, which is abandoned in its place.
            unsafe { T::abandon_in_place(NonNull::from((*this.shared.as_ptr()).value.get_mut())) };
        }
    }
}

/// The right to use the value, until it is dropped.
pub(crate) struct Turn<'a, T>(ReentrantMutexGuard<'a, T>);

impl<T> Deref for Turn<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<'a, T: Send + Abandonable> LockGuard<'a, T> for Turn<'a, T> {}

impl<T: Send + fmt::Debug + Abandonable> ArcSyncPolicy<T> for Recycled<T> {
    type LockGuard<'a>
        = Turn<'a, T>
    where
        Self: 'a,
        T: 'a;

    fn new(value: T) -> Result<Self, ArcSyncPolicyCreationError> {
        Ok(Self::with(value))
    }

    fn lock(&self) -> Turn<'_, T> {
        Turn(self.shared().value.lock())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn a_value_ends_once_with_its_last_owner_on_whatever_thread() {
        let alive = Arc::new(());
        for _ in 0..100 {
            let shared = Recycled::with(Arc::clone(&alive));
            let owners: Vec<_> = (0..4).map(|_| shared.clone()).collect();
            let threads: Vec<_> = owners
                .into_iter()
                .map(|owner| {
                    std::thread::spawn(move || {
                        assert_eq!(Arc::strong_count(&Turn(owner.shared().value.lock())), 2);
                        drop(owner);
                    })
                })
                .collect();
            for thread in threads {
                thread.join().unwrap();
            }
            assert_eq!(Arc::strong_count(&alive), 2);
            drop(shared);
            assert_eq!(Arc::strong_count(&alive), 1);
        }
    }

    #[test]
    fn memory_is_used_again_and_a_new_value_never_shares_it_with_a_living_one() {
        let first = Recycled::with(1_u64);
        let place = first.shared;
        let second = Recycled::with(2_u64);
        assert_ne!(place, second.shared);
        drop(first);
        let elsewhere = std::hint::black_box(Box::new(Cell::uninit()));
        let third = Recycled::with([3_u64; 4]);
        assert_eq!(place.cast(), third.shared, "the freed cell serves the next value");
        drop(elsewhere);
        assert_eq!((*second.shared().value.lock(), *third.shared().value.lock()), (2, [3; 4]));
    }

    #[test]
    fn small_and_large_values_in_any_number_live_side_by_side() {
        const { assert!(!Shared::<[u8; 1_000]>::SMALL && Shared::<[u8; 64]>::SMALL) };
        let small: Vec<_> = (0..3 * KEPT).map(|number| Recycled::with([number; 4])).collect();
        let large: Vec<_> = (0..3 * KEPT).map(|number| Recycled::with([number; 400])).collect();
        for (number, (small, large)) in small.iter().zip(&large).enumerate() {
            assert_eq!(
                (*small.shared().value.lock(), *large.shared().value.lock()),
                ([number; 4], [number; 400])
            );
        }
        drop((small, large));
        assert!(CELLS.with(|cells| cells.borrow().len()) <= KEPT);
    }

    #[test]
    fn the_same_thread_takes_it_again_and_another_one_waits() {
        let shared = Recycled::with(RefCell::new(0));
        let other = shared.clone();
        let turn = shared.shared().value.lock();
        *shared.shared().value.lock().borrow_mut() += 1;
        let thread = std::thread::spawn(move || *other.shared().value.lock().borrow_mut() += 10);
        std::thread::sleep(std::time::Duration::from_millis(20));
        assert_eq!(*turn.borrow(), 1);
        drop(turn);
        thread.join().unwrap();
        assert_eq!(*shared.shared().value.lock().borrow(), 11);
    }
}
