//! Mixed scenes: each obstacle is judged by the model of its class, under one barrier.

mod scene;

use std::path::PathBuf;

use allocation_counter::measure;
use barrier::Model;
use cbf_filter::{SafetyFilter, load_model};
use messages::{Obstacle, ObstacleClass};
use scene::{MS, START_NS, Scene, person};
use settings::{ClassName, Settings};

/// A folder of its own for each test, gone with it.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("cncbf-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("temporary folder");
        Self(path)
    }

    /// Saves `model` and returns its path as the settings take it.
    fn save(&self, name: &str, model: &Model) -> String {
        let path = self.0.join(name);
        model.save(&path).expect("writable");
        path.to_string_lossy().into_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).expect("own folder");
    }
}

/// The shipped model under a wider domain, as if made for cyclists; the file differs, the weights do not.
fn cyclist_model() -> Model {
    let shipped = load_model(&scene::settings().filter.model).expect("shipped model");
    let mut metadata = shipped.metadata().clone();
    metadata.grid.max[3] = 5.0;
    metadata.disturbance.max = vec![0.8];
    Model::new(shipped.weights().clone(), metadata).expect("usable metadata")
}

fn mixed_settings(folder: &Folder) -> Settings {
    let mut settings = scene::settings();
    settings.filter.class_models = [
        (ClassName::Static, folder.save("static.safetensors", &scene::static_model())),
        (ClassName::Cyclist, folder.save("cyclist.safetensors", &cyclist_model())),
        (ClassName::Vehicle, folder.0.join("cyclist.safetensors").to_string_lossy().into_owned()),
    ]
    .into();
    settings
}

fn mixed_filter(folder: &Folder) -> SafetyFilter {
    let settings = mixed_settings(folder);
    let model = load_model(&settings.filter.model).expect("shipped model");
    SafetyFilter::new(&settings, &model).expect("class models fit")
}

fn obstacle(class: ObstacleClass, speed_mps: f64) -> Obstacle {
    Obstacle { class: class.code(), ..person(1, [2.2, 0.4], [-speed_mps, 0.0], START_NS) }
}

fn h(filter: &mut SafetyFilter, obstacle: Obstacle) -> f64 {
    Scene::fresh(&[obstacle], START_NS).step(filter, START_NS).h_m
}

#[test]
fn the_class_decides_on_the_model() {
    let folder = Folder::new("class-decides");
    let (mut mixed, mut plain) = (mixed_filter(&folder), scene::filter());
    let mut static_settings = scene::settings();
    static_settings.obstacle.motion = settings::ObstacleMotion::Static;
    static_settings.obstacle.disturbance_min.clear();
    static_settings.obstacle.disturbance_max.clear();
    static_settings.obstacle.max_speed_mps = 0.0;
    let mut still = SafetyFilter::new(&static_settings, &scene::static_model()).expect("fits");

    for class in [ObstacleClass::Unknown, ObstacleClass::Pedestrian] {
        assert_eq!(h(&mut mixed, obstacle(class, 0.0)), h(&mut plain, obstacle(class, 0.0)));
    }
    let pillar = obstacle(ObstacleClass::Static, 0.0);
    assert_eq!(h(&mut mixed, pillar), h(&mut still, pillar));
    assert_ne!(h(&mut mixed, pillar), h(&mut plain, pillar));
}

#[test]
fn a_faster_class_is_inside_the_domain_of_its_own_model_only() {
    let folder = Folder::new("class-domain");
    let mut mixed = mixed_filter(&folder);
    for (class, outside) in [
        (ObstacleClass::Cyclist, 0),
        (ObstacleClass::Vehicle, 0),
        (ObstacleClass::Pedestrian, 1),
        (ObstacleClass::Unknown, 1),
    ] {
        let command = Scene::fresh(&[obstacle(class, 3.0)], START_NS).step(&mut mixed, START_NS);
        assert_eq!(command.outside_domain, outside, "{class:?}");
    }
}

