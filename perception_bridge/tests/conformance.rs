//! What every source promises, held against each of them.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::path::{Path, PathBuf};

use messages::{ControlKind, SafeCommand, Stamp};
use perception_bridge::{BridgeEvent, Obedience, Playback, SinkState, Source, SourceChoice, open_source};
use settings::Settings;

const MS: u64 = 1_000_000;
const BEGIN_NS: u64 = 7_000 * MS;

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn settings() -> Settings {
    let mut settings = Settings::load(&repository("config/ground_robot.toml")).unwrap();
    settings.simulation.timeout_s = 2.0;
    settings.simulation.position_noise_m = 0.02;
    settings
}

/// Every source there is, each opened anew.
fn sources() -> Vec<(&'static str, Box<dyn Source>)> {
    let file = repository("tests/data/mcap_rosbags_reference.mcap");
    let mcap = |closed_loop, playback| SourceChoice::Mcap { file: file.clone(), closed_loop, playback };
    let hurried = Playback::new(2.5, 3).unwrap();
    [
        ("simulation", SourceChoice::Simulation { obeys: Obedience::Filter }),
        ("recording", mcap(false, Playback::AS_RECORDED)),
        ("recording, hurried", mcap(false, hurried)),
        ("closed loop", mcap(true, Playback::AS_RECORDED)),
        ("closed loop, hurried", mcap(true, hurried)),
    ]
    .map(|(name, choice)| (name, open_source(&settings(), &choice).unwrap()))
    .into()
}

fn stamp(event: &BridgeEvent) -> (usize, Stamp) {
    match event {
        BridgeEvent::RobotState(message) => (0, message.stamp),
        BridgeEvent::Detections(message) => (1, message.stamp),
        BridgeEvent::Goal(message) => (2, message.stamp),
        BridgeEvent::NominalCommand(message) => (3, message.stamp),
    }
}

/// Polls at every due time to the end, at most ten seconds.
fn play(source: &mut dyn Source) -> Vec<(u64, BridgeEvent)> {
    let mut events = Vec::new();
    let mut now_ns = BEGIN_NS;
    while now_ns < BEGIN_NS + 10_000 * MS {
        while let Some(event) = source.poll(now_ns) {
            events.push((now_ns, event));
        }
        let Some(due_ns) = source.next_due_ns() else { break };
        assert!(due_ns > now_ns, "due, but not handed over");
        now_ns = due_ns;
    }
    events
}

#[test]
fn stamps_are_complete_sequences_count_and_time_runs_forwards() {
    for (name, mut source) in sources() {
        let events = play(&mut *source);
        let mut newest =
            [Stamp { sequence: 0, source_ns: 0, valid_at_ns: 0, ingress_ns: 0, published_ns: 0 }; 3];
        for (now_ns, event) in &events {
            let (stream, stamp) = stamp(event);
            let before = newest[stream];
            assert_eq!(stamp.sequence, before.sequence + 1, "{name}");
            assert!(stamp.valid_at_ns >= before.valid_at_ns || stream == 2, "{name}");
            assert!(stamp.valid_at_ns >= BEGIN_NS && stamp.valid_at_ns <= *now_ns, "{name}: {stamp:?}");
            assert_eq!((stamp.ingress_ns, stamp.published_ns), (*now_ns, 0), "{name}");
            newest[stream] = stamp;
        }
        assert!(newest.iter().all(|stamp| stamp.sequence > 0), "{name}: some kind of event never came");
    }
}

#[test]
fn the_end_is_said_and_final() {
    for (name, mut source) in sources() {
        assert_eq!(source.status(BEGIN_NS).finished, 0, "{name}");
        let events = play(&mut *source);
        let end_ns = BEGIN_NS + 20_000 * MS;
        let status = source.status(end_ns);
        assert_eq!((status.finished, status.published_ns), (1, end_ns), "{name}");
        assert_eq!(status.accepted, events.len() as u64, "{name}");
        assert_eq!((source.poll(end_ns), source.next_due_ns()), (None, None), "{name}");
        assert!(status.elapsed_ns <= status.total_ns, "{name}: {status:?}");
    }
}

#[test]
fn equal_runs_give_equal_events() {
    for ((name, mut first), (_, mut second)) in sources().into_iter().zip(sources()) {
        assert!(play(&mut *first) == play(&mut *second), "{name}");
    }
}

#[test]
fn a_late_poll_brings_everything_in_order() {
    for ((name, mut punctual), (_, mut late)) in sources().into_iter().zip(sources()) {
        let end_ns = BEGIN_NS + 10_000 * MS;
        late.poll(BEGIN_NS);
        let rest: Vec<_> =
            std::iter::from_fn(|| late.poll(end_ns)).map(|event| stamp(&event).1.valid_at_ns).collect();
        let events = play(&mut *punctual);
        let expected: Vec<_> = events[1..].iter().map(|(_, event)| stamp(event).1.valid_at_ns).collect();
        assert_eq!(rest, expected, "{name}");
    }
}

#[test]
fn only_a_robot_that_takes_commands_has_a_sink() {
    let command = bytemuck::Zeroable::zeroed();
    let mut command =
        SafeCommand { control: [0.5, 0.0], control_kind: ControlKind::Unicycle.code(), ..command };
    command.ledger.filter_woke_ns = BEGIN_NS;
    for (name, mut source) in sources() {
        source.poll(BEGIN_NS);
        source.command(&command, BEGIN_NS);
        while source.poll(BEGIN_NS + 15 * MS).is_some() {}
        let expected = (!name.starts_with("recording")).then_some(SinkState::Following);
        assert_eq!(source.sink_state(), expected, "{name}");
    }
}
