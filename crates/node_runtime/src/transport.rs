//! What carries the messages between processes.

use std::fmt;

/// What carries the messages of a process. All processes of a stack must be given the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Transport {
    /// Shared memory: what the stack is built on.
    #[default]
    Iceoryx2,
    /// ROS 2's DDS over loopback, in the domain that `ROS_DOMAIN_ID` names: to compare with, on the user's own machine.
    ///
    /// Its ports allocate, lock and copy. Nothing stops a second writer of a service, a process of another version is not
    /// heard instead of being refused, and a late joiner is handed the last sample of rarely sent services only.
    Dds,
}

/// The environment names a transport that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{variable}=`{value}` names no transport; use `iceoryx2` or `dds`", variable = Transport::VARIABLE)]
pub struct TransportError {
    /// What the variable holds.
    pub value: String,
}

impl Transport {
    /// Environment variable that names the transport for a process and its children.
    pub const VARIABLE: &str = "CNCBF_TRANSPORT";

    /// The transport that [`Self::VARIABLE`] names, or iceoryx2 where it is unset or empty.
    ///
    /// # Errors
    /// [`TransportError`] if it holds anything but a transport's name.
    pub fn from_env() -> Result<Self, TransportError> {
        std::env::var_os(Self::VARIABLE)
            .map_or(Ok(Self::default()), |value| Self::named(&value.to_string_lossy()))
    }

    /// The transport of this name; the empty name stands for iceoryx2.
    ///
    /// # Errors
    /// [`TransportError`].
    pub fn named(name: &str) -> Result<Self, TransportError> {
        match name {
            "" | "iceoryx2" => Ok(Self::Iceoryx2),
            "dds" => Ok(Self::Dds),
            other => Err(TransportError { value: other.to_owned() }),
        }
    }
}

impl fmt::Display for Transport {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Iceoryx2 => "iceoryx2",
            Self::Dds => "dds",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_there_and_back_and_others_are_refused() {
        for transport in [Transport::Iceoryx2, Transport::Dds] {
            assert_eq!(Transport::named(&transport.to_string()), Ok(transport));
        }
        assert_eq!(Transport::named(""), Ok(Transport::Iceoryx2));
        let refusal = Transport::named("DDS").unwrap_err();
        assert!(refusal.to_string().contains("CNCBF_TRANSPORT=`DDS`"), "{refusal}");
    }
}
