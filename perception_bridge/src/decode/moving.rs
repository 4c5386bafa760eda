//! Obstacles that bring their velocity: people, agents of a simulation, tracked objects of vehicles and of Nav2; and shapes.
//!
//! Velocities are given in the axes of the message's frame (but Autoware's, which are in the object's own) and over ground, so
//! that they are turned into `odom` and nothing is added for a frame that moves itself.

use messages::{Detection, DetectionFlags, ObstacleClass, Reason};
use nalgebra::{Isometry3, Vector3};
use recording::ros2::{self, hunav1};

use super::{HASHED_IDENTITY, RadiusRule, disc, fnv1a, identity, uuid};

/// One person.
///
/// # Errors
/// [`Reason::UnsoundObstacle`] if its position is not finite.
pub fn person(
    message: &ros2::Person,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let ros2::Point { x, y, z } = message.velocity;
    let mut detection = disc(&message.position, odom_from_frame, radius.default_m)?;
    detection.track_id = identity(&message.name);
    detection.class = ObstacleClass::Pedestrian.code();
    set_velocity(&mut detection, Vector3::new(x, y, z), odom_from_frame);
    Ok(detection)
}

/// One agent of HuNavSim 2.
///
/// # Errors
/// As [`person`].
pub fn agent(
    message: &ros2::Agent,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let ros2::Agent { id, r#type, position, velocity, radius: radius_m, .. } = message;
    any_agent((*id, *r#type, *radius_m), position, velocity, odom_from_frame, radius)
}

/// One agent of HuNavSim 1.
///
/// # Errors
/// As [`person`].
pub fn agent_of_hunav1(
    message: &hunav1::Agent,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let hunav1::Agent { id, r#type, position, velocity, radius: radius_m, .. } = message;
    any_agent((*id, *r#type, *radius_m), position, velocity, odom_from_frame, radius)
}

fn any_agent(
    (id, kind, radius_m): (i32, u8, f32),
    pose: &ros2::Pose,
    velocity: &ros2::Twist,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let radius_m = radius.radius_m(&round(f64::from(radius_m)));
    let mut detection = disc(&pose.position, odom_from_frame, radius_m)?;
    detection.track_id = numbered(id);
    let class = match kind {
        ros2::Agent::PERSON => ObstacleClass::Pedestrian,
        ros2::Agent::ROBOT => ObstacleClass::Vehicle,
        _ => ObstacleClass::Unknown,
    };
    detection.class = class.code();
    set_velocity(&mut detection, vector(&velocity.linear), odom_from_frame);
    Ok(detection)
}

/// One object of a vehicle's perception. Its velocity counts if it is tracked, its class if it is classified.
///
/// # Errors
/// As [`person`].
pub fn object(
    message: &ros2::Object,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let radius_m = radius.radius_m(&extent(&message.shape));
    let mut detection = disc(&message.pose.position, odom_from_frame, radius_m)?;
    if message.detection_level == ros2::Object::TRACKED {
        detection.track_id = u64::from(message.id);
        set_velocity(&mut detection, vector(&message.twist.linear), odom_from_frame);
    }
    let class = if message.object_classified { message.classification } else { 0 };
    detection.class = object_class(class).code();
    Ok(detection)
}

/// One obstacle of Nav2's tracking.
///
/// # Errors
/// As [`person`].
pub fn dynamic_obstacle(
    message: &ros2::Obstacle,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let mut detection = disc(&message.position, odom_from_frame, radius.radius_m(&message.size))?;
    detection.track_id = uuid(&message.uuid);
    set_velocity(&mut detection, vector(&message.velocity), odom_from_frame);
    Ok(detection)
}

/// One shape for a viewer.
///
/// # Errors
/// As [`person`].
pub(crate) fn marker(
    message: &ros2::Marker,
    odom_from_frame: &Isometry3<f64>,
    radius: RadiusRule,
) -> Result<Detection, Reason> {
    let radius_m = radius.radius_m(&message.scale);
    let mut detection = disc(&message.pose.position, odom_from_frame, radius_m)?;
    let name: Vec<u8> = message.ns.bytes().chain([0]).chain(message.id.to_le_bytes()).collect();
    detection.track_id = fnv1a(&name) | HASHED_IDENTITY;
    Ok(detection)
}

/// Turns a velocity into `odom`. One that is not finite is none.
fn set_velocity(detection: &mut Detection, in_frame_mps: Vector3<f64>, odom_from_frame: &Isometry3<f64>) {
    let in_odom_mps = odom_from_frame.rotation * in_frame_mps;
    let planar_mps = [in_odom_mps.x, in_odom_mps.y];
    if planar_mps.iter().all(|value| value.is_finite()) {
        detection.velocity_in_odom_mps = planar_mps;
        detection.flags |= DetectionFlags::HAS_VELOCITY;
    }
}

fn vector(vector: &ros2::Vector3) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

/// Edges of the box around a round thing, m.
fn round(radius_m: f64) -> ros2::Vector3 {
    ros2::Vector3 { x: 2.0 * radius_m, y: 2.0 * radius_m, z: 0.0 }
}

/// Edges of a box around a solid, m; zero where it does not say.
fn extent(shape: &ros2::SolidPrimitive) -> ros2::Vector3 {
    let dimension_m = |index: usize| shape.dimensions.get(index).copied().unwrap_or(0.0);
    match shape.r#type {
        ros2::SolidPrimitive::BOX => {
            ros2::Vector3 { x: dimension_m(0), y: dimension_m(1), z: dimension_m(2) }
        }
        ros2::SolidPrimitive::SPHERE => round(dimension_m(0)),
        ros2::SolidPrimitive::CYLINDER | ros2::SolidPrimitive::CONE => round(dimension_m(1)),
        ros2::SolidPrimitive::PRISM => {
            let reaches = shape.polygon.points.iter().map(|point| f64::from(point.x.hypot(point.y)));
            round(reaches.fold(0.0, f64::max))
        }
        _ => ros2::Vector3::default(),
    }
}

/// Identity of a numbered agent; zero is none.
fn numbered(id: i32) -> u64 {
    u64::try_from(id).unwrap_or_else(|_| fnv1a(&id.to_le_bytes()) | HASHED_IDENTITY)
}

/// What an object is, by the labels of `derived_object_msgs`.
fn object_class(label: u8) -> ObstacleClass {
    match label {
        ros2::Object::PEDESTRIAN => ObstacleClass::Pedestrian,
        ros2::Object::BIKE | ros2::Object::MOTORCYCLE => ObstacleClass::Cyclist,
        ros2::Object::CAR | ros2::Object::TRUCK | ros2::Object::OTHER_VEHICLE => ObstacleClass::Vehicle,
        ros2::Object::BARRIER | ros2::Object::SIGN => ObstacleClass::Static,
        _ => ObstacleClass::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decode::isometry;

    const RULE: RadiusRule = RadiusRule { default_m: 0.35, smallest_m: 0.1, largest_m: 1.5 };

    /// A frame at (10, 5), turned left by a quarter.
    fn quarter() -> Isometry3<f64> {
        let turned = ros2::Quaternion::from_heading(std::f64::consts::FRAC_PI_2);
        isometry([10.0, 5.0, 0.0], &turned).expect("a proper pose")
    }

    fn assert_moves(found: &Detection, position_m: [f64; 2], velocity_mps: [f64; 2]) {
        for axis in 0..2 {
            assert!((found.position_in_odom_m[axis] - position_m[axis]).abs() < 1e-12, "{found:?}");
            assert!((found.velocity_in_odom_mps[axis] - velocity_mps[axis]).abs() < 1e-12, "{found:?}");
        }
        assert_eq!(found.flags, DetectionFlags::HAS_VELOCITY);
    }

    #[test]
    fn a_person_is_turned_into_odom_with_its_velocity() {
        let mut message = ros2::Person { name: "track-7".to_owned(), ..ros2::Person::default() };
        message.position = ros2::Point { x: 2.0, y: 1.0, z: 0.3 };
        message.velocity = ros2::Point { x: 1.2, y: -0.5, z: 0.1 };
        let found = person(&message, &quarter(), RULE).expect("finite");
        assert_moves(&found, [9.0, 7.0], [0.5, 1.2]);
        assert_eq!((found.radius_m, found.class), (0.35, ObstacleClass::Pedestrian.code()));
        assert_eq!(found.track_id, identity("track-7"));
        message.velocity.y = f64::NAN;
        let found = person(&message, &quarter(), RULE).expect("it is there all the same");
        assert_eq!((found.flags, found.velocity_in_odom_mps), (0, [0.0; 2]));
        message.position.x = f64::NAN;
        assert_eq!(person(&message, &quarter(), RULE), Err(Reason::UnsoundObstacle));
    }

    #[test]
    fn agents_of_both_versions_bring_radius_class_and_identity() {
        let mut message =
            ros2::Agent { id: 3, r#type: ros2::Agent::PERSON, radius: 0.5, ..ros2::Agent::default() };
        message.position.position = ros2::Point { x: 2.0, y: 1.0, z: 0.0 };
        message.velocity.linear = ros2::Vector3 { x: 1.2, y: -0.5, z: 0.0 };
        let found = agent(&message, &quarter(), RULE).expect("finite");
        assert_moves(&found, [9.0, 7.0], [0.5, 1.2]);
        assert_eq!((found.track_id, found.radius_m), (3, 0.5));
        assert_eq!(found.class, ObstacleClass::Pedestrian.code());
        let old = hunav1::Agent { id: -1, r#type: 2, position: message.position, ..hunav1::Agent::default() };
        let found = agent_of_hunav1(&old, &quarter(), RULE).expect("finite");
        assert_eq!((found.class, found.radius_m), (ObstacleClass::Vehicle.code(), 0.35));
        assert!(found.track_id > HASHED_IDENTITY);
        assert_eq!((numbered(0), numbered(i32::MAX)), (0, 0x7fff_ffff));
    }

    #[test]
    fn an_object_says_what_counts_of_it() {
        let mut message =
            ros2::Object { id: 9, classification: ros2::Object::BIKE, ..ros2::Object::default() };
        message.pose.position = ros2::Point { x: 2.0, y: 1.0, z: 0.0 };
        message.twist.linear = ros2::Vector3 { x: 1.2, y: -0.5, z: 0.0 };
        let found = object(&message, &quarter(), RULE).expect("finite");
        let said = (found.flags, found.track_id, found.class, found.radius_m);
        assert_eq!(said, (0, 0, ObstacleClass::Unknown.code(), 0.35), "detected, not classified, no shape");
        message.detection_level = ros2::Object::TRACKED;
        message.object_classified = true;
        let found = object(&message, &quarter(), RULE).expect("finite");
        assert_moves(&found, [9.0, 7.0], [0.5, 1.2]);
        assert_eq!((found.track_id, found.class), (9, ObstacleClass::Cyclist.code()));
    }

    #[test]
    fn every_solid_has_a_radius() {
        let mut shape =
            ros2::SolidPrimitive { r#type: 1, dimensions: vec![0.4, 1.0, 2.0], ..Default::default() };
        let mut radius_m = |kind, dimensions: &[f64]| {
            (shape.r#type, shape.dimensions) = (kind, dimensions.to_vec());
            RULE.radius_m(&extent(&shape))
        };
        assert_eq!(radius_m(ros2::SolidPrimitive::BOX, &[0.4, 1.0, 2.0]), 0.5);
        assert_eq!(radius_m(ros2::SolidPrimitive::SPHERE, &[0.25]), 0.25);
        assert_eq!(radius_m(ros2::SolidPrimitive::CYLINDER, &[1.8, 0.3]), 0.3);
        assert_eq!(radius_m(ros2::SolidPrimitive::CONE, &[1.8, 0.2]), 0.2);
        assert_eq!(radius_m(ros2::SolidPrimitive::PRISM, &[1.8]), 0.35, "an outline without corners");
        assert_eq!(radius_m(ros2::SolidPrimitive::CYLINDER, &[]), 0.35);
        assert_eq!(radius_m(77, &[9.0]), 0.35);
        shape.polygon.points = vec![ros2::Point32 { x: 0.3, y: -0.4, z: 0.0 }];
        shape.r#type = ros2::SolidPrimitive::PRISM;
        assert!((RULE.radius_m(&extent(&shape)) - 0.5).abs() < 1e-6);
    }

    #[test]
    fn an_obstacle_of_nav2_brings_size_and_velocity() {
        let mut message = ros2::Obstacle::default();
        message.uuid.uuid[3] = 1;
        message.position = ros2::Point { x: 2.0, y: 1.0, z: 0.0 };
        message.velocity = ros2::Vector3 { x: 1.2, y: -0.5, z: 0.0 };
        message.size = ros2::Vector3 { x: 0.5, y: 0.8, z: 1.7 };
        let found = dynamic_obstacle(&message, &quarter(), RULE).expect("finite");
        assert_moves(&found, [9.0, 7.0], [0.5, 1.2]);
        assert_eq!(found.radius_m, 0.4);
        assert_eq!(found.track_id, uuid(&message.uuid));
    }
}
