//! Our half of the comparison with hj_reachability: seconds and errors on the paper's two grids, as one line of JSON.
//!
//! Seconds are given by the clock on the wall and by the processor; the latter also mean something on a shared machine.
//!
//! `tests/judges/hj_reachability_speed.py` runs the other half and this one, on the same cores one after the other, and joins
//! them. `OUT` is a folder; a file `hj_ground_robot.safetensors` in it is judged beside our own result.
//!
//! ```text
//! cargo run --release -p reachability --example solver_comparison -- OUT [--quick]
//! ```

use dynamics::{DoubleIntegratorPair, InputBox, RelativeDynamics, UnicyclePair};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use reachability::closed_form::DoubleIntegratorValue;
use reachability::{
    Axis, Convergence, Dissipation, Grid, Solution, SolverSettings, TimeIntegrator, TubeForm, UpwindScheme,
    disc_failure_function, solve,
};
use rustix::time::{ClockId, clock_gettime};
use safetensors::SafeTensors;
use serde_json::{Value, json};
use std::error::Error;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

const RADIUS_M: f64 = 0.7;
const SEED: u64 = 20_261;
/// Interior states of the quadrotor's grid that are compared.
const QUADROTOR_STATES: usize = 4_000;
/// Nodes nearer than this to the end of x or y feel the extrapolated boundary, m.
const EDGE_M: f64 = 1.0;

/// Sizes of the full comparison, or of one that only shows that everything runs.
struct Sizes {
    ground_robot: [usize; 4],
    ground_robot_horizon_s: f64,
    /// Twice the cells along x and y, three times the headings: every coarse node is one of its nodes.
    reference: [usize; 4],
    quadrotor: [usize; 4],
    quadrotor_horizon_s: f64,
}

const FULL: Sizes = Sizes {
    ground_robot: [80, 80, 20, 10],
    ground_robot_horizon_s: 5.0,
    reference: [159, 159, 60, 10],
    quadrotor: [80, 80, 20, 20],
    quadrotor_horizon_s: 3.0,
};

const QUICK: Sizes = Sizes {
    ground_robot: [40, 40, 12, 5],
    ground_robot_horizon_s: 1.0,
    reference: [79, 79, 36, 5],
    quadrotor: [40, 40, 16, 16],
    quadrotor_horizon_s: 1.5,
};

fn settings(max_horizon_s: f64) -> SolverSettings {
    SolverSettings {
        upwind: UpwindScheme::Weno3,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s,
        convergence: Convergence {
            check_interval_s: max_horizon_s,
            unsafe_share_tolerance: 0.0,
            value_tolerance_m: None,
            boundary_layer: 0.0,
        },
    }
}

