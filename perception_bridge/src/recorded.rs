//! A recording as a source: its messages at the pace they were recorded or another, the robot recorded or simulated.

mod clock;
mod error;
mod load;
mod playlist;
mod robot;
mod scenarios;
mod topics;
mod truth;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;

use bytemuck::Zeroable;
use crowd_sim::PlantError;
use messages::{
    Detections, Goal, MAX_OBSTACLES, Reason, RobotState, SafeCommand, SourceKind, SourceStatus, Stamp,
};
use recording::RefusalCounts;
use settings::Settings;

pub use error::SourceError;
pub use scenarios::{RecordedCrowd, RecordedCrowdError, scenarios_of_recording};

use crate::command_sink::SinkState;
use crate::nearest::by_distance;
use crate::playback::Playback;
use crate::source::{BridgeEvent, Source};
use playlist::{Content, Entry, Playlist};
use robot::SimulatedRobot;
use truth::Truth;

const NS_PER_MS: u64 = 1_000_000;
/// The goal is repeated this often, for controllers that start late.
const GOAL_PERIOD_NS: u64 = 1_000 * NS_PER_MS;

/// What became of the messages of a recording. Those handed on, those refused and those not needed are all there are.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct IntakeReport {
    /// Messages found in the file.
    pub found: u64,
    /// Odometry, detections, goals and transforms that are used.
    pub used: u64,
    /// Readable messages on topics that this source does not listen to.
    pub not_needed: u64,
    /// Messages that the reader refused.
    pub unreadable: RefusalCounts,
    /// Readable messages that made no sense, by reason.
    pub refused: BTreeMap<Reason, u64>,
    /// Single detections refused within frames that are used.
    pub refused_detections: u64,
    /// Single transforms refused, by reason.
    pub refused_transforms: BTreeMap<Reason, u64>,
    /// Messages whose stamp was missing or absurd, so that their log time was taken.
    pub restamped: u64,
    /// Messages whose frame was taken for `odom`, since the recording holds no transforms and the settings allow it.
    pub assumed_odom: u64,
    /// Odometry left out because a simulated robot takes the place of the recorded one. These count as used.
    pub replaced: u64,
}

/// How much one playback holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PlaybackCounts {
    /// Robot states, those included that a simulated robot replaces.
    pub robot_states: u64,
    /// Frames of detections.
    pub frames: u64,
    /// Detections in all frames together.
    pub people: u64,
}

impl IntakeReport {
    /// Messages refused, by the reader or here.
    pub fn refused_total(&self) -> u64 {
        self.unreadable.total() + self.refused.values().sum::<u64>()
    }
}

/// A recording, played back.
///
/// It is read and decoded completely when it is opened, so that playing it touches neither file nor heap.
pub struct McapSource {
    playlist: Playlist,
    report: IntakeReport,
    /// Present in a closed loop.
    simulated: Option<SimulatedRobot>,
    truth: Truth,
    goal: Goal,
    goal_tolerance_m: f64,
    goal_reached: bool,
    /// Stack time of the beginning of the recording; set when the source is first polled.
    origin_ns: Option<u64>,
    next_entry: usize,
    next_goal_ns: u64,
    /// Newest position of the robot, recorded or simulated, m.
    robot_m: [f64; 2],
    sequences: [u64; 3],
    order: Vec<usize>,
}

impl McapSource {
    /// Opens and decodes a recording. With `closed_loop`, a simulated robot that obeys the safe commands starts where the
    /// recorded one did and replaces it.
    ///
    /// # Errors
    /// [`SourceError`] if the file is unreadable or lacks what a stack needs.
    pub fn open(path: &Path, settings: &Settings, closed_loop: bool) -> Result<Self, SourceError> {
        let (playlist, report) = load::load(path, settings)?;
        Ok(Self::play(playlist, report, settings, closed_loop)?)
    }

