//! Package `cncbf_msgs`, this project's own: `bindings/ros2/cncbf_msgs` has it for ROS 2 workspaces.

use super::Header;

ros_message! {
    /// What the filter made of one cycle.
    "cncbf_msgs/FilterState" FilterState {
        /// When the cycle began; the frame of `x`, `y` and `heading`.
        header: Header,
        /// Counts the filter's cycles; most of them are left out between two messages.
        sequence: u64,
        /// Rung of the safety ladder: `filtered`, `relaxed`, `braking` or `stopped`.
        status: String,
        /// Why: `none`, `stale_robot_state` and so on.
        reason: String,
        /// Composite barrier value, m; infinite with no obstacle.
        h: f64,
        /// Smallest distance between the discs of robot and obstacle, m; infinite with no obstacle.
        sdf: f64,
        /// How far the command was moved: |u - u_nom| of the two numbers below.
        intervention: f64,
        /// Slack that the CBF-QP needed, m/s.
        slack: f64,
        /// Best margin that any admissible control has, m/s; negative where none satisfies the condition.
        hard_margin: f64,
        /// The command: speed m/s and yaw rate rad/s of a unicycle.
        control: [f64; 2],
        /// What the nominal controller wanted, in the same units.
        nominal: [f64; 2],
        /// Obstacles that counted.
        obstacle_count: u32,
        /// The obstacle that matters most; 0 with none.
        critical_track_id: u64,
        /// Its own barrier value, m; infinite with none.
        critical_h: f64,
        /// Robot's place the cycle used, m.
        x: f64,
        /// See `x`.
        y: f64,
        /// Robot's heading the cycle used, rad.
        heading: f64,
    }
}
