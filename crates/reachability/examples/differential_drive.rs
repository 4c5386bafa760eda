//! A pair made outside this workspace: a differential drive among things that stand still.
//!
//! The robot is commanded by the speeds of its two wheels, so it can stop, reverse and turn on the spot. The relative state
//! has two components, and the value function is solved in seconds:
//!
//! ```text
//! cargo run --release -p reachability --example differential_drive
//! ```
//!
//! `docs/own_dynamics.md` walks through this file.

use dynamics::{InputBox, RelativeDynamics};
use reachability::{
    Axis, Convergence, Dissipation, Grid, Outcome, Solution, SolverSettings, TimeIntegrator, TubeForm,
    UpwindScheme, disc_failure_function, solve,
};
use std::error::Error;
use std::ops::ControlFlow;

/// Robot and obstacle radius together, m.
const RADIUS_M: f64 = 0.5;
/// Half the side of the square that is looked at, m.
const HALF_WIDTH_M: f64 = 2.0;

/// Differential drive and an obstacle that stands still.
///
/// * control `u = [left_mps, right_mps]`, the speeds of the wheels' rims;
/// * relative `z = [x_rel_m, y_rel_m]`: the obstacle seen from the robot, x forward, y left.
///
/// ```text
/// v = (u₁ + u₂)/2     ω = (u₂ − u₁)/track     ż₁ = −v + ω z₂     ż₂ = −ω z₁
/// ```
pub struct DifferentialDrive {
    /// Limits of the wheels' speeds.
    pub wheels: InputBox<2>,
    /// Distance between the wheels, m.
    pub track_m: f64,
    /// What the obstacle may do: nothing.
    pub no_input: InputBox<0>,
}

impl RelativeDynamics<2, 2, 0> for DifferentialDrive {
    fn drift(&self, _z: &[f64; 2]) -> [f64; 2] {
        [0.0; 2]
    }

    fn control_jacobian(&self, z: &[f64; 2]) -> [[f64; 2]; 2] {
        let turn_per_mps = 1.0 / self.track_m;
        [
            [-0.5 - z[1] * turn_per_mps, -0.5 + z[1] * turn_per_mps],
            [z[0] * turn_per_mps, -z[0] * turn_per_mps],
        ]
    }

    fn disturbance_jacobian(&self, _z: &[f64; 2]) -> [[f64; 0]; 2] {
        [[]; 2]
    }

    fn control_box(&self) -> &InputBox<2> {
        &self.wheels
    }

    fn disturbance_box(&self) -> &InputBox<0> {
        &self.no_input
    }
}

/// Solves for wheels that turn no slower than `min_mps` (negative: that reverse) and no faster than 1 m/s.
fn solved(min_mps: f64) -> Result<Solution<2>, Box<dyn Error>> {
    let robot = DifferentialDrive {
        wheels: InputBox::new([min_mps; 2], [1.0; 2])?,
        track_m: 0.5,
        no_input: InputBox::new([], [])?,
    };
    let axis = Axis::bounded(-HALF_WIDTH_M, HALF_WIDTH_M, 161);
    let settings = SolverSettings {
        upwind: UpwindScheme::Weno5,
        integrator: TimeIntegrator::TvdRk3,
        dissipation: Dissipation::OptimalPlay,
        tube: TubeForm::Variational,
        cfl: 0.75,
        max_horizon_s: 10.0,
        convergence: Convergence {
            check_interval_s: 0.5,
            unsafe_share_tolerance: 1e-5,
            value_tolerance_m: Some(1e-3),
            boundary_layer: 0.1,
        },
    };
    let failure_function = disc_failure_function(RADIUS_M);
    let grid = Grid::new([axis, axis])?;
    Ok(solve(&robot, &failure_function, &grid, &settings, &mut |_| ControlFlow::Continue(()))?)
}

