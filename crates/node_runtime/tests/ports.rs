//! What ports promise, between two nodes of one process.

use std::time::Duration;

use messages::{Goal, ProcessId, Stamp};
use node_runtime::{Domain, Node, Woken};

fn goal(sequence: u64) -> Goal {
    let stamp = Stamp { sequence, source_ns: 1, valid_at_ns: 2, ingress_ns: 3, published_ns: 4 };
    Goal { stamp, position_in_odom_m: [0.5, -(sequence as f64)], heading_rad: 0.25 }
}

#[test]
fn a_message_arrives_intact() {
    let domain = Domain::isolated();
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
fn a_late_joiner_gets_the_last_sample() {
    let domain = Domain::isolated();
    let sender = Node::open_in(&domain, "demo", ProcessId::Bridge).unwrap();
    let port = sender.publisher::<Goal>().unwrap();
    port.send(&goal(1)).unwrap();
    port.send(&goal(2)).unwrap();
    let receiver = Node::open_in(&domain, "demo", ProcessId::Nominal).unwrap();
    let mut goals = receiver.subscriber::<Goal>().unwrap();
    // The publisher notices the new reader at its next sending; history comes with it.
    port.send(&goal(3)).unwrap();
    let mut seen = Vec::new();
    goals.drain(|message| seen.push(message.stamp.sequence));
    assert_eq!(seen, [2, 3]);
}

#[test]
fn wake_up_by_notify_and_by_timeout() {
    let domain = Domain::isolated();
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
fn a_rarely_sent_message_reaches_late_joiners_without_another_sending() {
    let domain = Domain::isolated();
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
