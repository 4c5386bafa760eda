//! Ports of a running stack with a plain C interface: the library `cncbf`, whose header is `bindings/c/cncbf.h`.
//!
//! A program in C, or in any language that calls C, reads what the processes say and takes the nominal controller's place.
//! [`handles`] holds the functions, [`kind`] knows the messages by their type names, [`failure`] says what went wrong.
//!
//! This is the only crate whose functions take raw pointers. Each function checks for null pointers and foreign types, and no panic
//! leaves it; that a handle is alive and used by one thread at a time is the caller's promise, which the header states.
//!
//! The header is written by `cargo run -p bindings` from the sources here: what a C programmer must know stands in the comments
//! of the functions.

#![expect(unsafe_code, reason = "C knows no other way to hand over a handle or a message")]

mod failure;
mod handles;
mod kind;

pub use failure::{Result, cncbf_last_error};
pub use handles::{
    CNCBF_ABI_VERSION, Node, Nominal, Reader, cncbf_abi_version, cncbf_node_close, cncbf_node_open,
    cncbf_nominal_close, cncbf_nominal_open, cncbf_nominal_send, cncbf_nominal_wait, cncbf_now_ns,
    cncbf_reader_close, cncbf_reader_newest, cncbf_reader_open,
};
