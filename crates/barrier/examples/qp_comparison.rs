//! The exact CBF-QP beside Clarabel on the same problems, in turns, as JSON.
//!
//! `cargo run --release -p barrier --example qp_comparison [ROUNDS]`
//!
//! Clarabel is used as a cycle would use it: set up once, its data overwritten. The exact solution is too short for the
//! clock, so its percentiles are of the means of batches.
#![allow(clippy::disallowed_methods)] // a measurement reads the clock
#![allow(clippy::unwrap_used)] // and may panic

use std::hint::black_box;
use std::time::Instant;

use barrier::{CbfQp, HalfSpace};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT::NonnegativeConeT,
};
use dynamics::InputBox;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

const MIN: [f64; 2] = [0.25, -0.8];
const MAX: [f64; 2] = [1.0, 0.8];
/// The slack is the variable `t = √w · slack`, so that the cost is the identity.
const SLACK_WEIGHT: f64 = 1e6;
const PROBLEMS: usize = 256;
const BATCH: usize = 64;

/// A nominal control and the row of people around a robot.
type Problem = ([f64; 2], HalfSpace<2>);

fn problems() -> Vec<Problem> {
    let mut rng = Pcg64::seed_from_u64(4);
    let mut within = |bound: f64| rng.random_range(-bound..bound);
    let mut problem = || {
        let row = HalfSpace { normal: [within(1.5), within(1.5)], offset: within(0.8) };
        ([0.6 + within(0.4), within(0.8)], row)
    };
    (0..PROBLEMS).map(|_| problem()).collect()
}

/// Rows `A v + s = b`, s ≥ 0, of `v = [u₀, u₁, t]`: the half-space, then the box.
fn constraints((_, row): &Problem) -> ([[f64; 3]; 5], Vec<f64>) {
    let [a, b] = row.normal;
    let half_space = [-a, -b, -1.0 / SLACK_WEIGHT.sqrt()];
    let boxed = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
    let bounds = vec![row.offset, MAX[0], -MIN[0], MAX[1], -MIN[1]];
    ([half_space, boxed[0], boxed[1], boxed[2], boxed[3]], bounds)
}

/// Clarabel with the pattern of these problems.
struct Clarabel(DefaultSolver<f64>);

impl Clarabel {
    fn new(problem: &Problem) -> Self {
        let (matrix, bounds) = constraints(problem);
        let settings = DefaultSettings {
            verbose: false,
            max_threads: 1,
            presolve_enable: false,
            input_sparse_dropzeros: false,
            ..DefaultSettings::default()
        };
        let linear = [-problem.0[0], -problem.0[1], 0.0];
        let cones = [NonnegativeConeT(5)];
        let matrix = CscMatrix::from(matrix.iter());
        Self(
            DefaultSolver::new(&CscMatrix::identity(3), &linear, &matrix, &bounds, &cones, settings).unwrap(),
        )
    }

    fn solve(&mut self, problem: &Problem) -> Option<[f64; 2]> {
        let (matrix, bounds) = constraints(problem);
        let matrix = CscMatrix::from(matrix.iter());
        self.0.update_A(&matrix.nzval).unwrap();
        self.0.update_b(&bounds).unwrap();
        self.0.update_q(&vec![-problem.0[0], -problem.0[1], 0.0]).unwrap();
        self.0.solve();
        let solution = &self.0.solution;
        (solution.status == SolverStatus::Solved).then(|| [solution.x[0], solution.x[1]])
    }
}

fn figures(mut durations_us: Vec<f64>) -> String {
    durations_us.sort_by(f64::total_cmp);
    let last = durations_us.len() - 1;
    let [min, p50, p99, max] =
        [0.0, 0.5, 0.99, 1.0].map(|share| durations_us[(share * last as f64) as usize]);
    let calls = durations_us.len();
    format!(r#"{{"calls": {calls}, "min_us": {min}, "p50_us": {p50}, "p99_us": {p99}, "max_us": {max}}}"#)
}

fn main() {
    let rounds: usize = std::env::args().nth(1).map_or(40, |rounds| rounds.parse().unwrap());
    let problems = problems();
    let qp = CbfQp::new(InputBox::new(MIN, MAX).unwrap(), SLACK_WEIGHT).unwrap();
    let mut clarabel = Clarabel::new(&problems[0]);
    let (mut exact_us, mut clarabel_us) = (Vec::new(), Vec::new());
    let (mut distance, mut undecided) = (0.0_f64, 0);
    for _ in 0..rounds {
        for batch in 0..PROBLEMS {
            let began = Instant::now();
            for index in 0..BATCH {
                let (nominal, row) = &problems[(batch + index) % PROBLEMS];
                black_box(qp.solve(black_box(nominal), Some(row)).unwrap());
            }
            exact_us.push(began.elapsed().as_secs_f64() * 1e6 / BATCH as f64);
        }
        for problem in &problems {
            let began = Instant::now();
            let judged = black_box(clarabel.solve(black_box(problem)));
            clarabel_us.push(began.elapsed().as_secs_f64() * 1e6);
            let exact = qp.solve(&problem.0, Some(&problem.1)).unwrap().u;
            match judged {
                Some(u) => distance = distance.max((u[0] - exact[0]).abs()).max((u[1] - exact[1]).abs()),
                None => undecided += 1,
            }
        }
    }
    println!(
        r#"{{"exact": {}, "clarabel": {}, "largest_difference": {distance:e}, "undecided_by_clarabel": {undecided}}}"#,
        figures(exact_us),
        figures(clarabel_us)
    );
}
