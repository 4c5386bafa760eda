//! Rights of this user.

use rustix::process::{Resource, getrlimit};

use super::Finding;
use crate::realtime::{can_lock_any_amount, can_set_any_priority};

pub(super) fn probe() -> Vec<Finding> {
    vec![
        realtime_priority(getrlimit(Resource::Rtprio).current.unwrap_or(u64::MAX), can_set_any_priority()),
        locked_memory(getrlimit(Resource::Memlock).current, can_lock_any_amount()),
    ]
}

fn realtime_priority(limit: u64, capable: bool) -> Finding {
    if capable {
        Finding::good("this user may use any real-time priority (CAP_SYS_NICE)")
    } else if limit > 0 {
        Finding::good(format!("this user may use real-time priorities up to {limit} (RLIMIT_RTPRIO)"))
    } else {
        Finding::note(
            "this user may not use real-time priorities (no CAP_SYS_NICE, and RLIMIT_RTPRIO is 0)",
            "add `USER - rtprio 99` to /etc/security/limits.conf and log in again",
        )
    }
}

fn locked_memory(limit_bytes: Option<u64>, capable: bool) -> Finding {
    match limit_bytes {
        _ if capable => Finding::good("this user may lock any amount of memory (CAP_IPC_LOCK)"),
        None => Finding::good("this user may lock any amount of memory (RLIMIT_MEMLOCK)"),
        Some(limit_bytes) => Finding::note(
            format!(
                "this user may lock {} KiB of memory (no CAP_IPC_LOCK, RLIMIT_MEMLOCK)",
                limit_bytes >> 10
            ),
            "add `USER - memlock unlimited` to /etc/security/limits.conf and log in again",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;

    #[test]
    fn either_a_capability_or_a_limit_suffices() {
        assert_eq!(realtime_priority(0, true).severity, Severity::Good);
        assert_eq!(realtime_priority(80, false).severity, Severity::Good);
        assert_eq!(realtime_priority(0, false).severity, Severity::Note);
        assert_eq!(locked_memory(Some(65_536), true).severity, Severity::Good);
        assert_eq!(locked_memory(None, false).severity, Severity::Good);
        assert!(locked_memory(Some(65_536), false).what.contains("64 KiB"));
    }
}
