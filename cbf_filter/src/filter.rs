//! One cycle of the filter: from the newest inputs to one safe command.

use barrier::{
    BarrierConstraint, BarrierObstacle, CbfQp, CompositeBarrier, CompositeSample, HalfSpace, Kernel, Model,
    QpSolution,
};
use dynamics::{DoubleIntegratorPair, UnicyclePair};
use messages::{
    ControlKind, Controller, Goal, Ledger, MAX_OBSTACLES, NominalCommand, Obstacles, Reason, RobotState,
    SafeCommand, SafetyStatus,
};
use node_runtime::Tick;
use settings::{KernelChoice, Settings};

use crate::anticipation::Anticipating;
use crate::brake::Brake;
use crate::class_models::ClassModels;
use crate::joint::Joint;
use crate::ladder::rung;
use crate::model::FilterSetupError;
use crate::options::{Options, within_speed_limit};
use crate::prediction::{self, Inflation};
use crate::trust::{Limits, Trusted};

/// Braking of one cycle counts at most this many periods: the command sink has braked by itself for longer silences.
const MOST_BRAKED_PERIODS: f64 = 5.0;

/// The newest message of each kind; `None` where none has arrived yet.
#[derive(Debug, Clone, Copy, Default)]
pub struct Inputs<'a> {
    /// Where the robot is.
    pub robot_state: Option<&'a RobotState>,
    /// What is around it.
    pub obstacles: Option<&'a Obstacles>,
    /// What it would do alone.
    pub nominal: Option<&'a NominalCommand>,
    /// Where it wants to be: only `[filter.anticipation]` asks.
    pub goal: Option<&'a Goal>,
}

/// The pair of robot and obstacle dynamics that the model was made for.
pub(crate) enum Pair {
    Unicycle(UnicyclePair),
    DoubleIntegrator(DoubleIntegratorPair),
}

/// The composite neural CBF filter: constructed once, stepped once per period. See [`SafetyFilter::step`].
pub struct SafetyFilter {
    pair: Pair,
    control_kind: ControlKind,
    barrier: CompositeBarrier,
    class_models: ClassModels,
    qp: CbfQp<2>,
    options: Option<Options>,
    /// Per axis, m/s; the double integrator's alone.
    max_speed_mps: Option<f64>,
    joint: Option<Joint>,
    anticipation: Option<Anticipating>,
    limits: Limits,
    inflation: Inflation,
    brake: Brake,
    alpha_per_s: f64,
    slack_tolerance_mps: f64,
    sensing_range_m: f64,
    period_s: f64,
    sequence: u64,
    last_woke_ns: Option<u64>,
    newest_state_ns: u64,
    /// The obstacles of this cycle as the barrier wants them, and their identities.
    obstacles: Vec<BarrierObstacle>,
    track_ids: Vec<u64>,
}

/// What the barrier and the QP made of trusted inputs.
struct Correction {
    solution: QpSolution<2>,
    /// Whether the joint look-ahead decided, not the QP.
    escaped: bool,
    sample: CompositeSample,
}

