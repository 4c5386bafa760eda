//! Package `vision_msgs`: detected objects.

use super::{Header, Pose, PoseWithCovariance, Vector3};

ros_message! {
    /// What an object may be.
    "vision_msgs/ObjectHypothesis" ObjectHypothesis {
        /// Name of the class.
        class_id: String,
        /// Confidence in [0, 1].
        score: f64,
    }

    /// What an object may be and where it then is.
    "vision_msgs/ObjectHypothesisWithPose" ObjectHypothesisWithPose {
        /// The class.
        hypothesis: ObjectHypothesis,
        /// The pose.
        pose: PoseWithCovariance,
    }

    /// A box around an object.
    "vision_msgs/BoundingBox3D" BoundingBox3D {
        /// Its middle.
        center: Pose,
        /// Its edges, m.
        size: Vector3,
    }

    /// A detected object.
    "vision_msgs/Detection3D" Detection3D {
        /// When and in which frame.
        header: Header,
        /// Hypotheses, best first by convention.
        results: Vec<ObjectHypothesisWithPose>,
        /// Extent.
        bbox: BoundingBox3D,
        /// Identity over time, empty if none.
        id: String,
    }

    /// All objects of one frame of perception.
    "vision_msgs/Detection3DArray" Detection3DArray {
        /// When and in which frame.
        header: Header,
        /// The objects.
        detections: Vec<Detection3D>,
    }
}
