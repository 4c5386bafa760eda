//! The stack's part: ports, the simulated robot, and the clock that moves both.

use std::time::Duration;

use bytemuck::Zeroable;
use messages::{Goal, NominalCommand, Obstacles, ProcessId, RobotState, Stamp};
use node_runtime::{Clock, Domain, Node, Publisher, RealClock, Shutdown, Subscriber, Waker};
use settings::Settings;

use crate::candidate::Candidate;
use crate::check::KitError;
use crate::observations::{Heard, Observations, Phase, Stretch};
use crate::robot::Robot;

const NS_PER_MS: u64 = 1_000_000;
/// Robot states are sent, and the robot moves, this often, ns: 100 Hz, as in the demo.
const STEP_NS: u64 = 10 * NS_PER_MS;
/// Obstacles, of which there are none, are sent every so many steps.
const OBSTACLE_STEPS: u64 = 5;
/// A late joiner is handed the last goal every so many steps, as the bridge does.
const SERVICE_STEPS: u64 = 10;
/// The goal is said again every so many steps, as its senders do, once it has been seen whether once is enough.
const GOAL_STEPS: u64 = 100;
/// Longest pretended step of the robot, s: a machine that stood still does not make it jump.
const LONGEST_STEP_S: f64 = 0.05;

/// Robot states that the bench gives out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Feed {
    /// As they are.
    States,
    /// None.
    Nothing,
    /// With a NaN for a position.
    NotANumber,
}

/// Ports, robot and what was seen so far.
pub(crate) struct Bench {
    // Declared, hence dropped, before the node they belong to.
    states: Publisher<RobotState>,
    goals: Publisher<Goal>,
    obstacles: Publisher<Obstacles>,
    commands: Subscriber<NominalCommand>,
    /// A candidate that is driven by robot states sleeps until it is woken, as the bridge does.
    candidate: Waker,
    node: Node,
    robot: Robot,
    shutdown: Shutdown,
    goal: Goal,
    newest: Option<NominalCommand>,
    step: u64,
    moved_ns: u64,
    pub(crate) repeats_goal: bool,
    pub(crate) seen: Observations,
}

impl Bench {
    /// Opens the stack's services in `domain`, so that the candidate finds them.
    pub(crate) fn open(
        domain: &Domain,
        instance: &str,
        settings: &Settings,
        shutdown: Shutdown,
    ) -> Result<Self, KitError> {
        let node = Node::open_in(domain, instance, ProcessId::Launcher)?;
        Ok(Self {
            states: node.publisher()?,
            goals: node.publisher()?,
            obstacles: node.publisher()?,
            commands: node.subscriber_all()?,
            candidate: node.waker(ProcessId::Nominal)?,
            node,
            robot: Robot::new(settings)?,
            shutdown,
            goal: Goal::zeroed(),
            newest: None,
            step: 0,
            moved_ns: RealClock.now_ns(),
            repeats_goal: false,
            seen: Observations::default(),
        })
    }

    /// Sets the goal `distance_m` away from the robot, `bearing_rad` left of where it looks, and says so once.
    pub(crate) fn set_goal(&mut self, distance_m: f64, bearing_rad: f64) {
        let ([x, y], heading_rad) = self.robot.pose();
        let direction_rad = heading_rad + bearing_rad;
        let (sin, cos) = direction_rad.sin_cos();
        self.goal.position_in_odom_m = [x + distance_m * cos, y + distance_m * sin];
        self.goal.heading_rad = sin.atan2(cos);
        self.send_goal();
    }

    /// Says the goal.
    pub(crate) fn send_goal(&mut self) {
        self.goal.stamp = stamp(self.goal.stamp.sequence + 1, RealClock.now_ns());
        if let Err(error) = self.goals.send(&self.goal) {
            tracing::warn!(%error, "a goal did not leave the bench");
        }
    }

    /// Distance from the robot to its goal, m.
    pub(crate) fn distance_m(&self) -> f64 {
        let ([x, y], _) = self.robot.pose();
        (self.goal.position_in_odom_m[0] - x).hypot(self.goal.position_in_odom_m[1] - y)
    }