impl SafetyFilter {
    /// Prepares the filter for `settings` with a model that fits them, and loads the models of `filter.class_models`.
    ///
    /// # Errors
    /// [`FilterSetupError`] if a class's model cannot be loaded, a model was made for other dynamics, bounds or radius, or
    /// the kernel does not run here.
    pub fn new(settings: &Settings, model: &Model) -> Result<Self, FilterSetupError> {
        let pair = crate::model::pair_that_fits(settings, model)?;
        let (robot, filter) = (&settings.robot, &settings.filter);
        let (control, control_kind) = match &pair {
            Pair::Unicycle(pair) => (pair.control, ControlKind::Unicycle),
            Pair::DoubleIntegrator(pair) => (pair.control, ControlKind::DoubleIntegrator),
        };
        let kernel = chosen_kernel(filter.kernel);
        let mut barrier = CompositeBarrier::new(model, kernel, filter.beta_per_m)?;
        let contact_radius_m = crate::model::contact_radius_m(settings);
        let class_models = ClassModels::add_to(&mut barrier, filter, model, contact_radius_m)?;
        let joint = Joint::of(settings, &pair);
        let anticipation = Anticipating::of(settings, &pair);
        Ok(Self {
            pair,
            control_kind,
            barrier,
            class_models,
            qp: CbfQp::new(control, filter.slack_weight)?,
            options: Options::of(filter),
            max_speed_mps: filter.robot_max_speed_mps,
            joint,
            anticipation,
            limits: Limits::new(filter),
            inflation: Inflation::new(settings),
            brake: Brake::new(robot, filter.period_ms as f64 * 1e-3),
            alpha_per_s: filter.alpha_per_s,
            slack_tolerance_mps: filter.slack_tolerance_mps,
            sensing_range_m: filter.sensing_range_m.unwrap_or(f64::INFINITY),
            period_s: filter.period_ms as f64 * 1e-3,
            sequence: 0,
            last_woke_ns: None,
            newest_state_ns: 0,
            obstacles: Vec::with_capacity(MAX_OBSTACLES),
            track_ids: Vec::with_capacity(MAX_OBSTACLES),
        })
    }

    /// Evaluation kernel in use.
    pub fn kernel(&self) -> Kernel {
        self.barrier.kernel()
    }

    /// Runs one cycle. Always returns a finite command; what the ledger says of the hand-over and of the
    /// thread is left to the sender.
    ///
    /// With trusted inputs the command is the CBF-QP's: the admissible control nearest to u_nom with
    /// L_f h + L_g h·u + ∂h/∂t + α·h ≥ −s (CN-CBF paper, eq. cbf_qp, softened by one slack s as in the authors' code).
    /// Where the settings have `[filter.anticipation]`, the best way through the crowd takes u_nom's place, and the QP's where no
    /// control meets the condition. Where they have `[filter.joint]`, a manoeuvre clear of everybody may take the command's place.
    /// With anything less it brakes, and [`SafeCommand::reason`] says why. Allocates nothing.
    pub fn step(&mut self, inputs: &Inputs<'_>, tick: Tick) -> SafeCommand {
        self.sequence += 1;
        let elapsed_s = self.elapsed_s(tick.woke_ns);
        let mut command = self.blank(inputs, tick);
        let outcome = self.limits.check(inputs, self.control_kind, tick.woke_ns).and_then(|trusted| {
            self.in_order(trusted.robot_state)?;
            self.correct(&trusted, inputs.goal, tick.woke_ns).map(|correction| (trusted, correction))
        });
        match outcome {
            Ok((trusted, correction)) => {
                self.brake.note(trusted.robot_state, correction.solution.u);
                self.fill(&mut command, &correction, &trusted);
            }
            Err(reason) => self.fall_back(&mut command, reason, inputs, elapsed_s),
        }
        command
    }

