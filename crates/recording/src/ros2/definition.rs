//! From a Rust struct to its `ros2msg` definition.
//!
//! A message is declared once, by `ros_message!`; its definition text follows from the field types, so text and coding
//! cannot drift apart.

use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Line between a definition and those it uses, as rosbag2 writes it.
const SEPARATOR: &str = "================================================================================";

/// Something that can be a field of a ROS 2 message.
pub trait Field {
    /// Name of the type in a definition, for example `float64` or `geometry_msgs/Pose[]`.
    fn ros_name() -> String;
    /// Appends the definitions this type needs, its own first, each one once, as (name, fields).
    fn collect(_definitions: &mut Vec<(&'static str, String)>) {}
}

/// A ROS 2 message type.
pub trait Ros2Message: Field + Serialize + DeserializeOwned {
    /// Package and name, for example `nav_msgs/Odometry`.
    const NAME: &'static str;

    /// The name that recordings carry, for example `nav_msgs/msg/Odometry`.
    fn type_name() -> String {
        Self::NAME.replacen('/', "/msg/", 1)
    }

    /// The complete definition in `ros2msg` form, with everything it uses.
    fn definition() -> String {
        let mut definitions = Vec::new();
        Self::collect(&mut definitions);
        let mut text = String::new();
        for (index, (name, fields)) in definitions.iter().enumerate() {
            if index > 0 {
                text.extend([SEPARATOR, "\nMSG: ", name, "\n"]);
            }
            text += fields;
        }
        text
    }
}

/// Eight bits without a meaning as a number: `byte` in a definition, which ROS tools tell from `uint8`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Byte(pub u8);

macro_rules! primitive {
    ($($rust:ty => $ros:literal),+ $(,)?) => {
        $(impl Field for $rust {
            fn ros_name() -> String { $ros.to_owned() }
        })+
    };
}

primitive!(
    bool => "bool", Byte => "byte", u8 => "uint8", i8 => "int8", i32 => "int32", u32 => "uint32", u64 => "uint64",
    f32 => "float32", f64 => "float64",
    String => "string",
    // serde has no arrays of 36; nested rows have the same bytes.
    [[f64; 6]; 6] => "float64[36]",
    [u8; 16] => "uint8[16]", [f64; 2] => "float64[2]",
);

impl<T: Field> Field for Vec<T> {
    fn ros_name() -> String {
        T::ros_name() + "[]"
    }
    fn collect(definitions: &mut Vec<(&'static str, String)>) {
        T::collect(definitions);
    }
}

/// Declares message structs with the definitions that ROS tools need.
macro_rules! ros_message {
    ($($(#[$doc:meta])* $ros:literal $name:ident { $($(#[$fdoc:meta])* $field:ident : $ty:ty),+ $(,)? })+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
        pub struct $name { $($(#[$fdoc])* pub $field: $ty),+ }

        impl $crate::ros2::Field for $name {
            fn ros_name() -> String { $ros.to_owned() }
            fn collect(definitions: &mut Vec<(&'static str, String)>) {
                if definitions.iter().any(|(name, _)| *name == $ros) {
                    return;
                }
                let mut fields = String::new();
                $(
                    let name = stringify!($field);
                    let name = name.strip_prefix("r#").unwrap_or(name);
                    fields.extend([<$ty as $crate::ros2::Field>::ros_name().as_str(), " ", name, "\n"]);
                )+
                definitions.push(($ros, fields));
                $(<$ty as $crate::ros2::Field>::collect(definitions);)+
            }
        }

        impl $crate::ros2::Ros2Message for $name {
            const NAME: &'static str = $ros;
        }
    )+};
}
