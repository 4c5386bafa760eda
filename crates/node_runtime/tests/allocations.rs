//! Counts heap allocations of what a control cycle calls.

mod common;

use std::time::Duration;

use allocation_counter::measure;
use common::goal;
use messages::{Goal, ProcessId};
use node_runtime::{Clock, HealthReporter, Node, Pacer, RealClock, ScopedDomain, Waiting, Woken};

fn allocations(action: impl FnOnce()) -> u64 {
    measure(action).count_total
}

#[test]
fn a_cycle_allocates_nothing() {
    assert_eq!(allocations(|| drop(std::hint::black_box(vec![1_u8; 100]))), 1, "the counter counts");

    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let publisher = node.publisher::<Goal>().unwrap();
    let mut subscriber = node.subscriber::<Goal>().unwrap();
    let (waker, wake_up) = (node.waker(ProcessId::Filter).unwrap(), node.wake_up().unwrap());
    let mut health = HealthReporter::new(&node).unwrap();
    let mut timer = Pacer::every(Duration::from_millis(1), Waiting::ASLEEP);
    let mut cycle = |number: u64| {
        allocations(|| {
            let tick = timer.wait();
            publisher.send(&goal(number)).unwrap();
            waker.wake();
            assert_eq!(wake_up.wait(Duration::from_secs(1)), Woken::Notified);
            assert_eq!(wake_up.wait(Duration::from_micros(1)), Woken::TimedOut);
            assert_eq!(wake_up.look(), Woken::TimedOut);
            match number % 2 {
                0 => assert_eq!(subscriber.newest(), Some(goal(number))),
                _ => assert_eq!(subscriber.drain(|_| {}), 1),
            }
            health.cycle(&tick);
            health.accepted(RealClock.now_ns() % 2);
            health.report(tick.woke_ns);
        })
    };
    cycle(0); // connects, and makes the one cell that every later loan uses
    for number in 1..=500 {
        assert_eq!(cycle(number), 0, "in cycle {number}");
    }
}
