//! What a cycle allocates: nothing in the filters, Clarabel's own in the planners.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use allocation_counter::measure;
use baselines::{Inputs, MethodKind, MethodParameters};

#[test]
fn a_filter_allocates_nothing() {
    let people: Vec<_> =
        (0..64).map(|i| common::person([1.0 + 0.05 * f64::from(i), 0.5], [-0.5, 0.0])).collect();
    let (state, nominal) = (common::flying_robot([0.0, 0.0, 1.0, 0.0]), common::accelerate([2.0, 0.0]));
    let obstacles = common::crowd(&people);
    let inputs = Inputs {
        robot_state: Some(&state),
        obstacles: Some(&obstacles),
        goal: None,
        nominal: Some(&nominal),
    };
    for kind in [MethodKind::C3bf, MethodKind::HoCbf] {
        let mut method = MethodParameters::published(kind).build(&common::quadrotor(), None).unwrap();
        let counted = measure(|| {
            method.step(&inputs, common::NOW_NS).unwrap();
        });
        assert_eq!(counted.count_total, 0, "{kind}");
    }
}

/// Clarabel allocates once for each quadratic program it solves.
#[test]
fn a_planner_allocates_as_often_as_it_solves() {
    let model = common::model();
    let people: Vec<_> =
        (0..6).map(|i| common::person([1.5 + 0.4 * f64::from(i), 0.5], [-0.5, 0.0])).collect();
    let (state, goal) = (common::robot([0.0; 3]), common::goal([8.0, 0.0]));
    let obstacles = common::crowd(&people);
    let inputs =
        Inputs { robot_state: Some(&state), obstacles: Some(&obstacles), goal: Some(&goal), nominal: None };
    for kind in [MethodKind::SdfMpc, MethodKind::DcbfMpc, MethodKind::VoMpc, MethodKind::RntcMpc] {
        let parameters = MethodParameters::published(kind);
        let mut method = parameters.build(&common::ground_robot(), Some(&model)).unwrap();
        // Once before, as Clarabel makes room at its first solve.
        method.step(&inputs, common::NOW_NS).unwrap();
        method.reset();
        let mut iterations = 0;
        let counted = measure(|| {
            iterations = method.step(&inputs, common::NOW_NS).unwrap().iterations;
        });
        assert_eq!(counted.count_total, u64::from(iterations), "{kind}");
    }
}
