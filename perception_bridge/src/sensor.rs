//! The simulated perception: who of the simulated people is seen, and how wrongly.
//!
//! Everything random is drawn from the scenario's seed, by one stream for each person and each kind of error, and drawn for
//! every frame, whether the person is present, seen, or neither. So the error of person 3 in frame 40 is the same in every run
//! of a scenario: whatever the robot does, and whatever other error is added or left out.

use bytemuck::Zeroable;
use crowd_sim::{PersonState, RobotState, Scenario, World};
use messages::{Detection, DetectionFlags, Detections, MAX_OBSTACLES, ObstacleClass};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use settings::{ClassName, SensingSettings, SimulationSettings};

use crate::nearest::by_distance;

/// Kinds of errors, as they select streams. A change changes every noisy run.
#[derive(Debug, Clone, Copy)]
enum Kind {
    White = 1,
    Drift = 2,
    Dropout = 3,
}

/// Who is seen at all.
#[derive(Debug, Clone)]
struct View {
    range_m: f64,
    window_m: f64,
    half_angle_rad: f64,
    is_occluding: bool,
}

/// A Gauss-Markov process in steps of one frame.
#[derive(Debug, Clone)]
struct Drift {
    /// Share that is kept from frame to frame.
    kept: f64,
    /// Standard deviation of what is added, m.
    added_m: f64,
}

/// The errors of one person.
#[derive(Debug, Clone)]
struct Errors {
    white: Pcg64,
    drift: Pcg64,
    dropout: Pcg64,
    drift_m: [f64; 2],
    offset_m: [f64; 2],
    is_missing: bool,
}

/// A sensor that travels with the robot.
#[derive(Debug, Clone)]
pub(crate) struct Sensor {
    view: View,
    white_m: f64,
    drift: Option<Drift>,
    dropout: f64,
    flags: u32,
    errors: Vec<Errors>,
    /// Indices of the people present, sorted by distance when a frame is made.
    nearest: Vec<usize>,
}

impl Sensor {
    /// As the settings say, for the people of `scenario`, its noise drawn from that one's seed.
    pub(crate) fn new(settings: &SimulationSettings, scenario: &Scenario) -> Self {
        let sensing = settings.sensing.as_ref();
        let drift = sensing.and_then(|sensing| sensing.drift);
        let period_s = settings.detections_period_ms as f64 * 1e-3;
        let hides_velocity = sensing.is_some_and(|sensing| sensing.hide_velocity);
        let errors = scenario.people.iter().map(|person| {
            let mut errors = Errors::new(scenario.seed, person.id);
            errors.drift_m = normal(&mut errors.drift, drift.map_or(0.0, |drift| drift.sigma_m));
            errors
        });
        Self {
            view: View::new(sensing),
            white_m: settings.position_noise_m,
            drift: drift.map(|drift| {
                let kept = (-period_s / drift.tau_s).exp();
                Drift { kept, added_m: drift.sigma_m * (1.0 - kept * kept).sqrt() }
            }),
            dropout: sensing.map_or(0.0, |sensing| sensing.dropout),
            flags: if hides_velocity { 0 } else { DetectionFlags::HAS_VELOCITY },
            errors: errors.collect(),
            nearest: Vec::with_capacity(scenario.people.len()),
        }
    }

    /// A frame of who is seen now, nearest first, without its stamp. To be asked for once in every period. Allocates nothing.
    pub(crate) fn look(&mut self, world: &World) -> Detections {
        for errors in &mut self.errors {
            errors.draw(self.white_m, self.drift.as_ref(), self.dropout);
        }
        let (robot, people) = (world.robot(), world.people());
        by_distance(&mut self.nearest, people.len(), robot.position_m, |index| people[index].position_m);
        let mut frame = Detections::zeroed();
        for person in self.nearest.iter().map(|&index| &people[index]) {
            let errors = &self.errors[person.index];
            if errors.is_missing || !self.view.sees(robot, person, people) {
                continue;
            }
            if let Some(item) = frame.items.get_mut(frame.count as usize) {
                *item = detection(person, errors.offset_m, self.flags);
                frame.count += 1;
            } else {
                frame.left_out += 1;
            }
        }
        debug_assert!(frame.count as usize <= MAX_OBSTACLES);
        frame
    }
}

