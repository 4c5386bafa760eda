//! A cycle allocates nothing, on any rung of the ladder.

mod scene;

use allocation_counter::measure;
use messages::SafetyStatus;
use scene::{MS, START_NS, Scene, filter, person};

#[test]
fn no_cycle_allocates_whether_filtered_relaxed_braking_or_recovering() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let mut filter = filter();
    let mut seen = [0_usize; 5];
    let mut now_ns = START_NS;
    for round in 0..2_000_u64 {
        now_ns += 4 * MS;
        let close = [
            person(1, [0.75, 0.0], [-1.2, 0.0], now_ns),
            person(2, [0.4, 0.8], [-0.3, -1.2], now_ns),
            person(3, [0.4, -0.8], [-0.3, 1.2], now_ns),
        ];
        let far: Vec<_> =
            (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 4.0], [0.0, -0.3], now_ns)).collect();
        let mut scene = match round / 400 {
            0 | 3 => Scene::fresh(&far, now_ns),
            1 => Scene::fresh(&close, now_ns),
            2 => Scene::fresh(&far, START_NS),
            _ => Scene::fresh(&[], now_ns),
        };
        if round % 97 == 0 {
            scene.robot_state = None;
        }
        let mut command = None;
        let allocations = measure(|| command = Some(scene.step(&mut filter, now_ns))).count_total;
        let command = command.expect("stepped");
        assert_eq!(allocations, 0, "round {round}, status {}", command.status);
        seen[command.status as usize] += 1;
    }
    for status in SafetyStatus::ALL {
        assert!(seen[status.code() as usize] > 0, "{status} never came up: {seen:?}");
    }
}
