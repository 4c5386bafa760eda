//! What the robot could do: manoeuvres of two parts, the paths they take, and when each would reach the goal.
//!
//! A part aims at something and keeps it: the unicycle at a speed and yaw rate, taken at once; the double integrator at a
//! velocity, each axis by its largest acceleration. The unicycle's paths are fixed in its own frame; the double integrator's
//! are pairs of profiles along the axes, computed anew from its velocity.

use dynamics::InputBox;

use super::people::Frame;
use super::{AnticipatingRobot, AnticipationHorizon};

/// When the first part ends, as shares of the horizon.
const SWITCHES: [f64; 3] = [0.125, 0.25, 0.45];
/// Levels of a unicycle's speed and yaw rate, in the first and the second part.
const UNICYCLE_FIRST: [usize; 2] = [4, 9];
const UNICYCLE_SECOND: [usize; 2] = [3, 5];
/// Levels of a double integrator's velocity along an axis, in the first and the second part.
const AXIS_FIRST: usize = 7;
const AXIS_SECOND: usize = 5;

/// Profiles of a double integrator are computed this many at once.
const TOGETHER: usize = 8;

/// Closer than this to the goal a path has reached it, m.
const REACHED_M: f64 = 0.5;
/// No coordinate of a path that has reached it is off by more, m: rounding included.
const NEAR_M: f32 = 1.001 * REACHED_M as f32;
/// Every so many moments a path is asked whether it has.
const REACHED_EVERY: usize = 4;
/// Heading is brought to the goal's bearing within 1/this, s; velocity likewise.
const TURNING_GAIN_PER_S: f64 = 4.0;
const VELOCITY_GAIN_PER_S: f64 = 2.0;

/// Two aims, one after the other: `[speed, yaw rate]` of a unicycle, `[vx, vy]` of a double integrator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Manoeuvre {
    first: [f64; 2],
    switch_s: f64,
    second: [f64; 2],
}

impl Manoeuvre {
    fn aim(&self, t_s: f64) -> [f64; 2] {
        if t_s < self.switch_s { self.first } else { self.second }
    }
}

/// What the paths of some manoeuvres have in common.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Beginning {
    first: [f64; 2],
    moments: usize,
}

/// A manoeuvre along one axis: to the first speed until `switch_s`, then to the second.
#[derive(Debug, Clone, Copy)]
struct Profile {
    aims_mps: [f64; 2],
    switch_s: f64,
}

/// All manoeuvres of a robot, and their paths.
#[derive(Debug)]
pub(super) struct Manoeuvres {
    robot: AnticipatingRobot,
    moments: usize,
    step_s: f64,
    cruise_speed_mps: f64,
    manoeuvres: Vec<Manoeuvre>,
    /// Which row of `xs` and of `ys` a manoeuvre takes.
    rows: Vec<[usize; 2]>,
    /// Where manoeuvres end, m: side by side, so that their times are computed side by side.
    ends: Vec<[f32; 2]>,
    /// Which of the beginnings a manoeuvre has.
    beginning_of: Vec<usize>,
    beginnings: Vec<Beginning>,
    /// What a double integrator does along an axis, a row each; two of them make a manoeuvre.
    profiles: Vec<Profile>,
    /// Coordinates at each moment, row after row, m.
    xs: Vec<f32>,
    ys: Vec<f32>,
    /// Which rows of `xs` and of `ys` come near that coordinate of the goal.
    near: [Vec<bool>; 2],
}

