//! The stack in one process and virtual time.
