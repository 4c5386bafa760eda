//! The standard HdrHistogram log, for the tools that read it.

use std::io::{self, Write};
use std::time::Duration;

use hdrhistogram::serialization::V2DeflateSerializer;
use hdrhistogram::serialization::interval_log::{IntervalLogWriterBuilder, IntervalLogWriterError, Tag};

use crate::{Latencies, ProfileFigures, Quantity};

/// Writes one interval for each repeat and quantity that was measured, tagged with the quantity's key: hops (`end_to_end`)
/// and loops (`filter_loop_lateness`). Values are ns, the maximum column ms; intervals begin at the time within the profile,
/// s, repeats one after the other. Maxima are those of the histogram, to three digits.
///
/// # Errors
/// What the writer fails with.
pub fn write_hlog(figures: &ProfileFigures, writer: &mut impl Write) -> io::Result<()> {
    let conditions = &figures.conditions;
    let comment = format!(
        "cncbf {} profile of {} at rate {}, load {}, transport {}; values in ns",
        conditions.tool_version,
        conditions.recording.file_name,
        conditions.rate,
        conditions.load,
        conditions.transport
    );
    let mut serializer = V2DeflateSerializer::new();
    let mut log = IntervalLogWriterBuilder::new()
        .add_comment(&comment)
        .with_max_value_divisor(1e6)
        .begin_log_with(writer, &mut serializer)?;
    let mut start = Duration::ZERO;
    for repeat in &figures.repeats {
        let length = Duration::from_nanos(repeat.duration_ns);
        for quantity in Quantity::all() {
            let measured = quantity.latencies(&repeat.hops, &repeat.loops);
            if let Some(Latencies { values, .. }) = measured.filter(|latencies| latencies.count() > 0) {
                let key = quantity.to_string();
                log.write_histogram(values, start, length, Tag::new(&key)).map_err(|error| match error {
                    IntervalLogWriterError::IoError(error) => error,
                    IntervalLogWriterError::SerializeError(error) => io::Error::other(error.to_string()),
                })?;
            }
        }
        start += length;
    }
    Ok(())
}