impl Manoeuvres {
    pub(super) fn new(robot: AnticipatingRobot, horizon: &AnticipationHorizon) -> Self {
        let mut all = Self {
            robot,
            moments: horizon.moments,
            step_s: horizon.horizon_s / horizon.moments as f64,
            cruise_speed_mps: horizon.cruise_speed_mps,
            manoeuvres: Vec::new(),
            rows: Vec::new(),
            ends: Vec::new(),
            beginning_of: Vec::new(),
            beginnings: Vec::new(),
            profiles: Vec::new(),
            xs: Vec::new(),
            ys: Vec::new(),
            near: [Vec::new(), Vec::new()],
        };
        match robot {
            AnticipatingRobot::Unicycle { control } => all.list_unicycle(&control, horizon.horizon_s),
            AnticipatingRobot::DoubleIntegrator { max_speed_mps, .. } => {
                all.list_double_integrator(max_speed_mps, horizon.horizon_s);
            }
        }
        all.ends = vec![[0.0; 2]; all.count()];
        let rows = all.xs.len() / all.moments;
        all.near = [vec![false; rows], vec![false; rows]];
        all.find_ends();
        all
    }

    fn list(&mut self, manoeuvre: Manoeuvre, rows: [usize; 2]) {
        let first_part = |moment: &usize| *moment as f64 * self.step_s < manoeuvre.switch_s;
        let moments = (0..self.moments).take_while(first_part).count();
        let beginning = Beginning { first: manoeuvre.first, moments };
        let listed = self.beginnings.iter().position(|known| *known == beginning);
        self.beginning_of.push(listed.unwrap_or(self.beginnings.len()));
        if listed.is_none() {
            self.beginnings.push(beginning);
        }
        self.manoeuvres.push(manoeuvre);
        self.rows.push(rows);
    }

    fn list_unicycle(&mut self, control: &InputBox<2>, horizon_s: f64) {
        for first in grid(control, UNICYCLE_FIRST) {
            for share in SWITCHES {
                for second in grid(control, UNICYCLE_SECOND) {
                    let manoeuvre = Manoeuvre { first, switch_s: share * horizon_s, second };
                    let index = self.manoeuvres.len();
                    let (mut xs, mut ys) = (vec![0.0; self.moments], vec![0.0; self.moments]);
                    self.follow(&manoeuvre, 0.0, &[0.0; 4], &mut xs, &mut ys);
                    self.xs.append(&mut xs);
                    self.ys.append(&mut ys);
                    self.list(manoeuvre, [index; 2]);
                }
            }
        }
    }

    /// Both axes switch from the first aim to the second at once.
    fn list_double_integrator(&mut self, max_speed_mps: f64, horizon_s: f64) {
        let aims = InputBox { min: [-max_speed_mps; 2], max: [max_speed_mps; 2] };
        for share in SWITCHES {
            let (begin, switch_s) = (self.profiles.len(), share * horizon_s);
            self.profiles.extend(
                grid(&aims, [AXIS_FIRST, AXIS_SECOND]).map(|aims_mps| Profile { aims_mps, switch_s }),
            );
            let end = self.profiles.len();
            for x in begin..end {
                for y in begin..end {
                    let [first, second] =
                        [0, 1].map(|part| [x, y].map(|row| self.profiles[row].aims_mps[part]));
                    self.list(Manoeuvre { first, switch_s, second }, [x, y]);
                }
            }
        }
        let table = self.profiles.len() * self.moments;
        self.xs = vec![0.0; table];
        self.ys = vec![0.0; table];
    }

    pub(super) fn count(&self) -> usize {
        self.manoeuvres.len()
    }

    pub(super) fn manoeuvre(&self, index: usize) -> Manoeuvre {
        self.manoeuvres[index]
    }

    /// The fastest that any manoeuvre gets, m/s.
    pub(super) fn top_speed_mps(&self) -> f64 {
        match self.robot {
            AnticipatingRobot::Unicycle { control } => control.max[0].max(-control.min[0]),
            AnticipatingRobot::DoubleIntegrator { max_speed_mps, .. } => {
                std::f64::consts::SQRT_2 * max_speed_mps
            }
        }
    }

    /// The axes of paths that begin at `x`.
    pub(super) fn frame(&self, x: &[f64; 4]) -> Frame {
        let cos_sin = match self.robot {
            AnticipatingRobot::Unicycle { .. } => [x[2].cos(), x[2].sin()],
            AnticipatingRobot::DoubleIntegrator { .. } => [1.0, 0.0],
        };
        Frame { origin_m: [x[0], x[1]], cos_sin }
    }

