//! The world: a robot among people, stepped by the caller.
//!
//! Lives here: the common clock of robot and crowd. People move on their own 100 Hz grid and are interpolated in
//! between: exactly for those who walk by forces, because the crowd's integrator moves them along straight lines, and to a
//! fraction of a millimetre for the others.

use settings::ClassName;

use crate::crowd::{CROWD_PERIOD_NS, Crowd};
use crate::ledger::RunLedger;
use crate::person::Person;
use crate::plant::{Plant, PlantError, PlantSettings, RobotState};
use crate::scenario::Scenario;
use crate::scenario_error::ScenarioError;
use crate::social_force::SocialForce;

/// Longest step, s: beyond it a command held constant says nothing about a robot.
const MAX_STEP_S: f64 = 1.0;

/// One person as an ideal sensor sees them. Everything in `odom`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PersonState {
    /// Place in the scenario's list.
    pub index: usize,
    /// Identity, from the scenario.
    pub id: u64,
    /// Centre, m.
    pub position_m: [f64; 2],
    /// Velocity, m/s.
    pub velocity_mps: [f64; 2],
    /// Radius, m.
    pub radius_m: f64,
    /// What they are.
    pub class: ClassName,
}

/// What does not change about a person.
#[derive(Debug, Clone, Copy)]
struct Body {
    id: u64,
    radius_m: f64,
    class: ClassName,
}

/// Why a world was not stepped. Its state is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The step is not a positive number of nanoseconds up to one second.
    #[error("a step of {dt_s} s cannot be taken; give a positive one of at most 1 s")]
    BadStep {
        /// The step asked for, s.
        dt_s: f64,
    },
    /// The command holds a NaN or an infinity.
    #[error("control {control:?} is not finite; brake instead")]
    NonFiniteControl {
        /// The command.
        control: [f64; 2],
    },
}

/// Why a world could not be built.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// See [`ScenarioError`].
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// See [`PlantError`].
    #[error(transparent)]
    Plant(#[from] PlantError),
}

/// A robot among people.
#[derive(Debug, Clone)]
pub struct World {
    time_ns: u64,
    goal_m: [f64; 2],
    goal_tolerance_m: f64,
    robot_radius_m: f64,
    plant: Plant,
    crowd: Crowd,
    /// Everybody, in the scenario's order.
    bodies: Vec<Body>,
    /// World time of the crowd's newest state, never before `time_ns`.
    crowd_time_ns: u64,
    /// Where people were one crowd period before `crowd_time_ns`, m; `None` for those who were absent.
    crowd_before_m: Vec<Option<[f64; 2]>>,
    /// Those who are present at `time_ns`; has room for everybody.
    people: Vec<PersonState>,
    ledger: RunLedger,
}

impl Body {
    const fn of(person: &Person) -> Self {
        Self { id: person.id, radius_m: person.radius_m, class: person.class }
    }
}

impl World {
    /// Sets everybody up at time zero, the robot at rest. Where the scenario states limits of the robot, they take the place of
    /// the plant's.
    ///
    /// # Errors
    /// See [`WorldError`].
    pub fn new(scenario: &Scenario, plant: PlantSettings) -> Result<Self, WorldError> {
        scenario.validate()?;
        let crowd = Crowd::new(SocialForce::HUNAVSIM, scenario.arena, &scenario.people);
        let mut plant = plant;
        if let Some(limits) = &scenario.robot_limits {
            plant.actuator_limits = limits.inputs();
            plant.axis_speed_limit_mps = limits.axis_speed_mps.or(plant.axis_speed_limit_mps);
        }
        let everybody = scenario.people.len();
        let mut world = Self {
            time_ns: 0,
            goal_m: scenario.goal_m,
            goal_tolerance_m: scenario.goal_tolerance_m,
            robot_radius_m: scenario.robot_radius_m,
            plant: Plant::new(plant, scenario.start)?,
            crowd_time_ns: 0,
            crowd_before_m: vec![None; everybody],
            ledger: RunLedger::new(scenario.start.position_m, everybody),
            bodies: scenario.people.iter().map(Body::of).collect(),
            crowd,
            people: Vec::with_capacity(everybody),
        };
        world.place_people(0.0);
        world.note();
        Ok(world)
    }