#[test]
fn a_thing_called_static_that_moves_is_judged_as_a_moving_one() {
    let folder = Folder::new("static-moves");
    let (mut mixed, mut plain) = (mixed_filter(&folder), scene::filter());
    for speed_mps in [0.3, 1.2] {
        let cart = obstacle(ObstacleClass::Static, speed_mps);
        assert_eq!(h(&mut mixed, cart), h(&mut plain, cart), "{speed_mps}");
    }
    let trembling = obstacle(ObstacleClass::Static, 0.1);
    assert_ne!(h(&mut mixed, trembling), h(&mut plain, trembling));
}

#[test]
fn all_classes_stand_under_one_barrier() {
    let folder = Folder::new("one-barrier");
    let mut mixed = mixed_filter(&folder);
    let classes = [ObstacleClass::Pedestrian, ObstacleClass::Static, ObstacleClass::Cyclist];
    let single = classes.map(|class| h(&mut mixed, obstacle(class, 0.0)));
    let all: Vec<_> = classes.into_iter().map(|class| obstacle(class, 0.0)).collect();
    let command = Scene::fresh(&all, START_NS).step(&mut mixed, START_NS);
    let beta_per_m = scene::settings().filter.beta_per_m;
    assert!((command.h_m - barrier::softmin(&single, beta_per_m)).abs() < 1e-12, "{command:?} {single:?}");
}

#[test]
fn a_mixed_cycle_allocates_nothing() {
    let folder = Folder::new("mixed-allocations");
    let mut mixed = mixed_filter(&folder);
    let people: Vec<_> = (0..64)
        .map(|k| Obstacle {
            class: k as u32 % 7,
            ..person(k + 1, [3.0, 2.0 + 0.1 * k as f64], [0.0, -0.1 * (k % 9) as f64], START_NS)
        })
        .collect();
    let mut counts = 0;
    for cycle in 0..50 {
        let now_ns = START_NS + cycle * 4 * MS;
        let scene = Scene::fresh(&people[..cycle as usize], now_ns);
        let of_cycle = measure(|| {
            std::hint::black_box(scene.step(&mut mixed, now_ns));
        });
        counts += of_cycle.count_total;
    }
    assert_eq!(counts, 0);
}

/// The message with which a filter refuses `class_model` for cyclists.
fn refusal(class_model: String) -> String {
    let mut settings = scene::settings();
    settings.filter.class_models = [(ClassName::Cyclist, class_model)].into();
    let model = load_model(&settings.filter.model).expect("shipped model");
    SafetyFilter::new(&settings, &model).err().expect("must be refused").to_string()
}

#[test]
fn a_class_model_of_another_robot_is_refused_by_its_name() {
    let folder = Folder::new("class-refusal");
    let mut metadata = cyclist_model().metadata().clone();
    metadata.control.max[0] = 2.0;
    let other = Model::new(cyclist_model().weights().clone(), metadata).expect("usable");
    let message = refusal(folder.save("fast_robot.safetensors", &other));
    assert!(message.contains("fast_robot") && message.contains("control box"), "{message}");

    let flying = load_model("embedded:quadrotor").expect("shipped model");
    let message = refusal(folder.save("flying.safetensors", &flying));
    assert!(message.contains("flying") && message.contains("double_integrator_pair"), "{message}");

    let message = refusal("no/such.safetensors".to_owned());
    assert!(message.contains("no/such.safetensors"), "{message}");
}

#[test]
fn the_default_model_may_be_named_for_a_class_too() {
    let mut settings = scene::settings();
    let name = settings.filter.model.clone();
    settings.filter.class_models =
        [(ClassName::Cyclist, name.clone()), (ClassName::Vehicle, name.clone())].into();
    let model = load_model(&name).expect("shipped model");
    let mut filter = SafetyFilter::new(&settings, &model).expect("fits");
    let mut plain = scene::filter();
    let cyclist = obstacle(ObstacleClass::Cyclist, 1.0);
    assert_eq!(h(&mut filter, cyclist), h(&mut plain, cyclist));
}
