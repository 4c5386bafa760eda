//! Why a recorded message was not handed over, and how often.

/// Why a message of a recording was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum RefusalReason {
    /// Its type is none that this stack reads.
    UnknownSchema,
    /// Its type has a known name but another definition: an older or newer version of the package.
    ForeignDefinition,
    /// Its encoding is neither CDR nor our own.
    UnsupportedEncoding,
    /// Its bytes do not decode as its type.
    Undecodable,
    /// A wire message whose size is not that of its type.
    WireSize,
    /// A wire message of a type or version that this program does not have.
    WireVersion,
    /// It belongs to a channel that the recording does not declare.
    UnknownChannel,
    /// It was in a chunk that is damaged.
    DamagedChunk,
    /// The record around it makes no sense.
    MalformedRecord,
}

impl RefusalReason {
    /// Every reason.
    pub const ALL: [Self; 9] = [
        Self::UnknownSchema,
        Self::ForeignDefinition,
        Self::UnsupportedEncoding,
        Self::Undecodable,
        Self::WireSize,
        Self::WireVersion,
        Self::UnknownChannel,
        Self::DamagedChunk,
        Self::MalformedRecord,
    ];

    /// The name in logs, reports and JSON.
    pub const fn label(self) -> &'static str {
        match self {
            Self::UnknownSchema => "unknown_schema",
            Self::ForeignDefinition => "foreign_definition",
            Self::UnsupportedEncoding => "unsupported_encoding",
            Self::Undecodable => "undecodable",
            Self::WireSize => "wire_size",
            Self::WireVersion => "wire_version",
            Self::UnknownChannel => "unknown_channel",
            Self::DamagedChunk => "damaged_chunk",
            Self::MalformedRecord => "malformed_record",
        }
    }
}

/// How many messages were refused for each reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RefusalCounts([u64; RefusalReason::ALL.len()]);

impl RefusalCounts {
    /// Counts `count` more.
    pub fn add(&mut self, reason: RefusalReason, count: u64) {
        self.0[reason as usize] += count;
    }

    /// How many were refused for `reason`.
    pub fn of(&self, reason: RefusalReason) -> u64 {
        self.0[reason as usize]
    }

    /// How many were refused.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// The reasons that occurred, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (RefusalReason, u64)> + '_ {
        RefusalReason::ALL.into_iter().map(|reason| (reason, self.of(reason))).filter(|(_, count)| *count > 0)
    }
}
