//! Where h = 0 around the robot of a running stack, for who shows it to others.
//!
//! Here because the bridge, which shows it, knows no barrier, and the filter, which has one, shows nothing.

use cbf_filter::{SafetyFilter, load_model};
use messages::{Obstacles, SafeCommand};
use perception_bridge::ZeroLevelOf;
use report::{BarrierGrid, ZeroLevel};
use settings::Settings;

/// Half width of the window around the robot, m, and its points a side: 20 cm apart, a quarter of what reports draw, since this
/// one is drawn while the robot drives.
const WINDOW_M: f64 = 4.0;
const WINDOW_SIDE: usize = 41;

/// Draws with the model and the filter of `settings`.
///
/// # Errors
/// If the model cannot be used.
pub(crate) fn zero_level_of(settings: &Settings) -> anyhow::Result<ZeroLevelOf> {
    let model = load_model(&settings.filter.model)?;
    let mut filter = SafetyFilter::new(settings, &model)?;
    Ok(Box::new(move |obstacles: &Obstacles, command: &SafeCommand| {
        let robot_m = command.robot_position_in_odom_m;
        let now_ns = command.ledger.filter_woke_ns;
        let h_at = filter.h_around(obstacles, robot_m, command.robot_heading_rad, now_ns);
        // Before the filter has seen a robot state there is no place to draw around.
        BarrierGrid::around(robot_m, WINDOW_M, WINDOW_SIDE, h_at)
            .map_or_else(|_| Vec::new(), |grid| ZeroLevel::of(now_ns, &grid).curves_m())
    }))
}
