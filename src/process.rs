//! `cncbf bridge | estimator | nominal | filter | record`: one process alone.

use std::time::Duration;

use messages::{
    Cycle, Detections, Goal, Health, NominalCommand, Obstacles, ProcessId, RobotState, SafeCommand,
    SourceStatus,
};
use node_runtime::{Node, Shutdown, Subscriber};
use perception_bridge::Playback;
use recording::{Recorder, RecordingInfo, WireMessage};

use crate::cli::{BridgeArgs, NominalArgs, ProcessArgs, RecordArgs, Source};
use crate::common::settings;
use crate::zero_level::zero_level_of;

/// Process 1.
pub(crate) fn bridge(args: &BridgeArgs) -> anyhow::Result<bool> {
    let settings = settings(&args.process)?;
    let playback = Playback::new(args.rate, args.passes)?;
    anyhow::ensure!(
        matches!(args.source, Source::Mcap(_)) || playback == Playback::AS_RECORDED,
        "--rate and --passes are for recordings; a simulated crowd or a live graph has its own pace"
    );
    let choice = args.source.choice(args.closed_loop, playback, args.shadow);
    // Made only where somebody is shown it: it takes the filter's model a second time.
    let markers = settings.source.ros2.as_ref().and_then(|ros2| ros2.markers).unwrap_or(true);
    let zero_level =
        (args.source == Source::Ros2 && markers).then(|| zero_level_of(&settings)).transpose()?;
    perception_bridge::shell::run(&settings, &args.process.instance, &choice, zero_level)?;
    Ok(true)
}

/// Process 2.
pub(crate) fn estimator(args: &ProcessArgs) -> anyhow::Result<bool> {
    obstacle_estimator::shell::run(&settings(args)?, &args.instance)?;
    Ok(true)
}

/// Process 3.
pub(crate) fn nominal(args: &NominalArgs) -> anyhow::Result<bool> {
    let mut settings = settings(&args.process)?;
    if let Some(controller) = args.controller {
        settings.use_controller(controller.kind())?;
    }
    nominal_mpc::shell::run(&settings, &args.process.instance)?;
    Ok(true)
}

/// Process 4.
pub(crate) fn filter(args: &ProcessArgs) -> anyhow::Result<bool> {
    cbf_filter::shell::run(&settings(args)?, &args.instance)?;
    Ok(true)
}

/// The robot's own frame in recordings.
const BASE_FRAME: &str = "base_link";

/// How often the recorder empties its queues. Each holds more than this period brings.
const RECORD_PERIOD: Duration = Duration::from_millis(20);

/// The recorder: writes what flows until told to stop. Reads only.
pub(crate) fn record(args: &RecordArgs) -> anyhow::Result<bool> {
    let settings = settings(&args.process)?;
    let shutdown = Shutdown::install()?;
    let node = Node::open(&args.process.instance, ProcessId::Recorder)?;
    let mut robot_states = node.subscriber_all::<RobotState>()?;
    let mut detections = node.subscriber_all::<Detections>()?;
    let mut obstacles = node.subscriber_all::<Obstacles>()?;
    let mut goals = node.subscriber_all::<Goal>()?;
    let mut nominal_commands = node.subscriber_all::<NominalCommand>()?;
    let mut safe_commands = node.subscriber_all::<SafeCommand>()?;
    let mut source_status = node.subscriber_all::<SourceStatus>()?;
    let mut health = node.subscriber_all::<Health>()?;
    let mut cycles = node.subscriber_all::<Cycle>()?;
    let mut recorder =
        Recorder::create(&args.file, RecordingInfo { shadow: args.shadow, ..recording_info(&settings)? })?;
    loop {
        // Looked at before the queues are emptied: what was sent before the wish to stop is still written.
        let last = shutdown.requested();
        take(&mut robot_states, &mut recorder, |message| message.stamp.published_ns);
        take(&mut detections, &mut recorder, |message| message.stamp.published_ns);
        take(&mut obstacles, &mut recorder, |message| message.stamp.published_ns);
        take(&mut goals, &mut recorder, |message| message.stamp.published_ns);
        take(&mut nominal_commands, &mut recorder, |message| message.stamp.published_ns);
        take(&mut safe_commands, &mut recorder, |message| message.ledger.filter_published_ns);
        take(&mut source_status, &mut recorder, |message| message.published_ns);
        take(&mut health, &mut recorder, |message| message.published_ns);
        take(&mut cycles, &mut recorder, |message| message.done_ns);
        if last {
            break;
        }
        std::thread::sleep(RECORD_PERIOD);
    }
    let report = recorder.finish()?;
    if report.dropped > 0 {
        tracing::warn!(
            dropped = report.dropped,
            "the disk did not keep up; messages are missing from the recording"
        );
    }
    Ok(report.dropped == 0)
}

/// Records what waits at a port, each message at the time it was sent.
fn take<T: messages::Message + Into<WireMessage>>(
    from: &mut Subscriber<T>,
    to: &mut Recorder,
    sent_ns: impl Fn(&T) -> u64,
) {
    from.drain(|message| {
        to.record(sent_ns(message), *message);
    });
}

/// What a recording says about its origin.
pub(crate) fn recording_info(settings: &settings::Settings) -> anyhow::Result<RecordingInfo> {
    Ok(RecordingInfo {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        kernel: cbf_filter::chosen_kernel(settings.filter.kernel).name().to_owned(),
        settings: settings.to_toml()?,
        shadow: false,
        odom_frame: settings.source.odom_frame.clone(),
        base_frame: BASE_FRAME.to_owned(),
    })
}
