//! The simulated crowd as a source: people who ignore the robot, and a robot that obeys the filter.
//!
//! Lives here: the world in step with the stack clock, and what is published when. Who is seen, and how wrongly, is in
//! `sensor`.

use std::collections::VecDeque;

use crowd_sim::{
    CrowdKind, GenerateError, PlantSettings, Rectangle, RobotStart, Scenario, ScenarioFileError,
    ScenarioRequest, World, WorldError, read_scenario,
};
use messages::{Detections, Goal, RobotState, SafeCommand, SourceKind, SourceStatus, Stamp};
use settings::{RobotKind, Settings};

use crate::command_sink::{CommandSink, Obedience, SinkState};
use crate::sensor::Sensor;
use crate::source::{BridgeEvent, Source};

const NS_PER_MS: u64 = 1_000_000;
const S_PER_NS: f64 = 1e-9;
/// Goals of each person, walked in a circle.
const GOALS_PER_PERSON: usize = 3;
/// Radius within which a person's goal counts as reached, m.
const PERSON_GOAL_RADIUS_M: f64 = 0.3;
/// The goal is repeated this often, for controllers that start late.
const GOAL_PERIOD_NS: u64 = 1_000 * NS_PER_MS;

/// Why a simulation cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// No scenario fits the settings.
    #[error("simulation: {0}")]
    Scenario(#[from] GenerateError),
    /// The robot cannot be simulated.
    #[error("simulation: {0}")]
    World(#[from] WorldError),
    /// The scenario that the settings name cannot be had.
    #[error("simulation.scenario: {0}")]
    File(#[from] ScenarioFileError),
}

/// A [`crowd_sim::World`] in step with the stack clock.
pub struct SimulatedCrowd {
    world: World,
    sink: CommandSink,
    kind: RobotKind,
    goal: [f64; 3],
    sensor: Sensor,
    latency_ns: u64,
    /// Frames that have not arrived yet, each with the world time it was measured at, ns. Has room for all there can be.
    on_their_way: VecDeque<(u64, Detections)>,
    step_ns: u64,
    state_period_ns: u64,
    detections_period_ns: u64,
    timeout_ns: u64,
    /// Stack time of world time zero; set when the source is first polled.
    origin_ns: Option<u64>,
    next_state_ns: u64,
    next_look_ns: u64,
    next_goal_ns: u64,
    sequences: [u64; 3],
    accepted: u64,
}

impl SimulatedCrowd {
    /// Takes the scenario that `settings.simulation` names or draws one, and puts everybody in place. The robot obeys the
    /// filter.
    ///
    /// # Errors
    /// [`SimulationError`] if people or robot cannot be simulated as asked.
    pub fn new(settings: &Settings) -> Result<Self, SimulationError> {
        Self::with_robot_obeying(settings, Obedience::Filter)
    }

    /// The same with a robot that obeys `whom`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_robot_obeying(settings: &Settings, whom: Obedience) -> Result<Self, SimulationError> {
        Ok(Self::in_scenario(settings, &simulated_scenario(settings)?, whom)?)
    }

    /// Puts everybody in place as `scenario` says, whatever scenario `settings.simulation` names; robot, periods and sensor are
    /// those of the settings. The robot obeys `whom`.
    ///
    /// # Errors
    /// [`WorldError`] if people or robot cannot be simulated.
    pub fn in_scenario(
        settings: &Settings,
        scenario: &Scenario,
        whom: Obedience,
    ) -> Result<Self, WorldError> {
        let simulation = &settings.simulation;
        let [x, y] = scenario.goal_m;
        let latency_ms = simulation.sensing.as_ref().map_or(0, |sensing| sensing.latency_ms);
        let most_on_their_way = (latency_ms / simulation.detections_period_ms) as usize + 2;
        Ok(Self {
            world: World::new(scenario, PlantSettings::of(settings))?,
            sink: CommandSink::obeying(settings, whom),
            kind: settings.robot.kind,
            goal: [x, y, scenario.goal_heading_rad],
            sensor: Sensor::new(simulation, scenario),
            latency_ns: latency_ms * NS_PER_MS,
            on_their_way: VecDeque::with_capacity(most_on_their_way),
            step_ns: simulation.step_ms * NS_PER_MS,
            state_period_ns: simulation.robot_state_period_ms * NS_PER_MS,
            detections_period_ns: simulation.detections_period_ms * NS_PER_MS,
            timeout_ns: (scenario.time_limit_s * 1e9) as u64,
            origin_ns: None,
            next_state_ns: 0,
            next_look_ns: 0,
            next_goal_ns: 0,
            sequences: [0; 3],
            accepted: 0,
        })
    }

    /// The world as it is.
    pub const fn world(&self) -> &World {
        &self.world
    }

    /// Steps the world, command by command, until it has caught up with `world_ns`.
    fn advance(&mut self, world_ns: u64, origin_ns: u64) {
        while self.world.time_ns() + self.step_ns <= world_ns {
            let robot = self.world.robot();
            let velocity = match self.kind {
                RobotKind::Unicycle => robot.body_velocity_mps(),
                RobotKind::DoubleIntegrator => robot.velocity_mps,
            };
            let now_ns = origin_ns + self.world.time_ns() + self.step_ns;
            let control = self.sink.control(now_ns, self.step_ns, velocity);
            // The sink's commands are finite and the step is a checked setting; a refused step leaves the world as it is.
            if let Err(error) = self.world.step(self.step_ns as f64 * S_PER_NS, control) {
                tracing::error!(%error, "the world was not stepped");
                return;
            }
        }
    }

    fn stamp(&mut self, which: usize, world_ns: u64, origin_ns: u64, now_ns: u64) -> Stamp {
        self.sequences[which] += 1;
        self.accepted += 1;
        Stamp {
            sequence: self.sequences[which],
            source_ns: world_ns,
            valid_at_ns: origin_ns + world_ns,
            ingress_ns: now_ns,
            published_ns: 0,
        }
    }

    fn robot_state(&mut self, world_ns: u64, origin_ns: u64, now_ns: u64) -> RobotState {
        let stamp = self.stamp(0, world_ns, origin_ns, now_ns);
        let robot = self.world.robot();
        RobotState {
            stamp,
            position_in_odom_m: robot.position_m,
            heading_rad: robot.heading_rad,
            velocity_in_base_mps: robot.body_velocity_mps(),
            yaw_rate_radps: robot.yaw_rate_radps,
        }
    }

    fn look(&mut self, world_ns: u64) {
        self.on_their_way.push_back((world_ns, self.sensor.look(&self.world)));
    }

    /// World time at which the next frame arrives, ns.
    fn next_arrival_ns(&self) -> u64 {
        self.on_their_way.front().map_or(u64::MAX, |(measured_ns, _)| measured_ns + self.latency_ns)
    }

    fn arrival(&mut self, origin_ns: u64, now_ns: u64) -> Option<Detections> {
        let (measured_ns, frame) = self.on_their_way.pop_front()?;
        Some(Detections { stamp: self.stamp(1, measured_ns, origin_ns, now_ns), ..frame })
    }

    fn goal(&mut self, world_ns: u64, origin_ns: u64, now_ns: u64) -> Goal {
        let stamp = self.stamp(2, world_ns, origin_ns, now_ns);
        let [x, y, heading_rad] = self.goal;
        Goal { stamp, position_in_odom_m: [x, y], heading_rad }
    }

    /// World time at which there is something to do next, ns.
    fn next_event_ns(&self) -> u64 {
        self.next_state_ns.min(self.next_look_ns).min(self.next_arrival_ns()).min(self.next_goal_ns)
    }

    fn timed_out(&self) -> bool {
        self.world.time_ns() >= self.timeout_ns
    }
}

impl Source for SimulatedCrowd {
    fn next_due_ns(&self) -> Option<u64> {
        (!self.timed_out()).then(|| self.origin_ns.unwrap_or(0) + self.next_event_ns())
    }

    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        let origin_ns = *self.origin_ns.get_or_insert(now_ns);
        if self.timed_out() {
            return None;
        }
        loop {
            let event_ns = self.next_event_ns();
            if origin_ns + event_ns > now_ns {
                return None;
            }
            self.advance(event_ns, origin_ns);
            if self.next_state_ns == event_ns {
                self.next_state_ns += self.state_period_ns;
                return Some(BridgeEvent::RobotState(self.robot_state(event_ns, origin_ns, now_ns)));
            }
            if self.next_look_ns == event_ns {
                self.next_look_ns += self.detections_period_ns;
                self.look(event_ns);
            }
            if self.next_arrival_ns() == event_ns {
                return self.arrival(origin_ns, now_ns).map(BridgeEvent::Detections);
            }
            if self.next_goal_ns == event_ns {
                self.next_goal_ns += GOAL_PERIOD_NS;
                return Some(BridgeEvent::Goal(self.goal(event_ns, origin_ns, now_ns)));
            }
        }
    }

    fn command(&mut self, command: &SafeCommand, now_ns: u64) {
        self.sink.take(command, now_ns);
    }

    fn status(&self, now_ns: u64) -> SourceStatus {
        let ledger = self.world.ledger();
        SourceStatus {
            published_ns: now_ns,
            elapsed_ns: self.world.time_ns(),
            total_ns: self.timeout_ns,
            accepted: self.accepted,
            refused: self.sink.refusals(),
            min_clearance_m: ledger.min_clearance_m(),
            clearance_m: ledger.clearance_m(),
            path_length_m: ledger.path_length_m(),
            goal_distance_m: self.world.goal_distance_m(),
            collisions: ledger.collisions(),
            goal_reached: u32::from(self.world.reached()),
            finished: u32::from(self.timed_out()),
            kind: SourceKind::Simulation.code(),
        }
    }

    fn sink_state(&self) -> Option<SinkState> {
        Some(self.sink.state())
    }
}

