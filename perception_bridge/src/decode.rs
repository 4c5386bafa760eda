//! From ROS 2 messages to what the stack believes: planar poses, discs, identities, all brought into `odom`.
//!
//! Every function takes the transform to `odom` and sets everything but the stamp. Recordings and live topics go through
//! the same functions.

use bytemuck::Zeroable;
use dynamics::wrap_angle;
use messages::{Detection, DetectionFlags, Goal, ObstacleClass, Reason, RobotState};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use recording::ros2;

mod moving;

pub(crate) use moving::marker;
pub use moving::{agent, agent_of_hunav1, dynamic_obstacle, object, person};

/// A quaternion this far from unit length is no orientation, but a field that nobody filled in.
const QUATERNION_TOLERANCE: f64 = 0.1;
/// Marks identities made of text, so that they cannot meet one that was a number.
const HASHED_IDENTITY: u64 = 1 << 63;

/// How the extent of a detection becomes a radius, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RadiusRule {
    /// Taken where perception gives no plausible extent.
    pub default_m: f64,
    /// Smaller than this is not plausible.
    pub smallest_m: f64,
    /// Larger is cut to this.
    pub largest_m: f64,
}

impl RadiusRule {
    /// Radius of the disc as wide as the longer horizontal edge of a box.
    ///
    /// Where nothing plausible is given the default is taken, never nothing: the obstacle is there.
    fn radius_m(&self, size: &ros2::Vector3) -> f64 {
        let radius_m = 0.5 * size.x.abs().max(size.y.abs());
        let is_plausible = radius_m.is_finite() && radius_m > 0.0 && radius_m >= self.smallest_m;
        if is_plausible { radius_m.min(self.largest_m) } else { self.default_m }
    }
}

/// The rigid motion that a pose describes: from the posed frame's coordinates to those of its reference frame.
///
/// # Errors
/// [`Reason::MalformedInput`] if a number is not finite or the quaternion is none.
pub fn isometry(position: [f64; 3], orientation: &ros2::Quaternion) -> Result<Isometry3<f64>, Reason> {
    let ros2::Quaternion { x, y, z, w } = *orientation;
    let quaternion = Quaternion::new(w, x, y, z);
    let is_unit = (quaternion.norm() - 1.0).abs() <= QUATERNION_TOLERANCE;
    if !is_unit || !position.iter().all(|value| value.is_finite()) {
        return Err(Reason::MalformedInput);
    }
    let [x, y, z] = position;
    Ok(Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(quaternion)))
}

/// [`isometry`] of a ROS pose.
///
/// # Errors
/// As [`isometry`].
pub fn pose_isometry(pose: &ros2::Pose) -> Result<Isometry3<f64>, Reason> {
    let ros2::Point { x, y, z } = pose.position;
    isometry([x, y, z], &pose.orientation)
}

/// [`isometry`] of a ROS transform.
///
/// # Errors
/// As [`isometry`].
pub fn transform_isometry(transform: &ros2::Transform) -> Result<Isometry3<f64>, Reason> {
    let ros2::Vector3 { x, y, z } = transform.translation;
    isometry([x, y, z], &transform.rotation)
}

/// Angle of the x axis in the horizontal plane, rad in [-π, π).
fn heading_rad(pose: &Isometry3<f64>) -> f64 {
    let forward = pose.rotation * Vector3::x();
    wrap_angle(forward.y.atan2(forward.x))
}

/// Where the robot is, from odometry whose pose frame lies at `odom_from_frame`.
///
/// # Errors
/// [`Reason::NonFiniteRobotState`] if a number is not finite, [`Reason::MalformedInput`] if the orientation is none.
pub fn odometry(message: &ros2::Odometry, odom_from_frame: &Isometry3<f64>) -> Result<RobotState, Reason> {
    let pose = odom_from_frame * pose_isometry(&message.pose.pose)?;
    let twist = &message.twist.twist;
    let state = RobotState {
        position_in_odom_m: [pose.translation.x, pose.translation.y],
        heading_rad: heading_rad(&pose),
        velocity_in_base_mps: [twist.linear.x, twist.linear.y],
        yaw_rate_radps: twist.angular.z,
        ..RobotState::zeroed()
    };
    if state.is_finite() { Ok(state) } else { Err(Reason::NonFiniteRobotState) }
}

