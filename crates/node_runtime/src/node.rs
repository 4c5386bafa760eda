//! A process' place among the others: makes ports.
//!
//! All of it is for start-up; nothing here belongs on a control path.

use messages::{Message, ProcessId};

#[cfg(feature = "dds")]
use crate::dds;
use crate::{
    Domain, DomainError, Publisher, Subscriber, Transport, TransportError, WakeUp, Waker, iceoryx, publisher,
    services::{self, SHORT_QUEUE},
    subscriber, wake,
};

/// Why a node or a port could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The prefix in the environment is unusable.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The environment names a transport that does not exist.
    #[error(transparent)]
    Transport(#[from] TransportError),
    /// The program was built without the transport.
    #[error("this program was built without `{transport}`; build it with the feature `{transport}`")]
    TransportMissing {
        /// What was asked for.
        transport: Transport,
    },
    /// DDS could not register the process.
    #[error("cannot join DDS ({cause}); may this user open UDP sockets on 127.0.0.1?")]
    Participate {
        /// What is wrong.
        cause: String,
    },
    /// The instance name is unusable.
    #[error("`{instance}` cannot name an instance; use 1 to 64 of the characters a-z A-Z 0-9 _ -")]
    InvalidInstance {
        /// The refused name.
        instance: String,
    },
    /// The program's name is unusable.
    #[error("`{name}` cannot name a program; use 1 to 64 of the characters a-z A-Z 0-9 _ -")]
    InvalidName {
        /// The refused name.
        name: String,
    },
    /// iceoryx2 could not register the process.
    #[error(
        "cannot join shared memory ({cause}); it takes a user who may write to /dev/shm and to /tmp/iceoryx2. Where that folder is \
         another user's, run every stack as one user, or have it removed once their stacks have ended"
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
    /// The transport failed in another way, iceoryx2 for the whole time of patience.
    #[error("cannot open `{service}` ({cause}); stop the stack, remove its leftovers and start again")]
    Open {
        /// Full service name.
        service: String,
        /// What the transport says.
        cause: String,
    },
}

/// One process of one stack. Keep it as long as its ports.
#[derive(Debug)]
pub struct Node {
    link: Link,
    instance: String,
    process: ProcessId,
}

/// The membership in one transport.
#[derive(Debug)]
enum Link {
    Iceoryx(iceoryx::Membership),
    #[cfg(feature = "dds")]
    Dds(Box<dds::Participant>),
}

impl Node {
    /// Joins the stack `instance` of the domain that the environment names, over the transport that the environment names,
    /// as `process`.
    ///
    /// What earlier processes left behind in shared memory when they crashed is removed on the way.
    ///
    /// # Errors
    /// [`NodeError::Domain`], [`NodeError::Transport`], and as [`Self::open_over`].
    pub fn open(instance: &str, process: ProcessId) -> Result<Self, NodeError> {
        Self::open_in(&Domain::from_env()?, instance, process)
    }

    /// [`Self::open`] in a domain given by hand.
    ///
    /// # Errors
    /// [`NodeError::Transport`], and as [`Self::open_over`].
    pub fn open_in(domain: &Domain, instance: &str, process: ProcessId) -> Result<Self, NodeError> {
        Self::open_over(Transport::from_env()?, domain, instance, process)
    }

    /// [`Self::open`] over a transport and in a domain given by hand.
    ///
    /// # Errors
    /// [`NodeError::InvalidInstance`], [`NodeError::Create`], [`NodeError::Participate`], [`NodeError::TransportMissing`].
    pub fn open_over(
        transport: Transport,
        domain: &Domain,
        instance: &str,
        process: ProcessId,
    ) -> Result<Self, NodeError> {
        Self::join(transport, domain, instance, process, &process.to_string())
    }

    /// [`Self::open`] for a program that is none of ours and does the work of `process`: others see it as `instance/name`.
    ///
    /// # Errors
    /// [`NodeError::InvalidName`], and as [`Self::open`].
    pub fn open_as(instance: &str, process: ProcessId, name: &str) -> Result<Self, NodeError> {
        services::check_instance(name).map_err(|_| NodeError::InvalidName { name: name.to_owned() })?;
        Self::join(Transport::from_env()?, &Domain::from_env()?, instance, process, name)
    }

