//! How a recording is played: how fast, and how often.

/// Rates beyond these serve nobody: slower than a minute a second, faster than any sensor.
const RATES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// How fast and how often a recording is played.
///
/// Rates other than 1 compress or stretch all its times. People and robot then change place so much faster, while the
/// velocities that the recording states stay as they were: only the timing of such a playback means anything. From the second
/// pass on, everybody jumps back to where the recording began.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Playback {
    rate: f64,
    passes: u32,
}

/// Why a recording cannot be played like that.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PlaybackError {
    /// The rate is no positive number, or far from any use.
    #[error("{rate} is no rate; use a number from {} to {}, where 1 is real time", RATES.start(), RATES.end())]
    Rate {
        /// What was asked for.
        rate: f64,
    },
    /// It is never played.
    #[error("0 passes play nothing; use at least 1")]
    NoPass,
}

impl Playback {
    /// Once, at the pace it was recorded.
    pub const AS_RECORDED: Self = Self { rate: 1.0, passes: 1 };

    /// `rate` times as fast as it was recorded, `passes` times in a row.
    ///
    /// # Errors
    /// [`PlaybackError`] if the rate is outside 0.01 to 1000, or nothing would be played.
    pub fn new(rate: f64, passes: u32) -> Result<Self, PlaybackError> {
        if !RATES.contains(&rate) {
            return Err(PlaybackError::Rate { rate });
        }
        if passes == 0 {
            return Err(PlaybackError::NoPass);
        }
        Ok(Self { rate, passes })
    }

    /// Recorded seconds per second.
    pub const fn rate(&self) -> f64 {
        self.rate
    }

    /// How often it is played in a row.
    pub const fn passes(&self) -> u32 {
        self.passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_useful_playbacks_exist() {
        assert_eq!(Playback::new(1.0, 1), Ok(Playback::AS_RECORDED));
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e9] {
            let error = Playback::new(rate, 1).expect_err("no rate").to_string();
            assert!(error.contains("is no rate") && error.contains("real time"), "{error}");
        }
        assert_eq!(Playback::new(2.0, 0), Err(PlaybackError::NoPass));
    }
}
