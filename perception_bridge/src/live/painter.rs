//! Pictures for a viewer: obstacles, where they go, and the curve h = 0 around the robot, drawn on a thread that yields to every
//! other one.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use messages::{Obstacles, SafeCommand};
use recording::ros2::{Header, MarkerArray};
use recording::{curve_marker, obstacle_markers};

use super::board::TopicRecord;
use super::error::RosError;
use super::outlet::Outlet;

/// Scenes that may wait. More would only be older.
const PLACES: usize = 1;
/// How far the thread steps back behind all others.
const NICENESS: i32 = 10;

/// Where h = 0 around the robot: takes the obstacles and the command of one cycle, returns curves of `[x, y]` in `odom`, m.
///
/// Whoever starts the bridge may bring it; the bridge itself knows no barrier.
pub type ZeroLevelOf = Box<dyn FnMut(&Obstacles, &SafeCommand) -> Vec<Vec<[f64; 2]>> + Send>;

/// What is drawn at once.
pub(super) struct Scene {
    /// When, and in which frame.
    pub(super) header: Header,
    /// The filter's cycle.
    pub(super) command: SafeCommand,
    /// What is around the robot.
    pub(super) obstacles: Box<Obstacles>,
}

/// The thread's end of the queue. Dropping it ends the thread after the picture it draws.
pub(super) struct Painter {
    scenes: Option<SyncSender<Scene>>,
    thread: Option<JoinHandle<()>>,
    record: Arc<TopicRecord>,
}

impl Painter {
    /// Starts the thread. Without `zero_level` the curve is left out.
    pub(super) fn start(
        outlet: Outlet<MarkerArray>,
        mut zero_level: Option<ZeroLevelOf>,
    ) -> Result<Self, RosError> {
        let record = Arc::clone(outlet.record());
        let (scenes, queue): (_, Receiver<Scene>) = sync_channel(PLACES);
        let thread = std::thread::Builder::new()
            .name("cncbf-ros2-draw".to_owned())
            .spawn(move || {
                // On Linux a thread's own; where it is refused, the thread is as good as any.
                let _ = rustix::process::nice(NICENESS);
                for scene in queue {
                    // What does not leave is counted by its outlet.
                    let _ = outlet.publish(picture(&scene, zero_level.as_mut()));
                }
            })
            .map_err(|error| RosError::Thread { cause: error.to_string() })?;
        Ok(Self { scenes: Some(scenes), thread: Some(thread), record })
    }

    /// Has a scene drawn, unless one is waiting already.
    pub(super) fn give(&self, scene: Scene) {
        if let Some(scenes) = &self.scenes {
            let _ = scenes.try_send(scene);
        }
    }

    /// What is known of its topic.
    pub(super) fn record(&self) -> &Arc<TopicRecord> {
        &self.record
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        self.scenes = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn picture(scene: &Scene, zero_level: Option<&mut ZeroLevelOf>) -> MarkerArray {
    let Scene { header, command, obstacles } = scene;
    let mut array = obstacle_markers(obstacles, header, command.critical_track_id);
    if let Some(zero_level) = zero_level {
        let curves_m = zero_level(obstacles, command);
        array.markers.push(curve_marker("h = 0", &curves_m, header));
    }
    array
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::Obstacle;
    use recording::ros2::Marker;

    #[test]
    fn a_picture_has_every_obstacle_where_it_goes_and_the_curve() {
        let mut obstacles = Box::new(Obstacles::zeroed());
        obstacles.count = 2;
        obstacles.items[1] = Obstacle {
            track_id: 7,
            position_in_odom_m: [1.0, 2.0],
            velocity_in_odom_mps: [0.5, 0.0],
            radius_m: 0.3,
            ..Obstacle::zeroed()
        };
        let command = SafeCommand { critical_track_id: 7, ..SafeCommand::zeroed() };
        let scene = Scene { header: Header::default(), command, obstacles };
        let mut square: ZeroLevelOf = Box::new(|_, _| vec![vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], vec![]]);
        let markers = picture(&scene, Some(&mut square)).markers;
        assert_eq!(markers.len(), 1 + 2 * 2 + 1, "what was there before vanishes first");
        assert_eq!((markers[0].action, markers[3].r#type), (Marker::DELETE_ALL, Marker::CYLINDER));
        assert_eq!((markers[3].pose.position.x, markers[3].scale.x), (1.0, 0.6));
        assert_eq!(markers[4].points[1].x, 1.5, "one second on");
        let curve = markers.last().expect("the curve");
        assert_eq!((curve.r#type, curve.points.len()), (Marker::LINE_LIST, 4));
        let mut nothing: ZeroLevelOf = Box::new(|_, _| vec![]);
        let curve = picture(&scene, Some(&mut nothing)).markers.pop().expect("the curve");
        assert_eq!(curve.action, Marker::DELETE);
    }
}
