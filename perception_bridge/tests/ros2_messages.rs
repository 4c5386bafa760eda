//! Every ROS 2 message of the stack against CycloneDDS (`tests/judges/ros2_echo.py`), field by field and in both directions.
//!
//! The peer publishes each type, this test reads it and sends it back; what was read is held against what the peer says that it
//! sent, and the peer holds what came back against that.

#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

#[path = "../../tests/stack/peer.rs"]
mod peer;

use std::collections::BTreeMap;
use std::net::Ipv4Addr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use recording::ros2::{self, Ros2Message};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::dds::{Context, Node, Publisher, Subscription};
use ros2_client::qos::{History, QosProfile, WhenFull};
use ros2_client::{MessageTypeName, NodeName, NodeOptions};
use serde_json::Value;

/// How long all messages together may take, s. Alone on a machine they need three.
const PATIENCE_S: &str = "90";
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(5);

/// One type that is read and sent back.
struct Port<M: Ros2Message> {
    name: &'static str,
    heard: Subscription<M>,
    said: Publisher<M>,
}

trait Echo {
    /// Sends back what has arrived and notes it as JSON.
    fn turn(&mut self, seen: &mut BTreeMap<&'static str, Value>);
}

impl<M: Ros2Message + Clone + 'static> Echo for Port<M> {
    fn turn(&mut self, seen: &mut BTreeMap<&'static str, Value>) {
        while let Some((message, _)) = self.heard.take().unwrap() {
            seen.insert(self.name, flat(serde_json::to_value(&message).unwrap()));
            assert!(self.said.publish(message).is_ok(), "{} does not leave", self.name);
        }
    }
}

/// Matrices as ROS has them: row after row.
fn flat(value: Value) -> Value {
    match value {
        Value::Array(items) => {
            let flatten = |item| match flat(item) {
                Value::Array(inner) => inner,
                other => vec![other],
            };
            Value::Array(items.into_iter().flat_map(flatten).collect())
        }
        Value::Object(fields) => fields.into_iter().map(|(name, value)| (name, flat(value))).collect(),
        other => other,
    }
}

fn open<M: Ros2Message + Clone + 'static>(
    (context, node): (&Context, &mut Node),
    name: &'static str,
    profile: &QosProfile,
) -> Box<dyn Echo> {
    let (package, type_name) = M::NAME.split_once('/').unwrap();
    let topic = |end: &str| {
        let type_name = MessageTypeName::new(package, type_name);
        context.create_topic(format!("rt/{end}/{name}"), type_name, profile).unwrap()
    };
    let (judge, stack) = (topic("judge"), topic("stack"));
    let heard = node.create_subscription(&judge, Some(profile.clone())).unwrap();
    let said = node.create_publisher(&stack, Some(profile.clone())).unwrap();
    Box::new(Port::<M> { name, heard, said })
}

macro_rules! every_type {
    ($graph:expr, $profile:expr; $($name:literal: $message:ty),+ $(,)?) => {
        vec![$(open::<$message>($graph, $name, $profile)),+]
    };
}

fn round_trip(domain_id: u32, profile: &QosProfile, options: &[&str]) {
    let Some(python) = peer::python_or_say() else { return };
    let builder = DomainParticipantBuilder::new(domain_id as u16).with_only_networks([Ipv4Addr::LOCALHOST]);
    let context = Context::from_domain_participant(builder.build().unwrap()).unwrap();
    let options_of_node = NodeOptions::new().enable_rosout(false);
    let mut node = context.new_node(NodeName::new("/", "echo").unwrap(), options_of_node).unwrap();
    let mut ports = every_type! { (&context, &mut node), profile;
        "Odometry": ros2::Odometry,
        "PoseStamped": ros2::PoseStamped,
        "PoseArray": ros2::PoseArray,
        "TFMessage": ros2::TFMessage,
        "Detection3DArray": ros2::Detection3DArray,
        "Crowd": ros2::Detection3DArray,
        "TrackedObjects": ros2::TrackedObjects,
        "People": ros2::People,
        "ObjectArray": ros2::ObjectArray,
        "Agents": ros2::Agents,
        "Agents1": ros2::hunav1::Agents,
        "ObstacleArray": ros2::ObstacleArray,
        "MarkerArray": ros2::MarkerArray,
        "Path": ros2::Path,
        "Clock": ros2::Clock,
        "Twist": ros2::Twist,
        "TwistStamped": ros2::TwistStamped,
        "DiagnosticArray": ros2::DiagnosticArray,
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/judges/ros2_echo.py");
    let mut judge = Command::new(python)
        .arg(script)
        .args(["--seconds", PATIENCE_S, "--domain", &domain_id.to_string()])
        .args(options)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut seen = BTreeMap::new();
    // The judge says more than a pipe holds, hence the reader of its own.
    let mut pipe = judge.stdout.take().unwrap();
    let said = std::thread::spawn(move || std::io::read_to_string(&mut pipe).unwrap());
    while !said.is_finished() {
        for port in &mut ports {
            port.turn(&mut seen);
        }
        std::thread::sleep(LOOK);
    }
    assert!(judge.wait().unwrap().success());
    let said: Value = serde_json::from_str(&said.join().unwrap()).unwrap();
    for (name, sent) in said["sent"].as_object().unwrap() {
        assert_eq!(seen.get(name.as_str()), Some(sent), "{name} as it was read");
    }
    assert_eq!(said["sent"].as_object().unwrap().len(), ports.len(), "a type that only one side knows");
    assert_eq!(said["missing"], Value::Array(Vec::new()), "what did not come back");
    assert_eq!(said["changed"], Value::Object(serde_json::Map::new()), "what came back changed");
}

fn keeping_one() -> QosProfile {
    QosProfile { history: History::KeepLast { depth: 1 }, ..QosProfile::subscription_default() }
}

#[test]
fn every_message_survives_the_default_profile_both_ways() {
    round_trip(peer::domain_id(0), &keeping_one().reliability_reliable(WhenFull::Fail), &[]);
}

#[test]
fn every_message_survives_the_sensors_profile_both_ways() {
    round_trip(peer::domain_id(1), &keeping_one().reliability_best_effort(), &["--best-effort"]);
}
