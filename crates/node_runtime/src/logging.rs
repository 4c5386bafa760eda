//! Where the words of a process go.

use std::io::IsTerminal;

use tracing_subscriber::EnvFilter;

/// Without `RUST_LOG`: warnings, but none of DDS, which repeats some ten times a second on a loopback without multicast and so
/// would spoil what is measured of it.
const DEFAULT_FILTER: &str = "warn,rustdds=off,ros2_client=off";

/// Sends logs to standard error; the environment variable `RUST_LOG` sets the level, `warn` without it. Call it once, in `main`.
pub fn start_logging() {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(DEFAULT_FILTER));
    let colours = std::io::stderr().is_terminal();
    tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr).with_ansi(colours).init();
}
