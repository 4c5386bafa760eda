//! Time of one evaluation, by kernel and number of obstacles: `cargo bench -p barrier`.
//!
//! `network` is residual and gradient alone, `values` the residual alone, `composite` everything that a cycle takes
//! before its quadratic program. The whole cycle is in the workspace's `benches/steps.rs`; instructions are counted by its
//! `examples/instructions.rs`.
#![allow(clippy::unwrap_used, missing_docs)] // a benchmark may panic

use std::path::Path;

use barrier::{BarrierObstacle, CompositeBarrier, Kernel, Model, NetworkBatch, ResidualNetwork};
use divan::Bencher;
use divan::counter::ItemsCount;
use dynamics::{InputBox, UnicyclePair};

const OBSTACLES: [usize; 5] = [1, 5, 15, 20, 64];

fn main() {
    divan::main();
}

/// A case under the name the table shows.
#[derive(Clone, Copy)]
struct Case(Kernel, usize);

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", self.0, self.1)
    }
}

fn cases() -> impl Iterator<Item = Case> {
    let supported = Kernel::ALL.into_iter().filter(|kernel| kernel.is_supported());
    supported.flat_map(|kernel| OBSTACLES.map(|count| Case(kernel, count)))
}

fn model() -> Model {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/ground_robot.safetensors");
    Model::load(Path::new(path)).unwrap()
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

fn batch(count: usize) -> NetworkBatch {
    let mut batch = NetworkBatch::new();
    batch.set_len(count);
    for index in 0..count {
        batch.set_state(index, &person(index).state.map(|component| component as f32));
    }
    batch
}

#[divan::bench(args = cases())]
fn network(bencher: Bencher<'_, '_>, Case(kernel, count): Case) {
    let mut network = ResidualNetwork::new(model().weights(), kernel).unwrap();
    let mut batch = batch(count);
    bencher.counter(ItemsCount::new(count)).bench_local(|| network.evaluate(divan::black_box(&mut batch)));
}

#[divan::bench(args = cases())]
fn values(bencher: Bencher<'_, '_>, Case(kernel, count): Case) {
    let mut network = ResidualNetwork::new(model().weights(), kernel).unwrap();
    let mut batch = batch(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| network.evaluate_values(divan::black_box(&mut batch)));
}

#[divan::bench(args = cases())]
fn composite(bencher: Bencher<'_, '_>, Case(kernel, count): Case) {
    let pair = UnicyclePair {
        control: InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(),
        disturbance: InputBox::new([-0.35], [0.35]).unwrap(),
    };
    let mut composite = CompositeBarrier::new(&model(), kernel, 4.0).unwrap();
    let people: Vec<_> = (0..count).map(person).collect();
    bencher
        .counter(ItemsCount::new(count))
        .bench_local(|| composite.evaluate(&pair, divan::black_box(&[0.05, 0.0, 0.02]), &people));
}