    /// Computes the paths that begin at `x`.
    pub(super) fn begin(&mut self, x: &[f64; 4]) {
        let AnticipatingRobot::DoubleIntegrator { control, .. } = self.robot else {
            return;
        };
        for (axis, table) in [&mut self.xs, &mut self.ys].into_iter().enumerate() {
            let limits = [control.min[axis], control.max[axis]];
            let (groups, rest) = self.profiles.as_chunks::<TOGETHER>();
            let (tables, rest_tables) = table.split_at_mut(groups.len() * TOGETHER * self.moments);
            for (group, ways) in groups.iter().zip(tables.chunks_exact_mut(TOGETHER * self.moments)) {
                accelerate(group, x[axis + 2], limits, self.step_s, ways);
            }
            for (profile, ways) in rest.iter().zip(rest_tables.chunks_exact_mut(self.moments)) {
                accelerate(&[*profile], x[axis + 2], limits, self.step_s, ways);
            }
        }
        self.find_ends();
    }

    fn find_ends(&mut self) {
        for ([end_x, end_y], &[x, y]) in self.ends.iter_mut().zip(&self.rows) {
            let last_of = |row: usize| (row + 1) * self.moments - 1;
            (*end_x, *end_y) = (self.xs[last_of(x)], self.ys[last_of(y)]);
        }
    }

    /// How many beginnings there are that manoeuvres share.
    pub(super) fn beginnings(&self) -> usize {
        self.beginnings.len()
    }

    /// Which beginning a manoeuvre has, and for how many moments its path is the same as that of all others that have it.
    pub(super) fn beginning(&self, index: usize) -> (usize, usize) {
        let beginning = self.beginning_of[index];
        (beginning, self.beginnings[beginning].moments)
    }

    /// The path of a manoeuvre, m.
    pub(super) fn path(&self, index: usize) -> (&[f32], &[f32]) {
        let [x, y] = self.rows[index].map(|row| row * self.moments..(row + 1) * self.moments);
        (&self.xs[x], &self.ys[y])
    }

    /// The path of what is left of `manoeuvre` after `begun_s`, m.
    pub(super) fn follow(
        &self,
        manoeuvre: &Manoeuvre,
        begun_s: f64,
        x: &[f64; 4],
        xs: &mut [f32],
        ys: &mut [f32],
    ) {
        match self.robot {
            AnticipatingRobot::Unicycle { .. } => {
                let mut drive = Drive::default();
                for (moment, (at_x, at_y)) in xs.iter_mut().zip(ys).enumerate() {
                    drive.go(manoeuvre.aim(begun_s + moment as f64 * self.step_s), self.step_s);
                    (*at_x, *at_y) = (drive.x_m as f32, drive.y_m as f32);
                }
            }
            AnticipatingRobot::DoubleIntegrator { control, .. } => {
                for (axis, ways) in [xs, ys].into_iter().enumerate() {
                    let aims_mps = [manoeuvre.first[axis], manoeuvre.second[axis]];
                    let left = Profile { aims_mps, switch_s: manoeuvre.switch_s - begun_s };
                    accelerate(
                        &[left],
                        x[axis + 2],
                        [control.min[axis], control.max[axis]],
                        self.step_s,
                        ways,
                    );
                }
            }
        }
    }

