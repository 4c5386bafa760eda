//! What figures were measured on: two measurements are comparable where all of this is equal.

use serde::{Deserialize, Serialize};

/// The machine, as far as it decides how long things take. Filled by the caller.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Model name of the processor.
    pub cpu_model: String,
    /// Logical processors the system may use.
    pub cores: u32,
    /// Kernel name and release, for example `Linux 6.12.0`.
    pub kernel: String,
    /// Whether the kernel was built with PREEMPT_RT.
    pub preempt_rt: bool,
    /// Frequency governor, where the kernel has one, for example `performance`.
    pub governor: Option<String>,
    /// The kernel's clock source, for example `tsc`.
    pub clock_source: Option<String>,
    /// Main memory, bytes.
    pub memory_bytes: u64,
}

/// The recording that was played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingIdentity {
    /// Name of the file, without its folder.
    pub file_name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Length at rate 1, s.
    pub duration_s: f64,
    /// Detections messages in it.
    pub detections: u64,
    /// Robot states in it.
    pub robot_states: u64,
}

/// Everything that figures depend on besides the code's speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Version of the tool that measured.
    pub tool_version: String,
    /// SHA-256 of the settings, as text with every key, hexadecimal.
    pub settings_sha256: String,
    /// The recording that was played.
    pub recording: RecordingIdentity,
    /// How many times faster than recorded.
    pub rate: f64,
    /// Length of each repeat, s, where it is not the recording's own.
    pub duration_s: Option<f64>,
    /// Whether the recorded robot was replaced by a simulated one.
    pub closed_loop: bool,
    /// Load beside the stack: `none`, `cpu`, `memory` or `io`.
    pub load: String,
    /// How processes wait: `listener` or `spin`.
    pub wait: String,
    /// What carries messages: `iceoryx2` or `dds`.
    pub transport: String,
    /// What begins a filter cycle: `timer`, `event` or `both`.
    pub trigger: String,
    /// Period the filter was meant to keep, ns.
    pub filter_period_ns: u64,
    /// The machine.
    pub machine: Machine,
}

/// One way in which two measurements' conditions differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Difference {
    /// What differs.
    pub what: String,
    /// The baseline's.
    pub old: String,
    /// The new one's.
    pub new: String,
}

impl core::fmt::Display for Difference {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {} then, {} now", self.what, self.old, self.new)
    }
}

/// Reads one condition as text.
type Reading<'a> = &'a dyn Fn(&Conditions) -> String;

impl Conditions {
    /// Everything that makes `new` incomparable with the baseline `self`. The file's name and the size of the memory do not
    /// count: the one is covered by the contents, the other decides no latency.
    pub fn differences(&self, new: &Self) -> Vec<Difference> {
        let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "none".to_owned());
        let duration = |conditions: &Self| {
            conditions.duration_s.map_or_else(|| "the recording's".to_owned(), |s| format!("{s} s"))
        };
        let readings: [(&str, Reading<'_>); 17] = [
            ("tool version", &|c| c.tool_version.clone()),
            ("processor", &|c| c.machine.cpu_model.clone()),
            ("cores", &|c| c.machine.cores.to_string()),
            ("kernel", &|c| c.machine.kernel.clone()),
            ("PREEMPT_RT", &|c| c.machine.preempt_rt.to_string()),
            ("governor", &|c| or_none(&c.machine.governor)),
            ("clock source", &|c| or_none(&c.machine.clock_source)),
            ("recording, SHA-256", &|c| c.recording.sha256.clone()),
            ("rate", &|c| c.rate.to_string()),
            ("duration", &duration),
            ("closed loop", &|c| c.closed_loop.to_string()),
            ("load", &|c| c.load.clone()),
            ("wait", &|c| c.wait.clone()),
            ("transport", &|c| c.transport.clone()),
            ("filter trigger", &|c| c.trigger.clone()),
            ("filter period", &|c| format!("{} ns", c.filter_period_ns)),
            ("settings, SHA-256", &|c| c.settings_sha256.clone()),
        ];
        readings
            .iter()
            .filter_map(|(what, reading)| {
                let (old, new) = (reading(self), reading(new));
                (old != new).then(|| Difference { what: (*what).to_owned(), old, new })
            })
            .collect()
    }
}
