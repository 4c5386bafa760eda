//! SCHED_FIFO for the calling thread.
//!
//! System calls through `unsafe`: no well-kept crate sets the class together with `SCHED_RESET_ON_FORK`
//! (`thread-priority` takes that flag for SCHED_DEADLINE only, `rustix` and `nix` know no scheduling class).

use rustix::process::{Resource, getrlimit};

use super::{
    granted::{Grant, Right},
    rights::can_set_any_priority,
};

/// The calling thread's class and priority, as the kernel tells them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Class {
    /// A `SCHED_` constant without flags.
    policy: libc::c_int,
    /// Whether children begin under the default class.
    reset_on_fork: bool,
    /// 0 outside the real-time classes.
    priority: libc::c_int,
}

/// Asks for SCHED_FIFO and reads back what the thread has.
pub(super) fn ask_fifo(priority: u8) -> Grant {
    let asked = format!("SCHED_FIFO {priority}");
    let wanted =
        Class { policy: libc::SCHED_FIFO, reset_on_fork: true, priority: libc::c_int::from(priority) };
    let refusal = set_fifo(wanted.priority).err();
    match (class(), refusal) {
        (Ok(class), None) if class == wanted => Grant::granted(Right::Fifo, asked, class.to_string()),
        (Ok(class), Some(error)) => {
            Grant::refused(Right::Fifo, asked, format!("{class} ({error})"), advice(priority))
        }
        (Ok(class), None) => Grant::refused(Right::Fifo, asked, class.to_string(), advice(priority)),
        (Err(error), _) => Grant::refused(Right::Fifo, asked, error.to_string(), advice(priority)),
    }
}

/// What stands in the way, as far as it can be seen from here.
fn advice(priority: u8) -> String {
    let limit = getrlimit(Resource::Rtprio).current.unwrap_or(u64::MAX);
    if can_set_any_priority() || limit >= u64::from(priority) {
        "the rights are there, so that a control group or a sandbox forbids it: give the group cpu.rt_runtime_us, or the container \
         --cap-add=SYS_NICE"
            .to_owned()
    } else {
        format!(
            "RLIMIT_RTPRIO is {limit}: add `USER - rtprio 99` to /etc/security/limits.conf and log in again, or LimitRTPRIO=99 \
             to the systemd unit, or --ulimit rtprio=99 to the container"
        )
    }
}

/// Sets SCHED_FIFO with `SCHED_RESET_ON_FORK`.
fn set_fifo(priority: libc::c_int) -> std::io::Result<()> {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: the thread 0 is the caller; `parameters` lives through the call, which only reads it.
    #[expect(unsafe_code, reason = "a system call that no safe crate wraps with this flag")]
    let failed = unsafe {
        libc::sched_setscheduler(0, libc::SCHED_FIFO | libc::SCHED_RESET_ON_FORK, &raw const parameters)
    };
    if failed == 0 { Ok(()) } else { Err(std::io::Error::last_os_error()) }
}

/// Whether the calling thread runs before everything of the default class, by its own asking or by whoever started it.
pub(crate) fn is_realtime() -> bool {
    class().is_ok_and(|class| [libc::SCHED_FIFO, libc::SCHED_RR].contains(&class.policy))
}

/// Class and priority of the calling thread.
pub(super) fn class() -> std::io::Result<Class> {
    let mut parameters = libc::sched_param { sched_priority: 0 };
    // SAFETY: thread 0 is the caller; the call takes no pointer.
    #[expect(unsafe_code, reason = "a system call that no safe crate wraps")]
    let policy = unsafe { libc::sched_getscheduler(0) };
    // SAFETY: thread 0 is the caller; `parameters` is a valid place for the answer and lives through the call.
    #[expect(unsafe_code, reason = "a system call that no safe crate wraps")]
    let failed = unsafe { libc::sched_getparam(0, &raw mut parameters) };
    if policy < 0 || failed != 0 {
        return Err(std::io::Error::last_os_error());
    }
    Ok(Class {
        policy: policy & !libc::SCHED_RESET_ON_FORK,
        reset_on_fork: policy & libc::SCHED_RESET_ON_FORK != 0,
        priority: parameters.sched_priority,
    })
}

impl std::fmt::Display for Class {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.policy {
            libc::SCHED_FIFO => write!(f, "SCHED_FIFO {}", self.priority)?,
            libc::SCHED_RR => write!(f, "SCHED_RR {}", self.priority)?,
            libc::SCHED_OTHER => f.write_str("SCHED_OTHER")?,
            other => write!(f, "scheduling class {other}")?,
        }
        if self.reset_on_fork && self.policy != libc::SCHED_OTHER {
            f.write_str(", not inherited")
        } else {
            Ok(())
        }
    }
}
