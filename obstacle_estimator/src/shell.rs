//! Time and ports around [`Estimator`].

use std::time::Duration;

use anyhow::Context;
use messages::{Detections, Obstacles, ProcessId, Reason};
use node_runtime::{Clock, HealthReporter, Node, Publisher, RealClock, Shutdown};
use settings::Settings;

use crate::{Estimator, EstimatorCounts};

/// Runs the estimator of stack `instance` until told to stop.
///
/// It wakes on every frame of detections and after `heartbeat_ms` without one, and publishes each time, so that the filter
/// can tell a dead estimator from a quiet scene.
///
/// # Errors
/// If a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Estimator)?;
    let mut frames = node.subscriber::<Detections>().context("detections")?;
    let obstacles = node.publisher::<Obstacles>().context("obstacles")?;
    let wake_up = node.wake_up().context("the estimator's wake-up")?;
    let mut health = HealthReporter::new(&node)?;
    let heartbeat = Duration::from_millis(settings.estimator.heartbeat_ms);
    let mut estimator = Estimator::new(settings.estimator.clone());
    tracing::info!(kind = ?settings.estimator.kind, "estimator runs");

    while !shutdown.requested() {
        wake_up.wait(heartbeat);
        let before = *estimator.counts();
        // Every frame counts, since differences are taken between neighbours; a late start finds several.
        let arrived = frames
            .drain(|frame| publish(&obstacles, *estimator.step(frame, RealClock.now_ns()), &mut health));
        if arrived == 0 {
            publish(&obstacles, *estimator.heartbeat(RealClock.now_ns()), &mut health);
        }
        count(&before, &estimator, &mut health);
        health.woken_cycle();
        health.report(RealClock.now_ns());
    }
    let counts = estimator.counts();
    tracing::info!(?counts, "estimator ends");
    Ok(())
}

fn publish(port: &Publisher<Obstacles>, mut obstacles: Obstacles, health: &mut HealthReporter) {
    obstacles.stamp.published_ns = RealClock.now_ns();
    if port.send(&obstacles).is_err() {
        health.error(Reason::PortFailed);
    }
}

/// Reports what the estimator counted since `before`.
fn count(before: &EstimatorCounts, estimator: &Estimator, health: &mut HealthReporter) {
    let counts = estimator.counts();
    health.accepted(counts.frames_used - before.frames_used);
    (before.refused()..counts.refused()).for_each(|_| health.refused(estimator.last_reason()));
    (before.tracks_disturbed()..counts.tracks_disturbed())
        .for_each(|_| health.error(estimator.last_reason()));
}
