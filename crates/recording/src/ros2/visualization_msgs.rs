//! Package `visualization_msgs`: shapes for viewers. The constants are left out of the definition; decoding needs none.

use super::{ColorRGBA, CompressedImage, Duration, Header, Point, Pose, Vector3};

ros_message! {
    /// A point of a texture.
    "visualization_msgs/UVCoordinate" UVCoordinate {
        /// Across.
        u: f32,
        /// Up.
        v: f32,
    }

    /// A mesh that travels with its marker.
    "visualization_msgs/MeshFile" MeshFile {
        /// Its name.
        filename: String,
        /// Its content.
        data: Vec<u8>,
    }

    /// A shape.
    "visualization_msgs/Marker" Marker {
        /// When and in which frame.
        header: Header,
        /// Namespace of `id`.
        ns: String,
        /// Identity within the namespace.
        id: i32,
        /// Shape: see the constants of this type.
        r#type: i32,
        /// What to do with it: see the constants of this type.
        action: i32,
        /// Where.
        pose: Pose,
        /// Edges, or widths for an arrow given by points, m.
        scale: Vector3,
        /// Colour.
        color: ColorRGBA,
        /// How long it is shown; zero is for ever.
        lifetime: Duration,
        /// Whether it moves with its frame.
        frame_locked: bool,
        /// Points, for shapes made of them.
        points: Vec<Point>,
        /// A colour for each point.
        colors: Vec<ColorRGBA>,
        /// Texture by name.
        texture_resource: String,
        /// Texture by content.
        texture: CompressedImage,
        /// Where points lie in the texture.
        uv_coordinates: Vec<UVCoordinate>,
        /// Text, for text.
        text: String,
        /// Mesh by name.
        mesh_resource: String,
        /// Mesh by content.
        mesh_file: MeshFile,
        /// Whether the mesh brings its colours.
        mesh_use_embedded_materials: bool,
    }

    /// Shapes that change together.
    "visualization_msgs/MarkerArray" MarkerArray {
        /// The shapes.
        markers: Vec<Marker>,
    }
}

impl Marker {
    /// An arrow from the first to the second point.
    pub const ARROW: i32 = 0;
    /// A box.
    pub const CUBE: i32 = 1;
    /// An ellipsoid.
    pub const SPHERE: i32 = 2;
    /// A cylinder.
    pub const CYLINDER: i32 = 3;
    /// Lines between the first and the second point, the third and the fourth, and so on.
    pub const LINE_LIST: i32 = 5;
    /// `type`: cubes at `points`; spheres at them and the points themselves come next.
    pub const CUBE_LIST: i32 = 6;
    /// `type`: the points themselves.
    pub const POINTS: i32 = 8;
    /// `type`: a mesh by name.
    pub const MESH_RESOURCE: i32 = 10;
    /// `type`: a mesh by its corners.
    pub const TRIANGLE_LIST: i32 = 11;
    /// Show or change this marker.
    pub const ADD: i32 = 0;
    /// Remove this marker.
    pub const DELETE: i32 = 2;
    /// Remove every marker of the topic.
    pub const DELETE_ALL: i32 = 3;
}
