//! Whatever arrives, one finite command leaves.

mod scene;

use bytemuck::Zeroable;
use messages::{MAX_OBSTACLES, NominalCommand, Obstacles, Reason, RobotState, SafetyStatus};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use scene::{MS, START_NS, Scene, filter, obstacles, person};

/// Any bit pattern, with NaN, infinities and extremes more often than chance gives them.
fn any_f64(rng: &mut Pcg64Mcg) -> f64 {
    match rng.random_range(0..8) {
        0 => f64::NAN,
        1 => f64::INFINITY,
        2 => -f64::MAX,
        3 => f64::from_bits(rng.next_u64()),
        4 => 0.0,
        _ => rng.random_range(-10.0..10.0),
    }
}

fn random_bytes<T: bytemuck::Pod>(rng: &mut Pcg64Mcg) -> T {
    let mut message = T::zeroed();
    rng.fill_bytes(bytemuck::bytes_of_mut(&mut message));
    message
}

#[test]
fn random_bytes_as_messages_never_reach_the_motors() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut filter = filter();
    for round in 0..20_000_u64 {
        let now_ns = START_NS + round * 4 * MS;
        let scene = Scene {
            robot_state: rng.random_bool(0.9).then(|| random_bytes::<RobotState>(&mut rng)),
            obstacles: rng.random_bool(0.9).then(|| random_bytes::<Obstacles>(&mut rng)),
            nominal: rng.random_bool(0.9).then(|| random_bytes::<NominalCommand>(&mut rng)),
            goal: None,
        };
        let command = scene.step(&mut filter, now_ns);
        assert!(command.control.iter().all(|value| value.is_finite()), "{command:?}");
        assert_eq!(command.status, SafetyStatus::Stopped.code());
    }
}

#[test]
fn one_wild_number_in_an_otherwise_good_scene_never_reaches_the_motors() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let mut filter = filter();
    let mut reasons = std::collections::BTreeSet::new();
    for round in 0..50_000_u64 {
        let now_ns = START_NS + round * 4 * MS;
        let people = [person(1, [3.0, 0.5], [-0.5, 0.0], now_ns), person(2, [-2.0, 0.0], [0.9, 0.1], now_ns)];
        let mut scene = Scene::fresh(&people, now_ns);
        let wild = any_f64(&mut rng);
        let state = scene.robot_state.as_mut().expect("complete");
        let list = scene.obstacles.as_mut().expect("complete");
        let nominal = scene.nominal.as_mut().expect("complete");
        match rng.random_range(0..9) {
            0 => state.position_in_odom_m[0] = wild,
            1 => state.heading_rad = wild,
            2 => state.velocity_in_base_mps[1] = wild,
            3 => list.items[1].position_in_odom_m[1] = wild,
            4 => list.items[0].speed_mps = wild,
            5 => list.items[0].heading_rad = wild,
            6 => list.items[1].radius_m = wild,
            7 => list.items[0].velocity_in_odom_mps[0] = wild,
            _ => nominal.control[rng.random_range(0..2)] = wild,
        }
        let command = scene.step(&mut filter, now_ns);
        assert!(command.control.iter().all(|value| value.is_finite()), "{command:?}");
        assert!((0.0..=1.0).contains(&command.control[0]) && command.control[1].abs() <= 0.8, "{command:?}");
        reasons.insert(command.reason);
    }
    for reason in
        [Reason::None, Reason::NonFiniteRobotState, Reason::UnsoundObstacle, Reason::NonFiniteNominalCommand]
    {
        assert!(reasons.contains(&reason.code()), "{reason} never came up");
    }
}

#[test]
fn a_full_list_and_a_count_beyond_capacity_are_taken_as_sixty_four() {
    let people: Vec<_> = (0..MAX_OBSTACLES)
        .map(|index| person(index as u64 + 1, [6.0 + index as f64, 3.0], [0.0, 0.0], START_NS))
        .collect();
    let mut scene = Scene::fresh(&people, START_NS);
    let full = scene.step(&mut filter(), START_NS);
    assert_eq!(full.obstacle_count as usize, MAX_OBSTACLES);
    let mut overflowing = obstacles(&people, START_NS);
    overflowing.count = 1_000;
    scene.obstacles = Some(overflowing);
    let cut = scene.step(&mut filter(), START_NS);
    assert_eq!((cut.obstacle_count, cut.control), (full.obstacle_count, full.control));
    assert_ne!(Obstacles::zeroed(), overflowing);
}
