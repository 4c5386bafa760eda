//! Time and ports around [`Estimator`].

use std::time::Duration;

use anyhow::Context;
use messages::{Detections, Obstacles, ProcessId, Reason};
use node_runtime::{
    Clock, HealthReporter, Node, Pacing, ProcessLoop, Publisher, RealClock, Shutdown, Subscriber, Tick,
    Waker, Work,
};
use settings::Settings;

use crate::{Estimator, EstimatorCounts};

/// Runs the estimator of stack `instance` until told to stop.
///
/// It wakes on every frame of detections and after `heartbeat_ms` without one, and publishes each time, so that the filter
/// can tell a dead estimator from a quiet scene. Only a frame wakes the filter.
///
/// # Errors
/// If a port cannot be opened; never once the loop runs.
pub fn run(settings: &Settings, instance: &str) -> anyhow::Result<()> {
    let _span = tracing::error_span!("estimator", instance).entered();
    let shutdown = Shutdown::install()?;
    let node = Node::open(instance, ProcessId::Estimator)?;
    let mut process = EstimatorProcess::open(settings, &node)?;
    let wake_up = node.wake_up().context("the estimator's wake-up")?;
    let pacing = Pacing::event(RealClock.now_ns(), Duration::from_millis(settings.estimator.heartbeat_ms));
    tracing::info!(kind = ?settings.estimator.kind, "estimator runs");
    ProcessLoop::new(&node)?.run(
        &mut process,
        pacing,
        Some(wake_up),
        settings.realtime.as_ref().and_then(|realtime| realtime.estimator.as_ref()),
        &shutdown,
    );
    tracing::info!(
        counts = ?process.estimator.counts(),
        position_sd_m = process.estimator.position_sd_m(),
        "estimator ends"
    );
    Ok(())
}

/// The estimator with its ports.
pub struct EstimatorProcess {
    estimator: Estimator,
    frames: Subscriber<Detections>,
    obstacles: Publisher<Obstacles>,
    filter: Waker,
}

impl EstimatorProcess {
    /// Opens the ports on `node`.
    ///
    /// # Errors
    /// If one of them cannot be opened.
    pub fn open(settings: &Settings, node: &Node) -> anyhow::Result<Self> {
        Ok(Self {
            estimator: Estimator::new(settings.estimator.clone()),
            frames: node.subscriber().context("detections")?,
            obstacles: node.publisher().context("obstacles")?,
            filter: node.waker(ProcessId::Filter).context("the filter's wake-up")?,
        })
    }
}

impl Work for EstimatorProcess {
    fn cycle(&mut self, _: &Tick, health: &mut HealthReporter) {
        let Self { estimator, frames, obstacles, filter } = self;
        let before = *estimator.counts();
        // Every frame counts, since differences are taken between neighbours; a late start finds several.
        let arrived = frames.drain(|frame| {
            publish(obstacles, *estimator.step(frame, RealClock.now_ns()), health);
        });
        if arrived == 0 {
            publish(obstacles, *estimator.heartbeat(RealClock.now_ns()), health);
        } else {
            filter.wake();
        }
        count(&before, estimator, health);
    }
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
