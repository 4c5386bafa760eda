//! The messages of one run and what was known at a time.

use messages::{Goal, NominalCommand, Obstacles, RobotState, SafeCommand, SourceStatus};

/// A finished run in memory: what flowed, in the order it flowed, and the few settings that the figures need.
///
/// Any list may be empty; the figures that need it are then unknown.
#[derive(Debug, Clone)]
pub struct RunRecord {
    /// Heading of the report, for example the command that ran.
    pub title: String,
    /// The settings, as text.
    pub settings: String,
    /// Which model the filter used: its file and what its metadata says.
    pub model: String,
    /// Radius of the robot without any buffer, m.
    pub robot_radius_m: f64,
    /// Period the filter was meant to keep, ns.
    pub filter_period_ns: u64,
    /// Smoothing β of the composite's softmin, 1/m.
    pub beta_per_m: f64,
    /// Whether the filter only watched: the robot obeyed somebody else, and the commands of the filter were recorded alone.
    pub shadow: bool,
    /// Every nominal command.
    pub nominal_commands: Vec<NominalCommand>,
    /// Every command of the filter.
    pub safe_commands: Vec<SafeCommand>,
    /// Every robot state.
    pub robot_states: Vec<RobotState>,
    /// Every message of the estimator.
    pub obstacles: Vec<Obstacles>,
    /// Every goal.
    pub goals: Vec<Goal>,
    /// Progress and outcome as the source told them; the last one counts.
    pub source_status: Vec<SourceStatus>,
}

/// What the filter did and believed at one time.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The time asked for, stack clock, ns.
    pub time_ns: u64,
    /// The command of the last cycle that had begun by then.
    pub command: &'a SafeCommand,
    /// The newest robot state that held by then, if any.
    pub robot_state: Option<&'a RobotState>,
    /// The obstacles that cycle used, if any.
    pub obstacles: Option<&'a Obstacles>,
    /// The newest goal by then, or the first one if none had come yet.
    pub goal: Option<&'a Goal>,
}

impl RunRecord {
    /// When the run began, stack clock, ns: the first filter cycle, or the first robot state where there was none.
    pub fn start_ns(&self) -> u64 {
        let first_command = self.safe_commands.first().map(|command| command.ledger.filter_woke_ns);
        first_command.or(self.robot_states.first().map(|state| state.stamp.valid_at_ns)).unwrap_or(0)
    }

    /// When the run ended, stack clock, ns: the last filter cycle, or the last robot state.
    pub fn end_ns(&self) -> u64 {
        let last_command = self.safe_commands.last().map(|command| command.ledger.filter_woke_ns);
        last_command.or(self.robot_states.last().map(|state| state.stamp.valid_at_ns)).unwrap_or(0)
    }

    /// Length of the run, s.
    pub fn duration_s(&self) -> f64 {
        self.end_ns().saturating_sub(self.start_ns()) as f64 * 1e-9
    }

    /// Seconds since the run began; negative before.
    pub fn seconds(&self, time_ns: u64) -> f64 {
        (i128::from(time_ns) - i128::from(self.start_ns())) as f64 * 1e-9
    }

    /// Stack clock time, ns, of a time in seconds since the run began.
    pub fn stack_time_ns(&self, time_s: f64) -> u64 {
        self.start_ns().saturating_add_signed((time_s * 1e9).round() as i64)
    }

    /// What the filter did and believed at `time_ns`; nothing before its first cycle.
    pub fn moment_at(&self, time_ns: u64) -> Option<Moment<'_>> {
        let command = newest(&self.safe_commands, time_ns, |command| command.ledger.filter_woke_ns)?;
        // The ledger names the very message a cycle used: publication times are unique per publisher.
        let used_ns = command.ledger.estimator_published_ns;
        let obstacles = (used_ns != 0)
            .then(|| newest(&self.obstacles, used_ns, |message| message.stamp.published_ns))
            .flatten();
        Some(Moment {
            time_ns,
            command,
            robot_state: newest(&self.robot_states, time_ns, |state| state.stamp.valid_at_ns),
            obstacles,
            goal: newest(&self.goals, time_ns, |goal| goal.stamp.published_ns).or(self.goals.first()),
        })
    }

    /// Times of the playback's frames, stack clock, ns: evenly spaced, 20 a second, fewer in a long run.
    pub fn frame_times_ns(&self) -> Vec<u64> {
        const MIN_STEP_NS: u64 = 50_000_000;
        const MAX_FRAMES: u64 = 900;
        if self.safe_commands.is_empty() {
            return Vec::new();
        }
        let (start_ns, end_ns) = (self.start_ns(), self.end_ns());
        let length_ns = end_ns.saturating_sub(start_ns);
        let step_ns = MIN_STEP_NS.max(length_ns.div_ceil(MAX_FRAMES));
        (0..=length_ns / step_ns).map(|index| start_ns + index * step_ns).collect()
    }
}

/// The last item whose time is not after `time_ns`. Items are in the order of their time.
fn newest<T>(items: &[T], time_ns: u64, time_of: impl Fn(&T) -> u64) -> Option<&T> {
    let count = items.partition_point(|item| time_of(item) <= time_ns);
    count.checked_sub(1).map(|index| &items[index])
}