fn timed<const NU: usize, const ND: usize>(
    dynamics: &impl RelativeDynamics<4, NU, ND>,
    grid: &Grid<4>,
    horizon_s: f64,
) -> Result<(Solution<4>, Value), Box<dyn Error>> {
    #[expect(clippy::disallowed_methods, reason = "a stopwatch: nothing is controlled by it")]
    let now = Instant::now;
    let cpu_s = || {
        let time = clock_gettime(ClockId::ProcessCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    };
    let (start, cpu_start_s) = (now(), cpu_s());
    let failure = disc_failure_function(RADIUS_M);
    let solution = solve(dynamics, &failure, grid, &settings(horizon_s), &mut |_| ControlFlow::Continue(()))?;
    let seconds = json!({
        "wall_s": start.elapsed().as_secs_f64(),
        "cpu_s": cpu_s() - cpu_start_s,
        "steps": solution.steps,
    });
    Ok((solution, seconds))
}

/// Mean, 99th percentile and maximum of absolute errors, m.
fn summary(mut errors: Vec<f64>) -> Value {
    errors.sort_by(f64::total_cmp);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    json!({
        "states": errors.len(),
        "mean_m": mean,
        "p99_m": errors[errors.len() * 99 / 100],
        "max_m": errors[errors.len() - 1],
    })
}

fn ground_robot_grid(count: [usize; 4]) -> Result<Grid<4>, Box<dyn Error>> {
    Ok(Grid::new([
        Axis::bounded(-6.0, 6.0, count[0]),
        Axis::bounded(-6.0, 6.0, count[1]),
        Axis::periodic(-PI, PI, count[2]),
        Axis::bounded(0.0, 1.5, count[3]),
    ])?)
}

/// Compares values on the coarse grid with those of the finer one at the same states, away from the edges.
fn against_reference(coarse: &Grid<4>, values: &[f32], reference: &Solution<4>) -> Value {
    let (mut errors, mut unsafe_states, mut called_safe) = (Vec::new(), 0_u32, 0_u32);
    for (node, &value) in values.iter().enumerate() {
        let z = coarse.state(node);
        if z[0].abs().max(z[1].abs()) > 6.0 - EDGE_M {
            continue;
        }
        let [x, y, heading, speed] = coarse.index(node);
        let exact = reference.values[reference.grid.node(&[2 * x, 2 * y, 3 * heading, speed])];
        errors.push(f64::from((value - exact).abs()));
        if exact < 0.0 {
            unsafe_states += 1;
            called_safe += u32::from(value >= 0.0);
        }
    }
    let mut summary = summary(errors);
    summary["unsafe_called_safe_share"] = json!(f64::from(called_safe) / f64::from(unsafe_states));
    summary
}

fn ground_robot(sizes: &Sizes, folder: &Path) -> Result<Value, Box<dyn Error>> {
    let pair = UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8])?,
        disturbance: InputBox::new([-0.35], [0.35])?,
    };
    let (grid, fine) = (ground_robot_grid(sizes.ground_robot)?, ground_robot_grid(sizes.reference)?);
    let (solution, seconds) = timed(&pair, &grid, sizes.ground_robot_horizon_s)?;
    eprintln!("ground robot: {seconds}; now the finer reference");
    let (reference, reference_seconds) = timed(&pair, &fine, sizes.ground_robot_horizon_s)?;
    let mut result = json!({
        "grid": sizes.ground_robot,
        "domain": grid.axes(),
        "horizon_s": sizes.ground_robot_horizon_s,
        "reference_grid": sizes.reference,
        "reference_seconds": reference_seconds,
        "ours": { "seconds": seconds, "error": against_reference(&grid, &solution.values, &reference) },
    });
    let theirs = folder.join("hj_ground_robot.safetensors");
    if theirs.exists() {
        let bytes = std::fs::read(theirs)?;
        let file = SafeTensors::deserialize(&bytes)?;
        let tensor = file.tensor("value")?;
        if tensor.shape() != grid.shape() {
            return Err(format!("hj_reachability solved {:?}, not this grid", tensor.shape()).into());
        }
        let values: Vec<f32> =
            tensor.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        result["hj_reachability"] = json!({ "error": against_reference(&grid, &values, &reference) });
    }
    Ok(result)
}

fn quadrotor(sizes: &Sizes) -> Result<Value, Box<dyn Error>> {
    let pair = DoubleIntegratorPair {
        control: InputBox::new([-2.0; 2], [2.0; 2])?,
        disturbance: InputBox::new([-1.0; 2], [1.0; 2])?,
    };
    let half = [4.0, 4.0, 3.5, 3.5];
    let grid = Grid::new(std::array::from_fn(|d| Axis::bounded(-half[d], half[d], sizes.quadrotor[d])))?;
    let (solution, seconds) = timed(&pair, &grid, sizes.quadrotor_horizon_s)?;
    let exact = DoubleIntegratorValue::new(&pair.control, &pair.disturbance, RADIUS_M)?;
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut errors = Vec::new();
    while errors.len() < QUADROTOR_STATES {
        let node = random.random_range(0..grid.node_count());
        let z = grid.state(node);
        // Three quarters of the domain along each axis.
        if (0..4).all(|d| z[d].abs() <= 0.75 * half[d]) {
            errors.push((f64::from(solution.values[node]) - exact.value_m(&z)).abs());
        }
    }
    let error = summary(errors);
    eprintln!("quadrotor: {seconds}, error {error}");
    Ok(json!({
        "grid": sizes.quadrotor,
        "domain": grid.axes(),
        "horizon_s": sizes.quadrotor_horizon_s,
        "ours": { "seconds": seconds, "error_against_closed_form": error },
    }))
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (folder, sizes) = match arguments.as_slice() {
        [folder] => (PathBuf::from(folder), FULL),
        [folder, quick] if quick == "--quick" => (PathBuf::from(folder), QUICK),
        _ => return Err("give a folder, and --quick for small grids".into()),
    };
    let result = json!({
        "accuracy": "high",
        "failure_radius_m": RADIUS_M,
        "threads": rayon::current_num_threads(),
        "quadrotor": quadrotor(&sizes)?,
        "ground_robot": ground_robot(&sizes, &folder)?,
    });
    println!("{result}");
    Ok(())
}
