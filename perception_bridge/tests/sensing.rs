//! The simulated perception: each shortcoming does what its setting says, and to nothing else.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::collections::BTreeMap;
use std::path::Path;

use allocation_counter::measure;
use crowd_sim::{Motion, Person, Scenario, ScenarioRequest};
use messages::{Detection, DetectionFlags, Detections, ObstacleClass};
use perception_bridge::{BridgeEvent, Obedience, SimulatedCrowd, Source};
use settings::{ClassName, ClassesSettings, DriftSettings, SensingSettings, Settings};

const MS: u64 = 1_000_000;
const PERFECT: SensingSettings = SensingSettings {
    range_m: None,
    window_m: None,
    field_of_view_deg: None,
    occlusion: false,
    dropout: 0.0,
    latency_ms: 0,
    drift: None,
    hide_velocity: false,
};

fn settings(position_noise_m: f64, sensing: SensingSettings) -> Settings {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/ground_robot.toml");
    let mut settings = Settings::load(&file).unwrap();
    settings.simulation.position_noise_m = position_noise_m;
    settings.simulation.sensing = Some(sensing);
    settings
}

fn standing(positions_m: &[[f64; 2]]) -> Scenario {
    let people = positions_m.iter().zip(1..).map(|(&position_m, id)| Person {
        id,
        radius_m: 0.35,
        class: ClassName::Pedestrian,
        motion: Motion::Bounce { position_m, velocity_mps: [0.0, 0.0] },
    });
    let people = people.collect();
    let empty = ScenarioRequest { count: 0, ..ScenarioRequest::evaluation(3, 0) }.generate().unwrap();
    Scenario { people, ..empty }
}

/// Frames with their arrival, ns after the start, of `seconds` of a scenario.
fn frames(settings: &Settings, scenario: &Scenario, seconds: u64) -> Vec<(u64, Detections)> {
    let mut source = SimulatedCrowd::in_scenario(settings, scenario, Obedience::Filter).unwrap();
    let mut frames = Vec::new();
    for tick in 0..seconds * 1_000 {
        while let Some(event) = source.poll(tick * MS) {
            match event {
                BridgeEvent::Detections(frame) => frames.push((tick * MS, frame)),
                BridgeEvent::RobotState(_) | BridgeEvent::Goal(_) | BridgeEvent::NominalCommand(_) => {}
            }
        }
    }
    frames
}

fn ids(frame: &Detections) -> Vec<u64> {
    let mut ids: Vec<u64> = frame.as_slice().iter().map(|detection| detection.track_id).collect();
    ids.sort_unstable();
    ids
}

/// Who of people standing at `positions_m` is seen from (−2, 0) with heading zero.
fn seen(sensing: SensingSettings, positions_m: &[[f64; 2]]) -> Vec<u64> {
    ids(&frames(&settings(0.0, sensing), &standing(positions_m), 1)[0].1)
}

#[test]
fn who_is_out_of_sight_is_not_seen() {
    let places = [[1.0, 0.0], [0.0, 2.9], [4.0, 0.0], [0.0, -5.0]];
    assert_eq!(seen(PERFECT, &places), [1, 2, 3, 4]);
    assert_eq!(seen(SensingSettings { range_m: Some(3.6), ..PERFECT }, &places), [1, 2]);
    assert_eq!(seen(SensingSettings { window_m: Some(2.95), ..PERFECT }, &places), [2]);
    assert_eq!(seen(SensingSettings { window_m: Some(5.5), ..PERFECT }, &places), [1, 2, 4]);
    // Bearings: 0°, 55.4°, 0°, −68.2°.
    assert_eq!(seen(SensingSettings { field_of_view_deg: Some(120.0), ..PERFECT }, &places), [1, 2, 3]);
    assert_eq!(seen(SensingSettings { field_of_view_deg: Some(90.0), ..PERFECT }, &places), [1, 3]);
    assert_eq!(seen(SensingSettings { field_of_view_deg: Some(360.0), ..PERFECT }, &places), [1, 2, 3, 4]);
}

#[test]
fn the_field_of_view_turns_with_the_robot() {
    let mut scenario = standing(&[[1.0, 0.0], [0.0, 2.9]]);
    scenario.start.heading_rad = 3.0;
    let sensing = SensingSettings { field_of_view_deg: Some(180.0), ..PERFECT };
    assert_eq!(ids(&frames(&settings(0.0, sensing.clone()), &scenario, 1)[0].1), Vec::<u64>::new());
    scenario.start.heading_rad = 1.6;
    assert_eq!(ids(&frames(&settings(0.0, sensing), &scenario, 1)[0].1), [2]);
}

#[test]
fn who_stands_behind_somebody_is_hidden() {
    let sensing = SensingSettings { occlusion: true, ..PERFECT };
    // The second behind the first; the third just beside the line; the fourth nearer than anybody, on the other side.
    let places = [[1.0, 0.0], [4.0, 0.3], [4.0, 1.1], [0.0, -1.0]];
    assert_eq!(seen(sensing.clone(), &places), [1, 3, 4]);
    assert_eq!(seen(sensing, &[[4.0, 0.3], [4.0, 1.1], [0.0, -1.0]]), [1, 2, 3]);
}

