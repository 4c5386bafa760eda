//! The transport that the stack is built on: iceoryx2's shared memory.
//!
//! Only this folder and the removal of leftovers know iceoryx2.

mod publisher;
mod recycled;
mod service;
mod services;
mod stillborn;
mod subscriber;
mod wake;

use std::{path::PathBuf, time::Duration};

use iceoryx2::{
    node::{Node as IceoryxNode, NodeBuilder, node_name::NodeName},
    port::{
        listener::ListenerCreateError, notifier::NotifierCreateError, publisher::PublisherCreateError,
        subscriber::SubscriberCreateError,
    },
    prelude::{PortFactory, SignalHandlingMode},
    service::service_name::ServiceName,
};
use messages::Message;

pub(crate) use self::{
    publisher::Publisher,
    stillborn::StillbornWatch,
    subscriber::Subscriber,
    wake::{Listener, Waker},
};
use self::{service::Service, services::OpenFailure};
use crate::{Clock, Domain, NodeError, RealClock, clock::nanoseconds, domain::quieten, leftovers};

/// How long a port is retried while another process creates, removes or cleans up the same service.
const PATIENCE: Duration = Duration::from_secs(1);
/// Pause between two tries.
const RETRY_PAUSE: Duration = Duration::from_millis(20);
/// Pause between two looks whether a writer has left. A change of controllers takes no longer than this, the one's farewell and
/// the other's first command.
const PLACE_PAUSE: Duration = Duration::from_millis(2);
/// Pause between two looks whether the writer was killed: each lists every process of the domain.
const SWEEP_PAUSE: Duration = Duration::from_millis(40);

/// One process' place in a domain of shared memory.
#[derive(Debug)]
pub(crate) struct Membership {
    node: IceoryxNode<Service>,
    domain: Domain,
    /// Last, so that it still watches while the others are dropped.
    watch: StillbornWatch,
}

