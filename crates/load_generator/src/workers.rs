//! One thread on each processor, all stopped together.

use crate::{Done, LoadError, processors};

/// What one thread did.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Share {
    pub(crate) iterations: u64,
    pub(crate) bytes: u64,
}

/// Runs `work` once on each of `processors`, until all have returned, and adds up what they did.
pub(crate) fn on_each(
    processors: &[usize],
    footprint_bytes: u64,
    work: impl Fn() -> Share + Sync,
) -> Result<Done, LoadError> {
    let shares = std::thread::scope(|scope| {
        let threads: Vec<_> = processors
            .iter()
            .map(|&processor| {
                let work = &work;
                std::thread::Builder::new().name(format!("load-{processor}")).spawn_scoped(scope, move || {
                    processors::stay_on(processor);
                    work()
                })
            })
            .collect();
        let mut shares = Vec::with_capacity(threads.len());
        for thread in threads {
            let thread = thread.map_err(|source| LoadError::Thread { source })?;
            // A worker does arithmetic on memory of its own; it cannot panic.
            shares.push(thread.join().unwrap_or_default());
        }
        Ok(shares)
    })?;
    Ok(Done {
        threads: shares.len(),
        iterations: shares.iter().map(|share| share.iterations).sum(),
        bytes: shares.iter().map(|share| share.bytes).sum(),
        footprint_bytes,
    })
}
