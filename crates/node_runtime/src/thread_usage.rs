//! What the kernel did for and to one thread, counted between two looks.

use nix::sys::resource::{Usage, UsageWho, getrusage};

/// Counts of the calling thread between two looks of a [`UsageMeter`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ThreadUsage {
    /// Processor time, in the kernel and outside, ns; the kernel tells it in whole µs.
    pub cpu_ns: u64,
    /// Page faults that needed no disk.
    pub minor_faults: u32,
    /// Page faults that waited for the disk.
    pub major_faults: u32,
    /// How often the thread gave up its processor, as it does for every sleep.
    pub voluntary_switches: u32,
    /// How often it was pushed off its processor.
    pub involuntary_switches: u32,
}

/// Reads the kernel's counters of the thread that calls it. One system call a look; allocates nothing.
#[derive(Debug)]
pub struct UsageMeter {
    last: Option<Counters>,
}

/// The kernel's counters since the thread began.
#[derive(Debug, Clone, Copy)]
struct Counters {
    cpu_us: i64,
    minor_faults: i64,
    major_faults: i64,
    voluntary_switches: i64,
    involuntary_switches: i64,
}

impl UsageMeter {
    /// A meter that counts from now. Belongs to the thread that makes it.
    pub fn new() -> Self {
        Self { last: Counters::read() }
    }

    /// What was counted since the last look; zero where the kernel does not tell.
    pub fn since_last(&mut self) -> ThreadUsage {
        let now = Counters::read();
        let usage = match (self.last, now) {
            (Some(last), Some(now)) => now.since(&last),
            _ => ThreadUsage::default(),
        };
        self.last = now;
        usage
    }
}

impl Default for UsageMeter {
    fn default() -> Self {
        Self::new()
    }
}

impl Counters {
    fn read() -> Option<Self> {
        getrusage(UsageWho::RUSAGE_THREAD).ok().as_ref().map(Self::of)
    }

    fn of(usage: &Usage) -> Self {
        let (user, system) = (usage.user_time(), usage.system_time());
        Self {
            cpu_us: (user.tv_sec() + system.tv_sec()) * 1_000_000 + user.tv_usec() + system.tv_usec(),
            minor_faults: usage.minor_page_faults(),
            major_faults: usage.major_page_faults(),
            voluntary_switches: usage.voluntary_context_switches(),
            involuntary_switches: usage.involuntary_context_switches(),
        }
    }

    fn since(&self, last: &Self) -> ThreadUsage {
        let grown = |now: i64, last: i64| u32::try_from(now - last).unwrap_or(0);
        ThreadUsage {
            cpu_ns: u64::try_from(self.cpu_us - last.cpu_us).unwrap_or(0) * 1_000,
            minor_faults: grown(self.minor_faults, last.minor_faults),
            major_faults: grown(self.major_faults, last.major_faults),
            voluntary_switches: grown(self.voluntary_switches, last.voluntary_switches),
            involuntary_switches: grown(self.involuntary_switches, last.involuntary_switches),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn a_sleep_is_a_voluntary_switch_and_fresh_memory_faults() {
        let mut meter = UsageMeter::new();
        std::thread::sleep(Duration::from_millis(2));
        assert!(meter.since_last().voluntary_switches >= 1);
        let pages = 600;
        let memory = std::hint::black_box(vec![1_u8; pages * 4096]);
        let usage = meter.since_last();
        assert!(usage.minor_faults > 0, "{usage:?}");
        assert_eq!(meter.since_last().major_faults, 0);
        drop(memory);
    }
}
