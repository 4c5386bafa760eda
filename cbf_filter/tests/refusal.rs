//! A model that was not made for the settings is refused before the first cycle, and the message says what to do.

mod scene;

use std::collections::BTreeMap;
use std::path::PathBuf;

use barrier::{Bounds, DynamicsKind, GridRecord, Model, ModelMetadata};
use cbf_filter::{FilterSetupError, SafetyFilter, load_model};
use settings::{KernelChoice, ObstacleMotion, Settings};

/// The message with which the filter refuses the shipped model, or the one `change` names, after `change`.
fn refusal(change: impl FnOnce(&mut Settings)) -> String {
    let mut settings = scene::settings();
    change(&mut settings);
    let outcome = load_model(&settings.filter.model).and_then(|model| SafetyFilter::new(&settings, &model));
    outcome.err().expect("must be refused").to_string()
}

fn shipped() -> Model {
    load_model(&scene::settings().filter.model).expect("shipped model")
}

/// The paper's weights under other metadata: raw inputs suit every pair.
fn changed(change: impl FnOnce(&mut ModelMetadata)) -> Model {
    let paper = load_model("embedded:ground_robot_paper").expect("shipped model");
    let mut metadata = paper.metadata().clone();
    change(&mut metadata);
    Model::new(paper.weights().clone(), metadata).expect("usable metadata")
}

/// The message with which the filter refuses `model` under the shipped settings.
fn refusal_of(model: &Model) -> String {
    SafetyFilter::new(&scene::settings(), model).err().expect("must be refused").to_string()
}

#[track_caller]
fn says(message: &str, parts: &[&str]) {
    assert!(parts.iter().all(|part| message.contains(part)), "{message} lacks one of {parts:?}");
}

#[test]
fn the_shipped_model_is_taken_and_may_be_pinned() {
    let mut settings = scene::settings();
    let model = shipped();
    for hash in [model.metadata().hash.clone(), model.metadata().hash.to_uppercase()] {
        settings.filter.model_sha256 = Some(hash);
        assert!(SafetyFilter::new(&settings, &model).is_ok());
    }
}

#[test]
fn another_model_than_the_pinned_one_is_refused() {
    let message = refusal(|settings| {
        let other = load_model("embedded:ground_robot_paper").expect("shipped model");
        settings.filter.model_sha256 = Some(other.metadata().hash.clone());
    });
    says(&message, &["SHA-256", "pin"]);
}

#[test]
fn a_model_is_another_one_once_its_verification_changes() {
    let mut settings = scene::settings();
    settings.filter.model_sha256 = Some(shipped().metadata().hash.clone());
    let verified = shipped().with_verification(BTreeMap::from([("scenario".to_owned(), 1.into())]));
    let refused = SafetyFilter::new(&settings, &verified.expect("JSON")).err();
    assert!(matches!(refused, Some(FilterSetupError::Mismatch(_))), "{refused:?}");
}

#[test]
fn a_model_for_other_dynamics_is_refused() {
    let model = changed(|metadata| {
        metadata.dynamics = DynamicsKind::DoubleIntegratorPair;
        metadata.disturbance = Bounds { min: vec![-0.35; 2], max: vec![0.35; 2] };
    });
    says(&refusal_of(&model), &["double_integrator_pair", "unicycle_pair"]);
}

#[test]
fn a_model_for_walking_obstacles_is_not_one_for_static_obstacles() {
    let message = refusal(|settings| {
        settings.obstacle.motion = ObstacleMotion::Static;
        settings.obstacle.disturbance_min.clear();
        settings.obstacle.disturbance_max.clear();
        settings.obstacle.max_speed_mps = 0.0;
    });
    says(&message, &["unicycle_static_pair"]);
}

#[test]
fn a_robot_with_other_limits_is_refused() {
    says(&refusal(|settings| settings.robot.control_max[1] = 0.7), &["control box", "train"]);
    says(&refusal(|settings| settings.robot.control_min[0] = 0.3), &["control box", "train"]);
}

#[test]
fn a_robot_that_may_also_stop_is_taken_and_stops_where_it_is_told_to() {
    let mut settings = scene::settings();
    settings.robot.control_min[0] = 0.0;
    let mut filter =
        SafetyFilter::new(&settings, &shipped()).expect("it can do all that the model counts on");
    let mut scene = scene::Scene::fresh(&[], scene::START_NS);
    if let Some(nominal) = &mut scene.nominal {
        nominal.control = [0.0, 0.0];
    }
    assert_eq!(scene.step(&mut filter, scene::START_NS).control, [0.0, 0.0]);
    // The robot of the model goes on at its lowest speed.
    let command = scene.step(&mut scene::filter(), scene::START_NS);
    assert!(command.control[0] >= 0.25, "{command:?}");
}

