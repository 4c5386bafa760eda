//! Whether and when a child that ended is started again. Pure: no clock, no process.

use std::{collections::VecDeque, time::Duration};

use crate::RestartPolicy;

/// What follows from the end of a child.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It ended well; leave it.
    Finished,
    /// Start it again at this time, ns on the clock of the exits.
    RestartAt(u64),
    /// It failed and stays down.
    GiveUp,
}

/// Judges the exits of one child.
#[derive(Debug, Clone)]
pub struct Supervisor {
    policy: RestartPolicy,
    /// Times of the restarts that still count, ns, oldest first.
    restarts_ns: VecDeque<u64>,
}

impl Supervisor {
    /// Judges by `policy`.
    pub fn new(policy: RestartPolicy) -> Self {
        Self { policy, restarts_ns: VecDeque::new() }
    }

    /// Judges an exit at `now_ns`; `success` means exit code 0.
    pub fn on_exit(&mut self, now_ns: u64, success: bool) -> Verdict {
        if success {
            return Verdict::Finished;
        }
        let RestartPolicy::OnFailure { limit, window, first_pause, longest_pause } = self.policy else {
            return Verdict::GiveUp;
        };
        let oldest_ns = now_ns.saturating_sub(nanoseconds(window));
        while self.restarts_ns.front().is_some_and(|&restart_ns| restart_ns < oldest_ns) {
            self.restarts_ns.pop_front();
        }
        let so_far = u32::try_from(self.restarts_ns.len()).unwrap_or(u32::MAX);
        if so_far >= limit {
            return Verdict::GiveUp;
        }
        let pause = match so_far {
            0 => Duration::ZERO,
            repeated => first_pause.saturating_mul(2_u32.saturating_pow(repeated - 1)).min(longest_pause),
        };
        let restart_ns = now_ns.saturating_add(nanoseconds(pause));
        self.restarts_ns.push_back(restart_ns);
        Verdict::RestartAt(restart_ns)
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn impatient() -> Supervisor {
        Supervisor::new(RestartPolicy::OnFailure {
            limit: 4,
            window: Duration::from_secs(10),
            first_pause: Duration::from_millis(100),
            longest_pause: Duration::from_millis(300),
        })
    }

    #[test]
    fn the_first_restart_is_immediate_and_the_pause_then_doubles_up_to_its_limit() {
        let mut supervisor = impatient();
        let pauses: Vec<_> = (0..5).map(|_| supervisor.on_exit(1_000 * MS, false)).collect();
        let at = |pause_ms: u64| Verdict::RestartAt((1_000 + pause_ms) * MS);
        assert_eq!(pauses, [at(0), at(100), at(200), at(300), Verdict::GiveUp]);
    }

    #[test]
    fn failures_older_than_the_window_are_forgiven() {
        let mut supervisor = impatient();
        for k in 0..100 {
            let now_ns = k * 11_000 * MS;
            assert_eq!(supervisor.on_exit(now_ns, false), Verdict::RestartAt(now_ns));
        }
    }

    #[test]
    fn success_is_final_and_no_policy_restarts_it() {
        assert_eq!(impatient().on_exit(5, true), Verdict::Finished);
        let mut never = Supervisor::new(RestartPolicy::Never);
        assert_eq!(never.on_exit(5, true), Verdict::Finished);
        assert_eq!(never.on_exit(5, false), Verdict::GiveUp);
    }

    #[test]
    fn extreme_limits_do_not_overflow() {
        let mut supervisor = Supervisor::new(RestartPolicy::OnFailure {
            limit: u32::MAX,
            window: Duration::MAX,
            first_pause: Duration::MAX,
            longest_pause: Duration::MAX,
        });
        for _ in 0..50 {
            assert!(matches!(supervisor.on_exit(u64::MAX - 1, false), Verdict::RestartAt(_)));
        }
    }
}
