//! Measures one filter tick: network, gradient, composite and QP.
//!
//! `cargo run --release -p barrier --example tick [models/ground_robot_paper.safetensors]`
#![allow(clippy::disallowed_methods)] // a measurement reads the clock

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use barrier::{
    BarrierObstacle, Bounds, CbfQp, CompositeBarrier, DynamicsKind, FORMAT_VERSION, GridRecord,
    InputEncoding, Kernel, LayerWeights, Model, ModelMetadata, NetworkWeights, TrainingRecord,
};
use dynamics::{InputBox, UnicyclePair};

const TICKS: usize = 20_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pair = UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8])?,
        disturbance: InputBox::new([-0.35], [0.35])?,
    };
    let model = match std::env::args().nth(1) {
        Some(path) => Model::load(Path::new(&path))?,
        None => untrained_model(&pair)?,
    };
    let qp = CbfQp::new(pair.control, 1e6)?;
    println!("kernel     people   p50 us   p99 us   min us");
    for kernel in Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported()) {
        let mut composite = CompositeBarrier::new(&model, kernel, 4.0)?;
        for count in [1, 5, 20, 64] {
            let people: Vec<_> = (0..count).map(person).collect();
            let mut micros = Vec::with_capacity(TICKS);
            for tick in 0..TICKS {
                let x = [0.001 * (tick % 100) as f64, 0.0, 0.001 * (tick % 70) as f64];
                let start = Instant::now();
                let sample = composite.evaluate(&pair, black_box(&x), black_box(&people))?;
                let solution = qp.solve(&[0.8, 0.1], sample.row(4.0).as_ref())?;
                black_box(solution);
                micros.push(start.elapsed().as_secs_f64() * 1e6);
            }
            micros.sort_by(f64::total_cmp);
            let [p50, p99, min] = [TICKS / 2, TICKS * 99 / 100, 0].map(|rank| micros[rank]);
            println!("{:<10} {count:>6} {p50:>8.2} {p99:>8.2} {min:>8.2}", kernel.name());
        }
    }
    Ok(())
}

/// People on a spiral around the robot, all inside the trained domain.
fn person(index: usize) -> BarrierObstacle {
    let (angle, distance) = (index as f64 * 2.4, 1.2 + 0.05 * index as f64);
    BarrierObstacle {
        state: [distance * angle.cos(), distance * angle.sin(), (angle + 2.0) % 6.0 - 3.0, 1.0],
        rate: [0.5, 0.5, 0.1, 0.0],
        radius_m: 0.7,
        model: 0,
    }
}

/// Arithmetic takes as long whatever the parameters are.
fn untrained_model(pair: &UnicyclePair) -> Result<Model, Box<dyn std::error::Error>> {
    let layers = InputEncoding::Raw
        .layer_sizes()
        .windows(2)
        .map(|sizes| LayerWeights {
            weight: (0..sizes[0] * sizes[1]).map(|k| ((k * 37 % 101) as f32 / 50.0 - 1.0) * 0.3).collect(),
            bias: vec![0.1; sizes[1]],
        })
        .collect();
    let metadata = ModelMetadata {
        format_version: FORMAT_VERSION,
        dynamics: DynamicsKind::UnicyclePair,
        encoding: InputEncoding::Raw,
        control: pair.control,
        disturbance: Bounds::from(&pair.disturbance),
        failure_radius_m: 0.7,
        grid: GridRecord {
            min: [-6.0, -6.0, -PI, 0.0],
            max: [6.0, 6.0, PI, 1.5],
            count: [80, 80, 20, 10],
            periodic: [false, false, true, false],
        },
        solver: BTreeMap::new(),
        training: TrainingRecord::default(),
        verification: BTreeMap::new(),
        value_sha256: String::new(),
        hash: String::new(),
    };
    Ok(Model::new(NetworkWeights::new(InputEncoding::Raw, layers)?, metadata)?)
}
