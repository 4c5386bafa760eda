//! What the robot can do: a grid of open-loop manoeuvres and the paths they take, seen from where it is.
//!
//! Unicycle: constant speed and yaw rate, and the same followed by the widest turn either way, straight on, or the slowest
//! circle; its paths do not depend on the state once seen in its own frame. Double integrator: constant acceleration up to the
//! speed limit, and acceleration for a while followed by braking to a halt, per axis; zero-order hold, exact.

use dynamics::InputBox;

use super::{JointHorizon, JointRobot};

/// Kinds of double-integrator profiles per control: accelerate throughout; accelerate, then brake.
const PROFILES: usize = 2;

/// All manoeuvres of a robot. A path has one point per moment, in metres.
#[derive(Debug)]
pub(super) struct Manoeuvres {
    moments: usize,
    controls: Vec<[f64; 2]>,
    paths: Paths,
}

#[derive(Debug)]
enum Paths {
    /// Fixed in the robot's frame: manoeuvre after manoeuvre.
    Unicycle { xs: Vec<f32>, ys: Vec<f32> },
    /// Per axis, profile and level, for the current velocity; the manoeuvre `(profile · levels + i) · levels + j` takes level
    /// `i` in x and `j` in y.
    DoubleIntegrator { axes: [Vec<f32>; 2], profiles: Profiles },
}

#[derive(Debug)]
struct Profiles {
    control: InputBox<2>,
    levels: usize,
    step_s: f64,
    switch_s: f64,
    max_speed_mps: f64,
}

impl Manoeuvres {
    pub(super) fn new(robot: &JointRobot, horizon: &JointHorizon) -> Self {
        let (levels, moments) = (horizon.levels, horizon.moments);
        let step_s = horizon.horizon_s / moments as f64;
        let level = |bounds: &InputBox<2>, axis: usize, index: usize| {
            let share = index as f64 / (levels - 1) as f64;
            bounds.min[axis] + share * (bounds.max[axis] - bounds.min[axis])
        };
        let grid = |bounds: &InputBox<2>| {
            let bounds = *bounds;
            (0..levels * levels)
                .map(|cell| [level(&bounds, 0, cell / levels), level(&bounds, 1, cell % levels)])
                .collect::<Vec<_>>()
        };
        match robot {
            JointRobot::Unicycle { control, .. } => {
                let [slow, fast] = [control.min[0], control.max[0]];
                let [right, left] = [control.min[1], control.max[1]];
                let ends = [[slow, left], [slow, right], [fast, 0.0], [fast, left], [fast, right]];
                let (mut controls, mut xs, mut ys) = (Vec::new(), Vec::new(), Vec::new());
                for first in grid(control) {
                    for second in std::iter::once(first).chain(ends) {
                        controls.push(first);
                        drive(first, second, horizon.switch_s, step_s, moments, &mut xs, &mut ys);
                    }
                }
                Self { moments, controls, paths: Paths::Unicycle { xs, ys } }
            }
            JointRobot::DoubleIntegrator { control, .. } => {
                let controls = grid(control).repeat(PROFILES);
                let axis = vec![0.0; PROFILES * levels * moments];
                let profiles = Profiles {
                    control: *control,
                    levels,
                    step_s,
                    switch_s: horizon.switch_s,
                    max_speed_mps: horizon.max_robot_speed_mps,
                };
                Self {
                    moments,
                    controls,
                    paths: Paths::DoubleIntegrator { axes: [axis.clone(), axis], profiles },
                }
            }
        }
    }

    pub(super) fn count(&self) -> usize {
        self.controls.len()
    }

    pub(super) fn control(&self, index: usize) -> [f64; 2] {
        self.controls[index]
    }

    /// Squared distance of a manoeuvre's control from `wish`.
    pub(super) fn distance(&self, index: usize, wish: &[f64; 2]) -> f64 {
        let [a, b] = self.controls[index];
        (a - wish[0]).powi(2) + (b - wish[1]).powi(2)
    }

