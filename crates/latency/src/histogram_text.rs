//! Histograms as text: the standard compressed form of HdrHistogram in base64, between figures that people read.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hdrhistogram::Histogram;
use hdrhistogram::serialization::{Deserializer, Serializer as _, V2DeflateSerializer};
use serde::{Deserialize, Serialize};

use crate::histogram::{DIGITS, LARGEST_NS};
use crate::{Latencies, LatencySummary};

/// Why a text is no histogram of ours.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HistogramTextError {
    /// Damaged.
    #[error("histogram cannot be decoded ({reason}); was the file cut off or edited?")]
    Undecodable {
        /// What the decoder said.
        reason: String,
    },
    /// Of another range or resolution.
    #[error("histogram spans {low} to {high} ns with {digits} digits; it was not written by this tool")]
    OtherBounds {
        /// Smallest value it resolves, ns.
        low: u64,
        /// Largest value it resolves, ns.
        high: u64,
        /// Significant digits.
        digits: u8,
    },
    /// The figures beside it contradict it.
    #[error("histogram holds {found} values where {stated} are stated; was the file edited?")]
    OtherCount {
        /// How many the histogram holds.
        found: u64,
        /// How many the figures beside it state.
        stated: u64,
    },
}

/// [`Latencies`] as they lie in JSON.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Text {
    #[serde(flatten)]
    summary: LatencySummary,
    histogram: String,
}

impl From<Latencies> for Text {
    fn from(latencies: Latencies) -> Self {
        Self { summary: latencies.summary(), histogram: encode(&latencies.values) }
    }
}

impl TryFrom<Text> for Latencies {
    type Error = HistogramTextError;

    fn try_from(text: Text) -> Result<Self, HistogramTextError> {
        let values = decode(&text.histogram)?;
        let (found, stated) = (values.len(), text.summary.count);
        if found != stated {
            return Err(HistogramTextError::OtherCount { found, stated });
        }
        if found > 0 && text.summary.min_ns > text.summary.max_ns {
            let reason = "the smallest value exceeds the largest".to_owned();
            return Err(HistogramTextError::Undecodable { reason });
        }
        let min_ns = if found == 0 { u64::MAX } else { text.summary.min_ns };
        Ok(Self { values, negative: text.summary.negative, min_ns, max_ns: text.summary.max_ns })
    }
}

fn encode(values: &Histogram<u64>) -> String {
    let mut bytes = Vec::new();
    V2DeflateSerializer::new().serialize(values, &mut bytes).expect("counts below 2^63, written to memory");
    STANDARD.encode(bytes)
}

fn decode(text: &str) -> Result<Histogram<u64>, HistogramTextError> {
    let undecodable = |reason: String| HistogramTextError::Undecodable { reason };
    let bytes = STANDARD.decode(text).map_err(|error| undecodable(error.to_string()))?;
    let values: Histogram<u64> = Deserializer::new()
        .deserialize(&mut bytes.as_slice())
        .map_err(|error| undecodable(error.to_string()))?;
    let (low, high, digits) = (values.low(), values.high(), values.sigfig());
    if (low, high, digits) != (1, LARGEST_NS, DIGITS) {
        return Err(HistogramTextError::OtherBounds { low, high, digits });
    }
    Ok(values)
}
