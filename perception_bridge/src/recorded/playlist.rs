//! A recording, decoded and in order, small enough to stay in memory.

use bytemuck::Zeroable;
use messages::{Detection, Goal, RobotState};

use super::PlaybackCounts;
use crate::playback::Playback;

/// Entries that a playlist may have, passes included: about 0.5 GB.
const LARGEST: usize = 10_000_000;

/// One thing to hand over. Times are ns since the beginning of the recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Entry {
    /// When the recorder received it.
    pub(super) due_ns: u64,
    /// When it held.
    pub(super) valid_ns: u64,
    /// The sensor's own stamp, for the log, ns on the sensor's clock.
    pub(super) source_ns: u64,
    pub(super) content: Content,
}

/// Where the content lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    /// Index into `states`.
    Robot(u32),
    /// A stretch of `people`.
    People { first: u32, count: u32, left_out: u32 },
    /// Index into `goals`.
    Goal(u32),
}

/// Everything a recording has to say, in order of `due_ns`.
#[derive(Debug, Clone)]
pub(super) struct Playlist {
    pub(super) entries: Vec<Entry>,
    pub(super) states: Vec<RobotState>,
    pub(super) people: Vec<Detection>,
    pub(super) goals: Vec<Goal>,
    /// Positions in `entries` of the frames, in order of their validity.
    pub(super) frames: Vec<u32>,
    pub(super) first_state: RobotState,
    pub(super) length_ns: u64,
}

impl Playlist {
    /// Completes a playlist whose entries are in order of time on the recorder's clock; there is at least one robot state.
    pub(super) fn new(
        mut entries: Vec<Entry>,
        states: Vec<RobotState>,
        people: Vec<Detection>,
        goals: Vec<Goal>,
    ) -> Self {
        let begin_ns = entries.iter().map(|entry| entry.due_ns.min(entry.valid_ns)).min().unwrap_or(0);
        for entry in &mut entries {
            entry.due_ns -= begin_ns;
            entry.valid_ns -= begin_ns;
        }
        entries.sort_by_key(|entry| entry.due_ns);
        let first_state = states.first().copied().unwrap_or_else(RobotState::zeroed);
        let mut playlist =
            Self { entries, states, people, goals, frames: Vec::new(), first_state, length_ns: 0 };
        playlist.note_frames_and_length();
        playlist
    }

    fn note_frames_and_length(&mut self) {
        let entries = &self.entries;
        let is_frame = |(_, entry): &(usize, &Entry)| matches!(entry.content, Content::People { .. });
        self.frames = entries.iter().enumerate().filter(is_frame).map(|(index, _)| index as u32).collect();
        self.frames.sort_by_key(|index| entries[*index as usize].valid_ns);
        self.length_ns = entries.last().map_or(0, |entry| entry.due_ns);
    }

    /// The same at another rate and several times in a row; `None` if that is too much to keep in memory.
    ///
    /// A pass begins one mean interval between two messages after the one before has ended. Sensor stamps keep their own
    /// pace and go on counting.
    pub(super) fn played(&self, playback: Playback) -> Option<Self> {
        let passes = playback.passes() as usize;
        if passes > 1 && self.entries.len().checked_mul(passes)? > LARGEST {
            return None;
        }
        let end_ns = self.entries.iter().map(|entry| entry.due_ns.max(entry.valid_ns)).max().unwrap_or(0);
        let pass_ns = end_ns.saturating_add(self.length_ns / self.entries.len().max(1) as u64);
        let at_rate = |time_ns: u64| {
            if playback.rate() == 1.0 { time_ns } else { (time_ns as f64 / playback.rate()) as u64 }
        };
        let entries = (0..passes as u64).flat_map(|pass| {
            let begin_ns = pass.saturating_mul(pass_ns);
            self.entries.iter().map(move |entry| Entry {
                due_ns: at_rate(begin_ns.saturating_add(entry.due_ns)),
                valid_ns: at_rate(begin_ns.saturating_add(entry.valid_ns)),
                source_ns: entry.source_ns.saturating_add(begin_ns),
                content: entry.content,
            })
        });
        let mut playlist = Self { entries: entries.collect(), ..self.clone() };
        playlist.note_frames_and_length();
        Some(playlist)
    }

    pub(super) fn counts(&self) -> PlaybackCounts {
        let mut counts = PlaybackCounts::default();
        for entry in &self.entries {
            match entry.content {
                Content::Robot(_) => counts.robot_states += 1,
                Content::People { count, .. } => {
                    counts.frames += 1;
                    counts.people += u64::from(count);
                }
                Content::Goal(_) => {}
            }
        }
        counts
    }

    /// People in the fullest frame.
    pub(super) fn largest_frame(&self) -> usize {
        let counts = self.entries.iter().map(|entry| match entry.content {
            Content::People { count, .. } => count as usize,
            Content::Robot(_) | Content::Goal(_) => 0,
        });
        counts.max().unwrap_or(0)
    }

    /// The goal before the recording names one: its first, or one ahead of the robot's first position, `[forward, left]`, m.
    pub(super) fn goal_or(&self, default_in_base_m: [f64; 2]) -> Goal {
        if let Some(first) = self.goals.first() {
            return *first;
        }
        let (sin, cos) = self.first_state.heading_rad.sin_cos();
        let ([x, y], [forward, left]) = (self.first_state.position_in_odom_m, default_in_base_m);
        Goal {
            position_in_odom_m: [x + cos * forward - sin * left, y + sin * forward + cos * left],
            heading_rad: self.first_state.heading_rad,
            ..Goal::zeroed()
        }
    }

    /// The people of a frame.
    pub(super) fn people_of(&self, entry: &Entry) -> &[Detection] {
        match entry.content {
            Content::People { first, count, .. } => &self.people[first as usize..][..count as usize],
            Content::Robot(_) | Content::Goal(_) => &[],
        }
    }
}
