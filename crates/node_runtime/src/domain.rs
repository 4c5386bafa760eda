//! Who can see whom: the prefix that every shared object of a group of stacks carries.
//!
//! Inside one domain, stacks are told apart by their instance name; two domains know nothing of each other.

use std::sync::{
    Once,
    atomic::{AtomicU64, Ordering},
};

use iceoryx2::{
    config::Config,
    prelude::{LogLevel, set_log_level, set_log_level_from_env_or},
};
use iceoryx2_bb_container::semantic_string::SemanticString;
use iceoryx2_bb_system_types::file_name::FileName;

/// Longest prefix. The path of a wake-up socket, at most 107 bytes on Linux, holds the prefix and a 128-bit number.
const MAX_PREFIX_LENGTH: usize = 32;

/// Why a name cannot serve as a prefix.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{prefix}` cannot be a shared-memory prefix; use 1 to {MAX_PREFIX_LENGTH} of the characters a-z A-Z 0-9 _"
)]
pub struct DomainError {
    /// The refused prefix.
    pub prefix: String,
}

/// A group of stacks that share a prefix in shared memory.
///
/// The default is iceoryx2's own, so that the `iox2` command and clients in other languages see a running stack without
/// being told anything. A configuration file of iceoryx2 is never read: the limits of a service are part of this program.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Domain {
    prefix: String,
}

impl Default for Domain {
    fn default() -> Self {
        Self { prefix: Config::default().global.prefix.as_str().to_owned() }
    }
}

impl Domain {
    /// Environment variable that names the prefix for a process and its children.
    pub const VARIABLE: &str = "CNCBF_IPC_PREFIX";

    /// The domain that [`Self::VARIABLE`] names, or the default one where it is unset or empty.
    ///
    /// # Errors
    /// [`DomainError`] if the variable holds anything but a usable prefix.
    pub fn from_env() -> Result<Self, DomainError> {
        match std::env::var_os(Self::VARIABLE) {
            None => Ok(Self::default()),
            Some(value) if value.is_empty() => Ok(Self::default()),
            Some(value) => Self::named(&value.to_string_lossy()),
        }
    }

    /// The domain of the given prefix. An underscore is added where the prefix does not end in one, so that `a1` is not
    /// taken for the beginning of `a12`.
    ///
    /// # Errors
    /// [`DomainError`] if the prefix is empty, too long, or holds a character other than letters, digits and `_`.
    pub fn named(prefix: &str) -> Result<Self, DomainError> {
        let mut owned = prefix.to_owned();
        if !owned.ends_with('_') {
            owned.push('_');
        }
        let usable = owned.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
        if prefix.is_empty() || owned.len() > MAX_PREFIX_LENGTH || !usable {
            return Err(DomainError { prefix: prefix.to_owned() });
        }
        Ok(Self { prefix: owned })
    }

    /// A domain that nobody else on this machine uses, for tests and for private stacks.
    pub fn isolated() -> Self {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        let count = COUNTER.fetch_add(1, Ordering::Relaxed);
        Self { prefix: format!("cncbf_{}_{count}_", std::process::id()) }
    }

    /// The prefix, to be handed to children in [`Self::VARIABLE`].
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// What iceoryx2 needs to know.
    pub(crate) fn config(&self) -> Config {
        let mut config = Config::default();
        config.global.prefix =
            FileName::new(self.prefix.as_bytes()).expect("letters, digits and _ make a file name");
        config
    }
}

/// Lets iceoryx2 log warnings only (`IOX2_LOG_LEVEL` says otherwise).
///
/// It also looks for its configuration file once, which nothing here uses, and would warn that there is none.
pub(crate) fn quieten() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        set_log_level(LogLevel::Error);
        Config::global_config();
        set_log_level_from_env_or(LogLevel::Warn);
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_prefix_is_checked_and_ends_in_an_underscore() {
        assert_eq!(Domain::named("a1").unwrap().prefix(), "a1_");
        assert_eq!(Domain::named("a1_").unwrap().prefix(), "a1_");
        for refused in ["", "a/b", "a b", "ä", &"x".repeat(MAX_PREFIX_LENGTH)] {
            assert_eq!(Domain::named(refused), Err(DomainError { prefix: refused.to_owned() }));
        }
    }

    #[test]
    fn isolated_domains_differ_from_each_other_and_from_the_default() {
        let (first, second) = (Domain::isolated(), Domain::isolated());
        assert_ne!(first, second);
        assert_ne!(first, Domain::default());
        assert_eq!(Domain::named(first.prefix()).unwrap(), first);
    }
}