    fn join(
        transport: Transport,
        domain: &Domain,
        instance: &str,
        process: ProcessId,
        name: &str,
    ) -> Result<Self, NodeError> {
        services::check_instance(instance)?;
        let link = match transport {
            Transport::Iceoryx2 => {
                Link::Iceoryx(iceoryx::Membership::join(domain, &format!("{instance}/{name}"))?)
            }
            #[cfg(feature = "dds")]
            Transport::Dds => Link::Dds(Box::new(dds::Participant::join(domain, instance, process)?)),
            #[cfg(not(feature = "dds"))]
            Transport::Dds => return Err(NodeError::TransportMissing { transport }),
        };
        Ok(Self { link, instance: instance.to_owned(), process })
    }

    /// Which process this is.
    pub const fn process(&self) -> ProcessId {
        self.process
    }

    /// The stack it belongs to.
    pub fn instance(&self) -> &str {
        &self.instance
    }

    /// Becomes the writer of `T`'s service, or one of the writers of [`messages::Health`] or [`messages::Cycle`].
    ///
    /// # Errors
    /// [`NodeError::Taken`] while another living process writes the service; also [`NodeError::OtherType`],
    /// [`NodeError::OtherLimits`], [`NodeError::Open`].
    pub fn publisher<T: Message>(&self) -> Result<Publisher<T>, NodeError> {
        let service = services::name::<T>(&self.instance);
        Ok(Publisher(match &self.link {
            Link::Iceoryx(membership) => publisher::Link::Iceoryx(membership.publisher(&service)?),
            #[cfg(feature = "dds")]
            Link::Dds(participant) => publisher::Link::Dds(Box::new(participant.publisher(&service)?)),
        }))
    }

    /// [`Self::publisher`] for who follows another writer: waits until the place is free, and asks `give_up` every few
    /// milliseconds whether to go on. `None` if not.
    ///
    /// The place of a writer that was killed is free within a tenth of a second.
    ///
    /// # Errors
    /// As [`Self::publisher`], but never [`NodeError::Taken`].
    pub fn publisher_when_free<T: Message>(
        &self,
        give_up: impl FnMut() -> bool,
    ) -> Result<Option<Publisher<T>>, NodeError> {
        let service = services::name::<T>(&self.instance);
        Ok(match &self.link {
            Link::Iceoryx(membership) => {
                let port = membership.publisher_when_free(&service, give_up)?;
                port.map(|port| Publisher(publisher::Link::Iceoryx(port)))
            }
            // Nothing there keeps a second writer out.
            #[cfg(feature = "dds")]
            Link::Dds(participant) => {
                Some(Publisher(publisher::Link::Dds(Box::new(participant.publisher(&service)?))))
            }
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
        Ok(Subscriber(match &self.link {
            Link::Iceoryx(membership) => subscriber::Link::Iceoryx(membership.subscriber(&service, length)?),
            #[cfg(feature = "dds")]
            Link::Dds(participant) => {
                subscriber::Link::Dds(Box::new(participant.subscriber(&service, length)?))
            }
        }))
    }

    /// Becomes able to wake `of`, which need not run yet.
    ///
    /// # Errors
    /// As [`Self::publisher`].
    pub fn waker(&self, of: ProcessId) -> Result<Waker, NodeError> {
        Ok(Waker(match &self.link {
            Link::Iceoryx(membership) => {
                wake::Notifier::Iceoryx(Box::new(membership.waker(&services::wake_name(&self.instance, of))?))
            }
            #[cfg(feature = "dds")]
            Link::Dds(participant) => wake::Notifier::Dds(participant.waker(of)),
        }))
    }

    /// Becomes this process' listener. There is one: wait on it for all inputs together.
    ///
    /// # Errors
    /// [`NodeError::Taken`] while another living process has the same role in this stack; others as
    /// [`Self::publisher`].
    pub fn wake_up(&self) -> Result<WakeUp, NodeError> {
        let service = services::wake_name(&self.instance, self.process);
        Ok(WakeUp(match &self.link {
            Link::Iceoryx(membership) => wake::Listener::Iceoryx(Box::new(membership.listener(&service)?)),
            #[cfg(feature = "dds")]
            Link::Dds(participant) => wake::Listener::Dds(participant.listener(&service)?),
        }))
    }
}
