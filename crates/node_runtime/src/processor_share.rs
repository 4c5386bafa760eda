//! How much of a processor a loop of a real-time class may take.

use rustix::time::{ClockId, clock_gettime};

/// Processor time out of a hundred parts of all time that a loop may take for long. Below what Linux leaves to all real-time
/// threads of a processor together (95, `/proc/sys/kernel/sched_rt_runtime_us`), so that one loop that has gone wild does not
/// have the kernel stop the others.
const PERCENT: u64 = 80;
/// Processor time beyond that share that a loop may take at once, ns: a long cycle, or a rush of inputs.
const BURST_NS: u64 = 20_000_000;
/// Time that a pause gives back beyond what is due, ns, so that pauses are few.
const PAUSE_NS: u64 = 1_000_000;

/// Keeps the account of one thread's processor time.
///
/// A thread of a real-time class that is never without work (its cycles take longer than its period, its source cannot keep up,
/// somebody wakes it without end) would starve its processor, until the kernel stops all real-time threads there, the
/// filter's too, for 50 ms in every second. This account says when such a thread has to pause by itself.
#[derive(Debug, Clone)]
pub(crate) struct ProcessorShare {
    at_ns: u64,
    used_ns: u64,
    /// What was taken beyond the share and not yet given back, ns.
    owed_ns: u64,
}

impl ProcessorShare {
    /// Nothing is owed at `now_ns`, when the thread had taken `used_ns` of processor time.
    pub(crate) const fn new(now_ns: u64, used_ns: u64) -> Self {
        Self { at_ns: now_ns, used_ns, owed_ns: 0 }
    }

    /// How long the thread has to pause at `now_ns`, when it had taken `used_ns` of processor time altogether, ns.
    pub(crate) const fn pause_ns(&mut self, now_ns: u64, used_ns: u64) -> u64 {
        let allowed_ns = now_ns.saturating_sub(self.at_ns) / 100 * PERCENT;
        let taken_ns = used_ns.saturating_sub(self.used_ns);
        (self.at_ns, self.used_ns) = (now_ns, used_ns);
        self.owed_ns = (self.owed_ns + taken_ns).saturating_sub(allowed_ns);
        if self.owed_ns > BURST_NS { (self.owed_ns - BURST_NS) / PERCENT * 100 + PAUSE_NS } else { 0 }
    }
}

/// Processor time that the calling thread has taken since it began, ns.
pub(crate) fn thread_time_ns() -> u64 {
    let used = clock_gettime(ClockId::ThreadCPUTime);
    used.tv_sec as u64 * 1_000_000_000 + used.tv_nsec as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    /// Processor time and all time, ns, of `cycles` cycles of `work_ns` that begin every `period_ns`, or at once when late.
    fn run(cycles: u64, work_ns: u64, period_ns: u64) -> (u64, u64) {
        let mut share = ProcessorShare::new(0, 0);
        let (mut now_ns, mut used_ns) = (0, 0);
        for cycle in 0..cycles {
            now_ns = now_ns.max(cycle * period_ns) + work_ns;
            used_ns += work_ns;
            now_ns += share.pause_ns(now_ns, used_ns);
        }
        (used_ns, now_ns)
    }

    #[test]
    fn a_loop_that_is_never_without_work_leaves_its_share_to_others() {
        for work_ns in [5_000, MS, 5 * MS, 60 * MS] {
            let (used_ns, all_ns) = run(2_000, work_ns, 0);
            assert!(
                used_ns <= all_ns / 100 * PERCENT + BURST_NS + work_ns,
                "{work_ns}: {used_ns} of {all_ns}"
            );
            assert!(used_ns >= all_ns / 100 * (PERCENT - 1), "{work_ns}: {used_ns} of {all_ns}");
        }
    }

    #[test]
    fn a_loop_within_its_share_is_never_held_up() {
        for (work_ns, period_ns) in [(3 * MS, 4 * MS), (40 * MS, 50 * MS), (10_000, 4 * MS)] {
            let (_, all_ns) = run(1_000, work_ns, period_ns);
            assert_eq!(all_ns, 999 * period_ns + work_ns);
        }
    }

    #[test]
    fn a_rush_is_served_at_once_and_later_given_back() {
        let mut share = ProcessorShare::new(0, 0);
        assert_eq!(share.pause_ns(90 * MS, 90 * MS), 0);
        assert_eq!(share.pause_ns(110 * MS, 110 * MS), 2 * MS / 80 * 100 + PAUSE_NS);
        assert_eq!(share.pause_ns(200 * MS, 110 * MS), 0);
        assert_eq!(share.owed_ns, 0);
    }
}
