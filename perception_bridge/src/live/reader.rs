//! The thread that hears the graph: takes messages as they arrive, has them checked, hands them to the bridge's loop.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use ros2_client::dds::rustdds::mio1::{Events, Poll};
use settings::{Ros2Settings, SourceSettings};

use super::arrival::Arrival;
use super::error::RosError;
use super::graph::Graph;
use super::hand_over::HandOver;
use super::inputs::Inputs;
use super::intake::Intake;

/// Longest sleep, so that the wish to end is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// How often the log is told what has changed, ns.
const TELL_PERIOD_NS: u64 = 250_000_000;
/// Topics that one look can tell of.
const EVENTS: usize = 16;

/// The running thread; ends when dropped.
pub(super) struct Reader {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Reader {
    /// Opens the topics of the settings and starts the thread.
    pub(super) fn start(
        graph: &mut Graph,
        source: &SourceSettings,
        ros2: &Ros2Settings,
        intake: Intake,
        hand_over: HandOver,
    ) -> Result<Self, RosError> {
        let failed = |error: io::Error| RosError::Thread { cause: error.to_string() };
        let poll = Poll::new().map_err(failed)?;
        let inputs = Inputs::open(graph, source, ros2, poll.registry())?;
        let listening = Listening { poll, inputs, intake, hand_over };
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, span) = (Arc::clone(&stop), tracing::Span::current());
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-in".to_owned())
            .spawn(move || span.in_scope(|| listening.run(&stopped)))
            .map_err(failed)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Reader {
    /// Whether the thread has ended though nobody asked it to.
    pub(super) fn has_ended(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// What the thread owns.
struct Listening {
    poll: Poll,
    inputs: Inputs,
    intake: Intake,
    hand_over: HandOver,
}

impl Listening {
    fn run(mut self, stop: &AtomicBool) {
        let mut events = Events::with_capacity(EVENTS);
        let mut told_ns = Arrival::now().stack_ns;
        let mut told_refused = 0;
        while !stop.load(Ordering::Acquire) {
            // A poll that fails leaves a look at every topic ten times a second.
            if self.poll.poll(&mut events, Some(LONGEST_WAIT)).is_err() {
                std::thread::sleep(LONGEST_WAIT);
            }
            self.take();
            let now_ns = Arrival::now().stack_ns;
            if now_ns.saturating_sub(told_ns) >= TELL_PERIOD_NS {
                told_ns = now_ns;
                self.inputs.tell(now_ns);
                self.intake.forget(now_ns);
                // As with whole messages: the first at once, more whenever their number has doubled.
                let refused = self.intake.refused_detections();
                if refused > told_refused && refused >= 2 * told_refused {
                    told_refused = refused;
                    tell_refused(refused);
                }
            }
        }
        self.inputs.tell(Arrival::now().stack_ns);
        if self.intake.refused_detections() > told_refused {
            tell_refused(self.intake.refused_detections());
        }
    }

    fn take(&mut self) {
        let Self { inputs, intake, hand_over, .. } = self;
        let refused = inputs.take(intake, &mut |event| hand_over.put(event));
        let counters = hand_over.counters();
        (0..refused).for_each(|_| counters.count_refused());
    }
}

/// Whom the filter knows nothing of.
fn tell_refused(refused: u64) {
    tracing::warn!(
        refused,
        "single obstacles refused so far within messages that were used: no position, too many, or a mesh or list of shapes"
    );
}
