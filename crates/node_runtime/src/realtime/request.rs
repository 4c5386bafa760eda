//! What a process asks the kernel for. How its loop waits is the loop's own affair.

use messages::ProcessId;
use settings::{ProcessRealtime, RealtimeSettings, SchedulerKind};

/// Scheduling class of a control thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduler {
    /// The kernel's default; nothing is asked for.
    Other,
    /// SCHED_FIFO.
    Fifo {
        /// 1 (lowest) to 99.
        priority: u8,
    },
}

/// What one process asks of the kernel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Request {
    /// Scheduling class of the control thread.
    pub scheduler: Scheduler,
    /// Processors that the control thread may run on; empty means all.
    pub processors: Vec<usize>,
    /// Whether all memory is to stay in RAM, touched before the loop.
    pub lock_memory: bool,
    /// Timer slack, ns, at least 1.
    pub timer_slack_ns: Option<u64>,
    /// Longest time any processor may take to wake up, µs.
    pub cpu_dma_latency_us: Option<u32>,
}

impl Request {
    /// Asks for nothing.
    pub const fn nothing() -> Self {
        Self {
            scheduler: Scheduler::Other,
            processors: Vec::new(),
            lock_memory: false,
            timer_slack_ns: None,
            cpu_dma_latency_us: None,
        }
    }

    /// What `settings` say of `process`. Recorder and launcher, and whatever the settings leave out, ask for nothing.
    pub fn of(settings: Option<&RealtimeSettings>, process: ProcessId) -> Self {
        let entry = settings.and_then(|settings| match process {
            ProcessId::Bridge => settings.bridge.as_ref(),
            ProcessId::Estimator => settings.estimator.as_ref(),
            ProcessId::Nominal => settings.nominal.as_ref(),
            ProcessId::Filter => settings.filter.as_ref(),
            ProcessId::Recorder | ProcessId::Launcher => None,
        });
        entry.map_or_else(Self::nothing, Self::from)
    }
}

impl From<&ProcessRealtime> for Request {
    fn from(entry: &ProcessRealtime) -> Self {
        Self {
            scheduler: match (entry.scheduler, entry.priority) {
                (SchedulerKind::Fifo, Some(priority)) => Scheduler::Fifo { priority },
                (SchedulerKind::Fifo | SchedulerKind::Other, _) => Scheduler::Other,
            },
            processors: entry.processors.clone(),
            lock_memory: entry.lock_memory,
            timer_slack_ns: entry.timer_slack_ns,
            cpu_dma_latency_us: entry.cpu_dma_latency_us,
        }
    }
}

#[cfg(test)]
mod tests {
    use settings::WaitKind;

    use super::*;

    #[test]
    fn each_process_gets_its_own_entry_and_others_ask_for_nothing() {
        let entry = |priority| {
            Some(ProcessRealtime {
                scheduler: SchedulerKind::Fifo,
                priority: Some(priority),
                processors: vec![1],
                lock_memory: true,
                timer_slack_ns: Some(1),
                cpu_dma_latency_us: Some(2),
                spin_us: 30,
                wait: WaitKind::Listener,
            })
        };
        let settings =
            RealtimeSettings { bridge: entry(1), estimator: entry(2), nominal: entry(3), filter: entry(4) };
        for &process in ProcessId::ALL {
            let request = Request::of(Some(&settings), process);
            let priority = match process {
                ProcessId::Bridge => 1,
                ProcessId::Estimator => 2,
                ProcessId::Nominal => 3,
                ProcessId::Filter => 4,
                ProcessId::Recorder | ProcessId::Launcher => {
                    assert_eq!(request, Request::nothing());
                    continue;
                }
            };
            assert_eq!(request.scheduler, Scheduler::Fifo { priority });
            assert_eq!((request.lock_memory, request.timer_slack_ns), (true, Some(1)));
            assert_eq!(request.cpu_dma_latency_us, Some(2));
            assert_eq!(request.processors, [1]);
            assert_eq!(Request::of(None, process), Request::nothing());
        }
    }
}
