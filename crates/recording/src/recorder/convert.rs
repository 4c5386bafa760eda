//! Wire messages as the ROS 2 messages that tools know.

use mcap::McapResult;
use messages::{
    ControlKind, Detection, DetectionFlags, Detections, Goal, NominalCommand, ObstacleClass, RobotState,
    SafeCommand,
};

use super::markers;
use crate::ros2::{
    Accel, AccelStamped, BoundingBox3D, Detection3D, Detection3DArray, Float64, Header, ObjectHypothesis,
    ObjectHypothesisWithPose, Odometry, Point, Pose, PoseStamped, PoseWithCovariance, Quaternion,
    Ros2Message, Time, Twist, TwistStamped, TwistWithCovariance, Vector3,
};
use crate::wire::WireMessage;

/// Where converted messages go.
pub(super) trait Sink {
    /// Takes a message for a topic.
    fn put<T: Ros2Message>(&mut self, topic: &str, message: &T) -> McapResult<()>;
}

/// Converts, remembering what one message needs of another.
pub(super) struct Converter {
    odom_frame: String,
    base_frame: String,
    /// The obstacle that mattered most to the newest safe command, 0 for none.
    critical_track_id: u64,
}

impl Converter {
    pub(super) fn new(odom_frame: String, base_frame: String) -> Self {
        Self { odom_frame, base_frame, critical_track_id: 0 }
    }

    /// Puts what ROS tools can show of a wire message.
    pub(super) fn convert(&mut self, message: &WireMessage, sink: &mut impl Sink) -> McapResult<()> {
        match message {
            WireMessage::RobotState(state) => sink.put("/odom", &self.odometry(state)),
            WireMessage::Detections(frame) => sink.put("/detections", &self.detections(frame)),
            WireMessage::Goal(goal) => sink.put("/goal_pose", &self.goal(goal)),
            WireMessage::NominalCommand(command) => self.nominal_command(command, sink),
            WireMessage::SafeCommand(command) => self.safe_command(command, sink),
            WireMessage::Obstacles(obstacles) => {
                let header = in_frame(&self.odom_frame, obstacles.stamp.published_ns);
                let shapes = markers::obstacle_markers(obstacles, &header, self.critical_track_id);
                sink.put("/cncbf/obstacles", &shapes)
            }
            // Figures of our own; no ROS type says them better than the raw message.
            WireMessage::SourceStatus(_) | WireMessage::Health(_) | WireMessage::Cycle(_) => Ok(()),
        }
    }

    fn odometry(&self, state: &RobotState) -> Odometry {
        let [vx, vy] = state.velocity_in_base_mps;
        Odometry {
            header: in_frame(&self.odom_frame, state.stamp.valid_at_ns),
            child_frame_id: self.base_frame.clone(),
            pose: PoseWithCovariance {
                pose: planar_pose(state.position_in_odom_m, state.heading_rad),
                ..PoseWithCovariance::default()
            },
            twist: TwistWithCovariance {
                twist: planar_twist([vx, vy], state.yaw_rate_radps),
                ..TwistWithCovariance::default()
            },
        }
    }

    fn detections(&self, frame: &Detections) -> Detection3DArray {
        let header = in_frame(&self.odom_frame, frame.stamp.valid_at_ns);
        let detections = frame.as_slice().iter().map(|detection| detection_3d(detection, &header)).collect();
        Detection3DArray { header, detections }
    }

    fn goal(&self, goal: &Goal) -> PoseStamped {
        PoseStamped {
            header: in_frame(&self.odom_frame, goal.stamp.valid_at_ns),
            pose: planar_pose(goal.position_in_odom_m, goal.heading_rad),
        }
    }

    fn nominal_command(&self, command: &NominalCommand, sink: &mut impl Sink) -> McapResult<()> {
        self.control("_nominal", command.control_kind, command.control, command.stamp.published_ns, sink)
    }

    fn safe_command(&mut self, command: &SafeCommand, sink: &mut impl Sink) -> McapResult<()> {
        self.critical_track_id = command.critical_track_id;
        self.control("", command.control_kind, command.control, command.ledger.filter_published_ns, sink)?;
        sink.put("/cncbf/h", &Float64 { data: command.h_m })?;
        sink.put("/cncbf/sdf", &Float64 { data: command.sdf_m })
    }

    /// A velocity command is a twist in `base`; an acceleration command is none and gets the type that says so.
    fn control(
        &self,
        suffix: &str,
        kind: u32,
        control: [f64; 2],
        time_ns: u64,
        sink: &mut impl Sink,
    ) -> McapResult<()> {
        let [first, second] = control;
        match ControlKind::try_from(kind) {
            Ok(ControlKind::Unicycle) => {
                let header = in_frame(&self.base_frame, time_ns);
                let twist = planar_twist([first, 0.0], second);
                sink.put(&format!("/cmd_vel{suffix}"), &TwistStamped { header, twist })
            }
            Ok(ControlKind::DoubleIntegrator) => {
                let header = in_frame(&self.odom_frame, time_ns);
                let linear = Vector3 { x: first, y: second, z: 0.0 };
                let accel = Accel { linear, angular: Vector3::default() };
                sink.put(&format!("/cmd_accel{suffix}"), &AccelStamped { header, accel })
            }
            // Only a foreign sender makes one; the raw message keeps it.
            Err(_) => Ok(()),
        }
    }
}

pub(super) fn in_frame(frame: &str, time_ns: u64) -> Header {
    Header { stamp: Time::from_ns(time_ns), frame_id: frame.to_owned() }
}

pub(super) fn planar_pose(position_m: [f64; 2], heading_rad: f64) -> Pose {
    Pose {
        position: Point { x: position_m[0], y: position_m[1], z: 0.0 },
        orientation: Quaternion::from_heading(heading_rad),
    }
}

fn planar_twist(velocity_mps: [f64; 2], yaw_rate_radps: f64) -> Twist {
    Twist {
        linear: Vector3 { x: velocity_mps[0], y: velocity_mps[1], z: 0.0 },
        angular: Vector3 { x: 0.0, y: 0.0, z: yaw_rate_radps },
    }
}

fn detection_3d(detection: &Detection, header: &Header) -> Detection3D {
    let pose = planar_pose(detection.position_in_odom_m, 0.0);
    let diameter_m = 2.0 * detection.radius_m;
    let mut covariance = [[0.0; 6]; 6];
    if detection.flags & DetectionFlags::HAS_COVARIANCE != 0 {
        let [xx, xy, yy] = detection.position_covariance_m2;
        (covariance[0][0], covariance[0][1], covariance[1][0], covariance[1][1]) = (xx, xy, xy, yy);
    }
    let class = ObstacleClass::try_from(detection.class).unwrap_or(ObstacleClass::Unknown);
    Detection3D {
        header: header.clone(),
        results: vec![ObjectHypothesisWithPose {
            hypothesis: ObjectHypothesis { class_id: class.label().to_owned(), score: 1.0 },
            pose: PoseWithCovariance { pose: pose.clone(), covariance },
        }],
        // The stack is planar: the height is not known.
        bbox: BoundingBox3D { center: pose, size: Vector3 { x: diameter_m, y: diameter_m, z: 0.0 } },
        id: if detection.track_id == 0 { String::new() } else { detection.track_id.to_string() },
    }
}
