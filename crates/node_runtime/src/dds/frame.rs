//! A message as DDS carries it: its bytes, unchanged, as a sequence of octets.

use std::{fmt, marker::PhantomData};

use messages::Message;
use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{Error, Visitor},
};

/// One message. Its length on the wire tells a message of another size; the type's name, one of another version.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame<T>(pub(super) T);

impl<T: Message> Serialize for Frame<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytemuck::bytes_of(&self.0))
    }
}

impl<'de, T: Message> Deserialize<'de> for Frame<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(FrameVisitor(PhantomData))
    }
}

struct FrameVisitor<T>(PhantomData<T>);

impl<T: Message> Visitor<'_> for FrameVisitor<T> {
    type Value = Frame<T>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "the {} bytes of a {}", size_of::<T>(), T::TYPE_NAME)
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Self::Value, E> {
        bytemuck::try_pod_read_unaligned(bytes).map(Frame).map_err(|_| E::invalid_length(bytes.len(), &self))
    }
}