    /// The path of a robot that makes for `goal` (in the frame of `x`, m) at cruising speed, as its nominal controller does.
    pub(super) fn toward(&self, x: &[f64; 4], goal: [f64; 2], xs: &mut [f32], ys: &mut [f32]) {
        let step_s = self.step_s;
        match self.robot {
            AnticipatingRobot::Unicycle { control } => {
                let mut drive = Drive::default();
                for (at_x, at_y) in xs.iter_mut().zip(ys) {
                    let [dx, dy] = [goal[0] - drive.x_m, goal[1] - drive.y_m];
                    let off = dynamics::wrap_angle(libm::atan2(dy, dx) - drive.heading_rad);
                    let speed_mps = self.cruise_speed_mps.min((dx * dx + dy * dy).sqrt() / step_s);
                    let yaw_rate = (TURNING_GAIN_PER_S * off).clamp(control.min[1], control.max[1]);
                    drive.go([speed_mps, yaw_rate], step_s);
                    (*at_x, *at_y) = (drive.x_m as f32, drive.y_m as f32);
                }
            }
            AnticipatingRobot::DoubleIntegrator { control, .. } => {
                let (mut at, mut speed) = ([0.0; 2], [x[2], x[3]]);
                for (at_x, at_y) in xs.iter_mut().zip(ys) {
                    let left = [goal[0] - at[0], goal[1] - at[1]];
                    let left_m = (left[0] * left[0] + left[1] * left[1]).sqrt().max(f64::MIN_POSITIVE);
                    let wanted_mps = self.cruise_speed_mps.min(left_m);
                    for axis in 0..2 {
                        let aim = wanted_mps * left[axis] / left_m;
                        let u = (VELOCITY_GAIN_PER_S * (aim - speed[axis]))
                            .clamp(control.min[axis], control.max[axis]);
                        at[axis] += speed[axis] * step_s + 0.5 * u * step_s * step_s;
                        speed[axis] += u * step_s;
                    }
                    (*at_x, *at_y) = (at[0] as f32, at[1] as f32);
                }
            }
        }
    }

    /// When a path is at `goal` (m, same axes), the rest of the way at cruising speed, s.
    pub(super) fn time_to_goal_s(&self, xs: &[f32], ys: &[f32], goal: [f64; 2]) -> f32 {
        let arrival = self.arrival(goal);
        let last = self.moments - 1;
        let least_s = arrival.time_s(last, xs[last], ys[last]);
        if !self.could_reach(goal) {
            return least_s;
        }
        (REACHED_EVERY - 1..last)
            .step_by(REACHED_EVERY)
            .filter(|&moment| arrival.left_m(xs[moment], ys[moment]) < REACHED_M as f32)
            .map(|moment| arrival.time_s(moment, xs[moment], ys[moment]))
            .fold(least_s, f32::min)
    }

    /// [`Self::time_to_goal_s`] of every manoeuvre, in their order.
    pub(super) fn times_to_goal_s(&mut self, goal: [f64; 2], times_s: &mut [f32]) {
        let (arrival, last) = (self.arrival(goal), self.moments - 1);
        for (time_s, &[x, y]) in times_s.iter_mut().zip(&self.ends) {
            *time_s = arrival.time_s(last, x, y);
        }
        if !self.could_reach(goal) {
            return;
        }
        // Only a path that comes near along both axes is worth a look at every moment.
        let [goal_x, goal_y] = arrival.goal;
        let [near_x, near_y] = &mut self.near;
        find_near(&self.xs, self.moments, goal_x, near_x);
        find_near(&self.ys, self.moments, goal_y, near_y);
        for (index, &[x, y]) in self.rows.iter().enumerate() {
            if self.near[0][x] && self.near[1][y] {
                let (xs, ys) = self.path(index);
                times_s[index] = self.time_to_goal_s(xs, ys, goal);
            }
        }
    }

    /// Whether `goal` is so near that the robot could be there within the horizon.
    fn could_reach(&self, goal: [f64; 2]) -> bool {
        let horizon_m = self.top_speed_mps() * self.step_s * self.moments as f64 + REACHED_M;
        goal[0] * goal[0] + goal[1] * goal[1] <= horizon_m * horizon_m
    }

    fn arrival(&self, goal: [f64; 2]) -> Arrival {
        Arrival {
            goal: goal.map(|coordinate| coordinate as f32),
            step_s: self.step_s as f32,
            cruise_speed_mps: self.cruise_speed_mps as f32,
        }
    }

