//! Trains the ground robot's model on a solved value function and writes the model file.
//!
//! `cargo run --release -p barrier_training --example train_ground_robot -- CONFIG VALUE MODEL [EPOCHS]`: settings from the
//! configuration file CONFIG, the value function from VALUE (the output of `cncbf solve`), the model to MODEL. EPOCHS
//! replaces the configured number, for a quick look.

use barrier_training::{Progress, Recipe, ResidualGrid, barrier_condition, to_model, train};
use dynamics::UnicyclePair;
use reachability::ValueFunction;
use std::error::Error;
use std::ops::ControlFlow;
use std::path::Path;

/// Class-K gain at which the barrier condition is counted, 1/s: the paper's.
const ALPHA_PER_S: f64 = 4.0;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [config, value, model, rest @ ..] = arguments.as_slice() else {
        return Err("usage: train_ground_robot CONFIG VALUE MODEL [EPOCHS]".into());
    };
    let settings = settings::Settings::load(Path::new(config))?;
    let mut training = settings.offline.ok_or("the configuration has no [offline] section")?.training;
    if let Some(epochs) = rest.first() {
        training.epochs = epochs.parse()?;
    }
    let recipe = Recipe::default();
    let value: ValueFunction = ValueFunction::load(Path::new(value))?;
    let target = ResidualGrid::try_from(&value)?;
    let mut show = |p: Progress| {
        if p.epoch.is_multiple_of(10) || p.epoch == p.epochs {
            eprintln!("epoch {} of {}: loss {:.3e} m²", p.epoch, p.epochs, p.loss);
        }
        ControlFlow::Continue(())
    };
    let trained = train(&target, &training, &recipe, &mut show)?;
    eprintln!("{:#?}", trained.report.fit);
    let problem = &value.metadata().problem;
    if let ([v0, w0], [v1, w1], [d0], [d1]) = (
        problem.control.min.as_slice(),
        problem.control.max.as_slice(),
        problem.disturbance.min.as_slice(),
        problem.disturbance.max.as_slice(),
    ) {
        let pair = UnicyclePair {
            control: dynamics::InputBox::new([*v0, *w0], [*v1, *w1])?,
            disturbance: dynamics::InputBox::new([*d0], [*d1])?,
        };
        eprintln!("{:#?}", barrier_condition(&target, &trained.parameters, &pair, ALPHA_PER_S));
    }
    to_model(&value, &trained, &training, &recipe)?.save(Path::new(model))?;
    Ok(())
}