#[test]
fn velocities_can_be_hidden() {
    let scenario = ScenarioRequest::evaluation(1, 5).generate().unwrap();
    let flags = |sensing| {
        let frames = frames(&settings(0.0, sensing), &scenario, 2);
        let last = frames.last().unwrap().1;
        let detections: Vec<Detection> = last.as_slice().to_vec();
        (
            detections.iter().all(|detection| detection.flags & DetectionFlags::HAS_VELOCITY != 0),
            detections.iter().any(|detection| detection.velocity_in_odom_mps != [0.0; 2]),
        )
    };
    assert_eq!(flags(PERFECT), (true, true));
    assert_eq!(flags(SensingSettings { hide_velocity: true, ..PERFECT }), (false, false));
}

#[test]
fn late_frames_come_late_with_the_stamp_of_their_measurement() {
    let scenario = ScenarioRequest::evaluation(1, 5).generate().unwrap();
    let prompt = frames(&settings(0.0, PERFECT), &scenario, 3);
    for latency_ms in [30, 100, 237] {
        let late = frames(&settings(0.0, SensingSettings { latency_ms, ..PERFECT }), &scenario, 3);
        assert!(late.len() > 50);
        for ((arrived_ns, frame), (measured_ns, same)) in late.iter().zip(&prompt) {
            assert_eq!(*arrived_ns, measured_ns + latency_ms * MS);
            let (stamp, original) = (frame.stamp, same.stamp);
            assert_eq!(
                (stamp.valid_at_ns, stamp.source_ns, stamp.sequence),
                (original.valid_at_ns, original.source_ns, original.sequence)
            );
            assert_eq!(stamp.ingress_ns, *arrived_ns);
            assert_eq!(frame.as_slice(), same.as_slice());
        }
    }
}

/// Position errors of everybody seen, by identity and frame.
fn errors(
    noise_m: f64,
    sensing: SensingSettings,
    scenario: &Scenario,
    seconds: u64,
) -> BTreeMap<(u64, u64), [f64; 2]> {
    let truth = frames(&settings(0.0, PERFECT), scenario, seconds);
    let measured = frames(&settings(noise_m, sensing), scenario, seconds);
    let mut errors = BTreeMap::new();
    for ((_, truth), (_, frame)) in truth.iter().zip(&measured) {
        assert_eq!(truth.stamp.sequence, frame.stamp.sequence);
        for detection in frame.as_slice() {
            let person =
                truth.as_slice().iter().find(|person| person.track_id == detection.track_id).unwrap();
            let error = [0, 1].map(|k| detection.position_in_odom_m[k] - person.position_in_odom_m[k]);
            errors.insert((detection.track_id, frame.stamp.sequence), error);
        }
    }
    errors
}

fn moments(errors: impl Iterator<Item = [f64; 2]>) -> (f64, f64) {
    let errors: Vec<f64> = errors.flatten().collect();
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / errors.len() as f64;
    (mean, variance.sqrt())
}

#[test]
fn noise_has_the_spread_and_the_memory_asked_for() {
    let scenario = ScenarioRequest::evaluation(1, 20).generate().unwrap();
    let white = errors(0.05, PERFECT, &scenario, 20);
    let drift = SensingSettings { drift: Some(DriftSettings { sigma_m: 0.08, tau_s: 0.5 }), ..PERFECT };
    let drifting = errors(0.0, drift, &scenario, 20);
    for (errors, sigma_m, kept) in [(&white, 0.05, 0.0), (&drifting, 0.08, (-0.1_f64).exp())] {
        let (mean, spread) = moments(errors.values().copied());
        assert!(mean.abs() < 0.006 && (spread / sigma_m - 1.0).abs() < 0.05, "{mean} ± {spread}");
        // What is left of one frame's error in the next, 50 ms later.
        let pairs: Vec<_> = errors
            .iter()
            .filter_map(|((id, frame), now)| errors.get(&(*id, frame + 1)).map(|next| (now, next)))
            .collect();
        let product: f64 = pairs.iter().map(|(now, next)| now[0] * next[0] + now[1] * next[1]).sum();
        let correlation = product / (2 * pairs.len()) as f64 / spread.powi(2);
        assert!((correlation - kept).abs() < 0.03, "{correlation} is not {kept}");
        // From the first frame on, not only after a while.
        let (_, first) =
            moments(errors.iter().filter(|((_, frame), _)| *frame == 1).map(|(_, error)| *error));
        assert!((0.6..1.4).contains(&(first / sigma_m)), "{first}");
    }
}

