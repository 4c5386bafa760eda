//! What the estimator met so far, each defined outcome with a counter of its own.

use messages::Reason;

/// Counters since construction. Every detection that reaches the estimator raises exactly one of `detections_used`,
/// `detections_malformed`, `detections_duplicate` or, with its whole frame, one of the three refused-frame counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EstimatorCounts {
    /// Frames that were used.
    pub frames_used: u64,
    /// Frames refused because a later one had been used already.
    pub frames_out_of_order: u64,
    /// Frames refused because they carry the time of the newest one.
    pub frames_duplicate: u64,
    /// Frames refused because they claim to come from the future.
    pub frames_from_future: u64,
    /// Detections that started or updated a track.
    pub detections_used: u64,
    /// Detections refused for a position or radius that cannot be.
    pub detections_malformed: u64,
    /// Detections refused because their identity had occurred earlier in the frame.
    pub detections_duplicate: u64,
    /// Detections without the measured velocity that `kind = "provided"` asks for; differences stood in.
    pub velocities_missing: u64,
    /// Tracks started.
    pub tracks_started: u64,
    /// Tracks that began anew where they were seen next, because nothing moves that fast.
    pub tracks_teleported: u64,
    /// Tracks whose velocity began anew after too long an interval.
    pub tracks_interrupted: u64,
    /// Frames in which a track went unseen and was predicted, summed over tracks.
    pub tracks_coasted: u64,
    /// Tracks dropped after having coasted for too long.
    pub tracks_dropped: u64,
    /// Coasting tracks given up early to make room for measured ones.
    pub tracks_evicted: u64,
}

impl EstimatorCounts {
    /// Frames and detections that were refused.
    pub fn refused(&self) -> u64 {
        self.frames_out_of_order
            + self.frames_duplicate
            + self.frames_from_future
            + self.detections_malformed
            + self.detections_duplicate
    }

    /// Tracks whose course was cut: teleported, or given up for want of room.
    pub fn tracks_disturbed(&self) -> u64 {
        self.tracks_teleported + self.tracks_evicted
    }
}

/// Why a whole frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FrameRefusal {
    OutOfOrder,
    Duplicate,
    FromFuture,
}

impl FrameRefusal {
    pub(crate) fn reason(self) -> Reason {
        match self {
            Self::OutOfOrder => Reason::BackwardStamp,
            Self::Duplicate => Reason::Duplicate,
            Self::FromFuture => Reason::FutureStamp,
        }
    }
}
