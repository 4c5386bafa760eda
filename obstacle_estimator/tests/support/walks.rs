//! People whose motion is known exactly, noisy sightings of them, and how far an estimator is off.

#![allow(dead_code)]

use bytemuck::Zeroable;
use messages::{Detection, Detections, MAX_OBSTACLES};
use obstacle_estimator::Estimator;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use settings::EstimatorSettings;

const MS: u64 = 1_000_000;
/// Time between two states of a walk, ms.
const STEP_MS: u64 = 10;
/// What an estimator is given to settle, ms.
const SETTLING_MS: u64 = 1_000;

/// Where somebody is and how they move, m, m/s, m/s².
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) position_m: [f64; 2],
    pub(crate) velocity_mps: [f64; 2],
    pub(crate) acceleration_mps2: [f64; 2],
}

/// What people do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Manner {
    /// They walk from goal to goal as the social force model has it: v̇ = 4 (v_d e - v), a new direction all at once.
    Goals,
    /// They walk straight for 2 s, then turn at ±1 rad/s for 1.5 s, at constant speed.
    Turns,
}

/// The walks of 64 people, each a state every 10 ms for `seconds`.
pub(crate) fn walks(manner: Manner, seconds: u64, seed: u64) -> Vec<Vec<State>> {
    let mut random = Pcg64::new(seed.into(), 7);
    (0..MAX_OBSTACLES).map(|_| walk(manner, seconds, &mut random)).collect()
}

fn walk(manner: Manner, seconds: u64, random: &mut Pcg64) -> Vec<State> {
    let dt_s = STEP_MS as f64 * 1e-3;
    let speed_mps = random.random_range(0.8..1.5);
    let mut heading = random.random_range(-3.0..3.0_f64);
    let mut somewhere = || [random.random_range(0.0..12.0), random.random_range(-4.0..4.0_f64)];
    let (mut p, mut goal) = (somewhere(), somewhere());
    let mut v = [speed_mps * heading.cos(), speed_mps * heading.sin()];
    (0..seconds * 1000 / STEP_MS)
        .map(|k| {
            let a = match manner {
                Manner::Goals => {
                    let way: [f64; 2] = [goal[0] - p[0], goal[1] - p[1]];
                    let distance_m = way[0].hypot(way[1]);
                    if distance_m < 0.3 {
                        goal = somewhere();
                    }
                    [0, 1].map(|i| 4.0 * (speed_mps * way[i] / distance_m.max(1e-9) - v[i]))
                }
                Manner::Turns => {
                    let phase_ms = k * STEP_MS % 7_000;
                    let turn_radps = match phase_ms {
                        2_000..3_500 => 1.0,
                        5_500..7_000 => -1.0,
                        _ => 0.0,
                    };
                    heading += turn_radps * dt_s;
                    let next = [speed_mps * heading.cos(), speed_mps * heading.sin()];
                    [0, 1].map(|i| (next[i] - v[i]) / dt_s)
                }
            };
            let state = State { position_m: p, velocity_mps: v, acceleration_mps2: a };
            for i in 0..2 {
                v[i] += a[i] * dt_s;
                p[i] += v[i] * dt_s;
            }
            state
        })
        .collect()
}

/// How people are seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight {
    pub(crate) interval_ms: u64,
    /// Of each coordinate, white, m.
    pub(crate) position_sd_m: f64,
    /// Probability that somebody is missing from a frame.
    pub(crate) dropout: f64,
    /// Age of a frame when it arrives, ms.
    pub(crate) latency_ms: u64,
}

