//! The filter among `M` people, whole and in parts.

use barrier::{
    BarrierObstacle, CbfQp, CompositeBarrier, CompositeSample, HalfSpace, Kernel, NetworkBatch, QpSolution,
    ResidualNetwork,
};
use bytemuck::Zeroable;
use cbf_filter::{Inputs, SafetyFilter, load_model};
use dynamics::{InputBox, RobotObstaclePair, UnicyclePair};
use messages::{
    ControlKind, Goal, Intent, NominalCommand, Obstacle, ObstacleQuality, Obstacles, RobotState, SafeCommand,
};
use node_runtime::Tick;
use settings::{KernelChoice, Settings};

use super::{NS_PER_MS, START_NS, settings, stamp};

/// Robot poses and nominal commands that take turns, so that no branch is foreseen from the call before.
pub const VARIANTS: usize = 64;

/// Person `index` of a spiral around the robot, all inside the trained domain and at a walk.
pub fn person(index: usize) -> Obstacle {
    let (angle, distance_m) = (index as f64 * 2.4, 1.2 + 0.05 * index as f64);
    let (heading_rad, speed_mps) = (dynamics::wrap_angle(angle + 2.0), 0.6 + 0.01 * index as f64);
    Obstacle {
        track_id: index as u64 + 1,
        measured_at_ns: START_NS,
        valid_at_ns: START_NS,
        position_in_odom_m: [distance_m * angle.cos(), distance_m * angle.sin()],
        velocity_in_odom_mps: [speed_mps * heading_rad.cos(), speed_mps * heading_rad.sin()],
        heading_rad,
        heading_rate_radps: 0.1,
        speed_mps,
        speed_rate_mps2: 0.05,
        radius_m: 0.35,
        quality: ObstacleQuality::Full.code(),
        ..Obstacle::zeroed()
    }
}

/// Pose `[x_m, y_m, heading_rad]` of a variant.
pub fn robot_pose(variant: usize) -> [f64; 3] {
    let turn = variant as f64 * 0.7;
    [0.05 * turn.cos(), 0.05 * turn.sin(), 0.2 * (1.3 * turn).sin()]
}

/// Nominal `[speed_mps, yaw_rate_radps]` of a variant.
pub fn nominal_control(variant: usize) -> [f64; 2] {
    let turn = variant as f64 * 0.9;
    [0.7 + 0.3 * turn.cos(), 0.4 * turn.sin()]
}

fn obstacles(people: usize) -> Obstacles {
    let mut message = Obstacles { stamp: stamp(START_NS), count: people as u32, ..Obstacles::zeroed() };
    for (index, item) in message.items.iter_mut().take(people).enumerate() {
        *item = person(index);
    }
    message
}

fn settings_on(kernel: KernelChoice) -> Settings {
    let mut settings = settings();
    settings.filter.kernel = kernel;
    settings
}

fn filter_of(settings: &Settings) -> SafetyFilter {
    let model = load_model(&settings.filter.model).unwrap();
    SafetyFilter::new(settings, &model).unwrap()
}

/// `SafetyFilter::step` with fresh inputs.
pub struct FilterStep {
    filter: SafetyFilter,
    obstacles: Box<Obstacles>,
    variants: Vec<(RobotState, NominalCommand)>,
    next: usize,
}

impl FilterStep {
    pub fn new(people: usize, kernel: KernelChoice) -> Self {
        let variants = (0..VARIANTS).map(|variant| (robot_state(variant), nominal(variant))).collect();
        Self {
            filter: filter_of(&settings_on(kernel)),
            obstacles: Box::new(obstacles(people)),
            variants,
            next: 0,
        }
    }

    pub fn kernel(&self) -> Kernel {
        self.filter.kernel()
    }

    pub fn step(&mut self) -> SafeCommand {
        let (robot_state, nominal) = &self.variants[self.next % VARIANTS];
        self.next += 1;
        let inputs = Inputs {
            robot_state: Some(robot_state),
            obstacles: Some(&self.obstacles),
            nominal: Some(nominal),
            goal: None,
        };
        self.filter.step(&inputs, Tick::timer(START_NS, START_NS))
    }
}

/// `SafetyFilter::step` with a goal beyond the crowd, in cycles that each look for a way through it.
pub struct SearchStep {
    filter: SafetyFilter,
    obstacles: Box<Obstacles>,
    goal: Goal,
    period_ns: u64,
    next: usize,
}

impl SearchStep {
    pub fn new(people: usize, kernel: KernelChoice) -> Self {
        let settings = settings_on(kernel);
        Self {
            filter: filter_of(&settings),
            obstacles: Box::new(obstacles(people)),
            goal: Goal { stamp: stamp(START_NS), position_in_odom_m: [12.0, 0.0], ..Goal::zeroed() },
            period_ns: settings.filter.anticipation.unwrap().period_ms * NS_PER_MS,
            next: 0,
        }
    }

