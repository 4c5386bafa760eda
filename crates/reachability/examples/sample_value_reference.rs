//! Draws states from a solved value function and stores value and gradient there, for tests of the network.
//!
//! `cargo run --release -p reachability --example sample_value_reference -- value.safetensors tests/data/value_reference_ground_robot.json`

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use reachability::ValueFunction;
use serde_json::json;
use std::error::Error;
use std::path::Path;

const SEED: u64 = 20_260;
/// States spread evenly over the interior.
const EVEN_STATES: usize = 1_500;
/// States near the zero level, where the filter acts.
const NEAR_STATES: usize = 500;
/// Half-width of the band around the zero level, m.
const NEAR_M: f64 = 0.2;
/// Share of each bounded axis left out at either end: there the boundary is extrapolated.
const BOUNDARY_LAYER: f64 = 0.05;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [source, target] = arguments.as_slice() else {
        return Err("give the value file and the file to write".into());
    };
    let value_function: ValueFunction = ValueFunction::load(Path::new(source))?;
    let axes = value_function.grid().axes();
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut draw = || -> [f64; 4] {
        std::array::from_fn(|d| {
            let axis = &axes[d];
            let layer = if axis.periodic { 0.0 } else { BOUNDARY_LAYER * (axis.max - axis.min) };
            // Rounded so that the file holds exactly the state that was looked up.
            (random.random_range(axis.min + layer..axis.max - layer) * 1e6).round() / 1e6
        })
    };
    let (mut even, mut near) = (Vec::new(), Vec::new());
    while even.len() < EVEN_STATES || near.len() < NEAR_STATES {
        let z = draw();
        let (Some(value), Some(gradient)) = (value_function.interpolate(&z), value_function.gradient(&z))
        else {
            return Err(format!("{z:?} is outside the grid").into());
        };
        let sample = json!({ "z": z, "value": value, "gradient": gradient });
        if even.len() < EVEN_STATES {
            even.push(sample);
        } else if value.abs() < NEAR_M {
            near.push(sample);
        }
    }
    let metadata = value_function.metadata();
    let reference = json!({
        "made_by": [
            "cncbf solve config/ground_robot_paper.toml",
            "cargo run --release -p reachability --example sample_value_reference -- <value file> <this file>",
        ],
        "value_sha256": metadata.value_sha256,
        "problem": metadata.problem,
        "grid": metadata.grid,
        "horizon_s": metadata.horizon_s,
        "seed": SEED,
        "even": even,
        "near_zero_level": near,
    });
    std::fs::write(target, serde_json::to_string(&reference)? + "\n")?;
    Ok(())
}
