//! What ports promise, between two nodes of one process.

mod common;

use std::time::Duration;

use bytemuck::{Pod, Zeroable};
use common::{PATIENCE, goal};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use messages::{Goal, Health, Message, ProcessId, SafeCommand};
use node_runtime::{
    Clock, HealthReporter, Node, NodeError, Publisher, RealClock, ScopedDomain, Subscriber, Tick, Woken,
};

/// [`Goal`] as a later version might define it: same service, same size.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Goal/v2")]
struct LaterGoal {
    words: [u64; 8],
}

impl Message for LaterGoal {
    const SERVICE: &'static str = Goal::SERVICE;
    const TYPE_NAME: &'static str = "cncbf/Goal/v2";
}

#[test]
fn a_message_arrives_intact() {
    let domain = ScopedDomain::new();
    let receiver = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = receiver.subscriber::<Goal>().unwrap();
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let port = sender.publisher::<Goal>().unwrap();
    assert_eq!(goals.newest(), None);
    port.send(&goal(7)).unwrap();
    assert_eq!(goals.newest(), Some(goal(7)));
    assert_eq!(goals.newest(), None);
}

#[test]
fn instances_do_not_hear_each_other() {
    let domain = ScopedDomain::new();
    let one = Node::open_in(&domain, "one", ProcessId::Nominal).unwrap();
    let two = Node::open_in(&domain, "two", ProcessId::Nominal).unwrap();
    let mut heard_by_two = two.subscriber::<Goal>().unwrap();
    one.publisher::<Goal>().unwrap().send(&goal(1)).unwrap();
    assert_eq!(heard_by_two.newest(), None);
}

#[test]
fn a_late_joiner_gets_the_last_sample() {
    let domain = ScopedDomain::new();
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let port = sender.publisher::<Goal>().unwrap();
    port.send(&goal(1)).unwrap();
    port.send(&goal(2)).unwrap();
    let receiver = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = receiver.subscriber::<Goal>().unwrap();
    port.send(&goal(3)).unwrap();
    assert_eq!(sequences(&mut goals), [2, 3]);
}

#[test]
fn a_rarely_sent_message_reaches_late_joiners_without_another_sending() {
    let domain = ScopedDomain::new();
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let port = sender.publisher::<Goal>().unwrap();
    port.send(&goal(1)).unwrap();
    let receiver = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = receiver.subscriber::<Goal>().unwrap();
    assert_eq!(goals.newest(), None);
    port.serve_late_joiners().unwrap();
    assert_eq!(goals.newest(), Some(goal(1)));
    port.serve_late_joiners().unwrap();
    assert_eq!(goals.newest(), None);
}

#[test]
fn a_full_queue_keeps_the_newest_in_order() {
    let domain = ScopedDomain::new();
    let receiver = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let (mut few, mut all) =
        (receiver.subscriber::<Goal>().unwrap(), receiver.subscriber_all::<Goal>().unwrap());
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let port = sender.publisher::<Goal>().unwrap();
    for sequence in 1..=1_000 {
        port.send(&goal(sequence)).unwrap();
    }
    assert_eq!(sequences(&mut few), (993..=1_000).collect::<Vec<_>>());
    assert_eq!(sequences(&mut all), (745..=1_000).collect::<Vec<_>>());
    port.send(&goal(1_001)).unwrap();
    port.send(&goal(1_002)).unwrap();
    assert_eq!(few.newest(), Some(goal(1_002)));
    assert_eq!(few.failures(), 0);
}

