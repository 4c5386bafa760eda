//! A safe command as the message that tells a ROS 2 graph what the filter made of it.

use messages::{Reason, SafeCommand, SafetyStatus};
use recording::ros2::{FilterState, Header};

/// The message of `command`; `header` says when its cycle began and in which frame it thought.
pub(super) fn filter_state(command: &SafeCommand, header: Header) -> FilterState {
    let [[u, v], [u_nom, v_nom]] = [command.control, command.nominal];
    let [x, y] = command.robot_position_in_odom_m;
    FilterState {
        header,
        sequence: command.sequence,
        status: status_label(command.status).to_owned(),
        reason: reason_label(command.reason).to_owned(),
        h: command.h_m,
        sdf: command.sdf_m,
        intervention: (u - u_nom).hypot(v - v_nom),
        slack: command.slack_mps,
        hard_margin: command.hard_margin_mps,
        control: command.control,
        nominal: command.nominal,
        obstacle_count: command.obstacle_count,
        critical_track_id: command.critical_track_id,
        critical_h: command.critical_h_m,
        x,
        y,
        heading: command.robot_heading_rad,
    }
}

/// Name of a rung; a code of another version is `unknown`.
pub(super) fn status_label(code: u32) -> &'static str {
    SafetyStatus::try_from(code).map_or("unknown", SafetyStatus::label)
}

/// Name of a reason; a code of another version is `unknown`.
pub(super) fn reason_label(code: u32) -> &'static str {
    Reason::try_from(code).map_or("unknown", Reason::label)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn codes_become_names_and_the_intervention_is_the_distance_of_both_commands() {
        let command = SafeCommand {
            control: [0.4, 0.1],
            nominal: [1.0, -0.7],
            status: SafetyStatus::Relaxed.code(),
            reason: Reason::SlackNeeded.code(),
            h_m: 0.25,
            robot_position_in_odom_m: [1.0, 2.0],
            ..SafeCommand::zeroed()
        };
        let state = filter_state(&command, Header::default());
        assert_eq!((state.status.as_str(), state.reason.as_str()), ("relaxed", "slack_needed"));
        assert!((state.intervention - 1.0).abs() < 1e-12, "{}", state.intervention);
        assert_eq!((state.h, state.x, state.y), (0.25, 1.0, 2.0));
        assert_eq!(reason_label(9_999), "unknown");
    }
}
