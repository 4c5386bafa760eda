//! The shipped files are accepted; what is wrong is refused by its name.

use super::*;

const GROUND_ROBOT: &str = include_str!("../../../config/ground_robot.toml");
const GROUND_ROBOT_PAPER: &str = include_str!("../../../config/ground_robot_paper.toml");

fn parse(text: &str) -> Result<Settings, SettingsError> {
    Settings::parse(text, Path::new("test.toml"), Path::new("config"))
}

#[test]
fn shipped_files_are_accepted_and_survive_a_round_trip() {
    for text in [GROUND_ROBOT, GROUND_ROBOT_PAPER] {
        let settings = parse(text).expect("shipped settings are valid");
        let again = parse(&settings.to_toml().expect("has a TOML form")).expect("its own output is valid");
        assert_eq!(again, settings);
    }
}

#[test]
fn a_ros2_graph_may_be_described_and_survives_a_round_trip() {
    let table = "[source.ros2]\nnode_name = \"filter\"\nnamespace = \"/robot1\"\n\
                 obstacles = \"autoware_perception_msgs/TrackedObjects\"\nreliability = \"reliable\"\n\
                 command_topic = \"cmd_vel\"\ncommand = \"geometry_msgs/TwistStamped\"\ncommand_period_ms = 20\n\n";
    let settings = parse(&GROUND_ROBOT.replacen("[simulation]", &(table.to_owned() + "[simulation]"), 1));
    let settings = settings.expect("valid");
    let ros2 = settings.source.ros2.as_ref().expect("described");
    assert_eq!((ros2.obstacles, ros2.command_period_ms), (ObstacleMessage::TrackedObjects, 20));
    assert_eq!(
        parse(&settings.to_toml().expect("has a TOML form")).expect("its own output is valid"),
        settings
    );
    assert_eq!(parse(GROUND_ROBOT).expect("shipped").source.ros2, None, "nothing needs it");
}

#[test]
fn an_unknown_key_is_named() {
    let text = GROUND_ROBOT.replace("[robot]", "[robot]\nradius_cm = 35.0");
    let message = parse(&text).expect_err("unknown key").to_string();
    assert!(message.contains("radius_cm"), "{message}");
}

#[test]
fn a_negative_radius_is_refused_by_name() {
    let text = GROUND_ROBOT.replacen("radius_m = 0.35", "radius_m = -0.35", 1);
    let message = parse(&text).expect_err("negative radius").to_string();
    assert!(message.contains("robot.radius_m") && message.contains("> 0"), "{message}");
}

#[test]
fn a_controller_for_another_robot_is_refused() {
    let text = GROUND_ROBOT.replace("controller = \"mpc\"", "controller = \"lqr\"");
    let message = parse(&text).expect_err("wrong controller").to_string();
    assert!(message.contains("nominal.controller"), "{message}");
}

#[test]
fn a_missing_file_says_which() {
    let message = Settings::load(Path::new("nowhere.toml")).expect_err("no file").to_string();
    assert!(message.contains("nowhere.toml") && message.contains("--config"), "{message}");
}

