//! Time of one search for a way through the crowd, by robot and number of people: `cargo bench -p barrier --bench anticipation`.
#![allow(clippy::unwrap_used, missing_docs)] // a benchmark may panic

use barrier::{AnticipatingRobot, Anticipation, AnticipationHorizon, BarrierObstacle};
use divan::Bencher;
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const PEOPLE: [usize; 4] = [1, 5, 15, 20];
const SCENES: usize = 50;
const GOAL: [f64; 2] = [12.0, 0.0];

fn main() {
    divan::main();
}

fn horizon(
    clearance_m: f64,
    risk_weight: f64,
    turn_share: f64,
    cruise_speed_mps: f64,
) -> AnticipationHorizon {
    AnticipationHorizon {
        horizon_s: 3.0,
        moments: 32,
        clearance_m,
        clearance_growth_mps: 0.15,
        risk_weight,
        turn_share,
        trust_s: 2.0,
        negligible_risk_s: 0.1,
        cruise_speed_mps,
    }
}

/// People around the robot in a rectangle of 8 m by 8 m, none of them in contact with it, and their paces.
fn scene(rng: &mut Pcg64, people: usize) -> (Vec<BarrierObstacle>, Vec<f64>) {
    let mut crowd = Vec::new();
    while crowd.len() < people {
        let [x, y] = [rng.random_range(-3.0..5.0_f64), rng.random_range(-4.0..4.0_f64)];
        let (way, speed) = (rng.random_range(-3.1..3.1_f64), rng.random_range(0.8..1.5));
        if x.hypot(y) > 0.8 {
            let [vx, vy] = [speed * way.cos(), speed * way.sin()];
            let (state, rate) = ([x, y, vx, vy], [vx, vy, 0.0, 0.0]);
            crowd.push(BarrierObstacle { state, rate, radius_m: 0.75, model: 0 });
        }
    }
    let paces = crowd.iter().map(|person| person.rate[0].hypot(person.rate[1])).collect();
    (crowd, paces)
}

fn search(bencher: Bencher<'_, '_>, people: usize, robot: AnticipatingRobot, horizon: AnticipationHorizon) {
    let mut rng = Pcg64::seed_from_u64(5);
    let scenes: Vec<_> = (0..SCENES).map(|_| scene(&mut rng, people)).collect();
    let mut ahead = Anticipation::new(robot, horizon);
    let mut next = scenes.iter().cycle();
    bencher.bench_local(|| {
        let (crowd, paces) = next.next().unwrap();
        ahead.choose(&[0.0, 0.0, 1.0, 0.0], GOAL, crowd, paces, 0.02)
    });
}

#[divan::bench(args = PEOPLE, sample_count = 200, sample_size = 50)]
fn unicycle(bencher: Bencher<'_, '_>, people: usize) {
    let control = InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap();
    search(bencher, people, AnticipatingRobot::Unicycle { control }, horizon(0.45, 20.0, 0.05, 1.0));
}

#[divan::bench(args = PEOPLE, sample_count = 200, sample_size = 50)]
fn double_integrator(bencher: Bencher<'_, '_>, people: usize) {
    let control = InputBox::new([-2.0; 2], [2.0; 2]).unwrap();
    let robot = AnticipatingRobot::DoubleIntegrator { control, max_speed_mps: 2.0 };
    search(bencher, people, robot, horizon(0.5, 40.0, 0.2, 1.79));
}
