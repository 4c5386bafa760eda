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
