//! Names and sizes of the services, the same for every transport.

use messages::{Message, ProcessId};

use crate::NodeError;

/// Queue of a subscriber that wants the newest few, messages.
pub(crate) const SHORT_QUEUE: usize = 8;
/// Memory that one reader's queue may ask of a publisher, bytes.
const QUEUE_BUDGET_BYTES: usize = 1 << 20;

/// Refuses names that could not be part of a service name.
///
/// # Errors
/// [`NodeError::InvalidInstance`].
pub fn check_instance(instance: &str) -> Result<(), NodeError> {
    let usable = instance.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-".contains(&byte));
    if usable && (1..=64).contains(&instance.len()) {
        Ok(())
    } else {
        Err(NodeError::InvalidInstance { instance: instance.to_owned() })
    }
}

/// Full name of the service of `T`.
pub(crate) fn name<T: Message>(instance: &str) -> String {
    format!("{instance}/{}", T::SERVICE)
}

/// Full name of the event that wakes `process`.
pub(crate) fn wake_name(instance: &str, process: ProcessId) -> String {
    format!("{instance}/wake/{process}")
}

/// Longest queue of one reader, messages: 256 (one second of the filter's commands) or what fits into 1 MiB, since a
/// publisher sets memory aside for every reader's whole queue.
pub(crate) const fn queue_length<T: Message>() -> usize {
    let fitting = QUEUE_BUDGET_BYTES / size_of::<T>();
    if fitting < 256 { fitting } else { 256 }
}