    /// The same people where they were, seen anew a search's period after the step before.
    pub fn step(&mut self) -> SafeCommand {
        let now_ns = START_NS + self.next as u64 * self.period_ns;
        let variant = self.next % VARIANTS;
        self.next += 1;
        self.obstacles.stamp = stamp(now_ns);
        for person in &mut self.obstacles.items {
            (person.measured_at_ns, person.valid_at_ns) = (now_ns, now_ns);
        }
        let robot_state = RobotState { stamp: stamp(now_ns), ..robot_state(variant) };
        let nominal = NominalCommand { stamp: stamp(now_ns), ..nominal(variant) };
        let inputs = Inputs {
            robot_state: Some(&robot_state),
            obstacles: Some(&self.obstacles),
            nominal: Some(&nominal),
            goal: Some(&self.goal),
        };
        self.filter.step(&inputs, Tick::timer(now_ns, now_ns))
    }
}

fn robot_state(variant: usize) -> RobotState {
    let [x, y, heading_rad] = robot_pose(variant);
    RobotState {
        stamp: stamp(START_NS),
        position_in_odom_m: [x, y],
        heading_rad,
        velocity_in_base_mps: [0.8, 0.0],
        yaw_rate_radps: 0.0,
    }
}

fn nominal(variant: usize) -> NominalCommand {
    NominalCommand {
        stamp: stamp(START_NS),
        control: nominal_control(variant),
        control_kind: ControlKind::Unicycle.code(),
        intent: Intent::Drive.code(),
        ..NominalCommand::zeroed()
    }
}

fn pair(settings: &Settings) -> UnicyclePair {
    let (robot, obstacle) = (&settings.robot, &settings.obstacle);
    UnicyclePair {
        control: InputBox::new(robot.control_min, robot.control_max).unwrap(),
        disturbance: InputBox::new([obstacle.disturbance_min[0]], [obstacle.disturbance_max[0]]).unwrap(),
    }
}

/// The same person as the barrier takes it: state, rate, and the radius with the robot's and the buffer in it.
fn barrier_obstacle(settings: &Settings, index: usize) -> BarrierObstacle {
    let person = person(index);
    let ([x, y], [vx, vy]) = (person.position_in_odom_m, person.velocity_in_odom_mps);
    BarrierObstacle {
        state: [x, y, person.heading_rad, person.speed_mps],
        rate: [vx, vy, person.heading_rate_radps, person.speed_rate_mps2],
        radius_m: person.radius_m + settings.robot.radius_m + settings.filter.sdf_buffer_m,
        model: 0,
    }
}

/// Residual and gradient of the network alone.
pub struct NetworkStep {
    network: ResidualNetwork,
    batch: NetworkBatch,
}

impl NetworkStep {
    pub fn new(people: usize, kernel: Kernel) -> Self {
        let settings = settings();
        let pair = pair(&settings);
        let model = load_model(&settings.filter.model).unwrap();
        let mut batch = NetworkBatch::new();
        batch.set_len(people);
        for index in 0..people {
            let z = pair.relative_state(&robot_pose(0), &barrier_obstacle(&settings, index).state);
            batch.set_state(index, &z.map(|component| component as f32));
        }
        Self { network: ResidualNetwork::new(model.weights(), kernel).unwrap(), batch }
    }

    pub fn step(&mut self) -> f32 {
        self.network.evaluate(std::hint::black_box(&mut self.batch));
        self.batch.residual(0)
    }
}

/// The composite barrier with its row: all of a cycle that lies between prediction and QP.
pub struct BarrierStep {
    pair: UnicyclePair,
    composite: CompositeBarrier,
    people: Vec<BarrierObstacle>,
    next: usize,
}

impl BarrierStep {
    pub fn new(people: usize, kernel: Kernel) -> Self {
        let settings = settings();
        let model = load_model(&settings.filter.model).unwrap();
        Self {
            pair: pair(&settings),
            composite: CompositeBarrier::new(&model, kernel, settings.filter.beta_per_m).unwrap(),
            people: (0..people).map(|index| barrier_obstacle(&settings, index)).collect(),
            next: 0,
        }
    }

    pub fn step(&mut self) -> CompositeSample {
        self.next += 1;
        self.composite.evaluate(&self.pair, &robot_pose(self.next % VARIANTS), &self.people).unwrap()
    }
}

/// The CBF-QP over rows as people around the robot make them.
pub struct QpStep {
    qp: CbfQp<2>,
    problems: Vec<([f64; 2], HalfSpace<2>)>,
    next: usize,
}

impl QpStep {
    pub fn new() -> Self {
        let settings = settings();
        let mut barrier = BarrierStep::new(20, Kernel::detect());
        let problems = (0..VARIANTS)
            .map(|variant| {
                (nominal_control(variant), barrier.step().row(settings.filter.alpha_per_s).unwrap())
            })
            .collect();
        let qp = CbfQp::new(barrier.pair.control, settings.filter.slack_weight).unwrap();
        Self { qp, problems, next: 0 }
    }

    pub fn step(&mut self) -> QpSolution<2> {
        let (nominal, row) = &self.problems[self.next % VARIANTS];
        self.next += 1;
        self.qp.solve(nominal, Some(row)).unwrap()
    }
}

impl Default for QpStep {
    fn default() -> Self {
        Self::new()
    }
}
