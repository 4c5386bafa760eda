//! The filter's options beyond the published composite: what each changes in the command, what it leaves, and that it costs no
//! memory.

mod scene;

use allocation_counter::measure;
use cbf_filter::{SafetyFilter, load_model};
use messages::{ControlKind, Obstacle, Reason, RobotState, SafeCommand, SafetyStatus};
use scene::{MS, START_NS, Scene, boxed_in, filter_with, person, robot_state, settings};
use settings::{Composition, ObstacleInput, Settings, SoftminOffset};

fn people() -> [Obstacle; 3] {
    [
        person(7, [3.0, 0.4], [-0.8, 0.1], START_NS),
        person(8, [2.2, -1.4], [-0.2, 0.7], START_NS),
        person(9, [4.0, 2.5], [0.0, 0.4], START_NS),
    ]
}

/// `L_g h·u + drift + α h` of the reported condition at the command's control, m/s.
fn held(command: &SafeCommand) -> f64 {
    let along = command.lg_h[0] * command.control[0] + command.lg_h[1] * command.control[1];
    command.drift_mps + along + command.alpha_per_s * command.h_m
}

fn status(command: &SafeCommand) -> SafetyStatus {
    SafetyStatus::try_from(command.status).expect("a known status")
}

#[test]
fn options_written_as_published_change_no_bit() {
    let scene = Scene::fresh(&people(), START_NS);
    let published = scene.step(&mut scene::filter(), START_NS);
    let mut same = filter_with(|filter| {
        filter.obstacle_input = ObstacleInput::Measured;
        filter.composition = Composition::Composite;
        filter.softmin_offset = SoftminOffset::Keep;
    });
    assert_eq!(bytemuck::bytes_of(&scene.step(&mut same, START_NS)), bytemuck::bytes_of(&published));
}

#[test]
fn the_worst_input_does_not_look_at_the_estimated_one_and_lies_below_every_estimate_within_bounds() {
    let mut worst = filter_with(|filter| filter.obstacle_input = ObstacleInput::WorstCase);
    let drifts = |filter: &mut SafetyFilter| {
        [-0.35, 0.0, 0.35].map(|turn_radps| {
            let mut people = people();
            for person in &mut people {
                person.heading_rate_radps = turn_radps;
            }
            Scene::fresh(&people, START_NS).step(filter, START_NS).drift_mps
        })
    };
    let robust = drifts(&mut worst);
    assert!(robust.iter().all(|drift| drift == &robust[0]), "{robust:?}");
    for drift in drifts(&mut scene::filter()) {
        assert!(robust[0] <= drift + 1e-12, "{robust:?} {drift}");
    }
    assert!(drifts(&mut scene::filter()).iter().any(|drift| robust[0] < drift - 1e-4), "it costs something");
}

#[test]
fn with_rows_everybody_s_own_condition_is_met_or_the_worst_missed_least() {
    let mut rows = filter_with(|filter| filter.composition = Composition::Rows);
    let command = Scene::fresh(&people(), START_NS).step(&mut rows, START_NS);
    assert_eq!(status(&command), SafetyStatus::Filtered);
    assert_eq!(command.h_m, command.critical_h_m, "the critical obstacle's own value");
    for person in people() {
        let alone = Scene::fresh(&[person], START_NS).step(&mut scene::filter(), START_NS);
        let along = alone.lg_h[0] * command.control[0] + alone.lg_h[1] * command.control[1];
        let own = alone.drift_mps + along + alone.alpha_per_s * alone.h_m;
        assert!(own > -1e-9, "{person:?} {own}");
    }
    let command = boxed_in().step(&mut rows, START_NS);
    assert_eq!(status(&command), SafetyStatus::Relaxed);
    assert!(command.hard_margin_mps < 0.0, "{command:?}");
    assert!((command.slack_mps + command.hard_margin_mps).abs() < 1e-6, "{command:?}");
}

