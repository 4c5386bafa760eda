//! Whether the grid of the value function covers what robot and obstacle can do.
//!
//! Refused here, before hours are spent on a value function that is undefined where it will be asked.

use std::f64::consts::TAU;

use crate::error::{Checked, require};
use crate::{GridSettings, ObstacleMotion, RobotKind, Settings};

/// Refuses a grid on which the game of `settings` cannot be stated or does not cover the obstacles it allows.
pub(crate) fn validate(grid: &GridSettings, settings: &Settings) -> Checked {
    let (min, max) = ("offline.grid.min", "offline.grid.max");
    let radius_m = settings.failure_radius_m();
    require(
        grid.min[..2].iter().all(|&end| end < -radius_m),
        min,
        grid.min,
        "beyond the failure disc along x and y: below -(robot.radius_m + obstacle.radius_m)",
    )?;
    require(
        grid.max[..2].iter().all(|&end| end > radius_m),
        max,
        grid.max,
        "beyond the failure disc along x and y: above robot.radius_m + obstacle.radius_m",
    )?;
    require(
        !grid.periodic[0] && !grid.periodic[1] && !grid.periodic[3],
        "offline.grid.periodic",
        grid.periodic,
        "false except for the relative heading, the third axis",
    )?;
    let speed_mps = settings.obstacle.max_speed_mps;
    match (settings.robot.kind, settings.obstacle.motion) {
        (RobotKind::Unicycle, ObstacleMotion::Walking) => {
            require(
                grid.periodic[2] && (grid.max[2] - grid.min[2] - TAU).abs() < 1e-9,
                "offline.grid.periodic",
                (grid.periodic, grid.min[2], grid.max[2]),
                "periodic along the third axis, over one turn: that axis is the relative heading in rad",
            )?;
            require(
                grid.min[3] <= 0.0,
                min,
                grid.min,
                "at most 0 along the fourth axis, the obstacle's speed: obstacles may stand",
            )?;
            require(
                grid.max[3] >= speed_mps,
                max,
                grid.max,
                "at least obstacle.max_speed_mps along the fourth axis, the obstacle's speed; lower the one or raise the other",
            )
        }
        (RobotKind::Unicycle, ObstacleMotion::Static) => require(
            (2..4).all(|d| grid.min[d] <= 0.0 && grid.max[d] >= 0.0),
            min,
            (grid.min, grid.max),
            "such that the last two axes contain 0: they are idle for obstacles that stand still",
        ),
        (RobotKind::DoubleIntegrator, _) => {
            require(
                !grid.periodic[2],
                "offline.grid.periodic",
                grid.periodic,
                "false: no state of a double integrator is an angle",
            )?;
            // A robot at rest sees the obstacle's own velocity; what its own speed adds, only the user can say.
            require(
                grid.min[2..].iter().all(|&end| end <= -speed_mps),
                min,
                grid.min,
                "at most -obstacle.max_speed_mps along the relative velocity; add the robot's own top speed",
            )?;
            require(
                grid.max[2..].iter().all(|&end| end >= speed_mps),
                max,
                grid.max,
                "at least obstacle.max_speed_mps along the relative velocity; add the robot's own top speed",
            )
        }
    }
}
