//! The transport to compare with: the same messages over ROS 2's DDS (ros2-client on RustDDS), on loopback only.
//!
//! A message travels as the bytes it has in shared memory, in a sequence of octets, on the topic
//! `/<domain's prefix>/<instance>/<service>`. Data that arrives wakes the process it is for; beside that a process can only wake
//! itself, from another of its threads.
//! Every port allocates, copies and locks, and RustDDS adds two threads to each process.

mod frame;
mod publisher;
mod quality;
mod subscriber;
mod wake;

use std::{cell::RefCell, fmt, net::Ipv4Addr, sync::Arc};

use messages::{Detections, Message, Obstacles, ProcessId, SafeCommand};
use ros2_client::{
    MessageTypeName, NodeName, NodeOptions,
    dds::{
        Context, Node as RosNode,
        rustdds::{
            DomainParticipantBuilder, Topic,
            mio1::{Interest, Poll, Registry, Token, Waker, event::Source},
        },
    },
};

pub(crate) use self::{publisher::Publisher, subscriber::Subscriber, wake::Listener};
use crate::{Domain, NodeError, services::SHORT_QUEUE};

/// Environment variable of every ROS 2 program.
const DOMAIN_ID_VARIABLE: &str = "ROS_DOMAIN_ID";
/// What readers report as.
const DATA: Token = Token(0);
/// What a wake-up by this process itself reports as.
const OWN: Token = Token(1);
/// Highest domain whose ports exist.
const MAX_DOMAIN_ID: u16 = 232;

/// One process' place in a DDS domain.
pub(crate) struct Participant {
    node: RefCell<RosNode>,
    context: Context,
    /// Begins the names of its topics.
    prefix: String,
    process: ProcessId,
    /// Where the readers that wake this process are registered.
    registry: Registry,
    /// Until the process asks for its listener.
    poll: RefCell<Option<Poll>>,
    own: Arc<Waker>,
}

impl Participant {
    /// Joins the DDS domain that the environment names.
    pub(crate) fn join(domain: &Domain, instance: &str, process: ProcessId) -> Result<Self, NodeError> {
        let failed = |cause: String| NodeError::Participate { cause };
        let participant = DomainParticipantBuilder::new(domain_id()?)
            .with_only_networks([Ipv4Addr::LOCALHOST])
            .build()
            .map_err(|error| failed(error.to_string()))?;
        let context =
            Context::from_domain_participant(participant).map_err(|error| failed(error.to_string()))?;
        // Names in a ROS graph have no hyphen; topics are told apart by the instance as it is.
        let namespace = format!("/{}", instance.replace('-', "_"));
        let name = NodeName::new(&namespace, &format!("cncbf_{process}"))
            .map_err(|error| failed(error.to_string()))?;
        let node = context
            .new_node(name, NodeOptions::new().enable_rosout(false))
            .map_err(|error| failed(error.to_string()))?;
        let poll = Poll::new().map_err(|error| failed(error.to_string()))?;
        let registry = poll.registry().try_clone().map_err(|error| failed(error.to_string()))?;
        let own = Waker::new(&registry, OWN).map_err(|error| failed(error.to_string()))?;
        Ok(Self {
            node: RefCell::new(node),
            context,
            prefix: format!("rt/{}", domain.prefix().trim_end_matches('_')),
            process,
            registry,
            poll: RefCell::new(Some(poll)),
            own: Arc::new(own),
        })
    }

    pub(crate) fn publisher<T: Message>(&self, service: &str) -> Result<Publisher<T>, NodeError> {
        let topic = self.topic::<T>(service)?;
        let quality = quality::of_writer::<T>(SHORT_QUEUE);
        let port = self.node.borrow_mut().create_publisher(&topic, Some(quality));
        Ok(Publisher { port: port.map_err(|error| open_failed(service, &error))? })
    }

    pub(crate) fn subscriber<T: Message>(
        &self,
        service: &str,
        queue_length: usize,
    ) -> Result<Subscriber<T>, NodeError> {
        let topic = self.topic::<T>(service)?;
        let quality = quality::of_reader::<T>(queue_length);
        let port = self.node.borrow_mut().create_subscription(&topic, Some(quality));
        let mut subscriber =
            Subscriber { port: port.map_err(|error| open_failed(service, &error))?, failures: 0 };
        if wakes(T::SERVICE) == Some(self.process) {
            subscriber
                .port
                .register(&self.registry, DATA, Interest::READABLE)
                .map_err(|error| open_failed(service, &error))?;
        }
        Ok(subscriber)
    }

    /// What wakes `of`, where that is this process.
    pub(crate) fn waker(&self, of: ProcessId) -> Option<Arc<Waker>> {
        (of == self.process).then(|| Arc::clone(&self.own))
    }

    pub(crate) fn listener(&self, service: &str) -> Result<Listener, NodeError> {
        let taken = || NodeError::Taken { service: service.to_owned(), role: "listener" };
        let poll = self.poll.borrow_mut().take().ok_or_else(taken)?;
        let registry = self.registry.try_clone().map_err(|error| open_failed(service, &error))?;
        Ok(Listener::new(poll, registry))
    }

    fn topic<T: Message>(&self, service: &str) -> Result<Topic, NodeError> {
        // The version is part of the type, so that DDS matches no reader and writer of two versions.
        let kind = MessageTypeName::new("cncbf", &T::TYPE_NAME.replace('/', "_"));
        self.context
            .create_topic(format!("{}/{service}", self.prefix), kind, &quality::of_writer::<T>(SHORT_QUEUE))
            .map_err(|error| open_failed(service, &error))
    }
}

impl fmt::Debug for Participant {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Participant")
            .field("prefix", &self.prefix)
            .field("process", &self.process)
            .finish_non_exhaustive()
    }
}

fn open_failed(service: &str, error: &impl fmt::Display) -> NodeError {
    NodeError::Open { service: service.to_owned(), cause: format!("DDS: {error}") }
}

/// The domain that the environment names, 0 where it names none.
fn domain_id() -> Result<u16, NodeError> {
    let value = std::env::var_os(DOMAIN_ID_VARIABLE).unwrap_or_default();
    let value = value.to_string_lossy();
    if value.is_empty() {
        return Ok(0);
    }
    value.parse().ok().filter(|id| *id <= MAX_DOMAIN_ID).ok_or_else(|| NodeError::Participate {
        cause: format!("{DOMAIN_ID_VARIABLE}=`{value}` is no number from 0 to {MAX_DOMAIN_ID}"),
    })
}

/// The process that a message on this service wakes.
fn wakes(service: &str) -> Option<ProcessId> {
    [
        (Detections::SERVICE, ProcessId::Estimator),
        (Obstacles::SERVICE, ProcessId::Filter),
        (SafeCommand::SERVICE, ProcessId::Bridge),
    ]
    .into_iter()
    .find_map(|(waking, process)| (waking == service).then_some(process))
}
