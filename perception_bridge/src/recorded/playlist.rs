//! A recording, decoded and in order, small enough to stay in memory.

use bytemuck::Zeroable;
use messages::{Detection, Goal, RobotState};

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
        let is_frame = |(_, entry): &(usize, &Entry)| matches!(entry.content, Content::People { .. });
        let mut frames: Vec<u32> =
            entries.iter().enumerate().filter(is_frame).map(|(index, _)| index as u32).collect();
        frames.sort_by_key(|index| entries[*index as usize].valid_ns);
        let length_ns = entries.last().map_or(0, |entry| entry.due_ns);
        let first_state = states.first().copied().unwrap_or_else(RobotState::zeroed);
        Self { entries, states, people, goals, frames, first_state, length_ns }
    }

    pub(super) fn robot_states(&self) -> u64 {
        self.states.len() as u64
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