    /// Advances robot and people by `dt_s` (s, rounded to whole ns), the robot under `control` held constant.
    ///
    /// `control` is clipped to the actuators: `[speed, yaw rate]` in m/s and rad/s for the unicycle, acceleration
    /// `[x, y]` in m/s² for the double integrator. Long steps are divided at the crowd's own ticks, so no contact is
    /// stepped over. Allocates nothing.
    ///
    /// # Errors
    /// See [`StepError`]; the world then has not moved.
    pub fn step(&mut self, dt_s: f64, control: [f64; 2]) -> Result<(), StepError> {
        let dt_ns = (dt_s * 1e9).round();
        if !(dt_ns >= 1.0 && dt_s <= MAX_STEP_S) {
            return Err(StepError::BadStep { dt_s });
        }
        if !control.iter().all(|input| input.is_finite()) {
            return Err(StepError::NonFiniteControl { control });
        }
        let end_ns = self.time_ns + dt_ns as u64;
        while self.time_ns < end_ns {
            let crowd_tick_ns = (self.time_ns / CROWD_PERIOD_NS + 1) * CROWD_PERIOD_NS;
            self.advance_to(end_ns.min(crowd_tick_ns), control);
        }
        Ok(())
    }

    /// Advances to `time_ns`, at most up to the crowd's next tick.
    fn advance_to(&mut self, time_ns: u64, control: [f64; 2]) {
        self.plant.step((time_ns - self.time_ns) as f64 * 1e-9, control);
        self.time_ns = time_ns;
        if time_ns > self.crowd_time_ns {
            for (before_m, walker) in self.crowd_before_m.iter_mut().zip(self.crowd.walkers()) {
                *before_m = walker.is_present.then_some(walker.position_m);
            }
            self.crowd.step(CROWD_PERIOD_NS as f64 * 1e-9);
            self.crowd_time_ns += CROWD_PERIOD_NS;
        }
        self.place_people((self.crowd_time_ns - time_ns) as f64 / CROWD_PERIOD_NS as f64);
        self.note();
    }

    /// Says where people are `remaining` crowd periods (0 to 1) before the crowd's newest state. Between two ticks only those
    /// are present who are at both.
    fn place_people(&mut self, remaining: f64) {
        self.people.clear();
        let everybody = self.crowd.walkers().iter().zip(&self.crowd_before_m).zip(&self.bodies);
        for (index, ((walker, before_m), &Body { id, radius_m, class })) in everybody.enumerate() {
            if !walker.is_present || (remaining > 0.0 && before_m.is_none()) {
                continue;
            }
            let before_m = before_m.unwrap_or(walker.position_m);
            let position_m =
                [0, 1].map(|k| walker.position_m[k] - remaining * (walker.position_m[k] - before_m[k]));
            let velocity_mps = walker.velocity_mps;
            self.people.push(PersonState { index, id, position_m, velocity_mps, radius_m, class });
        }
    }

    fn note(&mut self) {
        let position_m = self.plant.state().position_m;
        let robot_radius_m = self.robot_radius_m;
        let clearances_m = self.people.iter().map(|person| {
            let [dx, dy] = [person.position_m[0] - position_m[0], person.position_m[1] - position_m[1]];
            (person.index, dx.hypot(dy) - person.radius_m - robot_radius_m)
        });
        self.ledger.note_clearances(self.time_ns, clearances_m);
        let at_goal = self.goal_distance_m() <= self.goal_tolerance_m;
        self.ledger.note_robot(self.time_ns, position_m, at_goal);
    }

    /// World time since the start, ns.
    pub fn time_ns(&self) -> u64 {
        self.time_ns
    }

    /// The robot now.
    pub fn robot(&self) -> &RobotState {
        self.plant.state()
    }

    /// Radius of the robot, m.
    pub fn robot_radius_m(&self) -> f64 {
        self.robot_radius_m
    }

    /// Everybody who is present now, in the scenario's order.
    pub fn people(&self) -> &[PersonState] {
        &self.people
    }

    /// Clearance, contacts, path length and arrival so far.
    pub fn ledger(&self) -> &RunLedger {
        &self.ledger
    }

    /// Where the robot has to go, m.
    pub fn goal_m(&self) -> [f64; 2] {
        self.goal_m
    }

    /// Distance of the robot's centre from its goal now, m.
    pub fn goal_distance_m(&self) -> f64 {
        let [x, y] = self.plant.state().position_m;
        (self.goal_m[0] - x).hypot(self.goal_m[1] - y)
    }

    /// Whether the goal has been reached, now or before.
    pub fn reached(&self) -> bool {
        self.ledger.reached_at_ns().is_some()
    }
}
