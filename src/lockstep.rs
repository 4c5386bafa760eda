//! A recording or a simulated crowd through the stack in one process and virtual time.

use std::path::Path;
use std::time::Duration;

use cbf_filter::load_model;
use evaluation::{START_NS, VirtualStack};
use node_runtime::{Clock, RealClock};
use perception_bridge::{SourceChoice, open_source};
use recording::{Recorder, WireMessage};
use report::RunRecord;
use settings::Settings;
use sha2::{Digest, Sha256};

use crate::outcome::empty_record;
use crate::process::recording_info;
use crate::progress::Bar;

/// How often the source's status enters the record, ns.
const STATUS_PERIOD_NS: u64 = 100_000_000;

/// What came of it.
pub(crate) struct Replayed {
    /// Everything that flowed.
    pub(crate) record: RunRecord,
    /// SHA-256 over the bytes of all safe commands, hexadecimal.
    pub(crate) commands_sha256: String,
    /// Evaluation kernel used.
    pub(crate) kernel: &'static str,
    /// Virtual seconds per second.
    pub(crate) speed: f64,
}

/// What is played.
pub(crate) struct Play<'a> {
    /// Where the world comes from.
    pub(crate) source: SourceChoice,
    /// Heading of the record.
    pub(crate) title: String,
    /// File to record into.
    pub(crate) record: Option<&'a Path>,
    /// Virtual seconds per second; as fast as possible without it.
    pub(crate) rate: Option<f64>,
    /// Whether it ends when the goal is reached.
    pub(crate) ends_at_goal: bool,
    /// Longest duration, virtual s.
    pub(crate) duration_s: Option<f64>,
}

/// Plays once.
pub(crate) fn play(plan: &Play<'_>, settings: &Settings) -> anyhow::Result<Replayed> {
    let model = load_model(&settings.filter.model)?;
    let mut stack = VirtualStack::new(settings, &model, open_source(settings, &plan.source)?)?;
    let mut recorder = match plan.record {
        Some(file) => Some(Recorder::create(file, recording_info(settings)?)?),
        None => None,
    };
    let mut record = empty_record(settings, &model, plan.title.clone())?;
    let mut digest = Sha256::new();
    let pace = Pace { began_ns: RealClock.now_ns(), rate: plan.rate };
    let bar = Bar::new("playing", 1000);
    let mut status_due_ns = START_NS;
    loop {
        let command = stack.cycle(&mut |now_ns, message| {
            if let Some(recorder) = &mut recorder {
                recorder.record_waiting(now_ns, message);
            }
            keep(&mut record, &message);
        });
        let Some(command) = command else { break };
        digest.update(bytemuck::bytes_of(&command));
        let now_ns = command.ledger.filter_woke_ns;
        if now_ns >= status_due_ns {
            status_due_ns += STATUS_PERIOD_NS;
            let status = stack.status();
            record.source_status.push(status);
            if let Some(recorder) = &mut recorder {
                recorder.record_waiting(now_ns, status);
            }
            bar.set(status.elapsed_ns * 1000 / status.total_ns.max(1), String::new);
        }
        pace.wait(now_ns);
        if plan.duration_s.is_some_and(|limit_s| (now_ns - START_NS) as f64 * 1e-9 >= limit_s) {
            break;
        }
        if plan.ends_at_goal && stack.status().goal_reached != 0 {
            break;
        }
    }
    bar.finish();
    let status = stack.status();
    record.source_status.push(status);
    if let Some(mut recorder) = recorder {
        recorder.record_waiting(status.published_ns, status);
        recorder.finish()?;
    }
    let virtual_s = record.duration_s();
    Ok(Replayed {
        commands_sha256: digest
            .finalize()
            .iter()
            .fold(String::new(), |hex, byte| hex + &format!("{byte:02x}")),
        kernel: stack.kernel().name(),
        speed: virtual_s / pace.elapsed_s(),
        record,
    })
}

/// Files a message under its kind.
fn keep(record: &mut RunRecord, message: &WireMessage) {
    match *message {
        WireMessage::RobotState(message) => record.robot_states.push(message),
        WireMessage::Obstacles(message) => record.obstacles.push(message),
        WireMessage::Goal(message) => record.goals.push(message),
        WireMessage::SafeCommand(message) => record.safe_commands.push(message),
        WireMessage::SourceStatus(message) => record.source_status.push(message),
        WireMessage::NominalCommand(message) => record.nominal_commands.push(message),
        WireMessage::Detections(_) | WireMessage::Health(_) | WireMessage::Cycle(_) => {}
    }
}

/// Holds virtual time back to a multiple of real time, or not at all.
struct Pace {
    began_ns: u64,
    rate: Option<f64>,
}

impl Pace {
    fn wait(&self, virtual_ns: u64) {
        let Some(rate) = self.rate else { return };
        let due_ns = self.began_ns + ((virtual_ns - START_NS) as f64 / rate) as u64;
        std::thread::sleep(Duration::from_nanos(due_ns.saturating_sub(RealClock.now_ns())));
    }

    fn elapsed_s(&self) -> f64 {
        (RealClock.now_ns() - self.began_ns).max(1) as f64 * 1e-9
    }
}