#[test]
fn pairs_beside_the_composite_only_add_conditions() {
    let mut both = filter_with(|filter| filter.composition = Composition::CompositeAndPairs);
    let scene = Scene::fresh(&people(), START_NS);
    let (command, published) = (scene.step(&mut both, START_NS), scene.step(&mut scene::filter(), START_NS));
    assert_eq!(command.h_m, published.h_m);
    assert!(held(&command) > -1e-9 && command.hard_margin_mps <= published.hard_margin_mps + 1e-9);
    let distance = |command: &SafeCommand| {
        (command.control[0] - command.nominal[0]).hypot(command.control[1] - command.nominal[1])
    };
    assert!(distance(&command) >= distance(&published) - 1e-6);
}

/// With the offset's bound removed the composite is lax, and the pairs' own conditions are what holds the robot.
#[test]
fn pairs_beside_the_composite_hold_for_the_two_nearest() {
    let lax = |composition| {
        filter_with(|filter| {
            filter.composition = composition;
            filter.softmin_offset = SoftminOffset::RemoveBound;
        })
    };
    let (mut alone, mut both) = (lax(Composition::Composite), lax(Composition::CompositeAndPairs));
    let (mut missed, mut met) = (0, 0);
    for tenths in 15..35 {
        let ahead_m = f64::from(tenths) * 0.1;
        let people = [
            person(1, [ahead_m, 0.4], [-0.8, 0.0], START_NS),
            person(2, [ahead_m + 0.3, -0.5], [-0.7, 0.1], START_NS),
        ];
        let scene = Scene::fresh(&people, START_NS);
        let own = |control: [f64; 2]| {
            let of = people.map(|one| {
                let mut command = Scene::fresh(&[one], START_NS).step(&mut scene::filter(), START_NS);
                command.control = control;
                held(&command)
            });
            of[0].min(of[1])
        };
        let (with, without) = (scene.step(&mut both, START_NS), scene.step(&mut alone, START_NS));
        assert!(own(with.control) >= -with.slack_mps - 1e-9, "{with:?}");
        met += usize::from(with.slack_mps < 1e-9);
        missed += usize::from(own(without.control) < -without.slack_mps - 1e-3);
    }
    assert!(met > 0 && missed > 0, "the scenes are too tame: {met} {missed}");
}

#[test]
fn without_the_softmin_s_offset_h_is_the_smallest_value() {
    let scene = Scene::fresh(&people(), START_NS);
    let published = scene.step(&mut scene::filter(), START_NS);
    let mut removed = filter_with(|filter| filter.softmin_offset = SoftminOffset::Remove);
    let command = scene.step(&mut removed, START_NS);
    assert_eq!(command.h_m, command.critical_h_m);
    assert!(published.h_m < command.h_m);
    let mut bound = filter_with(|filter| filter.softmin_offset = SoftminOffset::RemoveBound);
    let h = scene.step(&mut bound, START_NS).h_m;
    assert!((h - published.h_m - 3.0_f64.ln() / settings().filter.beta_per_m).abs() < 1e-9, "{h}");
}

#[test]
fn with_the_ramp_h_does_not_jump_when_someone_appears_and_ends_where_it_would_be() {
    let at = |people: &[Obstacle], now_ns: u64| {
        let people: Vec<_> = people
            .iter()
            .map(|one| Obstacle { measured_at_ns: now_ns, valid_at_ns: now_ns, ..*one })
            .collect();
        Scene::fresh(&people, now_ns)
    };
    let ([first, _, _], second) = (people(), person(8, [0.5, -1.8], [0.2, -0.6], START_NS));
    let mut ramped = filter_with(|filter| filter.appearance_ramp_s = Some(0.1));
    let mut published = scene::filter();
    let before = at(&[first], START_NS).step(&mut ramped, START_NS).h_m;
    let later_ns = START_NS + 4 * MS;
    let (soft, hard) = (
        at(&[first, second], later_ns).step(&mut ramped, later_ns).h_m,
        at(&[first, second], later_ns).step(&mut published, later_ns).h_m,
    );
    assert!((soft - before).abs() < 0.002 && hard < before - 0.005, "{before} {soft} {hard}");
    let end_ns = later_ns + 100 * MS;
    let (soft, hard) = (
        at(&[first, second], end_ns).step(&mut ramped, end_ns).h_m,
        at(&[first, second], end_ns).step(&mut published, end_ns).h_m,
    );
    assert!((soft - hard).abs() < 1e-12, "{soft} {hard}");
    // Someone at the robot's feet is there at once.
    let near = person(11, [0.8, 0.0], [-1.0, 0.0], START_NS);
    let soft = at(&[first, second, near], end_ns).step(&mut ramped, end_ns).h_m;
    assert!(soft < 0.0, "{soft}");
}

