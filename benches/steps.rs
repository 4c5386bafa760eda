//! Time of the pure steps of a cycle and of the codec: `cargo bench --bench steps`.
//!
//! Medians, for a quick look while working on one of them. Percentiles, and the same work done by others, come from
//! `tests/judges/performance.py`; counts of instructions from `tests/instructions.rs`; the network and the composite for
//! each kernel from `cargo bench -p barrier`.
#![allow(clippy::unwrap_used, missing_docs)] // a benchmark may panic

mod scenes;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use scenes::{
    BarrierStep, Drive, EstimatorStep, FilterStep, NetworkStep, QpStep, Recordings, Ros2Coding, SearchStep,
};
use settings::{EstimatorKind, KernelChoice};

const PEOPLE: [usize; 5] = [1, 5, 15, 20, 64];

fn main() {
    divan::main();
}

#[divan::bench_group]
mod filter {
    use super::{
        BarrierStep, Bencher, FilterStep, KernelChoice, NetworkStep, PEOPLE, QpStep, SearchStep, black_box,
    };

    #[divan::bench(args = PEOPLE)]
    fn step(bencher: Bencher<'_, '_>, people: usize) {
        let mut filter = FilterStep::new(people, KernelChoice::Auto);
        bencher.bench_local(|| black_box(filter.step()));
    }

    #[divan::bench(args = PEOPLE)]
    fn step_with_search(bencher: Bencher<'_, '_>, people: usize) {
        let mut filter = SearchStep::new(people, KernelChoice::Auto);
        bencher.bench_local(|| black_box(filter.step()));
    }

    #[divan::bench(args = PEOPLE)]
    fn network_and_gradient(bencher: Bencher<'_, '_>, people: usize) {
        let mut network = NetworkStep::new(people, barrier::Kernel::detect());
        bencher.bench_local(|| black_box(network.step()));
    }

    #[divan::bench(args = PEOPLE)]
    fn composite(bencher: Bencher<'_, '_>, people: usize) {
        let mut composite = BarrierStep::new(people, barrier::Kernel::detect());
        bencher.bench_local(|| black_box(composite.step()));
    }

    #[divan::bench]
    fn qp(bencher: Bencher<'_, '_>) {
        let mut qp = QpStep::new();
        bencher.bench_local(|| black_box(qp.step()));
    }
}

#[divan::bench(sample_count = 1000, sample_size = 1)]
fn mpc_step(bencher: Bencher<'_, '_>) {
    let drive = std::cell::RefCell::new(Drive::new());
    bencher.with_inputs(|| drive.borrow_mut().arrive()).bench_local_values(|()| {
        let mut drive = drive.borrow_mut();
        let command = drive.step();
        drive.follow(&command);
    });
}

/// Of the shipped estimator.
#[divan::bench(args = [20, 64], consts = [true, false], sample_size = 1, sample_count = 1000)]
fn estimator_step<const NAMED: bool>(bencher: Bencher<'_, '_>, people: usize) {
    let estimator = std::cell::RefCell::new(EstimatorStep::new(EstimatorKind::Imm, people, NAMED));
    bencher
        .counter(ItemsCount::new(people))
        .with_inputs(|| estimator.borrow_mut().perceive())
        .bench_local_values(|()| black_box(estimator.borrow_mut().step().count));
}

#[divan::bench_group]
mod codec {
    use super::{Bencher, ItemsCount, Recordings, Ros2Coding, black_box};

    #[divan::bench]
    fn encode_odometry(bencher: Bencher<'_, '_>) {
        let mut coding = Ros2Coding::odometry();
        bencher.bench_local(|| black_box(coding.encode()));
    }

    #[divan::bench]
    fn decode_odometry(bencher: Bencher<'_, '_>) {
        let coding = Ros2Coding::odometry();
        bencher.bench_local(|| black_box(coding.decode()));
    }

    #[divan::bench(args = [20, 64])]
    fn encode_detections(bencher: Bencher<'_, '_>, people: usize) {
        let mut coding = Ros2Coding::detections(people);
        bencher.bench_local(|| black_box(coding.encode()));
    }

    #[divan::bench(args = [20, 64])]
    fn decode_detections(bencher: Bencher<'_, '_>, people: usize) {
        let coding = Ros2Coding::detections(people);
        bencher.bench_local(|| black_box(coding.decode()));
    }

    /// Raw and as ROS 2 markers, compressed, to the closed file.
    #[divan::bench(sample_count = 20, sample_size = 1)]
    fn write_recording(bencher: Bencher<'_, '_>) {
        let recordings = Recordings::new();
        bencher.counter(ItemsCount::new(Recordings::MESSAGES)).bench_local(|| black_box(recordings.write()));
    }

    #[divan::bench(sample_count = 20, sample_size = 1)]
    fn read_recording(bencher: Bencher<'_, '_>) {
        let recordings = Recordings::new();
        recordings.write();
        bencher.counter(ItemsCount::new(Recordings::MESSAGES)).bench_local(|| black_box(recordings.read()));
    }
}