#[test]
fn a_wait_for_less_than_the_shortest_time_ends() {
    let domain = ScopedDomain::new();
    let sleeper = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let wake_up = sleeper.wake_up().unwrap();
    // In a thread of its own: what would hang is the wait itself.
    let waits = std::thread::spawn(move || {
        [0, 1, 999, 1_000].map(|timeout_ns| wake_up.wait(Duration::from_nanos(timeout_ns)))
    });
    for _ in 0..1_000 {
        if waits.is_finished() {
            assert_eq!(waits.join().unwrap(), [Woken::TimedOut; 4]);
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("a wait without time has not ended in 10 s");
}

#[test]
fn wake_up_by_notify_and_by_timeout() {
    let domain = ScopedDomain::new();
    let sleeper = Node::open_in(&domain, "demo", ProcessId::Estimator).unwrap();
    let wake_up = sleeper.wake_up().unwrap();
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let waker = sender.waker(ProcessId::Estimator).unwrap();
    assert_eq!(wake_up.wait(Duration::from_millis(1)), Woken::TimedOut);
    waker.wake();
    waker.wake();
    assert_eq!(wake_up.wait(Duration::from_secs(10)), Woken::Notified);
    assert_eq!(wake_up.wait(Duration::from_millis(1)), Woken::TimedOut);
}

#[test]
fn a_wait_until_a_time_does_not_end_before_it() {
    let domain = ScopedDomain::new();
    let sleeper = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let wake_up = sleeper.wake_up().unwrap();
    for sleep_ns in [0, 1, 50_000, 1_300_000, 4_000_001] {
        let due_ns = RealClock.now_ns() + sleep_ns;
        assert_eq!(wake_up.wait_until(due_ns), Woken::TimedOut);
        assert!(RealClock.now_ns() >= due_ns, "asked for {sleep_ns} ns");
    }
    let waker = sleeper.waker(ProcessId::Filter).unwrap();
    waker.wake();
    assert_eq!(wake_up.wait_until(0), Woken::Notified, "a due time that has passed hides no wake-up");
}

#[test]
fn a_look_collects_a_wake_up_without_sleeping() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let (wake_up, waker) = (node.wake_up().unwrap(), node.waker(ProcessId::Filter).unwrap());
    assert_eq!(wake_up.look(), Woken::TimedOut);
    waker.wake();
    assert_eq!(wake_up.look(), Woken::Notified);
    assert_eq!(wake_up.look(), Woken::TimedOut);
}

#[test]
fn a_wake_up_is_heard_whatever_a_look_beside_a_busy_waker_left_behind() {
    let domain = ScopedDomain::new();
    let sleeper = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let (wake_up, waker) = (sleeper.wake_up().unwrap(), sleeper.waker(ProcessId::Filter).unwrap());
    for round in 0..500 {
        std::thread::scope(|scope| {
            let busy = scope.spawn(|| (0..200).for_each(|_| waker.wake()));
            while !busy.is_finished() {
                wake_up.look();
            }
        });
        waker.wake();
        assert_eq!(wake_up.wait(PATIENCE), Woken::Notified, "in round {round}");
    }
}

#[test]
fn another_version_of_a_type_is_refused_by_name() {
    let domain = ScopedDomain::new();
    let ours = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let _port = ours.publisher::<Goal>().unwrap();
    let theirs = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let error = theirs.subscriber::<LaterGoal>().unwrap_err();
    assert!(matches!(error, NodeError::OtherType { expected: "cncbf/Goal/v2", .. }), "{error:?}");
    assert!(error.to_string().contains("demo/goal"), "{error}");
}

#[test]
fn a_second_living_writer_is_refused_by_name() {
    let domain = ScopedDomain::new();
    let first = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let _port = first.publisher::<SafeCommand>().unwrap();
    let second = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let refusal = second.publisher::<SafeCommand>().unwrap_err();
    assert!(matches!(refusal, NodeError::Taken { role: "writer", .. }), "{refusal:?}");
    assert!(refusal.to_string().contains("demo/safe_command"), "{refusal}");
    let other_stack = Node::open_in(&domain, "demo2", ProcessId::Filter).unwrap();
    other_stack.publisher::<SafeCommand>().unwrap();
}

#[test]
fn names_that_cannot_be_part_of_a_service_are_refused() {
    let domain = ScopedDomain::new();
    for refused in ["", "a/b", "a b", &"x".repeat(65)] {
        let error = Node::open_in(&domain, refused, ProcessId::Filter).unwrap_err();
        assert!(matches!(error, NodeError::InvalidInstance { .. }), "{error:?}");
    }
}

#[test]
fn health_has_many_writers_and_at_most_five_reports_a_second() {
    let domain = ScopedDomain::new();
    let launcher = Node::open_in(&domain, "demo", ProcessId::Launcher).unwrap();
    let mut reports = launcher.subscriber_all::<Health>().unwrap();
    let filter = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
    let bridge = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let mut of_filter = HealthReporter::new(&filter).unwrap();
    let mut of_bridge = HealthReporter::new(&bridge).unwrap();
    for cycle in 1..=250_u64 {
        let due_ns = cycle * 4_000_000;
        of_filter.cycle(&Tick { skipped: cycle % 2, ..Tick::timer(due_ns, due_ns + cycle) });
        of_filter.report(due_ns + cycle);
    }
    of_bridge.refused(messages::Reason::MalformedInput);
    of_bridge.report_now(1);

    let mut seen = Vec::new();
    reports.drain(|health| seen.push(*health));
    let (filters, bridges): (Vec<_>, Vec<_>) =
        seen.into_iter().partition(|health| health.process == ProcessId::Filter.code());
    assert_eq!(filters.len(), 5);
    assert_eq!(bridges.len(), 1);
    assert_eq!(
        (bridges[0].refused_inputs, bridges[0].last_reason),
        (1, messages::Reason::MalformedInput.code())
    );
    let counters = of_filter.counters();
    assert_eq!((counters.cycles, counters.missed_deadlines, counters.max_lateness_ns), (250, 125, 250));
}

#[test]
fn ports_may_move_to_the_thread_that_uses_them() {
    fn movable<T: Send>() {}
    movable::<Publisher<Goal>>();
    movable::<Subscriber<Goal>>();
    movable::<node_runtime::WakeUp>();
    movable::<node_runtime::Waker>();
    movable::<Node>();
}

fn sequences(goals: &mut Subscriber<Goal>) -> Vec<u64> {
    let mut seen = Vec::new();
    goals.drain(|message| seen.push(message.stamp.sequence));
    seen
}