    fn play(
        playlist: Playlist,
        mut report: IntakeReport,
        settings: &Settings,
        closed_loop: bool,
    ) -> Result<Self, PlantError> {
        let first = playlist.first_state;
        let goal = playlist.goal_or(settings.source.default_goal_in_base_m);
        let simulated = if closed_loop { Some(SimulatedRobot::new(settings, &first)?) } else { None };
        if closed_loop {
            report.replaced = playlist.counts().robot_states;
        }
        Ok(Self {
            truth: Truth::new(settings.robot.radius_m, first.position_in_odom_m),
            order: Vec::with_capacity(playlist.largest_frame()),
            playlist,
            report,
            simulated,
            goal,
            goal_tolerance_m: settings.nominal.goal_tolerance_m,
            goal_reached: false,
            origin_ns: None,
            next_entry: 0,
            next_goal_ns: 0,
            robot_m: first.position_in_odom_m,
            sequences: [0; 3],
        })
    }

    /// The same recording, played at another rate or several times in a row. Only before it is first polled.
    ///
    /// In a closed loop the simulated robot keeps its own pace, whatever the people do.
    ///
    /// # Errors
    /// [`SourceError::TooLong`] if so many passes do not fit into memory.
    pub fn played(mut self, playback: Playback) -> Result<Self, SourceError> {
        self.playlist = self.playlist.played(playback).ok_or(SourceError::TooLong {
            passes: playback.passes(),
            messages: self.playlist.entries.len(),
        })?;
        Ok(self)
    }

    /// How much one playback holds, all passes together.
    pub fn counts(&self) -> PlaybackCounts {
        self.playlist.counts()
    }

    /// What became of the recording's messages.
    pub const fn report(&self) -> &IntakeReport {
        &self.report
    }

    /// Length of the playback, ns.
    pub const fn length_ns(&self) -> u64 {
        self.playlist.length_ns
    }

    fn has_ended(&self) -> bool {
        self.next_entry >= self.playlist.entries.len() || (self.simulated.is_some() && self.goal_reached)
    }

    /// Recording time of the next recorded entry, ns; the robot's own are passed over in a closed loop.
    fn next_entry_ns(&self) -> u64 {
        self.playlist.entries.get(self.next_entry).map_or(u64::MAX, |entry| entry.due_ns)
    }

    fn next_state_ns(&self) -> u64 {
        self.simulated.as_ref().map_or(u64::MAX, SimulatedRobot::next_state_ns)
    }

    fn next_event_ns(&self) -> u64 {
        self.next_entry_ns().min(self.next_state_ns()).min(self.next_goal_ns)
    }

    fn stamp(&mut self, which: usize, source_ns: u64, valid_ns: u64, now_ns: u64) -> Stamp {
        self.sequences[which] += 1;
        let valid_at_ns = self.origin_ns.unwrap_or(now_ns).saturating_add(valid_ns);
        Stamp { sequence: self.sequences[which], source_ns, valid_at_ns, ingress_ns: now_ns, published_ns: 0 }
    }

    fn note_robot(&mut self, at_ns: u64, position_m: [f64; 2]) {
        self.robot_m = position_m;
        self.truth.note(&self.playlist, at_ns, position_m);
        self.goal_reached |= self.goal_distance_m() <= self.goal_tolerance_m;
    }

    fn goal_distance_m(&self) -> f64 {
        let [x, y] = self.goal.position_in_odom_m;
        (x - self.robot_m[0]).hypot(y - self.robot_m[1])
    }

    /// The event of the next entry; `None` for a robot state that the simulated one replaces.
    fn take_entry(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        let Entry { valid_ns, source_ns, content, .. } = self.playlist.entries[self.next_entry];
        self.next_entry += 1;
        match content {
            Content::Robot(_) if self.simulated.is_some() => None,
            Content::Robot(index) => {
                let state = self.playlist.states[index as usize];
                self.note_robot(valid_ns, state.position_in_odom_m);
                let stamp = self.stamp(0, source_ns, valid_ns, now_ns);
                Some(BridgeEvent::RobotState(RobotState { stamp, ..state }))
            }
            Content::People { first, count, left_out } => {
                let stamp = self.stamp(1, source_ns, valid_ns, now_ns);
                Some(BridgeEvent::Detections(self.frame(stamp, first, count, left_out)))
            }
            Content::Goal(index) => {
                let goal = self.playlist.goals[index as usize];
                // Said again, it is still the goal that was reached.
                let aim = |goal: &Goal| (goal.position_in_odom_m, goal.heading_rad);
                self.goal_reached &= aim(&goal) == aim(&self.goal);
                self.goal = goal;
                Some(self.goal_event(source_ns, valid_ns, now_ns))
            }
        }
    }

