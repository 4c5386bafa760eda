//! What a value function promises, checked by playing the game, independently of how it was solved.
//!
//! From `V(z) = c` the robot that plays `argmax_u ∇V·ζ` is never approached closer than `c`, whatever the
//! obstacle does; from `V(z) < 0` the obstacle that plays `argmin_d ∇V·ζ` hits, whatever the robot does.
//!
//! The first is checked for obstacles slower than the robot. A faster one must be dodged at the right moment;
//! there a grid of 20 headings promises too much, which is a matter of resolution and not of this test's grid.

#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not recognise as such

use dynamics::{InputBox, RelativeDynamics, UnicyclePair, wrap_angle};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use reachability::{
    Axis, Convergence, Dissipation, Grid, ProblemDescription, SolverSettings, TimeIntegrator, TubeForm,
    UpwindScheme, ValueFunction, disc_failure_function, solve,
};
use std::f64::consts::PI;
use std::ops::{ControlFlow, Range};

const RADIUS_M: f64 = 0.7;
const HORIZON_S: f64 = 4.0;
const STEP_S: f64 = 0.02;

fn pair() -> UnicyclePair {
    UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    }
}

fn solved() -> ValueFunction {
    let grid = Grid::new([
        Axis::bounded(-5.0, 5.0, 51),
        Axis::bounded(-5.0, 5.0, 51),
        Axis::periodic(-PI, PI, 20),
        Axis::bounded(0.0, 1.5, 4),
    ])
    .unwrap();
    let settings = SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: HORIZON_S,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    };
    let failure = disc_failure_function(RADIUS_M);
    let solution = solve(&pair(), &failure, &grid, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
    let problem = ProblemDescription {
        dynamics: "unicycle_pair".to_owned(),
        control: (&pair().control).into(),
        disturbance: (&pair().disturbance).into(),
        failure_radius_m: RADIUS_M,
    };
    ValueFunction::new(solution, problem)
}

/// Plays for the horizon or until the pair leaves the grid and returns the smallest `ℓ`, m.
fn play(
    value: &ValueFunction,
    mut z: [f64; 4],
    robot: impl Fn(&[f64; 4], &[f64; 4]) -> [f64; 2],
    obstacle: impl Fn(&[f64; 4], &[f64; 4]) -> [f64; 1],
) -> f64 {
    let (pair, failure) = (pair(), disc_failure_function(RADIUS_M));
    let mut smallest = failure(&z);
    for _ in 0..(HORIZON_S / STEP_S) as usize {
        let Some(gradient) = value.gradient(&z) else { break };
        let (u, d) = (robot(&z, &gradient), obstacle(&z, &gradient));
        let here = pair.flow(&z, &u, &d);
        let middle: [f64; 4] = std::array::from_fn(|i| z[i] + 0.5 * STEP_S * here[i]);
        let there = pair.flow(&middle, &u, &d);
        z = std::array::from_fn(|i| z[i] + STEP_S * there[i]);
        z[2] = wrap_angle(z[2]);
        smallest = smallest.min(failure(&z));
    }
    smallest
}

/// Draws states whose value lies in `range`, m, obstacle speeds in `speed`, m/s, discs not overlapping yet.
fn states(value: &ValueFunction, range: Range<f64>, speed: Range<f64>, count: usize) -> Vec<[f64; 4]> {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    std::iter::repeat_with(|| {
        let mut within = |low: f64, high: f64| random.random_range(low..high);
        [within(-3.5, 3.5), within(-3.5, 3.5), within(-PI, PI), within(speed.start, speed.end)]
    })
    .filter(|z| {
        z[0].hypot(z[1]) > RADIUS_M + 0.05 && value.interpolate(z).is_some_and(|v| range.contains(&v))
    })
    .take(count)
    .collect()
}

#[test]
fn value_is_what_optimal_play_gives() {
    let value = solved();
    let pair = pair();
    let evade = |z: &[f64; 4], p: &[f64; 4]| pair.optimal_control(z, p);
    let pursue = |z: &[f64; 4], p: &[f64; 4]| pair.optimal_disturbance(z, p);

    // Safe states: no obstacle tried gets nearer than promised.
    let (mut worst, mut collisions, safe) = (0.0_f64, 0, states(&value, 0.2..1.0, 0.0..0.8, 300));
    for z in &safe {
        let promised = value.interpolate(z).unwrap();
        let fixed = |turn_rate: f64| move |_: &[f64; 4], _: &[f64; 4]| [turn_rate];
        let reached = play(&value, *z, evade, pursue)
            .min(play(&value, *z, evade, fixed(-0.35)))
            .min(play(&value, *z, evade, fixed(0.0)))
            .min(play(&value, *z, evade, fixed(0.35)));
        worst = worst.max(promised - reached);
        collisions += u32::from(reached <= 0.0);
    }
    println!(
        "safe: {collisions} collisions in {} games, at worst {worst:.3} m below the promise",
        safe.len()
    );

    // Lost states: no control tried escapes.
    let (mut farthest, mut escapes, lost) = (f64::NEG_INFINITY, 0, states(&value, -1.0..-0.1, 0.0..1.5, 300));
    for z in &lost {
        let steady = |u: [f64; 2]| move |_: &[f64; 4], _: &[f64; 4]| u;
        let reached = [[0.25, -0.8], [0.25, 0.0], [0.25, 0.8], [1.0, -0.8], [1.0, 0.0], [1.0, 0.8]]
            .map(|u| play(&value, *z, steady(u), pursue))
            .into_iter()
            .fold(play(&value, *z, evade, pursue), f64::max);
        farthest = farthest.max(reached);
        escapes += u32::from(reached > 0.0);
    }
    println!("lost: {escapes} escapes in {} games, by {farthest:.3} m at most", lost.len());
    assert_eq!(collisions, 0);
    // Measured 0.21 m, about one cell of this grid.
    assert!(worst < 0.3);
    assert_eq!(escapes, 0);
}
