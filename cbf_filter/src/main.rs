//! The safety filter as a program of its own.

use std::path::PathBuf;

use anyhow::Context;

fn main() -> anyhow::Result<()> {
    tracing_subscriber::fmt().with_writer(std::io::stderr).init();
    let mut arguments = std::env::args().skip(1);
    let settings =
        arguments.next().map(PathBuf::from).context("usage: cbf_filter SETTINGS.toml [INSTANCE]")?;
    let instance = arguments.next().unwrap_or_else(|| "cncbf".to_owned());
    cbf_filter::shell::run(&settings::Settings::load(&settings)?, &instance)
}
