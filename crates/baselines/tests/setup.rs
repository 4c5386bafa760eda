//! What is built from names, settings and parameters, and what is refused.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use barrier::ModelMismatch;
use baselines::{
    C3bfParameters, DcbfParameters, HoCbfParameters, MethodKind, MethodParameters, MethodSetupError,
    PlannerParameters, RntcParameters,
};
use settings::{RobotKind, Settings};

fn settings_of(kind: MethodKind) -> Settings {
    match kind.robot() {
        RobotKind::Unicycle => common::ground_robot(),
        RobotKind::DoubleIntegrator => common::quadrotor(),
    }
}

fn refused(parameters: MethodParameters) -> MethodSetupError {
    let model = common::model();
    parameters.build(&settings_of(parameters.kind()), Some(&model)).err().unwrap()
}

#[test]
fn every_method_is_built_as_published_and_known_by_its_name() {
    let model = common::model();
    for kind in MethodKind::ALL {
        let parameters = MethodParameters::published(kind);
        assert_eq!(parameters.kind(), kind);
        assert_eq!(kind.to_string().parse(), Ok(kind));
        assert!(parameters.build(&settings_of(kind), Some(&model)).is_ok(), "{kind}");
    }
}

#[test]
fn parameters_survive_being_written() {
    for kind in MethodKind::ALL {
        let parameters = MethodParameters::published(kind);
        let text = serde_json::to_string(&parameters).unwrap();
        assert!(text.contains(kind.name()), "{text}");
        assert_eq!(serde_json::from_str::<MethodParameters>(&text).unwrap(), parameters);
    }
}

#[test]
fn the_published_values_are_the_papers() {
    assert_eq!(DcbfParameters::published().gamma, 0.3);
    assert_eq!(C3bfParameters::published().k_per_s, 3.0);
    let HoCbfParameters { k1_per_s, k2_per_s, .. } = HoCbfParameters::published();
    assert_eq!((k1_per_s, k2_per_s), (3.0, 2.0));
    let planner = PlannerParameters::published();
    assert_eq!((planner.horizon_steps, planner.step_s), (20, 0.1));
}

#[test]
fn an_unknown_name_is_told_the_known_ones() {
    let error = "orca".parse::<MethodKind>().unwrap_err().to_string();
    assert!(error.contains("orca") && error.contains("vo_mpc"), "{error}");
}

#[test]
fn settings_of_the_other_robot_are_refused() {
    for kind in MethodKind::ALL {
        let other = match kind.robot() {
            RobotKind::Unicycle => common::quadrotor(),
            RobotKind::DoubleIntegrator => common::ground_robot(),
        };
        let error = MethodParameters::published(kind).build(&other, None).err().unwrap();
        assert!(matches!(error, MethodSetupError::OtherRobot { .. }), "{kind}: {error}");
    }
}

#[test]
fn a_terminal_set_needs_a_model_of_this_robot_among_walking_people() {
    let parameters = MethodParameters::published(MethodKind::RntcMpc);
    assert_eq!(parameters.build(&common::ground_robot(), None).err(), Some(MethodSetupError::NoModel));
    let path = common::root().join("models/static_obstacles.safetensors");
    let still = barrier::Model::load(&path).unwrap();
    let error = parameters.build(&common::ground_robot(), Some(&still)).err().unwrap();
    assert!(matches!(error, MethodSetupError::Model(ModelMismatch::Dynamics { .. })), "{error}");
    let mut slower = common::ground_robot();
    slower.robot.control_max[0] = 0.9;
    let error = parameters.build(&slower, Some(&common::model())).err().unwrap();
    assert!(matches!(error, MethodSetupError::Model(ModelMismatch::Control { .. })), "{error}");
}

#[test]
fn a_gamma_outside_its_range_is_refused() {
    for gamma in [0.0, -0.3, 1.01, f64::NAN] {
        let parameters = DcbfParameters { gamma, ..DcbfParameters::published() };
        let error = refused(MethodParameters::DcbfMpc(parameters));
        assert!(matches!(error, MethodSetupError::Parameter { parameter: "gamma", .. }), "{error}");
    }
}

#[test]
fn gains_that_are_not_above_zero_are_refused() {
    let c3bf = C3bfParameters { k_per_s: 0.0, ..C3bfParameters::published() };
    let error = refused(MethodParameters::C3bf(c3bf));
    assert!(matches!(error, MethodSetupError::Parameter { parameter: "k_per_s", .. }), "{error}");
    let ho_cbf = HoCbfParameters { k2_per_s: f64::INFINITY, ..HoCbfParameters::published() };
    let error = refused(MethodParameters::HoCbf(ho_cbf));
    assert!(matches!(error, MethodSetupError::Parameter { parameter: "k2_per_s", .. }), "{error}");
}

#[test]
fn a_slack_without_weight_is_refused() {
    let mut parameters = C3bfParameters::published();
    parameters.filter.slack_weight = 0.0;
    let error = refused(MethodParameters::C3bf(parameters));
    assert!(matches!(error, MethodSetupError::Parameter { parameter: "slack_weight", .. }), "{error}");
}

#[test]
fn a_negative_terminal_margin_is_refused() {
    let parameters = RntcParameters { terminal_margin_m: -0.1, ..RntcParameters::published() };
    let error = refused(MethodParameters::RntcMpc(parameters));
    assert!(matches!(error, MethodSetupError::Parameter { parameter: "terminal_margin_m", .. }), "{error}");
}

#[test]
fn sight_of_nobody_or_of_too_many_is_refused() {
    for given in [0, messages::MAX_OBSTACLES + 1] {
        let mut parameters = PlannerParameters::published();
        parameters.sight.obstacle_limit = given;
        let error = refused(MethodParameters::SdfMpc(parameters));
        assert_eq!(error, MethodSetupError::ObstacleLimit { given });
    }
}

#[test]
fn an_empty_horizon_and_a_free_violation_are_refused() {
    let parameters = PlannerParameters { horizon_steps: 0, ..PlannerParameters::published() };
    assert!(matches!(refused(MethodParameters::VoMpc(parameters)), MethodSetupError::Sqp(_)));
    let parameters = PlannerParameters { violation_weight: 0.0, ..PlannerParameters::published() };
    assert!(matches!(refused(MethodParameters::VoMpc(parameters)), MethodSetupError::Sqp(_)));
}
