//! CDR with its four-byte encapsulation header, as ROS 2 puts messages on the wire.

use byteorder::{BigEndian, LittleEndian};

use crate::ros2::Ros2Message;

/// Encapsulation of what we write: plain CDR, little endian, no options.
const HEADER_LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];
/// Encoders may pad a message up to CDR's largest alignment.
const MAX_PADDING: usize = 7;

/// Why bytes are no message.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// There is not even an encapsulation header.
    #[error("{length} bytes are too short for a CDR message")]
    NoHeader {
        /// Bytes there are.
        length: usize,
    },
    /// The representation is not plain CDR.
    #[error("CDR representation {identifier:#06x} is not supported; record with plain CDR (XCDR1)")]
    Representation {
        /// The representation identifier.
        identifier: u16,
    },
    /// The bytes do not fit the type.
    #[error("not a {type_name}: {reason}")]
    Malformed {
        /// The type expected.
        type_name: &'static str,
        /// What the decoder says.
        reason: String,
    },
    /// The message ends long before the bytes do.
    #[error("{count} bytes are left over after a {type_name}; is it another version of the type?")]
    LeftOver {
        /// The type expected.
        type_name: &'static str,
        /// Bytes that belong to nothing.
        count: usize,
    },
}

/// Decodes a message in either byte order.
///
/// # Errors
/// [`CdrError`] if the representation is not plain CDR or the bytes are not exactly one message of this type.
pub fn decode<T: Ros2Message>(bytes: &[u8]) -> Result<T, CdrError> {
    let Some((header, body)) = bytes.split_first_chunk::<4>() else {
        return Err(CdrError::NoHeader { length: bytes.len() });
    };
    let decoded = match u16::from_be_bytes([header[0], header[1]]) {
        0 => cdr_encoding::from_bytes::<T, BigEndian>(body),
        1 => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        identifier => return Err(CdrError::Representation { identifier }),
    };
    let (message, used) =
        decoded.map_err(|error| CdrError::Malformed { type_name: T::NAME, reason: error.to_string() })?;
    let left_over = body.len().saturating_sub(used);
    if left_over > MAX_PADDING {
        return Err(CdrError::LeftOver { type_name: T::NAME, count: left_over });
    }
    Ok(message)
}

/// Encodes a message into `buffer`, which is cleared first.
///
/// # Errors
/// [`CdrError::Malformed`] if the encoder refuses, which plain structs give it no reason to.
pub fn encode<T: Ros2Message>(message: &T, buffer: &mut Vec<u8>) -> Result<(), CdrError> {
    buffer.clear();
    buffer.extend_from_slice(&HEADER_LITTLE_ENDIAN);
    // Alignment counts from behind the header; the serialiser counts what it writes itself.
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut *buffer, message)
        .map_err(|error| CdrError::Malformed { type_name: T::NAME, reason: error.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ros2::{Float64, Header, Point, Pose, PoseStamped, Quaternion, Time};

    fn sample() -> PoseStamped {
        PoseStamped {
            header: Header { stamp: Time { sec: 5, nanosec: 6 }, frame_id: "odom".into() },
            pose: Pose {
                position: Point { x: 1.5, y: -2.5, z: 0.25 },
                orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
            },
        }
    }

    #[test]
    fn a_message_survives() {
        let mut bytes = Vec::new();
        encode(&sample(), &mut bytes).unwrap();
        assert_eq!(bytes[..4], [0, 1, 0, 0]);
        // 4 header, 8 time, 4 length + "odom\0" = 17, padded to 24, seven doubles.
        assert_eq!(bytes.len(), 4 + 24 + 56);
        assert_eq!(decode::<PoseStamped>(&bytes), Ok(sample()));
    }

    #[test]
    fn big_endian_is_read() {
        let mut bytes = vec![0, 0, 0, 0];
        bytes.extend(2.5_f64.to_be_bytes());
        assert_eq!(decode::<Float64>(&bytes), Ok(Float64 { data: 2.5 }));
    }

    #[test]
    fn every_truncation_is_refused() {
        let mut bytes = Vec::new();
        encode(&sample(), &mut bytes).unwrap();
        for length in 0..bytes.len() {
            assert!(decode::<PoseStamped>(&bytes[..length]).is_err(), "{length} bytes decoded");
        }
    }

    #[test]
    fn other_representations_and_left_over_bytes_are_refused() {
        assert_eq!(decode::<Float64>(&[0, 7, 0, 0]), Err(CdrError::Representation { identifier: 7 }));
        let mut bytes = Vec::new();
        encode(&Float64 { data: 1.0 }, &mut bytes).unwrap();
        bytes.extend([0; 8]);
        assert_eq!(
            decode::<Float64>(&bytes),
            Err(CdrError::LeftOver { type_name: "std_msgs/Float64", count: 8 })
        );
    }
}
