//! A process' place among the others: opens services and makes ports.
//!
//! All of it is for start-up; nothing here belongs on a control path.

use std::{path::PathBuf, time::Duration};

use iceoryx2::{
    node::{Node as IceoryxNode, NodeBuilder, node_name::NodeName},
    port::{
        listener::ListenerCreateError, publisher::PublisherCreateError, subscriber::SubscriberCreateError,
    },
    prelude::SignalHandlingMode,
    service::{ipc_threadsafe::Service, service_name::ServiceName},
};
use messages::{Message, ProcessId};

use crate::{
    Clock, Domain, DomainError, Publisher, RealClock, Subscriber, WakeUp, Waker,
    clock::nanoseconds,
    domain::quieten,
    leftovers,
    services::{self, OpenFailure},
    stillborn::StillbornWatch,
};

/// How long a port is retried while another process creates, removes or cleans up the same service.
const PATIENCE: Duration = Duration::from_secs(1);
/// Pause between two tries.
const RETRY_PAUSE: Duration = Duration::from_millis(20);
/// Queue of a subscriber that wants the newest few, messages.
const SHORT_QUEUE: usize = 8;

/// Why a node or a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The prefix in the environment is unusable.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The instance name is unusable.
    #[error("`{instance}` cannot name an instance; use 1 to 64 of the characters a-z A-Z 0-9 _ -")]
    InvalidInstance {
        /// The refused name.
        instance: String,
    },
    /// iceoryx2 could not register the process.
    #[error(
        "cannot join shared memory ({cause}); may this user write to /dev/shm and to iceoryx2's folder in /tmp?"
    )]
    Create {
        /// What iceoryx2 says.
        cause: String,
    },
    /// The service exists with another type.
    #[error(
        "`{service}` carries another type than `{expected}`: a process of another version is running; stop it first"
    )]
    OtherType {
        /// Full service name.
        service: String,
        /// The type this version speaks.
        expected: &'static str,
    },
    /// Somebody else created the service with limits that do not fit.
    #[error(
        "`{service}` was created with other limits ({cause}); let a process of the stack create it first"
    )]
    OtherLimits {
        /// Full service name.
        service: String,
        /// What iceoryx2 says.
        cause: String,
    },
    /// All places on the service are taken by living processes.
    #[error(
        "every place for a {role} of `{service}` is taken; is another process doing the same job? (`iox2 service details`)"
    )]
    Taken {
        /// Full service name.
        service: String,
        /// What was asked for: `writer`, `reader`, `listener`, `waker`.
        role: &'static str,
    },
    /// iceoryx2 failed in another way, for the whole time of patience.
    #[error("cannot open `{service}` ({cause}); stop the stack, remove its leftovers and start again")]
    Open {
        /// Full service name.
        service: String,
        /// What iceoryx2 says.
        cause: String,
    },
}

/// One process of one stack. Keep it as long as its ports.
#[derive(Debug)]
pub struct Node {
    membership: IceoryxNode<Service>,
    domain: Domain,
    instance: String,
    process: ProcessId,
    /// Last, so that it still watches while the others are dropped.
    watch: StillbornWatch,
}

impl Node {
    /// Joins the stack `instance` of the domain that the environment names, as `process`.
    ///
    /// What earlier processes left behind when they crashed is removed on the way.
    ///
    /// # Errors
    /// [`NodeError::Domain`], [`NodeError::InvalidInstance`], [`NodeError::Create`].
    pub fn open(instance: &str, process: ProcessId) -> Result<Self, NodeError> {
        Self::open_in(&Domain::from_env()?, instance, process)
    }

