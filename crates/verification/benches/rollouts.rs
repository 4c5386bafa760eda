//! How many rollout steps and condition states a second, on all cores.
//!
//! `cargo bench -p verification`. The published paper's quadrotor is stood in for by a hand-made model: the work is the same.

#[path = "../tests/common/mod.rs"]
mod common;

use barrier::Kernel;
use common::{go_on, quadrotor, scenario};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use verification::{
    ClosedForm, ConditionSettings, ScenarioSettings, Subject, ValueErrorSettings, certify_by_rollouts,
    measure_condition, measure_value_error,
};

fn main() {
    divan::main();
}

/// Items are filter periods of one pair: barrier, QP, disturbance, integration.
#[divan::bench(sample_count = 10)]
fn rollout_steps(bencher: Bencher<'_, '_>) {
    let model = quadrotor(0.0);
    let subject = Subject::new(&model, Kernel::detect()).expect("a kernel that was detected runs");
    let settings = ScenarioSettings { horizon_s: 1.0, ..scenario(1024) };
    bencher
        .counter(ItemsCount::new(250 * settings.rollouts))
        .bench(|| certify_by_rollouts(&subject, black_box(&settings), &mut go_on));
}

/// Items are states: value, gradient, Hamiltonian.
#[divan::bench(sample_count = 10)]
fn condition_states(bencher: Bencher<'_, '_>) {
    let model = quadrotor(0.0);
    let subject = Subject::new(&model, Kernel::detect()).expect("a kernel that was detected runs");
    let settings = ConditionSettings { alpha_per_s: 4.0, states: 200_000, search_steps: 1, seed: 1 };
    bencher
        .counter(ItemsCount::new(settings.states))
        .bench(|| measure_condition(&subject, black_box(&settings), &mut go_on));
}

/// Items are states: value and closed form.
#[divan::bench(sample_count = 10)]
fn error_states(bencher: Bencher<'_, '_>) {
    let model = quadrotor(0.0);
    let subject = Subject::new(&model, Kernel::detect()).expect("a kernel that was detected runs");
    let truth = ClosedForm::of(model.metadata()).expect("the pair has a closed form");
    let settings = ValueErrorSettings { states: 100_000, shell_states: 100_000, seed: 1 };
    bencher
        .counter(ItemsCount::new(settings.states + settings.shell_states))
        .bench(|| measure_value_error(&subject, &truth, black_box(&settings), &mut go_on));
}
