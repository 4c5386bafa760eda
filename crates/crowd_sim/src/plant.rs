//! Robot plants: what a commanded input does to a robot.
//!
//! Lives here: clipping to the actuators, their lag and rate limit, and the exact integration of both robots for a
//! constant input. Their dead time is in `delay`. No contact with people: that is `ledger`.

use dynamics::{InputBox, wrap_angle};
use serde::{Deserialize, Serialize};
use settings::{RobotKind, Settings};

use crate::delay::DelayLine;
use crate::scenario::RobotStart;

/// Longest dead time, s.
const LONGEST_DELAY_S: f64 = 10.0;

/// Which robot it is, hence what its two inputs mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlantModel {
    /// Kinematic unicycle; inputs: forward speed in m/s and yaw rate in rad/s (paper eq. kin_unicycle).
    Unicycle,
    /// Planar double integrator; inputs: acceleration `[x, y]` in `odom`, m/s².
    DoubleIntegrator,
}

/// Settings of a plant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlantSettings {
    /// Which robot.
    pub model: PlantModel,
    /// What the actuators can do, in units of the inputs. Wider than the filter's set of controls where that one
    /// excludes zero, since a robot must be able to stop when told to brake: zero has to lie inside.
    pub actuator_limits: InputBox<2>,
    /// Dead time after which the actuators begin to follow a command, s, at most 10; zero for none.
    #[serde(default)]
    pub delay_s: f64,
    /// Time constant with which the actuators then follow it, s; zero for none.
    pub lag_s: f64,
    /// Highest rate of change of each achieved input, in its unit per second.
    pub input_rate_limit_per_s: Option<[f64; 2]>,
    /// Highest speed along each axis, m/s. Double integrator only: its speed is a state, not an input.
    pub axis_speed_limit_mps: Option<f64>,
}

impl PlantSettings {
    /// The paper's ground robot, without lag: up to 1 m/s forward and 0.8 rad/s, and able to stop.
    pub fn ground_robot() -> Self {
        Self {
            model: PlantModel::Unicycle,
            actuator_limits: InputBox { min: [0.0, -0.8], max: [1.0, 0.8] },
            delay_s: 0.0,
            lag_s: 0.0,
            input_rate_limit_per_s: None,
            axis_speed_limit_mps: None,
        }
    }

    /// The paper's quadrotor in the plane, without lag: up to 2 m/s² and 2 m/s on each axis.
    pub fn quadrotor() -> Self {
        Self {
            model: PlantModel::DoubleIntegrator,
            actuator_limits: InputBox { min: [-2.0, -2.0], max: [2.0, 2.0] },
            delay_s: 0.0,
            lag_s: 0.0,
            input_rate_limit_per_s: None,
            axis_speed_limit_mps: Some(2.0),
        }
    }

    /// The simulated robot of `settings`: the actuators reach zero even where the filter's controls do not, since a brake must
    /// work.
    pub fn of(settings: &Settings) -> Self {
        let robot = &settings.robot;
        let limit = settings.simulation.acceleration_limit;
        let actuators = settings.simulation.actuators.as_ref();
        Self {
            actuator_limits: InputBox {
                min: robot.control_min.map(|lowest| lowest.min(0.0)),
                max: robot.control_max.map(|highest| highest.max(0.0)),
            },
            delay_s: actuators.map_or(0.0, |actuators| actuators.delay_ms * 1e-3),
            lag_s: actuators.map_or(0.0, |actuators| actuators.lag_ms * 1e-3),
            input_rate_limit_per_s: (limit > 0.0).then_some([limit; 2]),
            ..match robot.kind {
                RobotKind::Unicycle => Self::ground_robot(),
                RobotKind::DoubleIntegrator => Self::quadrotor(),
            }
        }
    }
}

/// Why a plant cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// Zero input lies outside of the actuators' reach.
    #[error("actuator limits {min:?}..{max:?} exclude zero, so the robot could not be stopped; include it")]
    CannotStop {
        /// Lower limits.
        min: [f64; 2],
        /// Upper limits.
        max: [f64; 2],
    },
    /// A number is negative, zero where it must not be, or not finite.
    #[error(
        "plant: {field} is {value}; give a finite number that is not negative (limits: greater than zero)"
    )]
    BadNumber {
        /// Name of the setting.
        field: &'static str,
        /// Its value.
        value: f64,
    },
    /// The dead time is negative, not finite, or longer than any actuator's.
    #[error("plant: delay_s is {delay_s}; give 0 to {LONGEST_DELAY_S} s")]
    BadDelay {
        /// Its value, s.
        delay_s: f64,
    },
}

/// Where the robot is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobotState {
    /// Centre in `odom`, m.
    pub position_m: [f64; 2],
    /// Heading in `odom`, rad, in [−π, π); constant for the double integrator.
    pub heading_rad: f64,
    /// Velocity in `odom`, m/s.
    pub velocity_mps: [f64; 2],
    /// Rate of the heading, rad/s.
    pub yaw_rate_radps: f64,
}

impl RobotState {
    /// Velocity in the robot's own frame `[forward, left]`, m/s.
    pub fn body_velocity_mps(&self) -> [f64; 2] {
        let (s, c) = self.heading_rad.sin_cos();
        let [vx, vy] = self.velocity_mps;
        [c * vx + s * vy, -s * vx + c * vy]
    }
}

/// A robot in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    settings: PlantSettings,
    /// Absent without dead time.
    delay: Option<DelayLine>,
    state: RobotState,
    achieved_input: [f64; 2],
}

