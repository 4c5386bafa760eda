//! What this process may do, whatever its limits say.

use rustix::thread::{CapabilitySet, capabilities};

/// Whether limits on real-time priorities do not apply (CAP_SYS_NICE).
pub(crate) fn can_set_any_priority() -> bool {
    has(CapabilitySet::SYS_NICE)
}

/// Whether limits on locked memory do not apply (CAP_IPC_LOCK).
pub(crate) fn can_lock_any_amount() -> bool {
    has(CapabilitySet::IPC_LOCK)
}

fn has(capability: CapabilitySet) -> bool {
    in_first_user_namespace() && capabilities(None).is_ok_and(|sets| sets.effective.contains(capability))
}

/// Capabilities inside a user namespace, which a container without root has, count for nothing here.
fn in_first_user_namespace() -> bool {
    std::fs::read_to_string("/proc/self/uid_map").is_ok_and(|map| maps_everyone_to_himself(&map))
}

fn maps_everyone_to_himself(map: &str) -> bool {
    map.split_whitespace().eq(["0", "0", "4294967295"])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_container_without_root_is_told_from_the_machine() {
        assert!(maps_everyone_to_himself("         0          0 4294967295\n"));
        assert!(!maps_everyone_to_himself(
            "         0       1000          1\n         1     100000      65536\n"
        ));
        assert!(!maps_everyone_to_himself(""));
    }
}
