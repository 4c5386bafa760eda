//! What the kernel answered.

use std::fs::File;

use messages::RealtimeFlags;

/// One thing that a process can ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Right {
    /// SCHED_FIFO.
    Fifo,
    /// Running on chosen processors only.
    Processors,
    /// All memory in RAM.
    MemoryLock,
    /// Heap and stack touched beforehand.
    Prefault,
    /// Waking no later than asked.
    TimerSlack,
    /// Processors kept out of deep sleep.
    CpuDmaLatency,
}

impl Right {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Fifo,
        Self::Processors,
        Self::MemoryLock,
        Self::Prefault,
        Self::TimerSlack,
        Self::CpuDmaLatency,
    ];

    /// Its name in tables, JSON and logs.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Fifo => "fifo",
            Self::Processors => "processors",
            Self::MemoryLock => "memory lock",
            Self::Prefault => "prefault",
            Self::TimerSlack => "timer slack",
            Self::CpuDmaLatency => "cpu dma latency",
        }
    }

    /// Its bit among [`messages::RealtimeFlags`].
    pub const fn flag(self) -> u32 {
        match self {
            Self::Fifo => RealtimeFlags::FIFO,
            Self::Processors => RealtimeFlags::PROCESSORS,
            Self::MemoryLock => RealtimeFlags::MEMORY_LOCK,
            Self::Prefault => RealtimeFlags::PREFAULT,
            Self::TimerSlack => RealtimeFlags::TIMER_SLACK,
            Self::CpuDmaLatency => RealtimeFlags::CPU_DMA_LATENCY,
        }
    }

    /// The rights among [`messages::RealtimeFlags`] bits.
    pub fn of(flags: u32) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(move |right| flags & right.flag() != 0)
    }
}

/// One thing that was asked for, and the answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grant {
    /// What it is about.
    pub what: Right,
    /// What was asked for.
    pub asked: String,
    /// Whether the kernel granted all of it.
    pub granted: bool,
    /// What there is now, as read back from the kernel, or why there is nothing.
    pub got: String,
    /// What a person can do about a refusal; empty if it was granted.
    pub advice: String,
}

impl Grant {
    pub(super) fn granted(what: Right, asked: String, got: String) -> Self {
        Self { what, asked, granted: true, got, advice: String::new() }
    }

    pub(super) fn refused(what: Right, asked: String, got: String, advice: impl Into<String>) -> Self {
        Self { what, asked, granted: false, got, advice: advice.into() }
    }
}

/// What a process asked for and was granted; gives `/dev/cpu_dma_latency` back when it is dropped.
#[derive(Debug)]
#[must_use = "the wake-up latency of the processors is held only as long as this lives"]
pub struct Granted {
    grants: Vec<Grant>,
    /// The kernel forgets the request when this is closed.
    _cpu_dma_latency: Option<File>,
}

impl Granted {
    pub(super) const fn new(grants: Vec<Grant>, cpu_dma_latency: Option<File>) -> Self {
        Self { grants, _cpu_dma_latency: cpu_dma_latency }
    }

    /// Everything that was asked for, in the order of asking.
    pub fn grants(&self) -> &[Grant] {
        &self.grants
    }

    /// [`messages::RealtimeFlags`] bits: asked, granted.
    pub fn flags(&self) -> (u32, u32) {
        self.grants.iter().fold((0, 0), |(asked, granted), grant| {
            let flag = grant.what.flag();
            (asked | flag, if grant.granted { granted | flag } else { granted })
        })
    }

    /// One line for what was granted and one for what was not.
    pub(super) fn log(&self) {
        let lines = |granted: bool| {
            let told = self.grants.iter().filter(move |grant| grant.granted == granted);
            told.map(|grant| match grant.advice.as_str() {
                "" => format!("{}: {}", grant.what.label(), grant.got),
                advice => format!("{} ({}): {}; {advice}", grant.what.label(), grant.asked, grant.got),
            })
            .collect::<Vec<_>>()
            .join("; ")
        };
        let (granted, refused) = (lines(true), lines(false));
        if !granted.is_empty() {
            tracing::info!("the kernel granted {granted}");
        }
        if !refused.is_empty() {
            tracing::warn!("the kernel did not grant what follows, the process runs without it: {refused}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_tell_what_was_asked_and_what_was_granted() {
        let granted = Granted::new(
            vec![
                Grant::granted(Right::TimerSlack, "1 ns".to_owned(), "1 ns".to_owned()),
                Grant::refused(Right::Fifo, "priority 80".to_owned(), "no".to_owned(), "become root"),
            ],
            None,
        );
        let (asked, got) = granted.flags();
        assert_eq!(
            (asked, got),
            (RealtimeFlags::FIFO | RealtimeFlags::TIMER_SLACK, RealtimeFlags::TIMER_SLACK)
        );
        assert_eq!(Right::of(asked).collect::<Vec<_>>(), [Right::Fifo, Right::TimerSlack]);
        assert_eq!(Right::of(63).count(), Right::ALL.len());
        assert_eq!(Right::of(0).count(), 0);
    }
}
