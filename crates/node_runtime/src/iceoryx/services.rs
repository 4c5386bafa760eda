//! Limits of the services. Every process states the same ones, so that any of them may come first.

use iceoryx2::{
    node::Node as IceoryxNode,
    service::{
        builder::{
            event::{EventOpenError, EventOpenOrCreateError},
            publish_subscribe::{PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError},
        },
        port_factory::{event, publish_subscribe},
        service_name::ServiceName,
    },
};
use messages::{Cycle, Health, Message};

use super::Service;
use crate::services::queue_length;

/// Readers of one service: the processes, a recorder, a live view, two more.
const MAX_SUBSCRIBERS: usize = 8;
/// Writers of [`Health`] and of [`Cycle`], and wakers of one process.
const MAX_WRITERS_OF_MANY: usize = 16;
/// Processes on one service, the dead ones that nobody has swept yet included.
const MAX_NODES: usize = 32;
/// Samples a reader can hold: the newest one, and the next while it is exchanged.
const MAX_BORROWED: usize = 2;

/// Why one try to open a port failed.
pub(crate) enum OpenFailure {
    /// The service carries another type than the named one.
    OtherType(&'static str),
    /// The service was created with limits that do not fit.
    OtherLimits(String),
    /// All places for this role are taken.
    Taken(&'static str),
    /// Another process has begun to create the service and not ended within a second.
    Unfinished,
    /// Something that another try may cure.
    Transient(String),
}

/// How many processes may write `T` at a time.
pub(crate) fn max_publishers<T: Message>() -> usize {
    if [Health::SERVICE, Cycle::SERVICE].contains(&T::SERVICE) { MAX_WRITERS_OF_MANY } else { 1 }
}

/// Opens or creates the service of `T`.
pub(crate) fn open<T: Message>(
    node: &IceoryxNode<Service>,
    name: &ServiceName,
) -> Result<publish_subscribe::PortFactory<Service, T, ()>, OpenFailure> {
    node.service_builder(name)
        .publish_subscribe::<T>()
        .enable_safe_overflow(true)
        .history_size(1)
        .subscriber_max_buffer_size(queue_length::<T>())
        .subscriber_max_borrowed_samples(MAX_BORROWED)
        .max_publishers(max_publishers::<T>())
        .max_subscribers(MAX_SUBSCRIBERS)
        .max_nodes(MAX_NODES)
        .open_or_create()
        .map_err(|error| data_failure(error, T::TYPE_NAME))
}

/// Opens or creates the event that wakes a process.
pub(crate) fn open_event(
    node: &IceoryxNode<Service>,
    name: &ServiceName,
) -> Result<event::PortFactory<Service>, OpenFailure> {
    node.service_builder(name)
        .event()
        .max_listeners(1)
        .max_notifiers(MAX_WRITERS_OF_MANY)
        .max_nodes(MAX_NODES)
        .event_id_max_value(0)
        .open_or_create()
        .map_err(event_failure)
}

fn data_failure(error: PublishSubscribeOpenOrCreateError, expected: &'static str) -> OpenFailure {
    use PublishSubscribeOpenError as Open;
    let PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(open_error) = error else {
        return OpenFailure::Transient(format!("{error:?}"));
    };
    match open_error {
        Open::IncompatibleTypes => OpenFailure::OtherType(expected),
        Open::IncompatibleMessagingPattern
        | Open::IncompatibleAttributes
        | Open::IncompatibleOverflowBehavior
        | Open::DoesNotSupportRequestedMinBufferSize
        | Open::DoesNotSupportRequestedMinHistorySize
        | Open::DoesNotSupportRequestedMinSubscriberBorrowedSamples
        | Open::DoesNotSupportRequestedAmountOfPublishers
        | Open::DoesNotSupportRequestedAmountOfSubscribers
        | Open::DoesNotSupportRequestedAmountOfNodes
        | Open::VersionMismatch => OpenFailure::OtherLimits(format!("{open_error:?}")),
        Open::HangsInCreation => OpenFailure::Unfinished,
        other => OpenFailure::Transient(format!("{other:?}")),
    }
}

fn event_failure(error: EventOpenOrCreateError) -> OpenFailure {
    use EventOpenError as Open;
    let EventOpenOrCreateError::EventOpenError(open_error) = error else {
        return OpenFailure::Transient(format!("{error:?}"));
    };
    match open_error {
        Open::IncompatibleMessagingPattern
        | Open::IncompatibleAttributes
        | Open::IncompatibleDeadline
        | Open::DoesNotSupportRequestedAmountOfNotifiers
        | Open::DoesNotSupportRequestedAmountOfListeners
        | Open::DoesNotSupportRequestedMaxEventId
        | Open::DoesNotSupportRequestedAmountOfNodes
        | Open::VersionMismatch => OpenFailure::OtherLimits(format!("{open_error:?}")),
        Open::HangsInCreation => OpenFailure::Unfinished,
        other => OpenFailure::Transient(format!("{other:?}")),
    }
}
