//! Definitions against those that the packages publish (`tests/data/ros2_definitions.json`: comments and constants left out,
//! names of types made complete, bounds dropped).

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::collections::BTreeMap;
use std::path::PathBuf;

use recording::ros2::{self, Ros2Message};
use serde_json::Value;

/// The fields of a message itself.
fn fields<M: Ros2Message>() -> Vec<String> {
    let definition = M::definition();
    definition.lines().take_while(|line| !line.starts_with("===")).map(str::to_owned).collect()
}

#[test]
fn every_field_is_the_one_that_the_package_publishes() {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/ros2_definitions.json");
    let published: BTreeMap<String, Value> =
        serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let ours = BTreeMap::from([
        ("derived_object_msgs/Object", fields::<ros2::Object>()),
        ("derived_object_msgs/ObjectArray", fields::<ros2::ObjectArray>()),
        ("diagnostic_msgs/DiagnosticStatus", fields::<ros2::DiagnosticStatus>()),
        ("hunav1/Agent", fields::<ros2::hunav1::Agent>()),
        ("hunav1/Agents", fields::<ros2::hunav1::Agents>()),
        ("hunav_msgs/Agent", fields::<ros2::Agent>()),
        ("nav2_dynamic_msgs/Obstacle", fields::<ros2::Obstacle>()),
        ("nav2_dynamic_msgs/ObstacleArray", fields::<ros2::ObstacleArray>()),
        ("nav_msgs/Path", fields::<ros2::Path>()),
        ("people_msgs/People", fields::<ros2::People>()),
        ("people_msgs/Person", fields::<ros2::Person>()),
        ("rosgraph_msgs/Clock", fields::<ros2::Clock>()),
        ("shape_msgs/SolidPrimitive", fields::<ros2::SolidPrimitive>()),
        ("visualization_msgs/Marker", fields::<ros2::Marker>()),
    ]);
    assert!(published.keys().eq(ours.keys()), "{:?}", published.keys());
    for (name, ours) in ours {
        let theirs = published[name]["fields"].as_array().unwrap();
        let theirs: Vec<_> = theirs.iter().map(|field| field.as_str().unwrap().to_owned()).collect();
        assert_eq!(ours, theirs, "{name} of {}", published[name]["published_by"]);
    }
}