/// Root mean squares over all people and frames, and shares.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// Of the velocity at the time of the sighting, m/s.
    pub(crate) velocity_mps: f64,
    /// Its 95th percentile, m/s.
    pub(crate) velocity_p95_mps: f64,
    /// Of the acceleration, m/s².
    pub(crate) acceleration_mps2: f64,
    /// Of the position when the frame arrives, predicted at constant velocity, m.
    pub(crate) position_m: f64,
    /// Share of frames in which that position is farther off than the radius has grown.
    pub(crate) outside_radius: f64,
    /// Mean growth of the radius, m.
    pub(crate) growth_m: f64,
    /// Tracks that were cut: teleported or interrupted.
    pub(crate) cut: u64,
    /// Standard deviation that positions are believed to have in the end, m.
    pub(crate) believed_sd_m: Option<f64>,
}

/// Shows `walks` to an estimator and compares.
pub(crate) fn errors(settings: &EstimatorSettings, walks: &[Vec<State>], sight: Sight, seed: u64) -> Errors {
    const RADIUS_M: f64 = 0.3;
    let mut random = Pcg64::new(seed.into(), 9);
    let mut estimator = Estimator::new(settings.clone());
    let (mut velocity2, mut acceleration2, mut position2) = (0.0, 0.0, 0.0);
    let (mut growth_m, mut outside, mut samples) = (0.0, 0_u64, 0_u64);
    let mut velocity_errors = Vec::new();
    let latency_steps = (sight.latency_ms / STEP_MS) as usize;
    let mut frame = Box::new(Detections::zeroed());
    let last = walks[0].len() - latency_steps;
    for at in (0..last).step_by((sight.interval_ms / STEP_MS) as usize) {
        frame.stamp.valid_at_ns = (1_000 + at as u64 * STEP_MS) * MS;
        frame.count = 0;
        for (person, walk) in walks.iter().enumerate() {
            let noise: [f64; 2] = [(); 2].map(|()| StandardNormal.sample(&mut random));
            if random.random::<f64>() < sight.dropout {
                continue;
            }
            frame.items[frame.count as usize] = Detection {
                track_id: person as u64 + 1,
                position_in_odom_m: [0, 1].map(|i| walk[at].position_m[i] + sight.position_sd_m * noise[i]),
                radius_m: RADIUS_M,
                class: 1,
                ..Detection::zeroed()
            };
            frame.count += 1;
        }
        let now_ns = frame.stamp.valid_at_ns + sight.latency_ms * MS;
        let answer = estimator.step(&frame, now_ns);
        if (at as u64) * STEP_MS < SETTLING_MS {
            continue;
        }
        for obstacle in answer.as_slice() {
            let walk = &walks[obstacle.track_id as usize - 1];
            let (truth, later) = (walk[at], walk[at + latency_steps]);
            let ahead_s = (now_ns - obstacle.valid_at_ns) as f64 * 1e-9;
            let off = |found: [f64; 2], truth: [f64; 2]| (found[0] - truth[0]).hypot(found[1] - truth[1]);
            let velocity = off(obstacle.velocity_in_odom_mps, truth.velocity_mps);
            let predicted =
                [0, 1].map(|i| obstacle.position_in_odom_m[i] + obstacle.velocity_in_odom_mps[i] * ahead_s);
            let position = off(predicted, later.position_m);
            velocity2 += velocity * velocity;
            velocity_errors.push(velocity);
            acceleration2 += off(obstacle.acceleration_in_odom_mps2, truth.acceleration_mps2).powi(2);
            position2 += position * position;
            growth_m += obstacle.radius_m - RADIUS_M;
            outside += u64::from(position > obstacle.radius_m - RADIUS_M);
            samples += 1;
        }
    }
    velocity_errors.sort_unstable_by(f64::total_cmp);
    let n = samples as f64;
    let counts = estimator.counts();
    Errors {
        velocity_mps: (velocity2 / n).sqrt(),
        velocity_p95_mps: velocity_errors[velocity_errors.len() * 95 / 100],
        acceleration_mps2: (acceleration2 / n).sqrt(),
        position_m: (position2 / n).sqrt(),
        outside_radius: outside as f64 / n,
        growth_m: growth_m / n,
        cut: counts.tracks_teleported + counts.tracks_interrupted,
        believed_sd_m: estimator.position_sd_m(),
    }
}
