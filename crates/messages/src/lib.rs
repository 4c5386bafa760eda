//! Wire types and service names that the processes share.
