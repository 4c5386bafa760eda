//! Whether people stay within what the obstacle model allows, from their true velocities at the crowd's own ticks.

use crowd_sim::CROWD_PERIOD_NS;
use settings::{RobotKind, Settings};

/// Who is slower has no heading, m/s.
const WALKING_MPS: f64 = 0.1;
/// Turn rate of the shares that are reported for both robots, rad/s: the paper's bound.
const TURN_RATE_RADPS: f64 = 0.35;
/// Acceleration on an axis of the shares that are reported for both robots, m/s²: the paper's bound.
const ACCELERATION_MPS2: f64 = 1.0;
/// Who was not seen for longer was away, ticks: nothing is known of how they moved.
const LONGEST_GAP_TICKS: u64 = 10;
/// A bound counts as left beyond this multiple of it: people who keep to it exactly shall not leave it by rounding.
const TOLERANCE: f64 = 1.0 + 1e-6;

/// What the settings' obstacle model allows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bounds {
    kind: RobotKind,
    lowest: [f64; 2],
    highest: [f64; 2],
    max_speed_mps: f64,
}

impl Bounds {
    /// Those of `settings.obstacle`: turn rate (beside the ground robot) or accelerations (beside the quadrotor), and speed.
    pub(crate) fn of(settings: &Settings) -> Self {
        let obstacle = &settings.obstacle;
        let ends = |ends: &[f64]| [0, 1].map(|axis| ends.get(axis).or(ends.first()).copied().unwrap_or(0.0));
        Self {
            kind: settings.robot.kind,
            lowest: ends(&obstacle.disturbance_min),
            highest: ends(&obstacle.disturbance_max),
            max_speed_mps: obstacle.max_speed_mps,
        }
    }

    /// The unicycle's model knows no change of speed at all; one beyond 1 m/s² counts as leaving it.
    fn are_left(&self, step: &Step) -> bool {
        let beyond = |value: f64, axis: usize| {
            value > self.highest[axis] * TOLERANCE || value < self.lowest[axis] * TOLERANCE
        };
        let input = match self.kind {
            RobotKind::Unicycle => {
                step.turn_rate_radps.is_some_and(|rate| beyond(rate, 0))
                    || step.speed_rate_mps2.abs() > ACCELERATION_MPS2 * TOLERANCE
            }
            RobotKind::DoubleIntegrator => {
                beyond(step.acceleration_mps2[0], 0) || beyond(step.acceleration_mps2[1], 1)
            }
        };
        input || step.speed_mps > self.max_speed_mps * TOLERANCE
    }
}

/// How someone moved between two ticks.
struct Step {
    speed_mps: f64,
    speed_rate_mps2: f64,
    /// Nothing while the person stands.
    turn_rate_radps: Option<f64>,
    acceleration_mps2: [f64; 2],
}

/// Ticks in which anybody walked, and how many of them left which bound.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Shares {
    walking: u64,
    turned: u64,
    accelerated: u64,
    left: u64,
}

impl Shares {
    /// Turn rate beyond 0.35 rad/s, acceleration beyond 1 m/s² on an axis, outside of the settings' model; shares of
    /// walking time.
    pub(crate) fn shares(&self) -> [f64; 3] {
        [self.turned, self.accelerated, self.left].map(|ticks| ticks as f64 / self.walking.max(1) as f64)
    }
}

/// One person's motion so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Motion {
    last: Option<(u64, [f64; 2])>,
    /// Last tick with a heading, and the heading, rad.
    heading: Option<(u64, f64)>,
    /// When the bounds were left, ns, rising.
    left_at_ns: Vec<u64>,
}

impl Motion {
    /// Notes the velocity at crowd tick `tick`; times between ticks repeat the tick's velocity and are passed over.
    pub(crate) fn note(&mut self, tick: u64, velocity_mps: [f64; 2], bounds: &Bounds, shares: &mut Shares) {
        let known = self.last.filter(|(last_tick, _)| tick - last_tick.min(&tick) <= LONGEST_GAP_TICKS);
        let Some((last_tick, last_mps)) = known else {
            (self.last, self.heading) = (Some((tick, velocity_mps)), None);
            self.turn_rate_radps(tick, velocity_mps, velocity_mps[0].hypot(velocity_mps[1]));
            return;
        };
        if tick <= last_tick {
            return;
        }
        self.last = Some((tick, velocity_mps));
        let dt_s = ((tick - last_tick) * CROWD_PERIOD_NS) as f64 * 1e-9;
        let (speed_mps, last_speed_mps) =
            (velocity_mps[0].hypot(velocity_mps[1]), last_mps[0].hypot(last_mps[1]));
        let step = Step {
            speed_mps,
            speed_rate_mps2: (speed_mps - last_speed_mps) / dt_s,
            turn_rate_radps: self.turn_rate_radps(tick, velocity_mps, speed_mps),
            acceleration_mps2: [0, 1].map(|axis| (velocity_mps[axis] - last_mps[axis]) / dt_s),
        };
        let left = bounds.are_left(&step);
        if left {
            self.left_at_ns.push(tick * CROWD_PERIOD_NS);
        }
        if speed_mps > WALKING_MPS {
            shares.walking += 1;
            shares.turned +=
                u64::from(step.turn_rate_radps.is_some_and(|rate| rate.abs() > TURN_RATE_RADPS * TOLERANCE));
            shares.accelerated +=
                u64::from(step.acceleration_mps2.iter().any(|a| a.abs() > ACCELERATION_MPS2 * TOLERANCE));
            shares.left += u64::from(left);
        }
    }

