//! How far each estimator is off, people being seen through white noise:
//!
//! ```text
//! cargo run --release -p obstacle_estimator --example errors
//! ```
//!
//! 64 people walk for 60 s. Prints a table in Markdown: root mean square errors over all people and frames, the first
//! second left out.

#[path = "../tests/support/mod.rs"]
mod support;
#[path = "../tests/support/walks.rs"]
mod walks;

use settings::{EstimatorSettings, NoiseSettings};
use support::{imm, kalman, settings};
use walks::{Manner, Sight, errors, walks};

fn told(base: &EstimatorSettings, position_sd_m: f64) -> EstimatorSettings {
    let noise = base.noise.map(|noise| NoiseSettings { position_sd_m, radius_sds: 2.0, ..noise });
    EstimatorSettings { noise, ..base.clone() }
}

fn main() {
    println!(
        "| people | Hz | noise, m | dropout | latency, ms | estimator | velocity, m/s | p95 | acceleration, m/s² | position on arrival, m | \
         beyond 2 sd | radius + | tracks cut |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for manner in [Manner::Goals, Manner::Turns] {
        let people = walks(manner, 60, 1);
        for interval_ms in [50, 100] {
            for position_sd_m in [0.02, 0.05, 0.10, 0.15] {
                for (dropout, latency_ms) in [(0.0, 0), (0.1, 100)] {
                    for (name, base) in [
                        ("difference", settings()),
                        ("kalman", kalman()),
                        ("imm", imm()),
                        ("imm of two", imm_of_two()),
                    ] {
                        let sight = Sight { interval_ms, position_sd_m, dropout, latency_ms };
                        let found = errors(&told(&base, position_sd_m), &people, sight, 5);
                        println!(
                            "| {manner:?} | {} | {position_sd_m:.2} | {dropout:.1} | {latency_ms} | {name} | {:.3} | {:.3} | {:.2} | \
                             {:.3} | {:.1} % | {:.3} | {} |",
                            1000 / interval_ms,
                            found.velocity_mps,
                            found.velocity_p95_mps,
                            found.acceleration_mps2,
                            found.position_m,
                            100.0 * found.outside_radius,
                            found.growth_m,
                            found.cut
                        );
                    }
                }
            }
        }
    }
}

fn imm_of_two() -> EstimatorSettings {
    let imm = imm();
    EstimatorSettings {
        imm: imm.imm.map(|settings| settings::ImmSettings { manoeuvre: None, ..settings }),
        ..imm
    }
}
