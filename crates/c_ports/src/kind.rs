//! The messages by their type names: which reader belongs to which structure.

use messages::{
    Cycle, Detections, Goal, Health, Message, NominalCommand, Obstacles, RobotState, SafeCommand,
    SourceStatus,
};
use node_runtime::{Node, Subscriber};

use crate::failure::Failure;

/// A subscriber of one type that is known by its name only.
pub(crate) trait AnyReader: Send {
    /// Copies the newest message that has arrived since the last call into `place`; false if there is none.
    fn newest_into(&mut self, place: Place) -> Result<bool, Failure>;
}

/// Where a caller wants a message.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    /// Not null, and may be written to for `size` bytes.
    pub(crate) begin: *mut u8,
    pub(crate) size: usize,
}

impl<T: Message> AnyReader for Subscriber<T> {
    fn newest_into(&mut self, place: Place) -> Result<bool, Failure> {
        if place.size != size_of::<T>() {
            return Err(Failure::OtherSize {
                type_name: T::TYPE_NAME,
                expected: size_of::<T>(),
                given: place.size,
            });
        }
        let Some(message) = self.newest() else { return Ok(false) };
        let bytes = bytemuck::bytes_of(&message);
        // SAFETY: the place is as long as the message, as was just compared, and may be written to, as its maker promises; the
        // message lies on this function's own stack.
        unsafe { place.begin.copy_from_nonoverlapping(bytes.as_ptr(), bytes.len()) };
        Ok(true)
    }
}

/// A reader of the messages of this type name.
pub(crate) fn reader(node: &Node, type_name: &str) -> Result<Box<dyn AnyReader>, Failure> {
    fn open<T: Message>(node: &Node) -> Result<Box<dyn AnyReader>, Failure> {
        Ok(Box::new(node.subscriber::<T>()?))
    }
    match type_name {
        RobotState::TYPE_NAME => open::<RobotState>(node),
        Goal::TYPE_NAME => open::<Goal>(node),
        Detections::TYPE_NAME => open::<Detections>(node),
        Obstacles::TYPE_NAME => open::<Obstacles>(node),
        NominalCommand::TYPE_NAME => open::<NominalCommand>(node),
        SafeCommand::TYPE_NAME => open::<SafeCommand>(node),
        SourceStatus::TYPE_NAME => open::<SourceStatus>(node),
        Health::TYPE_NAME => open::<Health>(node),
        Cycle::TYPE_NAME => open::<Cycle>(node),
        other => Err(Failure::UnknownType(other.to_owned())),
    }
}
