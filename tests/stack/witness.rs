//! Somebody who hears everything a running stack says, and disturbs nothing.

use std::time::Duration;

use messages::{ProcessId, RobotState, SafeCommand, SafetyStatus};
use node_runtime::{Clock, Domain, Node, RealClock, Subscriber};

/// Longest wait for anything. Generous: it only has to end a test that has failed.
const PATIENCE_NS: u64 = 40_000_000_000;
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(2);
/// Commands in a row that must be filtered before a stack counts as driving.
const CALM_COMMANDS: usize = 25;

/// Keeps every command and every robot state of one stack.
pub(crate) struct Witness {
    // Declared, hence dropped, before the node they belong to.
    command_port: Subscriber<SafeCommand>,
    state_port: Subscriber<RobotState>,
    _node: Node,
    /// Every safe command so far.
    pub(crate) commands: Vec<SafeCommand>,
    /// Every robot state so far.
    pub(crate) states: Vec<RobotState>,
}

impl Witness {
    /// Joins the stack `instance` of `domain`, which need not run yet. Drop it before the stack ends: whoever lives keeps a
    /// launcher from clearing shared memory.
    pub(crate) fn join(domain: &Domain, instance: &str) -> Self {
        let node = Node::open_in(domain, instance, ProcessId::Launcher).expect("a node");
        Self {
            command_port: node.subscriber_all().expect("a reader of safe commands"),
            state_port: node.subscriber_all().expect("a reader of robot states"),
            _node: node,
            commands: Vec::new(),
            states: Vec::new(),
        }
    }

    /// Listens until `met` is content with what was said so far.
    pub(crate) fn watch_until(&mut self, what: &str, mut met: impl FnMut(&Self) -> bool) {
        let give_up_ns = RealClock.now_ns() + PATIENCE_NS;
        loop {
            let Self { commands, states, .. } = self;
            self.command_port.drain(|command| commands.push(*command));
            self.state_port.drain(|state| states.push(*state));
            if met(self) {
                return;
            }
            assert!(
                RealClock.now_ns() < give_up_ns,
                "waited in vain for {what}; last command {:?}, last robot state {:?}",
                self.commands.last(),
                self.states.last()
            );
            std::thread::sleep(LOOK);
        }
    }

    /// Waits for a command of a cycle that began after `time_ns`.
    pub(crate) fn watch_until_a_cycle_after(&mut self, time_ns: u64) {
        self.watch_until("the filter's next cycles", |witness| {
            witness.commands.last().is_some_and(|command| command.ledger.filter_woke_ns > time_ns)
        });
    }

    /// Waits until the newest commands, all of cycles after `since_ns`, were all filtered and the robot drives. Returns when
    /// the first cycle of that unbroken row began, ns.
    pub(crate) fn watch_until_it_drives(&mut self, since_ns: u64) -> u64 {
        let mut row_began_ns = 0;
        self.watch_until("filtered commands that move the robot", |witness| {
            let filtered = SafetyStatus::Filtered.code();
            let row =
                witness.commands.iter().rev().take_while(|command| {
                    command.status == filtered && command.ledger.filter_woke_ns > since_ns
                });
            row_began_ns = row.clone().last().map_or(0, |command| command.ledger.filter_woke_ns);
            row.count() >= CALM_COMMANDS
                && witness.states.last().is_some_and(|state| state.velocity_in_base_mps[0] > 0.5)
        });
        row_began_ns
    }
}