    /// The state after the control `u` for `period_s`.
    pub(super) fn after(&self, x: &[f64; 4], u: &[f64; 2], period_s: f64) -> [f64; 4] {
        match &self.paths {
            Paths::Unicycle { .. } => {
                let middle = x[2] + 0.5 * u[1] * period_s;
                let way_m = u[0] * period_s;
                [x[0] + way_m * middle.cos(), x[1] + way_m * middle.sin(), x[2] + u[1] * period_s, x[3]]
            }
            Paths::DoubleIntegrator { .. } => {
                let way = |axis: usize| x[axis + 2] * period_s + 0.5 * u[axis] * period_s * period_s;
                [x[0] + way(0), x[1] + way(1), x[2] + u[0] * period_s, x[3] + u[1] * period_s]
            }
        }
    }

    /// Prepares the paths from `x` and returns `[cos, sin]` of the angle by which their axes are turned.
    pub(super) fn begin(&mut self, x: &[f64; 4]) -> [f64; 2] {
        match &mut self.paths {
            Paths::Unicycle { .. } => [x[2].cos(), x[2].sin()],
            Paths::DoubleIntegrator { axes, profiles } => {
                for (axis, table) in axes.iter_mut().enumerate() {
                    profiles.fill(axis, x[axis + 2], self.moments, table);
                }
                [1.0, 0.0]
            }
        }
    }

    /// The path of a manoeuvre: coordinates at each moment, m.
    pub(super) fn path(&self, index: usize) -> (&[f32], &[f32]) {
        let row = |at: usize| at * self.moments..(at + 1) * self.moments;
        match &self.paths {
            Paths::Unicycle { xs, ys } => (&xs[row(index)], &ys[row(index)]),
            Paths::DoubleIntegrator { axes: [xs, ys], profiles } => {
                let levels = profiles.levels;
                let (profile, cell) = (index / (levels * levels), index % (levels * levels));
                let (i, j) = (profile * levels + cell / levels, profile * levels + cell % levels);
                (&xs[row(i)], &ys[row(j)])
            }
        }
    }
}

impl Profiles {
    /// Fills the ways along `axis` from the speed `v`, m.
    fn fill(&self, axis: usize, v: f64, moments: usize, table: &mut [f32]) {
        let (least, most) = (self.control.min[axis], self.control.max[axis]);
        for (row, ways) in table.chunks_exact_mut(moments).enumerate() {
            let (profile, level) = (row / self.levels, row % self.levels);
            let share = level as f64 / (self.levels - 1) as f64;
            let a = least + share * (most - least);
            let (mut way, mut speed) = (0.0, v);
            for (moment, slot) in ways.iter_mut().enumerate() {
                let braking = profile == 1 && moment as f64 * self.step_s >= self.switch_s;
                let wanted = if !braking {
                    a
                } else if speed > 0.0 {
                    least.max(-speed / self.step_s)
                } else {
                    most.min(-speed / self.step_s)
                };
                // A plant at its limit keeps its speed; one beyond it, after a gust say, is not made faster.
                let limit = self.max_speed_mps.max(speed.abs());
                let next = (speed + wanted * self.step_s).clamp(-limit, limit);
                way += 0.5 * (speed + next) * self.step_s;
                speed = next;
                *slot = way as f32;
            }
        }
    }
}

/// Appends the path of a unicycle that starts at the origin along the x axis: `first` until `switch_s`, then `second`.
fn drive(
    first: [f64; 2],
    second: [f64; 2],
    switch_s: f64,
    step_s: f64,
    moments: usize,
    xs: &mut Vec<f32>,
    ys: &mut Vec<f32>,
) {
    let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0_f64);
    for moment in 0..moments {
        let [v, w] = if moment as f64 * step_s < switch_s { first } else { second };
        let middle = heading + 0.5 * w * step_s;
        // The chord of the arc.
        let half = 0.5 * w * step_s;
        let chord_m = v * step_s * if half.abs() < 1e-9 { 1.0 } else { half.sin() / half };
        x += chord_m * middle.cos();
        y += chord_m * middle.sin();
        heading += w * step_s;
        xs.push(x as f32);
        ys.push(y as f32);
    }
}
