//! Robot plants against closed forms and against a finely stepped integration.

use crowd_sim::{Plant, PlantError, PlantSettings, RobotStart};

const ORIGIN: RobotStart = RobotStart { position_m: [0.0, 0.0], heading_rad: 0.0 };

fn assert_close(a: [f64; 2], b: [f64; 2], tolerance: f64) {
    assert!((a[0] - b[0]).abs() <= tolerance && (a[1] - b[1]).abs() <= tolerance, "{a:?} is not {b:?}");
}

#[test]
fn a_full_circle_ends_where_it_began() {
    let mut plant = Plant::new(PlantSettings::ground_robot(), ORIGIN).unwrap();
    let turn_s = std::f64::consts::TAU / 0.5;
    for quarter in 1..=4 {
        plant.step(turn_s / 4.0, [0.6, 0.5]);
        let radius_m = 0.6 / 0.5;
        let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
        assert_close(
            plant.state().position_m,
            [radius_m * angle.sin(), radius_m * (1.0 - angle.cos())],
            1e-12,
        );
    }
    assert!(plant.state().heading_rad.abs() < 1e-12);
}

#[test]
fn arc_steps_of_any_length_agree_and_straight_lines_are_their_limit() {
    for yaw_rate in [0.0, 1e-9, 1e-5, 3e-4, 0.7] {
        let mut coarse = Plant::new(PlantSettings::ground_robot(), ORIGIN).unwrap();
        let mut fine = coarse.clone();
        coarse.step(0.8, [0.9, yaw_rate]);
        (0..800).for_each(|_| fine.step(0.001, [0.9, yaw_rate]));
        assert_close(coarse.state().position_m, fine.state().position_m, 1e-12);
    }
}

#[test]
fn the_double_integrator_follows_its_parabola_up_to_its_speed_limit() {
    let mut plant = Plant::new(PlantSettings::quadrotor(), ORIGIN).unwrap();
    plant.step(0.5, [1.0, -2.0]);
    assert_close(plant.state().position_m, [0.125, -0.25], 1e-15);
    assert_close(plant.state().velocity_mps, [0.5, -1.0], 1e-15);
    // The second axis reaches −2 m/s after another 0.5 s and coasts for the rest of the second.
    plant.step(1.0, [1.0, -2.0]);
    assert_close(plant.state().velocity_mps, [1.5, -2.0], 1e-15);
    assert_close(plant.state().position_m, [1.125, -0.25 - 0.75 - 1.0], 1e-15);
}

#[test]
fn commands_are_clipped_to_the_actuators() {
    let mut plant = Plant::new(PlantSettings::ground_robot(), ORIGIN).unwrap();
    plant.step(1.0, [9.0, 0.0]);
    assert_close(plant.state().position_m, [1.0, 0.0], 1e-15);
    plant.step(1.0, [-9.0, 7.0]);
    assert_close(plant.state().position_m, [1.0, 0.0], 1e-15);
    assert!((plant.state().heading_rad - 0.8).abs() < 1e-15);
    assert_eq!(plant.state().body_velocity_mps(), [0.0, 0.0]);
}

#[test]
fn a_lag_approaches_the_command_exponentially_at_any_step() {
    let settings = PlantSettings { lag_s: 0.2, ..PlantSettings::ground_robot() };
    for steps in [1, 7, 100] {
        let mut plant = Plant::new(settings.clone(), ORIGIN).unwrap();
        (0..steps).for_each(|_| plant.step(0.4 / f64::from(steps), [1.0, 0.0]));
        let expected = 1.0 - (-2.0_f64).exp();
        assert!((plant.state().body_velocity_mps()[0] - expected).abs() < 1e-12);
    }
}

#[test]
fn a_rate_limit_caps_acceleration_and_braking() {
    let settings =
        PlantSettings { input_rate_limit_per_s: Some([0.5, 0.5]), ..PlantSettings::ground_robot() };
    let mut plant = Plant::new(settings, ORIGIN).unwrap();
    (0..100).for_each(|_| plant.step(0.01, [1.0, 0.0]));
    assert!((plant.state().body_velocity_mps()[0] - 0.5).abs() < 1e-12);
    (0..50).for_each(|_| plant.step(0.01, [0.0, 0.0]));
    assert!((plant.state().body_velocity_mps()[0] - 0.25).abs() < 1e-12);
}

#[test]
fn a_robot_that_cannot_stop_is_refused() {
    let mut settings = PlantSettings::ground_robot();
    settings.actuator_limits.min[0] = 0.25;
    let error = Plant::new(settings, ORIGIN).unwrap_err();
    assert!(matches!(error, PlantError::CannotStop { .. }) && error.to_string().contains("stopped"));
}

#[test]
fn a_negative_lag_is_refused() {
    let settings = PlantSettings { lag_s: -0.1, ..PlantSettings::ground_robot() };
    assert!(matches!(Plant::new(settings, ORIGIN), Err(PlantError::BadNumber { field: "lag_s", .. })));
}

#[test]
fn a_rate_limit_of_zero_is_refused() {
    let settings =
        PlantSettings { input_rate_limit_per_s: Some([0.5, 0.0]), ..PlantSettings::ground_robot() };
    assert!(matches!(Plant::new(settings, ORIGIN), Err(PlantError::BadNumber { .. })));
}

#[test]
fn after_a_dead_time_the_robot_does_what_it_was_told() {
    for model in [PlantSettings::ground_robot(), PlantSettings::quadrotor()] {
        let mut late = Plant::new(PlantSettings { delay_s: 0.1, ..model.clone() }, ORIGIN).unwrap();
        let mut prompt = Plant::new(model, ORIGIN).unwrap();
        let control = |k: u32| [0.6 + 0.4 * (0.3 * f64::from(k)).sin(), 0.5 * (0.11 * f64::from(k)).cos()];
        // Steps that do not divide the dead time.
        for k in 0..1_000 {
            late.step(0.007, control(k));
            prompt.step(0.007, control(k));
        }
        assert_ne!(late.state(), prompt.state());
        // Given 0.1 s more, the late one has caught up with where the prompt one was.
        late.step(0.1, [0.0, 0.0]);
        assert_close(late.state().position_m, prompt.state().position_m, 1e-9);
        assert!((late.state().heading_rad - prompt.state().heading_rad).abs() < 1e-9);
    }
}

#[test]
fn a_step_longer_than_the_dead_time_is_divided_where_the_command_takes_effect() {
    let mut plant =
        Plant::new(PlantSettings { delay_s: 0.25, ..PlantSettings::ground_robot() }, ORIGIN).unwrap();
    plant.step(1.0, [0.8, 0.0]);
    assert_close(plant.state().position_m, [0.6, 0.0], 1e-12);
}

#[test]
fn dead_time_comes_before_lag() {
    let settings = PlantSettings { delay_s: 0.1, lag_s: 0.2, ..PlantSettings::ground_robot() };
    let mut plant = Plant::new(settings, ORIGIN).unwrap();
    (0..50).for_each(|_| plant.step(0.01, [1.0, 0.0]));
    let expected = 1.0 - (-2.0_f64).exp();
    assert!((plant.state().body_velocity_mps()[0] - expected).abs() < 1e-9);
}

#[test]
fn a_dead_time_beyond_reason_is_refused() {
    for delay_s in [-0.1, f64::NAN, f64::INFINITY, 1e9] {
        let settings = PlantSettings { delay_s, ..PlantSettings::ground_robot() };
        assert!(matches!(Plant::new(settings, ORIGIN), Err(PlantError::BadDelay { .. })), "{delay_s}");
    }
}
