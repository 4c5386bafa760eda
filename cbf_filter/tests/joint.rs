//! The joint look-ahead as an option of the filter: when it decides, what the command then says, and that it costs no memory.

mod scene;

use allocation_counter::measure;
use cbf_filter::SafetyFilter;
use messages::{Reason, SafetyStatus};
use scene::{MS, START_NS, Scene, boxed_in, filter_with, person, settings, verdict};
use settings::{JointSettings, JointUse};

fn filter(when: JointUse) -> SafetyFilter {
    let joint = JointSettings {
        when,
        horizon_s: 2.0,
        moments: 16,
        levels: 5,
        disturbance_share: 0.5,
        margin_m: 0.0,
        switch_s: 0.5,
        robot_max_speed_mps: None,
    };
    filter_with(|filter| filter.joint = Some(joint.clone()))
}

#[test]
fn it_decides_where_the_composite_is_infeasible_and_says_what_that_costs_the_row() {
    for when in [JointUse::Infeasible, JointUse::Gatekeeper, JointUse::Either] {
        let command = boxed_in().step(&mut filter(when), START_NS);
        assert_eq!(verdict(&command), (SafetyStatus::Relaxed, Reason::JointEscape), "{when:?}");
        let [a, b] = command.lg_h;
        let [v, w] = command.control;
        let held = command.drift_mps + a * v + b * w + command.alpha_per_s * command.h_m;
        assert!((command.slack_mps + held.min(0.0)).abs() < 1e-12, "{held} {command:?}");
        assert!(command.hard_margin_mps < 0.0);
        let settings = settings();
        for (axis, value) in command.control.into_iter().enumerate() {
            let range = settings.robot.control_min[axis]..=settings.robot.control_max[axis];
            assert!(range.contains(&value), "{command:?}");
        }
    }
}

#[test]
fn where_a_way_out_remains_the_command_is_the_programs_own_bit_for_bit() {
    let people = [person(7, [4.0, 0.6], [-0.6, 0.0], START_NS), person(8, [5.0, -3.0], [0.0, 0.4], START_NS)];
    let scene = Scene::fresh(&people, START_NS);
    let without = scene.step(&mut scene::filter(), START_NS);
    for when in [JointUse::Infeasible, JointUse::Gatekeeper, JointUse::Either] {
        assert_eq!(
            bytemuck::bytes_of(&scene.step(&mut filter(when), START_NS)),
            bytemuck::bytes_of(&without)
        );
    }
}

#[test]
fn no_cycle_allocates_whether_it_passes_or_decides() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let far: Vec<_> =
        (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 4.0], [0.0, -0.3], START_NS)).collect();
    let (boxed_in, far, nobody) = (boxed_in(), Scene::fresh(&far, START_NS), Scene::fresh(&[], START_NS));
    let mut filter = filter(JointUse::Either);
    for round in 0..30_u64 {
        let allocations = measure(|| {
            for scene in [&boxed_in, &far, &nobody] {
                scene.step(&mut filter, START_NS + round * MS / 1_000);
            }
        });
        assert_eq!(allocations.count_total, 0, "round {round}");
    }
}