    /// Change of heading since the person last had one. Who stops and goes elsewhere has turned.
    fn turn_rate_radps(&mut self, tick: u64, [vx, vy]: [f64; 2], speed_mps: f64) -> Option<f64> {
        if speed_mps <= WALKING_MPS {
            return None;
        }
        let heading_rad = vy.atan2(vx);
        let (last_tick, last_rad) = self.heading.replace((tick, heading_rad))?;
        let turned_rad = (heading_rad - last_rad).sin().atan2((heading_rad - last_rad).cos());
        Some(turned_rad / (((tick - last_tick) * CROWD_PERIOD_NS) as f64 * 1e-9))
    }

    /// Whether the bounds were left from `from_ns` to `to_ns`.
    pub(crate) fn left_between(&self, from_ns: u64, to_ns: u64) -> bool {
        let first = self.left_at_ns.partition_point(|&at_ns| at_ns < from_ns);
        self.left_at_ns.get(first).is_some_and(|&at_ns| at_ns <= to_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(kind: RobotKind) -> Bounds {
        let (lowest, highest) = match kind {
            RobotKind::Unicycle => ([-0.35; 2], [0.35; 2]),
            RobotKind::DoubleIntegrator => ([-1.0; 2], [1.0; 2]),
        };
        Bounds { kind, lowest, highest, max_speed_mps: 1.5 }
    }

    /// Notes a velocity for each of the first 100 ticks.
    fn walk(kind: RobotKind, velocity_mps: impl Fn(f64) -> [f64; 2]) -> (Motion, Shares) {
        let (mut motion, mut shares) = (Motion::default(), Shares::default());
        for tick in 0..=100 {
            motion.note(tick, velocity_mps(tick as f64 * 0.01), &bounds(kind), &mut shares);
        }
        (motion, shares)
    }

    #[test]
    fn turning_within_the_bound_is_no_departure_and_beyond_it_is() {
        let circle = |rate: f64| move |t: f64| [(rate * t).cos(), (rate * t).sin()];
        let (_, within) = walk(RobotKind::Unicycle, circle(0.34));
        assert_eq!(within.shares(), [0.0; 3]);
        let (motion, beyond) = walk(RobotKind::Unicycle, circle(-0.5));
        assert_eq!(beyond.shares(), [1.0, 0.0, 1.0]);
        assert!(
            motion.left_between(500_000_000, 510_000_000) && !motion.left_between(1_010_000_000, u64::MAX)
        );
    }

    #[test]
    fn who_stops_and_walks_off_elsewhere_has_turned() {
        let (motion, shares) = walk(RobotKind::Unicycle, |t| match t {
            t if t < 0.5 => [1.0, 0.0],
            t if t < 0.6 => [0.0, 0.0],
            _ => [0.0, 1.0],
        });
        assert!(shares.turned == 1 && motion.left_between(600_000_000, 600_000_000), "{shares:?}");
    }

    #[test]
    fn accelerations_count_on_each_axis() {
        let (_, shares) = walk(RobotKind::DoubleIntegrator, |t| [0.2 + 0.9 * t, 0.9 * t]);
        assert_eq!(shares.shares()[1..], [0.0; 2]);
        let (_, shares) = walk(RobotKind::DoubleIntegrator, |t| [0.2, 1.1 * t]);
        assert_eq!(shares.shares()[1..], [1.0; 2]);
    }

    #[test]
    fn times_between_ticks_are_passed_over() {
        let (mut motion, mut shares) = (Motion::default(), Shares::default());
        for tick in [0, 1, 1, 1, 2] {
            motion.note(tick, [1.0, 0.0], &bounds(RobotKind::Unicycle), &mut shares);
        }
        assert_eq!(shares.walking, 2);
    }
}