impl Membership {
    /// Joins `domain` as `name`, and removes what crashed processes left behind there.
    pub(crate) fn join(domain: &Domain, name: &str) -> Result<Self, NodeError> {
        quieten();
        let watch = StillbornWatch::start(domain);
        let create_failed = |cause: String| NodeError::Create { cause };
        let name = NodeName::new(name).map_err(|error| create_failed(format!("{error:?}")))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&domain.config())
            // Signals belong to `Shutdown`.
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|error| create_failed(format!("{error:?}")))?;
        let swept = node.try_cleanup_dead_nodes();
        if swept.failed_cleanups > 0 {
            tracing::warn!(
                failed = swept.failed_cleanups,
                "could not remove what crashed processes left behind"
            );
        }
        Ok(Self { node, domain: domain.clone(), watch })
    }

    pub(crate) fn publisher<T: Message>(&self, service: &str) -> Result<Publisher<T>, NodeError> {
        self.patiently(service, |name| {
            let factory = services::open::<T>(&self.node, name)?;
            let port = factory.publisher_builder().create().map_err(|error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => OpenFailure::Taken("writer"),
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(Publisher { port, _watch: self.watch.clone() })
        })
    }

    /// The place of `service`'s writer once it is free; `None` if `give_up` says so first.
    pub(crate) fn publisher_when_free<T: Message>(
        &self,
        service: &str,
        mut give_up: impl FnMut() -> bool,
    ) -> Result<Option<Publisher<T>>, NodeError> {
        // Kept open, so that a look costs no system call.
        let factory = self.patiently(service, |name| services::open::<T>(&self.node, name))?;
        let mut swept_ns = RealClock.now_ns();
        loop {
            if factory.dynamic_config().number_of_publishers() < services::max_publishers::<T>() {
                match self.publisher(service) {
                    // Another one who waited was faster.
                    Err(NodeError::Taken { .. }) => {}
                    other => return other.map(Some),
                }
            }
            if give_up() {
                return Ok(None);
            }
            let now_ns = RealClock.now_ns();
            if now_ns - swept_ns >= nanoseconds(SWEEP_PAUSE) {
                swept_ns = now_ns;
                self.node.try_cleanup_dead_nodes();
            }
            std::thread::sleep(PLACE_PAUSE);
        }
    }

    pub(crate) fn subscriber<T: Message>(
        &self,
        service: &str,
        queue_length: usize,
    ) -> Result<Subscriber<T>, NodeError> {
        self.patiently(service, |name| {
            let factory = services::open::<T>(&self.node, name)?;
            let port =
                factory.subscriber_builder().buffer_size(queue_length).create().map_err(
                    |error| match error {
                        SubscriberCreateError::ExceedsMaxSupportedSubscribers => OpenFailure::Taken("reader"),
                        other => OpenFailure::Transient(format!("{other:?}")),
                    },
                )?;
            Ok(Subscriber { port, failures: 0, _watch: self.watch.clone() })
        })
    }

    pub(crate) fn waker(&self, service: &str) -> Result<Waker, NodeError> {
        self.patiently(service, |name| {
            let factory = services::open_event(&self.node, name)?;
            let port = factory.notifier_builder().create().map_err(|error| match error {
                NotifierCreateError::ExceedsMaxSupportedNotifiers => OpenFailure::Taken("waker"),
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(Waker { port, _watch: self.watch.clone() })
        })
    }

    pub(crate) fn listener(&self, service: &str) -> Result<Listener, NodeError> {
        self.patiently(service, |name| {
            let factory = services::open_event(&self.node, name)?;
            let port = factory.listener_builder().create().map_err(|error| match error {
                ListenerCreateError::ExceedsMaxSupportedListeners => OpenFailure::Taken("listener"),
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(Listener { port, _watch: self.watch.clone() })
        })
    }

    /// Retries what another process' start, end or crash may have disturbed.
    fn patiently<P>(
        &self,
        service: &str,
        attempt: impl Fn(&ServiceName) -> Result<P, OpenFailure>,
    ) -> Result<P, NodeError> {
        let name = ServiceName::new(service)
            .map_err(|error| NodeError::Open { service: service.to_owned(), cause: format!("{error:?}") })?;
        let give_up_ns = RealClock.now_ns() + nanoseconds(PATIENCE);
        let mut stillborn = Stillborn::default();
        loop {
            let failure = match attempt(&name) {
                Ok(port) => return Ok(port),
                Err(failure) => failure,
            };
            let service = service.to_owned();
            let exhausted = RealClock.now_ns() >= give_up_ns;
            match failure {
                OpenFailure::OtherType(expected) => return Err(NodeError::OtherType { service, expected }),
                OpenFailure::OtherLimits(cause) => return Err(NodeError::OtherLimits { service, cause }),
                OpenFailure::Unfinished if stillborn.bury(&self.domain) => {}
                OpenFailure::Unfinished => {
                    return Err(NodeError::Open { service, cause: "its creation does not end".to_owned() });
                }
                OpenFailure::Taken(role) if exhausted => return Err(NodeError::Taken { service, role }),
                OpenFailure::Transient(cause) if exhausted => return Err(NodeError::Open { service, cause }),
                OpenFailure::Taken(_) | OpenFailure::Transient(_) => {
                    self.node.try_cleanup_dead_nodes();
                    std::thread::sleep(RETRY_PAUSE);
                }
            }
        }
    }
}

/// Services whose creators were killed in the middle, which nobody could open or create any more.
///
/// Creation takes milliseconds and iceoryx2 waits a second for it before it reports one as unfinished. What is still
/// unfinished at the next such report, another second later, has no living creator.
#[derive(Default)]
struct Stillborn {
    suspects: Option<Vec<PathBuf>>,
}

impl Stillborn {
    /// Removes what was unfinished at the last report and still is. False once that has been tried in vain.
    fn bury(&mut self, domain: &Domain) -> bool {
        let unfinished = leftovers::unfinished_services(domain);
        let Some(suspects) = &mut self.suspects else {
            self.suspects = Some(unfinished);
            return true;
        };
        let dead: Vec<_> = suspects.extract_if(.., |path| unfinished.contains(path)).collect();
        for path in &dead {
            tracing::warn!(path = %path.display(), "removing a service whose creator was killed");
            if let Err(error) = leftovers::remove(path) {
                tracing::warn!(%error);
            }
        }
        !dead.is_empty()
    }
}
