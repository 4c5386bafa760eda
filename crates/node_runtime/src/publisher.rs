//! The sending end of a service.

use messages::Message;

#[cfg(feature = "dds")]
use crate::dds;
use crate::iceoryx;

/// Why a message was not sent. The next one may pass: keep sending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// No room for the message, though the memory was sized for every subscriber the service admits.
    #[error("no memory left for `{service}`; does a subscriber hold samples without releasing them?")]
    OutOfMemory {
        /// Service without the instance.
        service: &'static str,
    },
    /// At least one subscriber could not be reached; the others were.
    #[error("not every subscriber of `{service}` was reached ({cause}); it reconnects when it restarts")]
    NotDelivered {
        /// Service without the instance.
        service: &'static str,
        /// What the transport says.
        cause: &'static str,
    },
}

/// Sends one type of message on its service. May be moved to another thread.
#[derive(Debug)]
pub struct Publisher<T: Message>(pub(crate) Link<T>);

/// The publisher of one transport.
#[derive(Debug)]
pub(crate) enum Link<T: Message> {
    Iceoryx(iceoryx::Publisher<T>),
    #[cfg(feature = "dds")]
    Dds(Box<dds::Publisher<T>>),
}

impl<T: Message> Publisher<T> {
    /// Hands `message` to every subscriber.
    ///
    /// Never blocks: a subscriber that is slow, stopped or dead loses its oldest sample instead.
    ///
    /// # Errors
    /// [`PortError`]; the publisher stays usable.
    pub fn send(&self, message: &T) -> Result<(), PortError> {
        match &self.0 {
            Link::Iceoryx(publisher) => publisher.send(message),
            #[cfg(feature = "dds")]
            Link::Dds(publisher) => publisher.send(message),
        }
    }

    /// Hands the last message to readers that came since the last sending; they do not get it before.
    ///
    /// Call it a few times a second on a service that is sent rarely, such as [`messages::Goal`]. Over
    /// [`crate::Transport::Dds`] such a service serves them by itself.
    ///
    /// # Errors
    /// [`PortError::NotDelivered`] if a new reader could not be connected.
    pub fn serve_late_joiners(&self) -> Result<(), PortError> {
        match &self.0 {
            Link::Iceoryx(publisher) => publisher.serve_late_joiners(),
            #[cfg(feature = "dds")]
            Link::Dds(_) => Ok(()),
        }
    }
}