    /// [`Self::open`] in a domain given by hand.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_in(domain: &Domain, instance: &str, process: ProcessId) -> Result<Self, NodeError> {
        services::check_instance(instance)?;
        quieten();
        let watch = StillbornWatch::start(domain);
        let create_failed = |cause: String| NodeError::Create { cause };
        let name = NodeName::new(&format!("{instance}/{process}"))
            .map_err(|error| create_failed(format!("{error:?}")))?;
        let membership = NodeBuilder::new()
            .name(&name)
            .config(&domain.config())
            // Signals belong to `Shutdown`.
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Service>()
            .map_err(|error| create_failed(format!("{error:?}")))?;
        let swept = membership.try_cleanup_dead_nodes();
        if swept.failed_cleanups > 0 {
            tracing::warn!(
                failed = swept.failed_cleanups,
                "could not remove what crashed processes left behind"
            );
        }
        Ok(Self { membership, domain: domain.clone(), instance: instance.to_owned(), process, watch })
    }

    /// Which process this is.
    pub const fn process(&self) -> ProcessId {
        self.process
    }

    /// The stack it belongs to.
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// Becomes the writer of `T`'s service, or one of the writers of [`messages::Health`].
    ///
    /// # Errors
    /// [`NodeError::Taken`] while another living process writes the service; also [`NodeError::OtherType`],
    /// [`NodeError::OtherLimits`], [`NodeError::Open`].
    pub fn publisher<T: Message>(&self) -> Result<Publisher<T>, NodeError> {
        let service = services::name::<T>(&self.instance);
        self.patiently(&service, |name| {
            let factory = services::open::<T>(&self.membership, name)?;
            let port = factory.publisher_builder().create().map_err(|error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => OpenFailure::Taken("writer"),
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(Publisher { port, _watch: self.watch.clone() })
        })
    }

    /// Reads `T`'s service with a short queue: for who wants the newest, or the newest few.
    ///
    /// # Errors
    /// As [`Self::publisher`].
    pub fn subscriber<T: Message>(&self) -> Result<Subscriber<T>, NodeError> {
        self.subscriber_with_queue(SHORT_QUEUE)
    }

    /// Reads `T`'s service with the longest queue it has (see `queue_length` in the sources): for recorders.
    ///
    /// # Errors
    /// As [`Self::publisher`].
    pub fn subscriber_all<T: Message>(&self) -> Result<Subscriber<T>, NodeError> {
        self.subscriber_with_queue(services::queue_length::<T>())
    }

    fn subscriber_with_queue<T: Message>(&self, length: usize) -> Result<Subscriber<T>, NodeError> {
        let service = services::name::<T>(&self.instance);
        self.patiently(&service, |name| {
            let factory = services::open::<T>(&self.membership, name)?;
            let port =
                factory.subscriber_builder().buffer_size(length).create().map_err(|error| match error {
                    SubscriberCreateError::ExceedsMaxSupportedSubscribers => OpenFailure::Taken("reader"),
                    other => OpenFailure::Transient(format!("{other:?}")),
                })?;
            Ok(Subscriber { port, failures: 0, _watch: self.watch.clone() })
        })
    }

    /// Becomes able to wake `of`, which need not run yet.
    ///
    /// # Errors
    /// As [`Self::publisher`].
    pub fn waker(&self, of: ProcessId) -> Result<Waker, NodeError> {
        let service = services::wake_name(&self.instance, of);
        self.patiently(&service, |name| {
            let factory = services::open_event(&self.membership, name)?;
            let notifier = factory.notifier_builder().create().map_err(|error| match error {
                iceoryx2::port::notifier::NotifierCreateError::ExceedsMaxSupportedNotifiers => {
                    OpenFailure::Taken("waker")
                }
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(Waker { notifier, _watch: self.watch.clone() })
        })
    }

    /// Becomes this process' listener. There is one: wait on it for all inputs together.
    ///
    /// # Errors
    /// [`NodeError::Taken`] while another living process has the same role in this stack; others as
    /// [`Self::publisher`].
    pub fn wake_up(&self) -> Result<WakeUp, NodeError> {
        let service = services::wake_name(&self.instance, self.process);
        self.patiently(&service, |name| {
            let factory = services::open_event(&self.membership, name)?;
            let listener = factory.listener_builder().create().map_err(|error| match error {
                ListenerCreateError::ExceedsMaxSupportedListeners => OpenFailure::Taken("listener"),
                other => OpenFailure::Transient(format!("{other:?}")),
            })?;
            Ok(WakeUp { listener, _watch: self.watch.clone() })
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
                    self.membership.try_cleanup_dead_nodes();
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