#[test]
fn obstacles_that_turn_faster_are_refused() {
    let message = refusal(|settings| {
        settings.obstacle.disturbance_min = vec![-0.5];
        settings.obstacle.disturbance_max = vec![0.5];
    });
    says(&message, &["disturbance box", "train"]);
}

#[test]
fn another_radius_is_refused() {
    says(&refusal(|settings| settings.obstacle.radius_m = 0.45), &["failure radius", "0.7 m", "0.8 m"]);
}

#[test]
fn obstacles_faster_than_the_model_covers_are_refused() {
    let message = refusal(|settings| settings.obstacle.max_speed_mps = 5.0);
    says(&message, &["5 m/s", "1.5 m/s", "obstacle.max_speed_mps"]);
}

#[test]
fn a_double_integrator_model_covers_obstacles_in_every_direction() {
    let grid = GridRecord {
        min: [-4.0, -4.0, -3.5, -1.0],
        max: [4.0, 4.0, 3.5, 3.5],
        count: [80, 80, 20, 20],
        periodic: [false; 4],
    };
    let model = changed(|metadata| {
        metadata.dynamics = DynamicsKind::DoubleIntegratorPair;
        metadata.disturbance = Bounds { min: vec![-1.0; 2], max: vec![1.0; 2] };
        metadata.grid = grid;
    });
    assert!(model.check_covers(1.0, 0.7).is_ok());
    says(&model.check_covers(1.5, 0.7).expect_err("too fast").to_string(), &["1 m/s"]);
}

#[test]
fn a_buffer_that_reaches_the_edge_of_the_domain_is_refused() {
    let message = refusal(|settings| settings.filter.sdf_buffer_m = 7.0);
    says(&message, &["7.7 m", "7.5 m", "filter.sdf_buffer_m"]);
}

#[test]
fn a_file_that_is_missing_truncated_or_foreign_is_refused_by_its_name() {
    let folder = std::env::temp_dir().join(format!("cncbf-refusal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("temporary folder");
    let bytes = shipped().to_bytes().expect("bytes of a model");
    let files: [(&str, &[u8], &str); 3] = [
        ("truncated.safetensors", &bytes[..bytes.len() / 2], "copy it again"),
        ("foreign.safetensors", b"PK\x03\x04, something else, longer than a header", "no safetensors file"),
        ("empty.safetensors", b"", "copy it again"),
    ];
    for (name, contents, reason) in files {
        let path: PathBuf = folder.join(name);
        std::fs::write(&path, contents).expect("writable");
        let message = refusal(|settings| settings.filter.model = path.to_string_lossy().into_owned());
        says(&message, &[name, reason]);
    }
    says(
        &refusal(|settings| settings.filter.model = "no/such.safetensors".to_owned()),
        &["no/such", "check path"],
    );
    says(&refusal(|settings| settings.filter.model = "embedded:tank".to_owned()), &["tank", "ground_robot"]);
    std::fs::remove_dir_all(folder).expect("own folder");
}

#[test]
fn a_static_model_guards_against_things_that_stand() {
    let mut settings = scene::settings();
    settings.obstacle.motion = ObstacleMotion::Static;
    settings.obstacle.disturbance_min.clear();
    settings.obstacle.disturbance_max.clear();
    settings.obstacle.max_speed_mps = 0.0;
    let model = scene::static_model();
    let mut filter = SafetyFilter::new(&settings, &model).expect("fits static settings");
    let pillar = scene::person(3, [2.0, 0.1], [0.0; 2], scene::START_NS);
    let command = scene::Scene::fresh(&[pillar], scene::START_NS).step(&mut filter, scene::START_NS);
    assert!(command.h_m.is_finite() && command.outside_domain == 0, "{command:?}");
    assert_eq!(command.critical_track_id, 3);
}

#[test]
fn a_kernel_this_processor_lacks_is_refused_and_any_other_runs() {
    for choice in [KernelChoice::Auto, KernelChoice::Portable, KernelChoice::Avx2Fma, KernelChoice::Avx512] {
        let mut settings = scene::settings();
        settings.filter.kernel = choice;
        let kernel = cbf_filter::chosen_kernel(choice);
        match SafetyFilter::new(&settings, &shipped()) {
            Ok(filter) => assert!(kernel.is_supported() && filter.kernel() == kernel),
            Err(refused) => {
                assert!(!kernel.is_supported());
                says(&refused.to_string(), &["cannot run kernel", "portable"]);
            }
        }
    }
}
