//! `cncbf inspect MODEL --plot`: slices of V and h, zero levels, failure set and error, as a picture.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use anyhow::Context;
use barrier::{DynamicsKind, Kernel, Model, RelativeBarrier, RelativeObstacle, RelativeSample};
use report::{ModelFigure, ModelSlice, model_figure_svg};
use verification::TrueValue;

use crate::cli::InspectArgs;

/// Samples along each axis of a slice.
const SIDE: usize = 91;

/// Writes the picture of `model`, with V where `--value` names its file or a closed form is known.
pub(crate) fn plot(args: &InspectArgs, model: &Model, output: &Path) -> anyhow::Result<()> {
    crate::common::refuse_unwritable(output, "--output")?;
    let metadata = model.metadata();
    let truth = (args.value.is_some() || metadata.dynamics == DynamicsKind::DoubleIntegratorPair)
        .then(|| crate::verify::truth(model, args.value.as_deref()))
        .transpose()?;
    let planes = if args.at.is_empty() { default_planes(model) } else { args.at.clone() };
    let mut barrier = RelativeBarrier::new(model, Kernel::detect())?;
    let slices = planes.iter().map(|plane| slice(model, &mut barrier, truth.as_deref(), *plane)).collect();
    let name = args.file.file_stem().map_or_else(Default::default, |name| name.to_string_lossy());
    let figure = ModelFigure {
        title: format!("{name}: {}, R = {} m", metadata.dynamics, metadata.failure_radius_m),
        min_m: [metadata.grid.min[0], metadata.grid.min[1]],
        max_m: [metadata.grid.max[0], metadata.grid.max[1]],
        side: SIDE,
        axis_names: match metadata.dynamics {
            DynamicsKind::UnicyclePair | DynamicsKind::UnicycleStaticPair => ["ahead, m", "left, m"],
            DynamicsKind::DoubleIntegratorPair => ["relative x, m", "relative y, m"],
        },
        failure_radius_m: metadata.failure_radius_m,
        slices,
    };
    std::fs::write(output, model_figure_svg(&figure))
        .with_context(|| format!("cannot write {}", output.display()))
}

/// Slices that show most: the fastest obstacle head-on, crossing and ahead of the robot, or closing in at three speeds.
fn default_planes(model: &Model) -> Vec<[f64; 2]> {
    let max = model.metadata().grid.max;
    match model.metadata().dynamics {
        DynamicsKind::UnicyclePair => vec![[-PI, max[3]], [-FRAC_PI_2, max[3]], [0.0, max[3]]],
        DynamicsKind::UnicycleStaticPair => vec![[0.0, 0.0]],
        DynamicsKind::DoubleIntegratorPair => {
            vec![[-0.3 * max[2], 0.0], [-0.8 * max[2], 0.0], [-0.6 * max[2], 0.6 * max[3]]]
        }
    }
}

fn slice(
    model: &Model,
    barrier: &mut RelativeBarrier,
    truth: Option<&dyn TrueValue>,
    [third, fourth]: [f64; 2],
) -> ModelSlice {
    let metadata = model.metadata();
    let (min, max) = (metadata.grid.min, metadata.grid.max);
    let along =
        |axis: usize, step: usize| min[axis] + (max[axis] - min[axis]) * step as f64 / (SIDE - 1) as f64;
    let states: Vec<[f64; 4]> = (0..SIDE * SIDE)
        .map(|index| [along(0, index % SIDE), along(1, index / SIDE), third, fourth])
        .collect();
    let obstacles: Vec<_> =
        states.iter().map(|&z| RelativeObstacle { z, radius_m: metadata.failure_radius_m }).collect();
    let mut samples = vec![RelativeSample::default(); obstacles.len()];
    barrier.evaluate_values(&obstacles, &mut samples);
    let value_m = truth.map(|truth| states.iter().map(|z| truth.value_m(z).unwrap_or(f64::NAN)).collect());
    ModelSlice {
        caption: match metadata.dynamics {
            DynamicsKind::UnicyclePair => {
                format!("obstacle heading {:.0}° against the robot's, at {fourth} m/s", third.to_degrees())
            }
            DynamicsKind::UnicycleStaticPair => "obstacle at rest".to_owned(),
            DynamicsKind::DoubleIntegratorPair => format!("relative velocity ({third:.2}, {fourth:.2}) m/s"),
        },
        barrier_m: samples.iter().map(|sample| sample.h_bar).collect(),
        value_m,
    }
}