/// Where the robot shall go, from a pose whose frame lies at `odom_from_frame`.
///
/// # Errors
/// [`Reason::MalformedInput`] if a number is not finite or the orientation is none.
pub fn goal(message: &ros2::PoseStamped, odom_from_frame: &Isometry3<f64>) -> Result<Goal, Reason> {
    let pose = odom_from_frame * pose_isometry(&message.pose)?;
    let position_in_odom_m = [pose.translation.x, pose.translation.y];
    Ok(Goal { position_in_odom_m, heading_rad: heading_rad(&pose), ..Goal::zeroed() })
}

/// One detected object.
///
/// # Errors
/// [`Reason::UnsoundObstacle`] if its position is not finite.
pub fn detection(
    message: &ros2::Detection3D,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let best = message.results.iter().max_by(|a, b| a.hypothesis.score.total_cmp(&b.hypothesis.score));
    // Some publishers place an object by its hypothesis only. Their box tells nothing by its orientation, which ROS 2
    // initialises to the unit quaternion and ROS 1 to zero, nor by its size, which may be filled in all the same.
    let (centre, nowhere) = (&message.bbox.center.position, ros2::Point::default());
    let place = match best {
        Some(best) if *centre == nowhere && best.pose.pose.position != nowhere => &best.pose.pose.position,
        Some(_) | None => centre,
    };
    let mut detection = disc(place, odom_from_frame, radius.radius_m(&message.bbox.size))?;
    detection.track_id = identity(&message.id);
    if let Some(best) = best {
        detection.class = class(&best.hypothesis.class_id).code();
        if let Some(covariance) = planar_covariance(&best.pose.covariance, odom_from_frame) {
            detection.position_covariance_m2 = covariance;
            detection.flags |= DetectionFlags::HAS_COVARIANCE;
        }
    }
    Ok(detection)
}

/// One object of which nothing but the pose is known.
///
/// # Errors
/// As [`detection`].
pub fn anonymous(
    pose: &ros2::Pose,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    disc(&pose.position, odom_from_frame, radius.default_m)
}

/// One tracked object: its disc, and its velocity unless the orientation that this is given in is unknown.
///
/// # Errors
/// As [`detection`].
pub fn tracked(
    message: &ros2::TrackedObject,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let kinematics = &message.kinematics;
    let pose = &kinematics.pose_with_covariance;
    let radius_m = radius.radius_m(&extent(&message.shape));
    let mut detection = disc(&pose.pose.position, odom_from_frame, radius_m)?;
    detection.track_id = uuid(&message.object_id);
    let likeliest = message.classification.iter().max_by(|a, b| a.probability.total_cmp(&b.probability));
    detection.class = likeliest.map_or(ObstacleClass::Unknown, |found| label(found.label)).code();
    if let Some(covariance) = planar_covariance(&pose.covariance, odom_from_frame) {
        detection.position_covariance_m2 = covariance;
        detection.flags |= DetectionFlags::HAS_COVARIANCE;
    }
    if let Some(velocity) = tracked_velocity(kinematics, odom_from_frame) {
        detection.velocity_in_odom_mps = velocity;
        detection.flags |= DetectionFlags::HAS_VELOCITY;
    }
    Ok(detection)
}

/// Velocity of a tracked object in `odom`, m/s. The message gives it in the object's own frame.
fn tracked_velocity(
    kinematics: &ros2::TrackedObjectKinematics,
    odom_from_frame: &Isometry3<f64>,
) -> Option<[f64; 2]> {
    if kinematics.is_stationary {
        return Some([0.0; 2]);
    }
    if kinematics.orientation_availability != ros2::TrackedObjectKinematics::AVAILABLE {
        return None;
    }
    let linear = &kinematics.twist_with_covariance.twist.linear;
    let odom_from_object = odom_from_frame * pose_isometry(&kinematics.pose_with_covariance.pose).ok()?;
    let velocity = odom_from_object.rotation * Vector3::new(linear.x, linear.y, linear.z);
    let velocity = [velocity.x, velocity.y];
    velocity.iter().all(|value| value.is_finite()).then_some(velocity)
}

