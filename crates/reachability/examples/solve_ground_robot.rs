//! Solves the game of a settings file and writes the value function: `cncbf solve` without its surroundings.
//!
//! `cargo run --release -p reachability --example solve_ground_robot -- config/ground_robot_paper.toml value.safetensors`

use reachability::solve_settings;
use settings::Settings;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [config, target] = arguments.as_slice() else {
        return Err("give the settings file and the file to write".into());
    };
    let value = solve_settings(&Settings::load(Path::new(config))?, &mut |_| ControlFlow::Continue(()))?;
    let metadata = value.metadata();
    for check in &metadata.history {
        println!(
            "{:4.1} s: max |dV| {:.4} m, share V < 0 {:.6}",
            check.time_s, check.max_change_m, check.unsafe_share
        );
    }
    println!("{:?} at {} s after {} steps", metadata.outcome, metadata.horizon_s, metadata.steps);
    value.save(Path::new(target))?;
    Ok(())
}
