//! What a step of each estimator costs:
//!
//! ```text
//! cargo run --release -p obstacle_estimator --example cost
//! ```
//!
//! Named people, and anonymous ones that have to be told apart, a metre from each other. Prints a table in Markdown of µs.

#[path = "../tests/support/mod.rs"]
mod support;

use bytemuck::Zeroable;
use messages::Detections;
use node_runtime::{Clock, RealClock};
use obstacle_estimator::Estimator;
use support::{MS, START_NS, imm, kalman, seen, settings};

const STEPS: u64 = 4_000;

fn main() {
    println!(
        "| estimator | people | named, p50 µs | p99 | anonymous, p50 µs | p99 |\n|---|---|---|---|---|---|"
    );
    for (name, settings) in [("difference", settings()), ("kalman", kalman()), ("imm", imm())] {
        for people in [20, 64] {
            let [named, anonymous] = [true, false].map(|named| {
                let mut estimator = Estimator::new(settings.clone());
                let mut durations_ns: Vec<_> =
                    (0..STEPS).map(|k| step(&mut estimator, people, named, k)).collect();
                durations_ns.sort_unstable();
                [50, 99].map(|percent| durations_ns[durations_ns.len() * percent / 100] as f64 * 1e-3)
            });
            println!(
                "| {name} | {people} | {:.1} | {:.1} | {:.1} | {:.1} |",
                named[0], named[1], anonymous[0], anonymous[1]
            );
        }
    }
}

/// One frame of a crowd that walks to and fro; returns what the step took, ns.
fn step(estimator: &mut Estimator, people: u64, named: bool, k: u64) -> u64 {
    let now_ns = START_NS + 50 * k * MS;
    let way_m = (now_ns as f64 * 1e-9).sin();
    let mut frame = Box::new(Detections::zeroed());
    frame.stamp.valid_at_ns = now_ns;
    frame.count = people as u32;
    for (index, item) in frame.items.iter_mut().take(people as usize).enumerate() {
        let [row, column] = [index / 8, index % 8].map(|place| place as f64);
        *item = seen(if named { index as u64 + 1 } else { 0 }, [column + way_m, row - way_m]);
    }
    let before_ns = RealClock.now_ns();
    std::hint::black_box(estimator.step(&frame, now_ns));
    RealClock.now_ns() - before_ns
}
