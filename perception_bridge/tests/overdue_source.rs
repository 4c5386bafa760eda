//! A source that is never done does not keep the bridge from anything else, and one that has failed ends it.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::cell::Cell;
use std::rc::Rc;
use std::time::Duration;

use bytemuck::Zeroable;
use messages::{ProcessId, RobotState, SafeCommand, SourceStatus};
use node_runtime::{Clock, Node, Pacing, ProcessLoop, RealClock, ScopedDomain, Shutdown, Tick};
use perception_bridge::shell::BridgeProcess;
use perception_bridge::{BridgeEvent, SinkState, Source};

/// More than any cycle may hand over, few enough for a test that fails to end.
const BACKLOG: u64 = 100_000;

/// Has fallen behind the clock by a whole backlog.
struct Overdue {
    given: Rc<Cell<u64>>,
    commands: Rc<Cell<u64>>,
}

impl Source for Overdue {
    fn next_due_ns(&self) -> Option<u64> {
        Some(self.given.get())
    }

    fn poll(&mut self, _: u64) -> Option<BridgeEvent> {
        self.given.set(self.given.get() + 1);
        (self.given.get() < BACKLOG).then(|| BridgeEvent::RobotState(RobotState::zeroed()))
    }

    fn command(&mut self, _: &SafeCommand, _: u64) {
        self.commands.set(self.commands.get() + 1);
    }

    fn status(&self, _: u64) -> SourceStatus {
        SourceStatus::zeroed()
    }

    fn has_failed(&self) -> bool {
        self.given.get() >= BACKLOG
    }

    fn sink_state(&self) -> Option<SinkState> {
        None
    }
}

#[test]
fn a_command_is_taken_though_the_source_has_more_to_give() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "overdue", ProcessId::Bridge).unwrap();
    let filter = Node::open_in(&domain, "overdue", ProcessId::Filter).unwrap();
    let safe_commands = filter.publisher().unwrap();
    let (given, commands) = (Rc::new(Cell::new(0)), Rc::new(Cell::new(0)));
    let source = Overdue { given: Rc::clone(&given), commands: Rc::clone(&commands) };
    let mut bridge = BridgeProcess::open(Box::new(source), &node).unwrap();
    let mut cycles = ProcessLoop::new(&node).unwrap();
    for cycle in 1..=3 {
        safe_commands.send(&SafeCommand::zeroed()).unwrap();
        cycles.cycle(&mut bridge, &Tick::event(RealClock.now_ns()));
        assert_eq!(commands.get(), cycle);
        assert!(given.get() >= cycle && given.get() < BACKLOG / 100 * cycle, "{}", given.get());
    }
}

#[test]
fn a_source_that_has_failed_ends_the_loop() {
    let domain = ScopedDomain::new();
    let node = Node::open_in(&domain, "failed", ProcessId::Bridge).unwrap();
    let source = Overdue { given: Rc::new(Cell::new(BACKLOG - 2)), commands: Rc::default() };
    let mut bridge = BridgeProcess::open(Box::new(source), &node).unwrap();
    let shutdown = Shutdown::install().unwrap();
    let longest = Duration::from_secs(1);
    let pacing = Pacing::event(RealClock.now_ns(), longest);
    let (patience, gives_up) = (2 * longest, shutdown.clone());
    let ended = std::thread::spawn(move || {
        std::thread::park_timeout(patience);
        gives_up.request();
    });
    ProcessLoop::new(&node).unwrap().run(&mut bridge, pacing, None, None, &shutdown);
    assert!(!shutdown.requested(), "the loop ended by itself");
    ended.thread().unpark();
    ended.join().unwrap();
}
