//! The simulated crowd under the eyes of a judge who knows the truth: contacts at two radii, and people's motion.

use crowd_sim::{CROWD_PERIOD_NS, Scenario, World};
use messages::{SafeCommand, SourceStatus};
use perception_bridge::{BridgeEvent, SimulatedCrowd, SinkState, Source};
use settings::Settings;

use crate::motion::{Bounds, Motion, Shares};

/// By how much the discs may overlap before contact counts, m: not at all, and 5 cm.
pub const ALLOWED_OVERLAPS_M: [f64; 2] = [0.0, 0.05];

/// The beginning of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// World time, ns.
    pub(crate) time_ns: u64,
    /// Who was touched.
    pub(crate) person_id: u64,
}

/// [`SimulatedCrowd`] as a source, and what really happens in it.
pub(crate) struct Watched {
    crowd: SimulatedCrowd,
    bounds: Bounds,
    noted_ns: Option<u64>,
    contacts: [Option<Contact>; 2],
    /// Everybody's identity and motion, in the scenario's order.
    motions: Vec<(u64, Motion)>,
    shares: Shares,
}

impl Watched {
    pub(crate) fn new(settings: &Settings, scenario: &Scenario, crowd: SimulatedCrowd) -> Self {
        Self {
            crowd,
            bounds: Bounds::of(settings),
            noted_ns: None,
            contacts: [None; 2],
            motions: scenario.people.iter().map(|person| (person.id, Motion::default())).collect(),
            shares: Shares::default(),
        }
    }

    /// The world.
    pub(crate) const fn world(&self) -> &World {
        self.crowd.world()
    }

    /// First contact at each of [`ALLOWED_OVERLAPS_M`].
    pub(crate) const fn contacts(&self) -> &[Option<Contact>; 2] {
        &self.contacts
    }

    /// How people moved.
    pub(crate) const fn shares(&self) -> &Shares {
        &self.shares
    }

    /// Whether person `id` left the model's bounds from `from_ns` to `to_ns`, world time.
    pub(crate) fn left_bounds_between(&self, id: u64, from_ns: u64, to_ns: u64) -> bool {
        let motion = self.motions.iter().find(|(person, _)| *person == id);
        motion.is_some_and(|(_, motion)| motion.left_between(from_ns, to_ns))
    }

    /// Looks at the world if it has moved.
    fn note(&mut self) {
        let world = self.crowd.world();
        let time_ns = world.time_ns();
        if self.noted_ns.replace(time_ns) == Some(time_ns) {
            return;
        }
        let robot_m = world.robot().position_m;
        // The velocity between two ticks is that of the coming one.
        let tick = time_ns.div_ceil(CROWD_PERIOD_NS);
        for person in world.people() {
            let (_, motion) = &mut self.motions[person.index];
            motion.note(tick, person.velocity_mps, &self.bounds, &mut self.shares);
        }
        // The ledger looks at every step, events come more rarely.
        let min_distance_m = world.ledger().min_clearance_m();
        let away_m = |position_m: [f64; 2]| (position_m[0] - robot_m[0]).hypot(position_m[1] - robot_m[1]);
        for (contact, allowed_m) in self.contacts.iter_mut().zip(ALLOWED_OVERLAPS_M) {
            if contact.is_none() && min_distance_m <= -allowed_m {
                let nearest = world
                    .people()
                    .iter()
                    .min_by(|a, b| {
                        let discs_m = [a, b].map(|person| away_m(person.position_m) - person.radius_m);
                        discs_m[0].total_cmp(&discs_m[1])
                    })
                    .map_or(0, |person| person.id);
                *contact = Some(Contact { time_ns, person_id: nearest });
            }
        }
    }
}

impl Source for Watched {
    fn next_due_ns(&self) -> Option<u64> {
        self.crowd.next_due_ns()
    }

    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        let event = self.crowd.poll(now_ns);
        self.note();
        event
    }

    fn command(&mut self, command: &SafeCommand, now_ns: u64) {
        self.crowd.command(command, now_ns);
    }

    fn status(&self, now_ns: u64) -> SourceStatus {
        self.crowd.status(now_ns)
    }

    fn sink_state(&self) -> Option<SinkState> {
        self.crowd.sink_state()
    }
}