    /// Whether a place for a nominal controller is free.
    pub(crate) fn place_is_free(&self) -> bool {
        self.node.publisher::<NominalCommand>().is_ok()
    }

    /// Goes on until `met` is content or `limit_s` is over, or the candidate has ended. Returns whether `met` was content.
    pub(crate) fn play(
        &mut self,
        candidate: &mut Candidate,
        phase: Phase,
        feed: Feed,
        limit_s: f64,
        mut met: impl FnMut(&Self) -> bool,
    ) -> Result<bool, KitError> {
        let start_ns = RealClock.now_ns();
        let mut due_ns = start_ns;
        let outcome = loop {
            if self.shutdown.requested() {
                return Err(KitError::Interrupted);
            }
            self.cycle(phase, feed);
            if met(self) {
                break true;
            }
            if self.seen.ended_early.is_none()
                && let Some(status) = candidate.ended()
            {
                self.seen.ended_early = Some((status.to_string(), phase));
            }
            let now_ns = RealClock.now_ns();
            if self.seen.ended_early.is_some() || (now_ns - start_ns) as f64 * 1e-9 >= limit_s {
                break false;
            }
            due_ns = (due_ns + STEP_NS).max(now_ns);
            std::thread::sleep(Duration::from_nanos(due_ns - now_ns));
        };
        self.seen.stretches.push(Stretch { phase, start_ns, end_ns: RealClock.now_ns() });
        Ok(outcome)
    }

    /// Takes what was said, moves the robot, says where it is.
    fn cycle(&mut self, phase: Phase, feed: Feed) {
        let now_ns = RealClock.now_ns();
        let (seen, newest) = (&mut self.seen, &mut self.newest);
        self.commands.drain(|command| {
            // Read per command: one sent while this step began would seem to come from the future.
            seen.heard.push(Heard { command: *command, received_ns: RealClock.now_ns(), phase });
            *newest = Some(*command);
        });
        let dt_s = ((now_ns - self.moved_ns) as f64 * 1e-9).min(LONGEST_STEP_S);
        self.moved_ns = now_ns;
        if dt_s > 0.0 {
            // Without a robot state the filter would brake, whatever the candidate says.
            let obeyed = self.newest.as_ref().filter(|_| feed == Feed::States);
            self.robot.step(dt_s, obeyed, now_ns);
        }
        self.step += 1;
        match feed {
            Feed::Nothing => {}
            Feed::States => self.send_state([0.0; 2]),
            Feed::NotANumber => self.send_state([f64::NAN; 2]),
        }
        if self.step.is_multiple_of(OBSTACLE_STEPS) {
            let obstacles =
                Obstacles { stamp: stamp(self.step / OBSTACLE_STEPS, now_ns), ..Obstacles::zeroed() };
            if let Err(error) = self.obstacles.send(&obstacles) {
                tracing::warn!(%error, "obstacles did not leave the bench");
            }
        }
        if self.repeats_goal && self.step.is_multiple_of(GOAL_STEPS) {
            self.send_goal();
        }
        if self.step.is_multiple_of(SERVICE_STEPS)
            && let Err(error) = self.goals.serve_late_joiners()
        {
            tracing::warn!(%error, "a late joiner was not served");
        }
    }

    /// Says where the robot is, `off_m` beside it.
    fn send_state(&mut self, off_m: [f64; 2]) {
        let mut state = self.robot.state(stamp(self.step, RealClock.now_ns()));
        let [x, y] = state.position_in_odom_m;
        state.position_in_odom_m = [x + off_m[0], y + off_m[1]];
        match self.states.send(&state) {
            Ok(()) => {
                self.candidate.wake();
                self.seen.sent.push(state);
            }
            Err(error) => tracing::warn!(%error, "a robot state did not leave the bench"),
        }
    }
}

/// A stamp of something that was measured just now.
const fn stamp(sequence: u64, now_ns: u64) -> Stamp {
    Stamp { sequence, source_ns: now_ns, valid_at_ns: now_ns, ingress_ns: now_ns, published_ns: now_ns }
}