impl Plant {
    /// Puts the robot at its start, at rest.
    ///
    /// # Errors
    /// See [`PlantError`].
    pub fn new(settings: PlantSettings, start: RobotStart) -> Result<Self, PlantError> {
        let InputBox { min, max } = settings.actuator_limits;
        if !(0..2).all(|k| min[k] <= 0.0 && max[k] >= 0.0 && min[k].is_finite() && max[k].is_finite()) {
            return Err(PlantError::CannotStop { min, max });
        }
        if !(settings.lag_s.is_finite() && settings.lag_s >= 0.0) {
            return Err(PlantError::BadNumber { field: "lag_s", value: settings.lag_s });
        }
        if !(0.0..=LONGEST_DELAY_S).contains(&settings.delay_s) {
            return Err(PlantError::BadDelay { delay_s: settings.delay_s });
        }
        let limits = [
            ("input_rate_limit_per_s", settings.input_rate_limit_per_s.map(|rate| rate[0])),
            ("input_rate_limit_per_s", settings.input_rate_limit_per_s.map(|rate| rate[1])),
            ("axis_speed_limit_mps", settings.axis_speed_limit_mps),
        ];
        for (field, limit) in limits {
            match limit {
                Some(value) if !(value.is_finite() && value > 0.0) => {
                    return Err(PlantError::BadNumber { field, value });
                }
                Some(_) | None => {}
            }
        }
        let state = RobotState {
            position_m: start.position_m,
            heading_rad: wrap_angle(start.heading_rad),
            velocity_mps: [0.0, 0.0],
            yaw_rate_radps: 0.0,
        };
        let delay = (settings.delay_s > 0.0).then(|| DelayLine::new(settings.delay_s));
        Ok(Self { settings, delay, state, achieved_input: [0.0, 0.0] })
    }

    /// The state now.
    pub fn state(&self) -> &RobotState {
        &self.state
    }

    /// The settings.
    pub fn settings(&self) -> &PlantSettings {
        &self.settings
    }

    /// Applies `control` (finite; units by [`PlantModel`]) for `dt_s` (s, positive).
    ///
    /// The actuators move first, then the robot is integrated exactly with what they achieved held over the step. With a dead
    /// time, the step is divided where an earlier command takes effect. Allocates nothing.
    pub fn step(&mut self, dt_s: f64, control: [f64; 2]) {
        let Some(delay) = &mut self.delay else {
            return self.obey(dt_s, control);
        };
        delay.command(control);
        let mut left_s = dt_s;
        while left_s > 0.0
            && let Some((control, lasts_s)) = self.delay.as_mut().map(|delay| delay.next(left_s))
        {
            self.obey(lasts_s, control);
            left_s -= lasts_s;
        }
    }

    /// What `control` does if it takes effect now.
    fn obey(&mut self, dt_s: f64, control: [f64; 2]) {
        self.move_actuators(dt_s, control);
        match self.settings.model {
            PlantModel::Unicycle => self.drive(dt_s),
            PlantModel::DoubleIntegrator => self.accelerate(dt_s),
        }
    }

    fn move_actuators(&mut self, dt_s: f64, control: [f64; 2]) {
        let PlantSettings { actuator_limits, lag_s, input_rate_limit_per_s, .. } = &self.settings;
        let wanted = actuator_limits.clamp(&control);
        for k in 0..2 {
            let before = self.achieved_input[k];
            let mut after = if *lag_s > 0.0 {
                wanted[k] + (before - wanted[k]) * (-dt_s / lag_s).exp()
            } else {
                wanted[k]
            };
            if let Some(rate_per_s) = input_rate_limit_per_s {
                after = after.clamp(before - rate_per_s[k] * dt_s, before + rate_per_s[k] * dt_s);
            }
            self.achieved_input[k] = after;
        }
    }

    /// Constant speed and yaw rate: an arc, given by its chord.
    fn drive(&mut self, dt_s: f64) {
        let [speed_mps, yaw_rate_radps] = self.achieved_input;
        let half_turn_rad = 0.5 * yaw_rate_radps * dt_s;
        let chord_m = speed_mps * dt_s * sin_over(half_turn_rad);
        let (s, c) = (self.state.heading_rad + half_turn_rad).sin_cos();
        self.state.position_m[0] += chord_m * c;
        self.state.position_m[1] += chord_m * s;
        self.state.heading_rad = wrap_angle(self.state.heading_rad + 2.0 * half_turn_rad);
        let (s, c) = self.state.heading_rad.sin_cos();
        self.state.velocity_mps = [speed_mps * c, speed_mps * s];
        self.state.yaw_rate_radps = yaw_rate_radps;
    }

    /// Constant acceleration: a parabola, cut off where an axis reaches its highest speed.
    fn accelerate(&mut self, dt_s: f64) {
        let limit_mps = self.settings.axis_speed_limit_mps.unwrap_or(f64::INFINITY);
        for k in 0..2 {
            let acceleration_mps2 = self.achieved_input[k];
            let before_mps = self.state.velocity_mps[k];
            let unlimited_mps = before_mps + acceleration_mps2 * dt_s;
            let after_mps = unlimited_mps.clamp(-limit_mps, limit_mps);
            // The time for which the axis still accelerates; afterwards it coasts at its limit.
            let accelerating_s =
                if after_mps == unlimited_mps { dt_s } else { (after_mps - before_mps) / acceleration_mps2 };
            self.state.position_m[k] +=
                0.5 * (before_mps + after_mps) * accelerating_s + after_mps * (dt_s - accelerating_s);
            self.state.velocity_mps[k] = after_mps;
        }
    }
}

/// `sin(x)/x`, continued by its series near zero, where the quotient loses its digits.
fn sin_over(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}