#[test]
fn a_grid_that_misses_allowed_obstacles_is_refused() {
    for (from, to, key) in [
        ("max_speed_mps = 1.5", "max_speed_mps = 1.6", "offline.grid.max"),
        (
            "min = [-6.0, -6.0, -3.141592653589793, 0.0]",
            "min = [-6.0, -6.0, -3.141592653589793, 0.1]",
            "offline.grid.min",
        ),
        ("min = [-6.0, -6.0,", "min = [-0.7, -6.0,", "offline.grid.min"),
        ("max = [6.0, 6.0,", "max = [6.0, 0.5,", "offline.grid.max"),
        (
            "periodic = [false, false, true, false]",
            "periodic = [false, false, false, false]",
            "offline.grid.periodic",
        ),
        (
            "periodic = [false, false, true, false]",
            "periodic = [true, false, true, false]",
            "offline.grid.periodic",
        ),
        ("-3.141592653589793, 0.0]", "-3.0, 0.0]", "offline.grid.periodic"),
    ] {
        assert!(GROUND_ROBOT_PAPER.contains(from), "{from}");
        let message = parse(&GROUND_ROBOT_PAPER.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(message.contains(key), "{to}: {message}");
    }
}

/// The paper's ground robot among things that stand still.
fn among_static_things() -> String {
    GROUND_ROBOT_PAPER
        .replace("disturbance_min = [-0.35]", "disturbance_min = []")
        .replace("disturbance_max = [0.35]", "disturbance_max = []")
        .replace("max_speed_mps = 1.5\n", "max_speed_mps = 0.0\nmotion = \"static\"\n")
}

#[test]
fn obstacles_walk_unless_the_file_says_that_they_stand() {
    assert_eq!(parse(GROUND_ROBOT_PAPER).expect("valid").obstacle.motion, ObstacleMotion::Walking);
    let settings = parse(&among_static_things()).expect("valid");
    assert_eq!(settings.obstacle.motion, ObstacleMotion::Static);
    let again = parse(&settings.to_toml().expect("has a TOML form")).expect("its own output is valid");
    assert_eq!(again, settings);
}

#[test]
fn a_static_obstacle_has_neither_inputs_nor_speed() {
    for (from, to, key) in [
        ("disturbance_min = []", "disturbance_min = [-0.35]", "obstacle.disturbance_min"),
        ("max_speed_mps = 0.0", "max_speed_mps = 0.5", "obstacle.max_speed_mps"),
        ("kind = \"unicycle\"", "kind = \"double_integrator\"", "obstacle.motion"),
    ] {
        assert!(among_static_things().contains(from), "{from}");
        let text = among_static_things().replacen(from, to, 1).replace(
            "disturbance_max = []",
            if from.starts_with("dist") { "disturbance_max = [0.35]" } else { "disturbance_max = []" },
        );
        let message = parse(&text).expect_err(to).to_string();
        assert!(message.contains(key), "{to}: {message}");
    }
}

#[test]
fn slack_shrinks_the_robot_and_strengthens_the_obstacle_about_their_centres() {
    let plain = parse(GROUND_ROBOT_PAPER).expect("valid").training_game();
    assert_eq!((plain.control_min, plain.control_max), ([0.25, -0.8], [1.0, 0.8]));
    assert_eq!((plain.disturbance_min, plain.disturbance_max), (vec![-0.35], vec![0.35]));

    let text =
        format!("{GROUND_ROBOT_PAPER}\n[offline.slack]\ncontrol_scale = 0.8\ndisturbance_scale = 2.0\n");
    let settings = parse(&text).expect("valid");
    let game = settings.training_game();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(near(game.control_min[0], 0.325) && near(game.control_max[0], 0.925));
    assert!(near(game.control_min[1], -0.64) && near(game.control_max[1], 0.64));
    assert!(near(game.disturbance_min[0], -0.7) && near(game.disturbance_max[0], 0.7));
    assert_eq!(settings.robot.control_min, [0.25, -0.8], "the true game stays as it is");

    for (key, value) in [
        ("control_scale", "0.0"),
        ("control_scale", "1.1"),
        ("disturbance_scale", "0.9"),
        ("disturbance_scale", "inf"),
    ] {
        let text = format!("{GROUND_ROBOT_PAPER}\n[offline.slack]\n{key} = {value}\n");
        let message = parse(&text).expect_err(value).to_string();
        assert!(message.contains(key), "{message}");
    }
}

#[test]
fn all_four_accuracies_have_a_name() {
    for name in ["low", "medium", "high", "very_high"] {
        let text = GROUND_ROBOT_PAPER.replace("accuracy = \"high\"", &format!("accuracy = \"{name}\""));
        assert!(parse(&text).is_ok(), "{name}");
    }
}