#[test]
fn at_its_speed_limit_the_quadrotor_is_not_told_to_go_faster() {
    let text = include_str!("../../config/quadrotor_paper.toml");
    let mut settings = Settings::parse(text, "quadrotor.toml".as_ref(), ".".as_ref()).expect("shipped");
    let model = load_model(&settings.filter.model).expect("shipped model");
    let step = |settings: &Settings, velocity_mps: [f64; 2]| {
        let mut scene = Scene::fresh(&[person(1, [-1.4, 0.3], [1.5, 0.0], START_NS)], START_NS);
        scene.robot_state = Some(RobotState { velocity_in_base_mps: velocity_mps, ..robot_state(START_NS) });
        if let Some(nominal) = &mut scene.nominal {
            (nominal.control_kind, nominal.control) = (ControlKind::DoubleIntegrator.code(), [2.0, 0.5]);
        }
        let mut filter = SafetyFilter::new(settings, &model).expect("shipped model fits shipped settings");
        scene.step(&mut filter, START_NS)
    };
    let (slow, fast) = ([0.5, 0.0], [2.0, 0.0]);
    let unlimited = step(&settings, fast);
    assert!(unlimited.control[0] > 0.5, "without the limit it accelerates");
    let without = step(&settings, slow);
    settings.filter.robot_max_speed_mps = Some(2.0);
    let limited = step(&settings, fast);
    assert!(limited.control[0] <= 0.0, "{limited:?}");
    assert!(limited.hard_margin_mps < unlimited.hard_margin_mps, "{limited:?}");
    assert_eq!(bytemuck::bytes_of(&step(&settings, slow)), bytemuck::bytes_of(&without), "far from it");
}

#[test]
fn what_is_not_finite_brakes_with_options_too() {
    let mut person = people()[0];
    person.velocity_in_odom_mps = [f64::MAX; 2];
    for composition in [Composition::Rows, Composition::CompositeAndPairs] {
        let mut filter = filter_with(|filter| {
            filter.composition = composition;
            filter.obstacle_input = ObstacleInput::WorstCase;
        });
        let command = Scene::fresh(&[person], START_NS).step(&mut filter, START_NS);
        assert_eq!(Reason::try_from(command.reason), Ok(Reason::NonFiniteBarrier), "{command:?}");
        assert!(command.control.iter().all(|value| value.is_finite()));
    }
}

#[test]
fn no_cycle_allocates_whatever_the_options() {
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1_u8; 100]))).count_total, 1, "the counter counts");
    let far: Vec<_> =
        (0..64).map(|k| person(k + 1, [3.0 + k as f64 * 0.2, 4.0], [0.0, -0.3], START_NS)).collect();
    let (boxed_in, far, nobody) = (boxed_in(), Scene::fresh(&far, START_NS), Scene::fresh(&[], START_NS));
    for composition in [Composition::Composite, Composition::Rows, Composition::CompositeAndPairs] {
        let mut filter = filter_with(|filter| {
            filter.composition = composition;
            filter.obstacle_input = ObstacleInput::WorstCase;
            filter.appearance_ramp_s = Some(0.3);
        });
        for round in 0..20_u64 {
            let now_ns = START_NS + round * MS / 1_000;
            let allocations = measure(|| {
                for scene in [&nobody, &boxed_in, &far] {
                    scene.step(&mut filter, now_ns);
                }
            });
            assert_eq!(allocations.count_total, 0, "{composition:?} round {round}");
        }
    }
}
