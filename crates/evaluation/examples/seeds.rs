//! Drives the simulated crowd of a settings file once per seed and prints how each run ended.
//!
//! `cargo run --release -p evaluation --example seeds -- SETTINGS FIRST LAST [PEOPLE]`

use std::path::Path;

use evaluation::VirtualStack;
use perception_bridge::SimulatedCrowd;
use settings::Settings;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, first, last, rest @ ..] = arguments.as_slice() else {
        return Err("usage: seeds SETTINGS FIRST LAST [PEOPLE]".into());
    };
    let mut settings = Settings::load(Path::new(file))?;
    if let Some(people) = rest.first() {
        settings.simulation.people = people.parse()?;
    }
    let model = cbf_filter::load_model(&settings.filter.model)?;
    let (mut reached, mut untouched, mut total) = (0, 0, 0);
    println!(
        "{:>5} {:>8} {:>11} {:>14} {:>7} {:>7}",
        "seed", "reached", "collisions", "clearance m", "time s", "path m"
    );
    for seed in first.parse::<u64>()?..=last.parse()? {
        settings.simulation.seed = seed;
        let mut stack = VirtualStack::new(&settings, &model, Box::new(SimulatedCrowd::new(&settings)?))?;
        while stack.cycle(&mut |_, _| {}).is_some() && stack.status().goal_reached == 0 {}
        let status = stack.status();
        println!(
            "{seed:>5} {:>8} {:>11} {:>14.3} {:>7.1} {:>7.1}",
            status.goal_reached,
            status.collisions,
            status.min_clearance_m,
            status.elapsed_ns as f64 * 1e-9,
            status.path_length_m
        );
        total += 1;
        reached += status.goal_reached;
        untouched += u32::from(status.goal_reached == 1 && status.collisions == 0);
    }
    println!("{total} seeds: {reached} reached the goal, {untouched} of them without a contact");
    Ok(())
}