impl View {
    fn new(sensing: Option<&SensingSettings>) -> Self {
        let or_all = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
        Self {
            range_m: or_all(sensing.and_then(|sensing| sensing.range_m)),
            window_m: or_all(sensing.and_then(|sensing| sensing.window_m)),
            half_angle_rad: or_all(sensing.and_then(|sensing| sensing.field_of_view_deg)).to_radians() / 2.0,
            is_occluding: sensing.is_some_and(|sensing| sensing.occlusion),
        }
    }

    fn sees(&self, robot: &RobotState, person: &PersonState, people: &[PersonState]) -> bool {
        let [dx, dy] = between(robot.position_m, person.position_m);
        let (sin, cos) = robot.heading_rad.sin_cos();
        let bearing_rad = (cos * dy - sin * dx).atan2(cos * dx + sin * dy);
        dx.hypot(dy) <= self.range_m
            && dx.abs().max(dy.abs()) <= self.window_m
            && bearing_rad.abs() <= self.half_angle_rad
            && !(self.is_occluding && people.iter().any(|other| hides(robot, other, person)))
    }
}

/// Whether the disc of `other` lies across the line from the robot's centre to that of `person`.
fn hides(robot: &RobotState, other: &PersonState, person: &PersonState) -> bool {
    let [dx, dy] = between(robot.position_m, person.position_m);
    let [ox, oy] = between(robot.position_m, other.position_m);
    let length_m = dx.hypot(dy);
    if other.id == person.id || ox.hypot(oy) >= length_m {
        return false;
    }
    // Nearest point of the line to the other's centre; behind the robot it is the robot itself, who is hidden by nobody.
    let along_m = (ox * dx + oy * dy) / length_m;
    let aside_m = (ox * dy - oy * dx).abs() / length_m;
    along_m > 0.0 && aside_m < other.radius_m
}

fn between(from_m: [f64; 2], to_m: [f64; 2]) -> [f64; 2] {
    [to_m[0] - from_m[0], to_m[1] - from_m[1]]
}

impl Errors {
    fn new(seed: u64, person_id: u64) -> Self {
        let stream = |kind: Kind| {
            // The generator shifts its selector left by one, so that the highest bit would be lost.
            Pcg64::new(u128::from(seed), (u128::from(person_id) << 8) | kind as u128)
        };
        Self {
            white: stream(Kind::White),
            drift: stream(Kind::Drift),
            dropout: stream(Kind::Dropout),
            drift_m: [0.0; 2],
            offset_m: [0.0; 2],
            is_missing: false,
        }
    }

    /// Goes on to the next frame.
    fn draw(&mut self, white_m: f64, drift: Option<&Drift>, dropout: f64) {
        self.offset_m = normal(&mut self.white, white_m);
        if let Some(Drift { kept, added_m }) = drift {
            let added_m = normal(&mut self.drift, *added_m);
            self.drift_m = [0, 1].map(|k| kept * self.drift_m[k] + added_m[k]);
            self.offset_m = [0, 1].map(|k| self.offset_m[k] + self.drift_m[k]);
        }
        self.is_missing = dropout > 0.0 && self.dropout.random::<f64>() < dropout;
    }
}

/// Two independent samples with standard deviation `sigma`; nothing is drawn for zero.
fn normal(random: &mut Pcg64, sigma: f64) -> [f64; 2] {
    if sigma > 0.0 {
        [0, 1].map(|_| sigma * Distribution::<f64>::sample(&StandardNormal, random))
    } else {
        [0.0; 2]
    }
}

fn detection(person: &PersonState, offset_m: [f64; 2], flags: u32) -> Detection {
    let is_velocity_known = flags & DetectionFlags::HAS_VELOCITY != 0;
    Detection {
        track_id: person.id,
        position_in_odom_m: [0, 1].map(|k| person.position_m[k] + offset_m[k]),
        velocity_in_odom_mps: if is_velocity_known { person.velocity_mps } else { [0.0; 2] },
        position_covariance_m2: [0.0; 3],
        radius_m: person.radius_m,
        class: class(person.class).code(),
        flags,
    }
}

/// A class of a scenario on the wire.
const fn class(name: ClassName) -> ObstacleClass {
    match name {
        ClassName::Pedestrian => ObstacleClass::Pedestrian,
        ClassName::Cyclist => ObstacleClass::Cyclist,
        ClassName::Static => ObstacleClass::Static,
        ClassName::Vehicle => ObstacleClass::Vehicle,
    }
}