    fn frame(&mut self, stamp: Stamp, first: u32, count: u32, left_out: u32) -> Detections {
        let people = &self.playlist.people[first as usize..][..count as usize];
        by_distance(&mut self.order, people.len(), self.robot_m, |index| people[index].position_in_odom_m);
        let mut frame = Detections { stamp, ..Detections::zeroed() };
        let kept = people.len().min(MAX_OBSTACLES);
        frame.count = kept as u32;
        frame.left_out = left_out + (people.len() - kept) as u32;
        for (item, &index) in frame.items.iter_mut().zip(&self.order) {
            *item = people[index];
        }
        frame
    }

    fn goal_event(&mut self, source_ns: u64, valid_ns: u64, now_ns: u64) -> BridgeEvent {
        let stamp = self.stamp(2, source_ns, valid_ns, now_ns);
        BridgeEvent::Goal(Goal { stamp, ..self.goal })
    }

    fn take_simulated_state(&mut self, at_ns: u64, now_ns: u64) -> Option<BridgeEvent> {
        let origin_ns = self.origin_ns.unwrap_or(now_ns);
        let simulated = self.simulated.as_mut()?;
        // Every step is looked at, so that no contact falls between two published states.
        let mut state = None;
        while let Some(stepped) = simulated.step_towards(at_ns, origin_ns) {
            self.truth.note(&self.playlist, stepped.at_ns, stepped.state.position_in_odom_m);
            state = Some(stepped.state);
        }
        let state = state.unwrap_or_else(|| simulated.state());
        simulated.published(at_ns);
        self.note_robot(at_ns, state.position_in_odom_m);
        let stamp = self.stamp(0, at_ns, at_ns, now_ns);
        Some(BridgeEvent::RobotState(RobotState { stamp, ..state }))
    }
}

impl Source for McapSource {
    fn next_due_ns(&self) -> Option<u64> {
        (!self.has_ended()).then(|| self.origin_ns.unwrap_or(0).saturating_add(self.next_event_ns()))
    }

    fn poll(&mut self, now_ns: u64) -> Option<BridgeEvent> {
        let origin_ns = *self.origin_ns.get_or_insert(now_ns);
        while !self.has_ended() {
            let at_ns = self.next_event_ns();
            if origin_ns.saturating_add(at_ns) > now_ns {
                return None;
            }
            // The robot first: a frame keeps those nearest to where it is at the same moment.
            let event = if self.next_state_ns() == at_ns {
                self.take_simulated_state(at_ns, now_ns)
            } else if self.next_entry_ns() == at_ns {
                self.take_entry(now_ns)
            } else {
                self.next_goal_ns = self.next_goal_ns.saturating_add(GOAL_PERIOD_NS);
                Some(self.goal_event(at_ns, at_ns, now_ns))
            };
            if event.is_some() {
                return event;
            }
        }
        None
    }

    fn command(&mut self, command: &SafeCommand, now_ns: u64) {
        if let Some(simulated) = &mut self.simulated {
            simulated.command(command, now_ns);
        }
    }

    fn status(&self, now_ns: u64) -> SourceStatus {
        let since_origin_ns = self.origin_ns.map_or(0, |origin_ns| now_ns.saturating_sub(origin_ns));
        let refused_commands = self.simulated.as_ref().map_or(0, SimulatedRobot::refused_commands);
        SourceStatus {
            published_ns: now_ns,
            elapsed_ns: since_origin_ns.min(self.playlist.length_ns),
            total_ns: self.playlist.length_ns,
            accepted: self.sequences.iter().sum(),
            refused: self.report.refused_total() + refused_commands,
            min_clearance_m: self.truth.min_clearance_m(),
            clearance_m: self.truth.clearance_m(),
            path_length_m: self.truth.path_length_m(),
            goal_distance_m: self.goal_distance_m(),
            collisions: self.truth.collisions(),
            goal_reached: u32::from(self.goal_reached),
            finished: u32::from(self.has_ended()),
            kind: SourceKind::Mcap.code(),
        }
    }

    fn sink_state(&self) -> Option<SinkState> {
        self.simulated.as_ref().map(SimulatedRobot::sink_state)
    }
}