    /// Prepares the composite for pictures: with `obstacles` as they are at `now_ns` around a robot at `robot_m` (`odom`, m),
    /// the result maps a robot position `[x, y]` to h there, m, for the heading `heading_rad` and a robot at rest; `+∞` where
    /// no obstacle counts. Not for the cycle.
    pub fn h_around<'a>(
        &'a mut self,
        obstacles: &Obstacles,
        robot_m: [f64; 2],
        heading_rad: f64,
        now_ns: u64,
    ) -> impl FnMut([f64; 2]) -> f64 + 'a {
        self.gather(obstacles, robot_m, now_ns);
        move |[x, y]| {
            let h = match &self.pair {
                Pair::Unicycle(pair) => self.barrier.h_at(pair, &[x, y, heading_rad], &self.obstacles),
                Pair::DoubleIntegrator(pair) => self.barrier.h_at(pair, &[x, y, 0.0, 0.0], &self.obstacles),
            };
            h.unwrap_or(f64::INFINITY)
        }
    }

    /// Refuses a robot state that is older than one already used: a clock ran backwards, or two bridges speak. Only
    /// trusted states count, so that one wild stamp cannot lock out the good ones after it.
    fn in_order(&mut self, state: &RobotState) -> Result<(), Reason> {
        if state.stamp.valid_at_ns < self.newest_state_ns {
            return Err(Reason::BackwardStamp);
        }
        self.newest_state_ns = state.stamp.valid_at_ns;
        Ok(())
    }

    fn correct(
        &mut self,
        trusted: &Trusted<'_>,
        goal: Option<&Goal>,
        now_ns: u64,
    ) -> Result<Correction, Reason> {
        let pose = prediction::robot_pose(trusted.robot_state, now_ns);
        self.gather(trusted.obstacles, [pose[0], pose[1]], now_ns);
        let x = match &self.pair {
            Pair::Unicycle(_) => [pose[0], pose[1], pose[2], 0.0],
            Pair::DoubleIntegrator(_) => {
                let [vx, vy] = trusted.robot_state.velocity_in_odom_mps();
                [pose[0], pose[1], vx, vy]
            }
        };
        // A planner upstream follows a goal of its own, which nobody told the stack.
        let own = trusted.nominal.controller != Controller::Upstream.code();
        let ahead = self.anticipation.as_mut().filter(|_| own);
        let anticipated =
            ahead.and_then(|ahead| ahead.wish(&x, goal, &self.obstacles, &self.track_ids, now_ns));
        let wish = anticipated.unwrap_or(trusted.nominal.control);
        let (sample, solution) = self.solve(&wish, &x, now_ns)?;
        let Some(row) = sample.row(self.alpha_per_s) else {
            return Ok(Correction { solution, escaped: false, sample });
        };
        let joint = self.joint.as_mut();
        let overruled =
            joint.and_then(|joint| joint.overrule(&x, &self.obstacles, &row, &solution)).or_else(|| {
                // Where no control meets the condition, the way looked for ahead is better than the least violation now.
                anticipated.filter(|_| solution.hard_margin < 0.0).map(|u| beside(&row, u, &solution))
            });
        Ok(Correction { solution: overruled.unwrap_or(solution), escaped: overruled.is_some(), sample })
    }

    /// The control nearest to `wish` at the robot's state `x`, `[x, y, heading, _]` or `[x, y, vx, vy]`, and the condition it
    /// is under: the paper's, or with what the settings have beyond it.
    fn solve(
        &mut self,
        wish: &[f64; 2],
        x: &[f64; 4],
        now_ns: u64,
    ) -> Result<(CompositeSample, QpSolution<2>), Reason> {
        let qp = self.qp_at([x[2], x[3]]);
        let Some(options) = &mut self.options else {
            return self.solve_published(&qp, wish, x);
        };
        match &self.pair {
            Pair::Unicycle(pair) => {
                options.look(&mut self.barrier, pair, &[x[0], x[1], x[2]], &self.obstacles)
            }
            Pair::DoubleIntegrator(pair) => options.look(&mut self.barrier, pair, x, &self.obstacles),
        }?;
        options.decide(&mut self.barrier, &qp, wish, &self.track_ids, now_ns)
    }

    /// The CBF-QP under the composite's one condition.
    fn solve_published(
        &mut self,
        qp: &CbfQp<2>,
        wish: &[f64; 2],
        x: &[f64; 4],
    ) -> Result<(CompositeSample, QpSolution<2>), Reason> {
        let sample = match &self.pair {
            Pair::Unicycle(pair) => self.barrier.evaluate(pair, &[x[0], x[1], x[2]], &self.obstacles),
            Pair::DoubleIntegrator(pair) => self.barrier.evaluate(pair, x, &self.obstacles),
        }
        .map_err(|_| Reason::NonFiniteBarrier)?;
        let solution = qp.solve(wish, sample.row(self.alpha_per_s).as_ref());
        Ok((sample, solution.map_err(|_| Reason::NonFiniteBarrier)?))
    }

    /// The program over the controls that keep the double integrator's own speed limit, if the settings name one.
    fn qp_at(&self, velocity_mps: [f64; 2]) -> CbfQp<2> {
        match self.max_speed_mps {
            Some(limit_mps) => {
                let control = self.qp.control();
                self.qp.within(within_speed_limit(control, velocity_mps, limit_mps, self.period_s))
            }
            None => self.qp,
        }
    }

    /// Collects the obstacles within sensing range, predicted to `now_ns`.
    fn gather(&mut self, obstacles: &Obstacles, robot_m: [f64; 2], now_ns: u64) {
        self.obstacles.clear();
        self.track_ids.clear();
        for obstacle in obstacles.as_slice() {
            let mut predicted = match self.pair {
                Pair::Unicycle(_) => prediction::unicycle_obstacle(obstacle, &self.inflation, now_ns),
                Pair::DoubleIntegrator(_) => {
                    prediction::double_integrator_obstacle(obstacle, &self.inflation, now_ns)
                }
            };
            predicted.model = self.class_models.of(obstacle);
            let distance_m = (predicted.state[0] - robot_m[0]).hypot(predicted.state[1] - robot_m[1]);
            if distance_m <= self.sensing_range_m {
                self.obstacles.push(predicted);
                self.track_ids.push(obstacle.track_id);
            }
        }
    }

    fn fill(&self, command: &mut SafeCommand, correction: &Correction, trusted: &Trusted<'_>) {
        let solution = &correction.solution;
        let reason = if correction.escaped {
            Reason::JointEscape
        } else if solution.slack > self.slack_tolerance_mps {
            Reason::SlackNeeded
        } else {
            Reason::None
        };
        command.status = rung(reason).code();
        command.reason = reason.code();
        command.control = solution.u;
        command.nominal = trusted.nominal.control;
        command.slack_mps = solution.slack;
        command.hard_margin_mps = solution.hard_margin;
        command.obstacle_count = self.obstacles.len() as u32;
        match &correction.sample {
            CompositeSample::Unconstrained => {}
            CompositeSample::Constrained(constraint) => self.fill_constraint(command, constraint),
        }
    }

    fn fill_constraint(&self, command: &mut SafeCommand, constraint: &BarrierConstraint) {
        command.h_m = constraint.h;
        command.sdf_m = constraint.sdf;
        command.drift_mps = constraint.drift;
        command.lg_h = constraint.lg_h;
        command.outside_domain = constraint.outside_domain;
        command.critical_track_id = self.track_ids[constraint.critical];
        command.critical_h_m = self.barrier.values()[constraint.critical].h_bar;
    }

    /// Time since the last cycle, s: what braking goes by. A clock that stood still or jumped does not count.
    fn elapsed_s(&mut self, woke_ns: u64) -> f64 {
        let last_ns = self.last_woke_ns.replace(woke_ns);
        let elapsed_ns = last_ns.and_then(|last_ns| woke_ns.checked_sub(last_ns)).filter(|&ns| ns > 0);
        elapsed_ns.map_or(self.period_s, |ns| (ns as f64 * 1e-9).min(MOST_BRAKED_PERIODS * self.period_s))
    }

    /// The rung below: brake, whatever is missing.
    fn fall_back(&mut self, command: &mut SafeCommand, reason: Reason, inputs: &Inputs<'_>, elapsed_s: f64) {
        let now_ns = command.ledger.filter_woke_ns;
        let fresh = inputs.robot_state.filter(|state| self.limits.is_fresh(state, now_ns));
        let (control, standing) = self.brake.step(fresh, elapsed_s);
        command.control = control;
        command.status = if standing { SafetyStatus::Stopped } else { rung(reason) }.code();
        command.reason = reason.code();
    }

    /// A command that knows nothing but its times.
    fn blank(&self, inputs: &Inputs<'_>, tick: Tick) -> SafeCommand {
        let pose = inputs
            .robot_state
            .filter(|state| state.is_finite())
            .map_or([0.0; 3], |state| prediction::robot_pose(state, tick.woke_ns));
        SafeCommand {
            sequence: self.sequence,
            control: [0.0; 2],
            nominal: [0.0; 2],
            control_kind: self.control_kind.code(),
            status: SafetyStatus::Stopped.code(),
            reason: Reason::None.code(),
            obstacle_count: 0,
            h_m: f64::INFINITY,
            sdf_m: f64::INFINITY,
            drift_mps: 0.0,
            lg_h: [0.0; 2],
            alpha_per_s: self.alpha_per_s,
            slack_mps: 0.0,
            hard_margin_mps: f64::INFINITY,
            critical_track_id: 0,
            critical_h_m: f64::INFINITY,
            robot_position_in_odom_m: [pose[0], pose[1]],
            robot_heading_rad: pose[2],
            outside_domain: 0,
            kernel: kernel_code(self.barrier.kernel()),
            ledger: ledger(inputs, tick),
        }
    }
}