#[test]
fn dropout_takes_the_share_asked_for_each_on_its_own() {
    let scenario = ScenarioRequest::evaluation(1, 20).generate().unwrap();
    let seen = errors(0.0, SensingSettings { dropout: 0.1, ..PERFECT }, &scenario, 20);
    let share = 1.0 - seen.len() as f64 / f64::from(20 * 400);
    assert!((share - 0.1).abs() < 0.012, "{share}");
    let missing_twice = (1..400_u64)
        .flat_map(|frame| (1..=20_u64).map(move |id| (id, frame)))
        .filter(|(id, frame)| !seen.contains_key(&(*id, *frame)) && !seen.contains_key(&(*id, frame + 1)))
        .count();
    assert!((40..130).contains(&missing_twice), "{missing_twice} of about 80");
}

#[test]
fn one_more_shortcoming_leaves_the_others_as_they_were() {
    let scenario = ScenarioRequest::evaluation(7, 12).generate().unwrap();
    let drift = Some(DriftSettings { sigma_m: 0.08, tau_s: 0.5 });
    let white = errors(0.05, PERFECT, &scenario, 5);
    let drifting = errors(0.0, SensingSettings { drift, ..PERFECT }, &scenario, 5);
    let both = errors(0.05, SensingSettings { drift, ..PERFECT }, &scenario, 5);
    for (key, error) in &both {
        for k in 0..2 {
            assert!((error[k] - white[key][k] - drifting[key][k]).abs() < 1e-12);
        }
    }
    let all = SensingSettings {
        range_m: Some(9.0),
        field_of_view_deg: Some(170.0),
        occlusion: true,
        dropout: 0.2,
        latency_ms: 100,
        drift,
        ..PERFECT
    };
    let few = errors(0.05, all, &scenario, 5);
    assert!(few.len() > 100 && few.len() < both.len(), "{} of {}", few.len(), both.len());
    assert!(few.iter().all(|(key, error)| both[key] == *error));
    // Another seed, another error.
    let other = errors(0.05, PERFECT, &Scenario { seed: 8, ..scenario }, 5);
    assert!(other.iter().all(|(key, error)| white[key] != *error));
}

#[test]
fn sensing_allocates_nothing() {
    let all = SensingSettings {
        range_m: Some(9.0),
        field_of_view_deg: Some(170.0),
        occlusion: true,
        dropout: 0.2,
        latency_ms: 237,
        drift: Some(DriftSettings { sigma_m: 0.08, tau_s: 0.5 }),
        ..PERFECT
    };
    let scenario = ScenarioRequest::evaluation(7, 20).generate().unwrap();
    let mut source = SimulatedCrowd::in_scenario(&settings(0.05, all), &scenario, Obedience::Filter).unwrap();
    let mut events = 0;
    let of_playing = measure(|| {
        for tick in 0..5_000 {
            while source.poll(tick * MS).is_some() {
                events += 1;
            }
        }
    });
    assert!(of_playing.count_total == 0 && events > 500, "{of_playing:?}, {events} events");
}

#[test]
fn what_a_scenario_calls_somebody_is_what_perception_calls_them() {
    let mut scenario = standing(&[[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [4.0, 0.0]]);
    let classes = [ClassName::Pedestrian, ClassName::Cyclist, ClassName::Static, ClassName::Vehicle];
    for (person, class) in scenario.people.iter_mut().zip(classes) {
        person.class = class;
    }
    let (_, frame) = &frames(&settings(0.0, PERFECT), &scenario, 1)[0];
    let seen: BTreeMap<u64, u32> = frame.as_slice().iter().map(|seen| (seen.track_id, seen.class)).collect();
    let expected =
        [ObstacleClass::Pedestrian, ObstacleClass::Cyclist, ObstacleClass::Static, ObstacleClass::Vehicle];
    assert_eq!(seen, (1..).zip(expected.map(ObstacleClass::code)).collect());
}

#[test]
fn settings_draw_a_mixed_crowd_that_perception_tells_apart() {
    let mut settings = settings(0.0, PERFECT);
    settings.simulation.people = 30;
    settings.simulation.arena_max_m = [30.0, 4.0];
    let of_class = |settings: &Settings| {
        let mut source = SimulatedCrowd::new(settings).unwrap();
        let mut counts = BTreeMap::<u32, usize>::new();
        while let Some(event) = source.poll(0) {
            if let BridgeEvent::Detections(frame) = event {
                for detection in frame.as_slice() {
                    *counts.entry(detection.class).or_default() += 1;
                }
            }
        }
        counts
    };
    assert_eq!(of_class(&settings), [(ObstacleClass::Pedestrian.code(), 30)].into());
    settings.simulation.classes = Some(ClassesSettings {
        cyclist_share: 0.4,
        cyclist_speed_mps: [2.0, 4.0],
        cyclist_radius_m: 0.5,
        static_share: 0.3,
        static_radius_m: 0.35,
    });
    let counts = of_class(&settings);
    assert_eq!(counts.values().sum::<usize>(), 30);
    for class in [ObstacleClass::Pedestrian, ObstacleClass::Cyclist, ObstacleClass::Static] {
        assert!(counts.get(&class.code()).is_some_and(|&count| count >= 3), "{counts:?}");
    }
}