/// Edges of a box around a shape, m; a prism's is the square that holds it however it is turned.
fn extent(shape: &ros2::Shape) -> ros2::Vector3 {
    match shape.r#type {
        ros2::Shape::POLYGON => {
            let reaches = shape.footprint.points.iter().map(|point| f64::from(point.x.hypot(point.y)));
            let width = 2.0 * reaches.fold(0.0, f64::max);
            ros2::Vector3 { x: width, y: width, z: shape.dimensions.z }
        }
        // Types of later versions have dimensions, too.
        _ => shape.dimensions.clone(),
    }
}

/// Identity of a track by its UUID; nil is none.
fn uuid(id: &ros2::UUID) -> u64 {
    if id.uuid == [0; 16] { 0 } else { fnv1a(&id.uuid) | HASHED_IDENTITY }
}

/// What an object is, by Autoware's labels.
fn label(label: u8) -> ObstacleClass {
    match label {
        1..=ros2::ObjectClassification::TRAILER => ObstacleClass::Vehicle,
        ros2::ObjectClassification::MOTORCYCLE | ros2::ObjectClassification::BICYCLE => {
            ObstacleClass::Cyclist
        }
        ros2::ObjectClassification::PEDESTRIAN => ObstacleClass::Pedestrian,
        _ => ObstacleClass::Unknown,
    }
}

/// A point in `odom`, `[x, y]`, m; not finite if it was not.
pub(crate) fn place(point: &ros2::Point, odom_from_frame: &Isometry3<f64>) -> [f64; 2] {
    let found = odom_from_frame * Point3::new(point.x, point.y, point.z);
    [found.x, found.y]
}

fn disc(centre: &ros2::Point, odom_from_frame: &Isometry3<f64>, radius_m: f64) -> Result<Detection, Reason> {
    let position_in_odom_m = place(centre, odom_from_frame);
    if position_in_odom_m.iter().all(|value| value.is_finite()) {
        Ok(Detection { position_in_odom_m, radius_m, ..Detection::zeroed() })
    } else {
        Err(Reason::UnsoundObstacle)
    }
}

/// `[xx, xy, yy]` in `odom`, m²; `None` where no variance is given.
fn planar_covariance(covariance: &[[f64; 6]; 6], odom_from_frame: &Isometry3<f64>) -> Option<[f64; 3]> {
    let in_frame = nalgebra::Matrix3::from_fn(|row, column| covariance[row][column]);
    let rotation = odom_from_frame.rotation.to_rotation_matrix();
    let in_odom = rotation.matrix() * in_frame * rotation.matrix().transpose();
    let [xx, xy, yy] = [in_odom[(0, 0)], in_odom[(0, 1)], in_odom[(1, 1)]];
    let is_given = xx > 0.0 && yy > 0.0 && [xx, xy, yy].iter().all(|value| value.is_finite());
    is_given.then_some([xx, xy, yy])
}

/// Identity of a track by its name: a whole number keeps its value, other text is hashed, nothing gives 0.
///
/// The hash is FNV-1a, the same on every machine and run. `"0"` and `"007"` count as text, since 0 means "no identity" and
/// two names must not become one.
pub fn identity(name: &str) -> u64 {
    match name.parse::<u64>() {
        Ok(number) if number > 0 && number < HASHED_IDENTITY && number.to_string() == name => number,
        _ if name.is_empty() => 0,
        Ok(_) | Err(_) => fnv1a(name.as_bytes()) | HASHED_IDENTITY,
    }
}

fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// What an object is, by the class names in common use.
fn class(name: &str) -> ObstacleClass {
    match name.to_ascii_lowercase().as_str() {
        "person" | "pedestrian" | "people" | "human" => ObstacleClass::Pedestrian,
        "cyclist" | "bicycle" | "bicyclist" | "scooter" | "motorcycle" => ObstacleClass::Cyclist,
        "static" | "obstacle" => ObstacleClass::Static,
        "vehicle" | "car" | "truck" | "bus" | "robot" => ObstacleClass::Vehicle,
        _ => ObstacleClass::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use recording::ros2::{BoundingBox3D, Detection3D, Odometry, Point, Pose};

    const RULE: RadiusRule = RadiusRule { default_m: 0.35, smallest_m: 0.1, largest_m: 1.5 };

    fn upright() -> ros2::Quaternion {
        ros2::Quaternion::from_heading(0.0)
    }

    #[test]
    fn everything_is_brought_into_odom() {
        // A frame at (10, 5), turned left by a quarter.
        let odom_from_frame =
            isometry([10.0, 5.0, 1.0], &ros2::Quaternion::from_heading(std::f64::consts::FRAC_PI_2));
        let odom_from_frame = odom_from_frame.expect("a proper pose");
        let mut message = Odometry::default();
        message.pose.pose = Pose {
            position: Point { x: 2.0, y: 1.0, z: 0.0 },
            orientation: ros2::Quaternion::from_heading(0.25),
        };
        message.twist.twist.linear.x = 0.5;
        let state = odometry(&message, &odom_from_frame).expect("finite");
        let expected = [9.0, 7.0];
        for axis in 0..2 {
            assert!((state.position_in_odom_m[axis] - expected[axis]).abs() < 1e-12);
        }
        assert!((state.heading_rad - (std::f64::consts::FRAC_PI_2 + 0.25)).abs() < 1e-12);
        assert_eq!(state.velocity_in_base_mps, [0.5, 0.0], "velocities are in base whatever the frame");
    }

    #[test]
    fn a_covariance_turns_with_its_frame() {
        let quarter = isometry([0.0; 3], &ros2::Quaternion::from_heading(std::f64::consts::FRAC_PI_2));
        let mut covariance = [[0.0; 6]; 6];
        (covariance[0][0], covariance[1][1]) = (0.04, 0.01);
        (covariance[0][1], covariance[1][0]) = (0.002, 0.002);
        let [xx, xy, yy] = planar_covariance(&covariance, &quarter.expect("a proper pose")).expect("given");
        assert!((xx - 0.01).abs() < 1e-15 && (xy + 0.002).abs() < 1e-15 && (yy - 0.04).abs() < 1e-15);
        assert_eq!(planar_covariance(&[[0.0; 6]; 6], &Isometry3::identity()), None);
    }

    #[test]
    fn unfilled_orientations_and_numbers_that_are_none_are_refused() {
        let identity = Isometry3::identity();
        let mut message = Odometry::default();
        assert_eq!(odometry(&message, &identity), Err(Reason::MalformedInput), "zero quaternion");
        message.pose.pose.orientation = upright();
        assert!(odometry(&message, &identity).is_ok());
        message.twist.twist.angular.z = f64::NAN;
        assert_eq!(odometry(&message, &identity), Err(Reason::NonFiniteRobotState));
        message.pose.pose.position.x = f64::INFINITY;
        assert_eq!(odometry(&message, &identity), Err(Reason::MalformedInput));
        let mut person = Detection3D::default();
        person.bbox.center.position.y = f64::NAN;
        assert_eq!(detection(&person, &identity, RULE), Err(Reason::UnsoundObstacle));
    }

    #[test]
    fn implausible_extents_fall_back_but_never_lose_the_obstacle() {
        let radius = |x: f64, y: f64| {
            let size = ros2::Vector3 { x, y, z: 1.8 };
            let bbox = BoundingBox3D { size, ..BoundingBox3D::default() };
            let message = Detection3D { bbox, ..Detection3D::default() };
            detection(&message, &Isometry3::identity(), RULE).map(|found| found.radius_m)
        };
        assert_eq!(radius(0.5, 0.8), Ok(0.4));
        assert_eq!(radius(0.0, 0.0), Ok(0.35));
        assert_eq!(radius(0.1, 0.1), Ok(0.35));
        assert_eq!(radius(f64::NAN, f64::NAN), Ok(0.35));
        assert_eq!(radius(40.0, 2.0), Ok(1.5));
        assert_eq!(radius(f64::INFINITY, 0.5), Ok(0.35));
    }

    #[test]
    fn the_hypothesis_places_an_object_whose_box_has_no_centre() {
        let mut message = Detection3D::default();
        // As ROS 2 initialises a box, and as those leave it who fill in its size only.
        message.bbox.center.orientation = upright();
        message.bbox.size = ros2::Vector3 { x: 0.6, y: 0.5, z: 1.8 };
        let mut hypothesis = ros2::ObjectHypothesisWithPose::default();
        hypothesis.pose.pose.position = Point { x: 4.0, y: -1.0, z: 0.0 };
        message.results = vec![hypothesis];
        let place = |message: &Detection3D| {
            detection(message, &Isometry3::identity(), RULE)
                .map(|found| (found.position_in_odom_m, found.radius_m))
        };
        assert_eq!(place(&message), Ok(([4.0, -1.0], 0.3)));
        message.bbox.center.position.x = 2.0;
        assert_eq!(place(&message), Ok(([2.0, 0.0], 0.3)), "a box with a centre rules");
        message.bbox.center.position.x = 0.0;
        message.results[0].pose.pose.position = Point::default();
        assert_eq!(place(&message), Ok(([0.0, 0.0], 0.3)), "both at the origin: there it is");
    }

    #[test]
    fn a_tracked_object_brings_its_velocity_from_its_own_frame() {
        let mut message = ros2::TrackedObject::default();
        message.object_id.uuid[15] = 7;
        message.shape.dimensions = ros2::Vector3 { x: 0.6, y: 0.6, z: 1.8 };
        message.classification = vec![
            ros2::ObjectClassification { label: 1, probability: 0.2 },
            ros2::ObjectClassification { label: 7, probability: 0.7 },
        ];
        let kinematics = &mut message.kinematics;
        kinematics.pose_with_covariance.pose.position = Point { x: 2.0, y: 1.0, z: 0.0 };
        kinematics.pose_with_covariance.pose.orientation = ros2::Quaternion::from_heading(0.5);
        kinematics.twist_with_covariance.twist.linear.x = 1.2;
        // The frame is turned by a quarter in odom.
        let quarter = isometry([0.0; 3], &ros2::Quaternion::from_heading(std::f64::consts::FRAC_PI_2));
        let quarter = quarter.expect("a proper pose");
        let found = tracked(&message, &quarter, RULE).expect("finite");
        assert_eq!(found.flags & DetectionFlags::HAS_VELOCITY, 0, "a speed along an unknown direction");
        message.kinematics.orientation_availability = 2;
        let found = tracked(&message, &quarter, RULE).expect("finite");
        let heading = 0.5 + std::f64::consts::FRAC_PI_2;
        for (value, expected) in found.velocity_in_odom_mps.iter().zip([heading.cos(), heading.sin()]) {
            assert!((value - 1.2 * expected).abs() < 1e-12);
        }
        assert_eq!(found.flags, DetectionFlags::HAS_VELOCITY);
        assert_eq!((found.radius_m, found.class), (0.3, ObstacleClass::Pedestrian.code()));
        assert_ne!(found.track_id, 0);
        message.shape.r#type = ros2::Shape::POLYGON;
        message.shape.footprint.points = vec![ros2::Point32 { x: 0.3, y: -0.4, z: 0.0 }];
        let found = tracked(&message, &quarter, RULE).expect("finite");
        assert!((found.radius_m - 0.5).abs() < 1e-6);
        message.kinematics.is_stationary = true;
        assert_eq!(tracked(&message, &quarter, RULE).expect("finite").velocity_in_odom_mps, [0.0; 2]);
        assert_eq!(uuid(&ros2::UUID::default()), 0);
    }

    #[test]
    fn names_become_identities_that_do_not_collide() {
        assert_eq!(identity(""), 0);
        assert_eq!(identity("216"), 216);
        let names = ["0", "007", "7", "-7", "track-7", "3f0a", "18446744073709551615", "9223372036854775815"];
        let mut found: Vec<_> = names.iter().map(|name| identity(name)).collect();
        assert_eq!(found[2], 7);
        assert_eq!(identity("track-7"), 0xa29b_9429_8c0c_a0bc | HASHED_IDENTITY, "stable over releases");
        assert!(found.iter().all(|id| *id != 0));
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), names.len());
    }
}
