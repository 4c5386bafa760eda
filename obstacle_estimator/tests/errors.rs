//! What the filters are for: smaller errors than differences, and a radius that holds. `examples/errors.rs` prints the table.

mod support;
#[path = "support/walks.rs"]
mod walks;

use settings::{EstimatorSettings, NoiseSettings};
use support::{NOISE, imm, kalman, settings};
use walks::{Errors, Manner, Sight, errors, walks};

fn of(base: &EstimatorSettings, manner: Manner, sight: Sight) -> Errors {
    let told = NoiseSettings { position_sd_m: sight.position_sd_m, radius_sds: 2.0, ..NOISE };
    let noise = base.noise.map(|_| told);
    errors(&EstimatorSettings { noise, ..base.clone() }, &walks(manner, 20, 1), sight, 5)
}

#[test]
fn velocities_are_several_times_better_than_differences() {
    for manner in [Manner::Goals, Manner::Turns] {
        for interval_ms in [50, 100] {
            let sight = Sight { interval_ms, position_sd_m: 0.05, dropout: 0.1, latency_ms: 100 };
            let difference = of(&settings(), manner, sight);
            let (kalman, imm) = (of(&kalman(), manner, sight), of(&imm(), manner, sight));
            assert!(kalman.velocity_mps < 0.4 * difference.velocity_mps, "{kalman:?} {difference:?}");
            assert!(imm.velocity_mps < kalman.velocity_mps, "{imm:?} {kalman:?}");
            assert!(imm.position_m < 0.5 * difference.position_m, "{imm:?} {difference:?}");
            assert!((kalman.cut, imm.cut) == (0, 0), "{kalman:?} {imm:?}");
        }
    }
}

/// Two standard deviations along both axes leave exp(-2) = 13.5 % outside if they are honest.
#[test]
fn two_standard_deviations_of_the_interacting_models_hold_what_they_promise() {
    for manner in [Manner::Goals, Manner::Turns] {
        for position_sd_m in [0.02, 0.05, 0.10, 0.15] {
            let sight = Sight { interval_ms: 50, position_sd_m, dropout: 0.1, latency_ms: 100 };
            let imm = of(&imm(), manner, sight);
            assert!(imm.outside_radius < (-2.0_f64).exp(), "{imm:?}");
        }
    }
}
