//! Package `shape_msgs`: solids. The constants are left out of the definition; decoding needs none.

use super::Polygon;

ros_message! {
    /// A solid around its own origin.
    "shape_msgs/SolidPrimitive" SolidPrimitive {
        /// Which solid: see the constants of this type.
        r#type: u8,
        /// At most three lengths, m, whose meaning depends on the solid.
        dimensions: Vec<f64>,
        /// Base of a prism.
        polygon: Polygon,
    }
}

impl SolidPrimitive {
    /// A box; its dimensions are its edges along x, y, z.
    pub const BOX: u8 = 1;
    /// A sphere; its dimension is its radius.
    pub const SPHERE: u8 = 2;
    /// A cylinder along z; its dimensions are height and radius.
    pub const CYLINDER: u8 = 3;
    /// A cone along z; its dimensions are height and radius.
    pub const CONE: u8 = 4;
    /// A prism along z over `polygon`; its dimension is its height.
    pub const PRISM: u8 = 5;
}