/// Farthest obstacle straight ahead from which a touch cannot be avoided, m.
fn unsafe_ahead_m(solution: &Solution<2>) -> f64 {
    let grid = &solution.grid;
    let middle = grid.shape()[1] / 2;
    (0..grid.shape()[0])
        .map(|i| grid.node(&[i, middle]))
        .filter(|&node| solution.values[node] < 0.0)
        .map(|node| grid.state(node)[0])
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Area of the states from which a touch cannot be avoided, m².
fn unsafe_area_m2(solution: &Solution<2>) -> f64 {
    let cell_m2: f64 = solution.grid.axes().iter().map(Axis::spacing).product();
    solution.values.iter().filter(|value| **value < 0.0).count() as f64 * cell_m2
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("failure disc: radius {RADIUS_M} m, area {:.3} m²", std::f64::consts::PI * RADIUS_M * RADIUS_M);
    for (robot, min_mps) in
        [("may stop and reverse", -1.0), ("may stop", 0.0), ("keeps both wheels at 0.2 m/s or more", 0.2)]
    {
        let solution = solved(min_mps)?;
        let settled = match solution.outcome {
            Outcome::Converged => "settled",
            Outcome::HorizonReached => "not settled",
            Outcome::Interrupted => "interrupted",
        };
        println!(
            "{robot}: unavoidable within {:.3} m straight ahead, area {:.3} m² ({settled} after {} s, {} steps)",
            unsafe_ahead_m(&solution),
            unsafe_area_m2(&solution),
            solution.horizon_s,
            solution.steps
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dynamics::conformance::{check_game, check_mirror_symmetry, check_motion};

    fn robot() -> DifferentialDrive {
        DifferentialDrive {
            wheels: InputBox::new([-1.0, -0.8], [1.0, 1.2]).unwrap(),
            track_m: 0.5,
            no_input: InputBox::new([], []).unwrap(),
        }
    }

    #[test]
    fn conforms() {
        let scale = [3.0, 3.0];
        check_game(&robot(), &scale).unwrap();
        check_motion(&robot(), &scale, |z, [left, right], _, time_s| {
            // The robot drives from the origin of the world; the obstacle stays where it is and is looked at again.
            let heading = (right - left) / 0.5 * time_s;
            let way = 0.5 * (left + right) * time_s;
            let (dx, dy) = (z[0] - way * (0.5 * heading).cos(), z[1] - way * (0.5 * heading).sin());
            let (sin, cos) = heading.sin_cos();
            [cos * dx + sin * dy, -sin * dx + cos * dy]
        })
        .unwrap();
        let symmetric = DifferentialDrive { wheels: InputBox::new([-1.0; 2], [1.0; 2]).unwrap(), ..robot() };
        check_mirror_symmetry(&symmetric, &scale, &[1.0, -1.0]).unwrap();
    }

    #[test]
    fn whoever_can_stop_is_unsafe_only_where_it_touches() {
        let failure_function = disc_failure_function(RADIUS_M);
        for min_mps in [-1.0, 0.0] {
            let solution = solved(min_mps).unwrap();
            for (node, &value) in solution.values.iter().enumerate() {
                let distance = failure_function(&solution.grid.state(node));
                // Blunted by dissipation at the tip of the cone only, where robot and obstacle are one.
                assert!(
                    distance < -0.4 || (f64::from(value) - distance).abs() < 0.01,
                    "{value} instead of {distance} at {:?}",
                    solution.grid.state(node)
                );
            }
        }
    }

    #[test]
    fn whoever_cannot_stop_must_turn_in_time() {
        let solution = solved(0.2).unwrap();
        // The tightest circle has a radius of 0.375 m about the side of the inner wheel.
        let exact_m = (0.875_f64.powi(2) - 0.375_f64.powi(2)).sqrt();
        let found_m = unsafe_ahead_m(&solution);
        let spacing_m = solution.grid.axes()[0].spacing();
        assert!((found_m - exact_m).abs() < spacing_m, "{found_m} m instead of {exact_m} m");
    }

    #[test]
    fn the_guide_shows_this_file() {
        let (guide, code) =
            (include_str!("../../../docs/own_dynamics.md"), include_str!("differential_drive.rs"));
        let blocks: Vec<&str> =
            guide.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
        assert!(blocks.len() >= 3, "found {} blocks", blocks.len());
        for block in blocks {
            // A test's lines stand indented in this file.
            let as_here = |line: &str| code.lines().any(|own| own.trim() == line.trim());
            for line in block.lines() {
                assert!(as_here(line), "docs/own_dynamics.md shows a line that is not here: {line}");
            }
        }
    }
}