fn ledger(inputs: &Inputs<'_>, tick: Tick) -> Ledger {
    let (state, obstacles, nominal) = (inputs.robot_state, inputs.obstacles, inputs.nominal);
    Ledger {
        detections_source_ns: obstacles.map_or(0, |message| message.stamp.source_ns),
        detections_ingress_ns: obstacles.map_or(0, |message| message.stamp.ingress_ns),
        detections_published_ns: obstacles.map_or(0, |message| message.bridge_published_ns),
        estimator_received_ns: obstacles.map_or(0, |message| message.received_ns),
        estimator_published_ns: obstacles.map_or(0, |message| message.stamp.published_ns),
        robot_state_source_ns: state.map_or(0, |message| message.stamp.source_ns),
        robot_state_ingress_ns: state.map_or(0, |message| message.stamp.ingress_ns),
        robot_state_published_ns: state.map_or(0, |message| message.stamp.published_ns),
        nominal_received_ns: nominal.map_or(0, |message| message.received_ns),
        nominal_published_ns: nominal.map_or(0, |message| message.stamp.published_ns),
        filter_due_ns: tick.due_ns,
        filter_woke_ns: tick.woke_ns,
        filter_computed_ns: 0,
        filter_published_ns: 0,
        filter_trigger: tick.trigger.code(),
        filter_skipped: tick.skipped.min(u32::MAX.into()) as u32,
        minor_faults: 0,
        major_faults: 0,
        voluntary_switches: 0,
        involuntary_switches: 0,
    }
}

/// `solution` with the control `u` instead, whose slack is what `u` misses of the condition of `row`.
pub(crate) fn beside(row: &HalfSpace<2>, u: [f64; 2], solution: &QpSolution<2>) -> QpSolution<2> {
    let held = row.offset + row.normal[0] * u[0] + row.normal[1] * u[1];
    QpSolution { u, slack: (-held).max(0.0), ..*solution }
}

/// The kernel that a setting means on this processor.
pub fn chosen_kernel(choice: KernelChoice) -> Kernel {
    match choice {
        KernelChoice::Auto => Kernel::detect(),
        KernelChoice::Portable => Kernel::Portable,
        KernelChoice::Avx2Fma => Kernel::Avx2Fma,
        KernelChoice::Avx512 => Kernel::Avx512,
    }
}

/// Position of a kernel among all kernels, as [`SafeCommand::kernel`] carries it.
fn kernel_code(kernel: Kernel) -> u32 {
    match kernel {
        Kernel::Portable => 0,
        Kernel::Avx2Fma => 1,
        Kernel::Avx512 => 2,
    }
}
