//! Room in shared memory, leftovers and other stacks.

use super::Finding;
use crate::{CleanUpError, Domain, Member, leftovers, members};

/// Shared memory that one stack with a recorder may touch, bytes: 8 readers' queues of at most 1 MiB on 8 services.
const SHARED_MEMORY_NEED_BYTES: u64 = 64 << 20;

pub(super) fn probe(domain: &Domain) -> Vec<Finding> {
    let room = match rustix::fs::statvfs("/dev/shm") {
        Ok(status) => shared_memory(status.f_bavail.saturating_mul(status.f_frsize)),
        Err(error) => {
            Finding::warning(format!("/dev/shm cannot be read: {error}"), "mount a tmpfs at /dev/shm")
        }
    };
    match members(domain) {
        Ok(members) => vec![room, leftover_files(domain), other_stacks(&members)],
        Err(error) => vec![room, unlisted(&error)],
    }
}

fn shared_memory(free_bytes: u64) -> Finding {
    let what = format!("{} MiB free in /dev/shm", free_bytes >> 20);
    if free_bytes >= SHARED_MEMORY_NEED_BYTES {
        Finding::good(what)
    } else {
        Finding::warning(
            what,
            format!(
                "a stack needs up to {} MiB; a full /dev/shm kills whoever writes to it. In a container, raise --shm-size",
                SHARED_MEMORY_NEED_BYTES >> 20
            ),
        )
    }
}

fn leftover_files(domain: &Domain) -> Finding {
    match leftovers(domain) {
        Ok(files) if files.is_empty() => Finding::good("no leftovers of crashed processes in shared memory"),
        Ok(files) => Finding::note(
            format!(
                "{} leftover files in shared memory, {} KiB, for example {}",
                files.len(),
                files.iter().map(|file| file.bytes).sum::<u64>() >> 10,
                files[0].path.display()
            ),
            "the next start and end of a stack removes them",
        ),
        Err(error) => unlisted(&error),
    }
}

/// No process of this user can join a stack then.
fn unlisted(error: &CleanUpError) -> Finding {
    Finding::warning(
        error.to_string(),
        "no stack starts like this; run every stack as one user, or stop the other user's and have them remove /tmp/iceoryx2",
    )
}

fn other_stacks(members: &[Member]) -> Finding {
    let alive: Vec<_> = members.iter().filter(|member| member.alive).collect();
    if alive.is_empty() {
        return Finding::good("no other stack is running");
    }
    let list: Vec<_> = alive.iter().map(|member| format!("{} (pid {})", member.name, member.pid)).collect();
    Finding::note(
        format!("{} processes are already in shared memory: {}", list.len(), list.join(", ")),
        "they take processor time; a second stack needs an `--instance` name of its own",
    )
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;
    use crate::{Node, ScopedDomain};
    use messages::ProcessId;

    #[test]
    fn a_running_process_is_named() {
        let domain = ScopedDomain::new();
        assert_eq!(other_stacks(&members(&domain).unwrap()).severity, Severity::Good);
        let node = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
        let finding = other_stacks(&members(&domain).unwrap());
        assert!(finding.what.contains("demo/filter"), "{finding:?}");
        assert!(finding.what.contains(&std::process::id().to_string()), "{finding:?}");
        drop(node);
    }

    #[test]
    fn a_small_shared_memory_is_a_warning() {
        assert_eq!(shared_memory(SHARED_MEMORY_NEED_BYTES - 1).severity, Severity::Warning);
        assert_eq!(shared_memory(SHARED_MEMORY_NEED_BYTES).severity, Severity::Good);
    }
}
