//! What a cycle allocates: nothing, but for what Clarabel does while it solves.

mod common;

use allocation_counter::measure;
use common::{MS, controller, goal, ground_robot, inputs, pursuer, quadrotor, state};
use messages::Intent;
use nominal_mpc::{Inputs, NominalController};
use settings::ControllerKind;

const NOW_NS: u64 = 1_000 * MS;

fn allocations(controller: &mut NominalController, inputs: &Inputs<'_>, now_ns: u64) -> u64 {
    measure(|| {
        let _ = std::hint::black_box(controller.step(inputs, now_ns));
    })
    .count_total
}

#[test]
fn lqr_pursuit_hold_silence_and_stopping_allocate_nothing() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let (robot, far, here) = (state([0.0; 3], NOW_NS), goal(9.0, 1.0), goal(0.1, 0.0));
    let mut hold_settings = ground_robot();
    hold_settings.nominal.controller = ControllerKind::Hold;
    for settings in [quadrotor(), pursuer(), hold_settings] {
        assert_eq!(allocations(&mut controller(&settings), &inputs(&robot, &far), NOW_NS), 0);
    }
    let mut mpc = controller(&ground_robot());
    assert_eq!(allocations(&mut mpc, &inputs(&robot, &here), NOW_NS), 0);
    assert_eq!(allocations(&mut mpc, &inputs(&robot, &far), NOW_NS + 1_000 * MS), 0);
    assert_eq!(allocations(&mut mpc, &Inputs::default(), NOW_NS), 0);
}

#[test]
fn the_mpc_allocates_once_per_qp_inside_clarabel() {
    let mut mpc = controller(&ground_robot());
    let far = goal(9.0, 4.0);
    for cycle in 0..40 {
        let now_ns = NOW_NS + cycle * 50 * MS;
        let robot = state([0.04 * cycle as f64, 0.0, 0.02 * cycle as f64], now_ns);
        let mut effort = 0;
        let count = measure(|| {
            if let Ok(command) = mpc.step(&inputs(&robot, &far), now_ns) {
                assert_eq!(command.intent, Intent::Drive.code());
                effort = command.effort;
            }
        })
        .count_total;
        // The first solve also sets something up in Clarabel.
        let expected = u64::from(effort) + u64::from(cycle == 0);
        assert!(effort > 0 && count == expected, "cycle {cycle}: {effort} QPs, {count} allocations");
    }
}
