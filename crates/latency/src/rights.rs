//! What each process asked of the kernel and what it was granted.

use messages::{Health, ProcessId, RealtimeFlags};
use serde::{Deserialize, Serialize};

use crate::process_key;

/// Real-time rights of one process.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rights {
    /// Which process.
    #[serde(with = "process_key")]
    pub process: ProcessId,
    /// Names of what it asked for, for example `fifo`.
    pub asked: Vec<String>,
    /// Names of what it was granted.
    pub granted: Vec<String>,
}

/// Every right with its bit.
const NAMES: [(u32, &str); 6] = [
    (RealtimeFlags::FIFO, "fifo"),
    (RealtimeFlags::PROCESSORS, "processors"),
    (RealtimeFlags::MEMORY_LOCK, "memory lock"),
    (RealtimeFlags::PREFAULT, "prefault"),
    (RealtimeFlags::TIMER_SLACK, "timer slack"),
    (RealtimeFlags::CPU_DMA_LATENCY, "cpu dma latency"),
];

impl Rights {
    /// The rights that the newest health message of each process tells, in the order of the processes' codes.
    pub fn of(health: &[Health]) -> Vec<Self> {
        let names = |bits: u32| {
            NAMES.iter().filter(|(bit, _)| bits & bit != 0).map(|(_, name)| (*name).to_owned()).collect()
        };
        ProcessId::ALL
            .iter()
            .filter_map(|&process| {
                let own = health.iter().filter(|health| health.process == process.code());
                let newest = own.max_by_key(|health| health.published_ns)?;
                Some(Self {
                    process,
                    asked: names(newest.realtime_asked),
                    granted: names(newest.realtime_granted),
                })
            })
            .collect()
    }

    /// What was asked for and not granted.
    pub fn missing(&self) -> Vec<&str> {
        self.asked.iter().filter(|name| !self.granted.contains(name)).map(String::as_str).collect()
    }
}
