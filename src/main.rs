//! The `cncbf` command.
fn main() {}