/// The scenario that `settings.simulation` names, or else the one that it draws.
///
/// # Errors
/// [`SimulationError`] if the file cannot be had or the people have no room.
pub fn simulated_scenario(settings: &Settings) -> Result<Scenario, SimulationError> {
    let simulation = &settings.simulation;
    if let Some(named) = &simulation.scenario {
        return Ok(read_scenario(&named.file, named.name.as_deref())?);
    }
    let [x_min, y_min] = simulation.arena_min_m;
    let [x_max, y_max] = simulation.arena_max_m;
    let [start_x, start_y, start_heading] = simulation.start;
    let [goal_x, goal_y, goal_heading_rad] = simulation.goal;
    let drawn = ScenarioRequest {
        seed: simulation.seed,
        crowd: CrowdKind::SocialForce,
        count: simulation.people,
        classes: simulation.classes,
        arena: Rectangle { x_m: [x_min, x_max], y_m: [y_min, y_max] },
        desired_speed_mps: simulation.desired_speed_mps,
        goals_per_person: GOALS_PER_PERSON,
        goal_radius_m: PERSON_GOAL_RADIUS_M,
        person_radius_m: simulation.person_radius_m,
        clear_of_start_m: simulation.start_clearance_m,
        start: RobotStart { position_m: [start_x, start_y], heading_rad: start_heading },
        goal_m: [goal_x, goal_y],
        goal_tolerance_m: settings.nominal.goal_tolerance_m,
        time_limit_s: simulation.timeout_s,
        robot_radius_m: settings.robot.radius_m,
    }
    .generate()?;
    Ok(Scenario { goal_heading_rad, ..drawn })
}
