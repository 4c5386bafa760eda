//! The pure steps once each, for counting their instructions, which no other load on the machine disturbs.
//!
//! Callgrind collects inside `counted_step` and dumps after each, so that one run gives one count per line printed:
//!
//! ```text
//! cargo build --release --example instructions
//! valgrind --tool=callgrind --callgrind-out-file=counts --toggle-collect='*counted_step*' \
//!     --dump-after='*::counted_step*' target/release/examples/instructions
//! ```
//!
//! `tests/instructions.rs` does that and compares. Valgrind knows no AVX-512, so the kernels are named, not detected.
#![allow(clippy::unwrap_used)] // a measurement may panic

#[path = "../benches/scenes/mod.rs"]
mod scenes;

use std::hint::black_box;

use barrier::Kernel;
use scenes::{Drive, ESTIMATORS, EstimatorStep, FilterStep, NetworkStep, QpStep, Ros2Coding, SearchStep};
use settings::KernelChoice;

/// Calls before the one that counts: buffers are then in use and plans stand.
const WARM_UP: usize = 8;
/// Steps of the controller before the one that counts: 5 s, when it is past its first turn.
const UNDER_WAY: usize = 100;

/// What callgrind counts.
#[inline(never)]
fn counted_step<R>(step: impl FnOnce() -> R) {
    black_box(step());
}

/// Warms a step up, counts one call and says which it was.
fn count<R>(name: &str, mut step: impl FnMut() -> R) {
    for _ in 0..WARM_UP {
        black_box(step());
    }
    counted_step(step);
    println!("{name}");
}

fn main() {
    for (kernel, choice) in
        [(Kernel::Portable, KernelChoice::Portable), (Kernel::Avx2Fma, KernelChoice::Avx2Fma)]
    {
        if !kernel.is_supported() {
            continue;
        }
        for people in [1, 5, 20] {
            let mut filter = FilterStep::new(people, choice);
            count(&format!("filter_step/{kernel}/{people}"), || filter.step());
        }
        for people in [5, 20] {
            let mut filter = SearchStep::new(people, choice);
            count(&format!("filter_step/{kernel}/{people}/search"), || filter.step());
        }
        let mut network = NetworkStep::new(20, kernel);
        count(&format!("network/{kernel}/20"), || network.step());
    }
    let mut qp = QpStep::new();
    count("qp", || qp.step());
    mpc_steps();
    for (kind_name, kind) in ESTIMATORS {
        for (name, named) in [("named", true), ("anonymous", false)] {
            let mut estimator = EstimatorStep::new(kind, 20, named);
            for _ in 0..WARM_UP {
                estimator.perceive();
                estimator.step();
            }
            estimator.perceive();
            counted_step(|| estimator.step().count);
            println!("estimator_step/{kind_name}/{name}/20");
        }
    }
    let mut detections = Ros2Coding::detections(20);
    count("encode/detections/20", || detections.encode());
    count("decode/detections/20", || detections.decode());
}

/// One step of the controller under way to its first goal.
fn mpc_steps() {
    let mut drive = Drive::new();
    for _ in 0..UNDER_WAY {
        drive.arrive();
        let command = drive.step();
        drive.follow(&command);
    }
    drive.arrive();
    counted_step(|| drive.step());
    println!("mpc_step");
}
