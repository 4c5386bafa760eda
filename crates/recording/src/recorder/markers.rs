//! Shapes for a viewer: obstacles as discs with their velocity, curves on the ground. For recordings and live graphs alike.

use messages::{Obstacle, ObstacleQuality, Obstacles};

use super::convert::planar_pose;
use crate::ros2::{ColorRGBA, Header, Marker, MarkerArray, Point, Vector3};

/// Height of the shapes, m; what they stand for has none.
const HEIGHT_M: f64 = 0.1;
/// Width of an arrow's shaft and head, m.
const ARROW_M: [f64; 2] = [0.06, 0.14];

/// Width of a curve, m.
const CURVE_M: f64 = 0.04;

const CRITICAL: ColorRGBA = ColorRGBA { r: 0.85, g: 0.15, b: 0.15, a: 0.8 };
const MEASURED: ColorRGBA = ColorRGBA { r: 0.15, g: 0.45, b: 0.85, a: 0.6 };
const COASTING: ColorRGBA = ColorRGBA { r: 0.6, g: 0.6, b: 0.6, a: 0.5 };
const CURVE: ColorRGBA = ColorRGBA { r: 0.95, g: 0.6, b: 0.1, a: 0.9 };

/// All obstacles, each where it is and an arrow to where it would be in one second; the one that matters most in red, those
/// predicted in grey. What was shown before on the topic vanishes.
pub fn obstacle_markers(obstacles: &Obstacles, header: &Header, critical_track_id: u64) -> MarkerArray {
    // What is not shown again has vanished.
    let clear = Marker { header: header.clone(), action: Marker::DELETE_ALL, ..Marker::default() };
    let mut markers = vec![clear];
    for (id, obstacle) in (0..).zip(obstacles.as_slice()) {
        let color = color_of(obstacle, critical_track_id);
        markers.push(disc(obstacle, header, id, &color));
        markers.push(arrow(obstacle, header, id, &color));
    }
    MarkerArray { markers }
}

fn color_of(obstacle: &Obstacle, critical_track_id: u64) -> ColorRGBA {
    if obstacle.track_id == critical_track_id {
        CRITICAL
    } else if obstacle.quality == ObstacleQuality::Coasting.code() {
        COASTING
    } else {
        MEASURED
    }
}

fn disc(obstacle: &Obstacle, header: &Header, id: i32, color: &ColorRGBA) -> Marker {
    let diameter_m = 2.0 * obstacle.radius_m;
    Marker {
        header: header.clone(),
        ns: "discs".to_owned(),
        id,
        r#type: Marker::CYLINDER,
        pose: planar_pose(obstacle.position_in_odom_m, obstacle.heading_rad),
        scale: Vector3 { x: diameter_m, y: diameter_m, z: HEIGHT_M },
        color: color.clone(),
        ..Marker::default()
    }
}

/// From the centre to where the obstacle would be in one second.
fn arrow(obstacle: &Obstacle, header: &Header, id: i32, color: &ColorRGBA) -> Marker {
    let [x, y] = obstacle.position_in_odom_m;
    let [vx, vy] = obstacle.velocity_in_odom_mps;
    let point = |x, y| Point { x, y, z: HEIGHT_M };
    Marker {
        header: header.clone(),
        ns: "velocities".to_owned(),
        id,
        r#type: Marker::ARROW,
        pose: planar_pose([0.0, 0.0], 0.0),
        scale: Vector3 { x: ARROW_M[0], y: ARROW_M[1], z: 0.0 },
        color: color.clone(),
        points: vec![point(x, y), point(x + vx, y + vy)],
        ..Marker::default()
    }
}

/// Curves, `[x, y]` in the frame of `header`, m, as one shape named `name`.
pub fn curve_marker(name: &str, curves_m: &[Vec<[f64; 2]>], header: &Header) -> Marker {
    let point = |[x, y]: [f64; 2]| Point { x, y, z: HEIGHT_M };
    let stretches = curves_m.iter().flat_map(|curve| curve.windows(2));
    Marker {
        header: header.clone(),
        ns: name.to_owned(),
        r#type: Marker::LINE_LIST,
        // A viewer refuses a list without points.
        action: if curves_m.iter().any(|curve| curve.len() > 1) { Marker::ADD } else { Marker::DELETE },
        pose: planar_pose([0.0, 0.0], 0.0),
        scale: Vector3 { x: CURVE_M, y: 0.0, z: 0.0 },
        color: CURVE,
        points: stretches.flat_map(|pair| [point(pair[0]), point(pair[1])]).collect(),
        ..Marker::default()
    }
}