    /// The control of `manoeuvre` after `begun_s`, at `x`.
    pub(super) fn control(&self, manoeuvre: &Manoeuvre, begun_s: f64, x: &[f64; 4]) -> [f64; 2] {
        let aim = manoeuvre.aim(begun_s);
        match self.robot {
            AnticipatingRobot::Unicycle { .. } => aim,
            AnticipatingRobot::DoubleIntegrator { control, .. } => [0, 1].map(|axis| {
                ((aim[axis] - x[axis + 2]) / self.step_s).clamp(control.min[axis], control.max[axis])
            }),
        }
    }
}

/// When the goal is reached from somewhere.
struct Arrival {
    goal: [f32; 2],
    step_s: f32,
    cruise_speed_mps: f32,
}

impl Arrival {
    fn left_m(&self, x: f32, y: f32) -> f32 {
        let (dx, dy) = (self.goal[0] - x, self.goal[1] - y);
        (dx * dx + dy * dy).sqrt()
    }

    /// For a robot that is at `(x, y)` at this moment and cruises from there.
    fn time_s(&self, moment: usize, x: f32, y: f32) -> f32 {
        (moment + 1) as f32 * self.step_s + self.left_m(x, y) / self.cruise_speed_mps
    }
}

/// A unicycle that starts at the origin along the x axis.
#[derive(Debug, Default)]
struct Drive {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
}

impl Drive {
    /// Goes on at `[speed, yaw rate]` for `step_s`, by the midpoint rule.
    fn go(&mut self, [speed_mps, yaw_rate_radps]: [f64; 2], step_s: f64) {
        let middle_rad = self.heading_rad + 0.5 * yaw_rate_radps * step_s;
        self.x_m += speed_mps * step_s * middle_rad.cos();
        self.y_m += speed_mps * step_s * middle_rad.sin();
        self.heading_rad += yaw_rate_radps * step_s;
    }
}

/// The ways of `N` profiles along an axis, one after the other in `ways`, from the speed `v` within `limits` of the acceleration.
fn accelerate<const N: usize>(
    profiles: &[Profile; N],
    v: f64,
    limits: [f64; 2],
    step_s: f64,
    ways: &mut [f32],
) {
    // One array for each field, so that the compiler computes profiles side by side.
    let [first_mps, second_mps] = [0, 1].map(|part| profiles.map(|profile| profile.aims_mps[part]));
    let switch_s = profiles.map(|profile| profile.switch_s);
    let (mut way_m, mut speed_mps) = ([0.0; N], [v; N]);
    let moments = ways.len() / N;
    for moment in 0..moments {
        let t_s = moment as f64 * step_s;
        for k in 0..N {
            let aim_mps = if t_s < switch_s[k] { first_mps[k] } else { second_mps[k] };
            let a = ((aim_mps - speed_mps[k]) / step_s).clamp(limits[0], limits[1]);
            way_m[k] += speed_mps[k] * step_s + 0.5 * a * step_s * step_s;
            speed_mps[k] += a * step_s;
        }
        for k in 0..N {
            ways[k * moments + moment] = way_m[k] as f32;
        }
    }
}

/// Which rows of `table`, of so many `moments` each, come near `goal` where a path is asked whether it has reached it.
fn find_near(table: &[f32], moments: usize, goal: f32, near: &mut [bool]) {
    for (near, ways) in near.iter_mut().zip(table.chunks_exact(moments)) {
        let mut asked = ways.iter().skip(REACHED_EVERY - 1).step_by(REACHED_EVERY);
        *near = asked.any(|way| (goal - way).abs() < NEAR_M);
    }
}

/// All cells of a grid of `levels` over `bounds`, the second component fastest.
fn grid(bounds: &InputBox<2>, levels: [usize; 2]) -> impl Iterator<Item = [f64; 2]> + use<> {
    let bounds = *bounds;
    (0..levels[0] * levels[1]).map(move |cell| {
        [
            between(bounds.min[0], bounds.max[0], cell / levels[1], levels[0]),
            between(bounds.min[1], bounds.max[1], cell % levels[1], levels[1]),
        ]
    })
}

fn between(least: f64, most: f64, level: usize, levels: usize) -> f64 {
    least + (most - least) * level as f64 / (levels - 1) as f64
}
