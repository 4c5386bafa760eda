//! The sending end of a service.

use iceoryx2::{
    port::{
        LoanError, SendError, publisher::Publisher as IceoryxPublisher, update_connections::UpdateConnections,
    },
    service::ipc_threadsafe::Service,
};
use messages::Message;

use crate::stillborn::StillbornWatch;

/// Why a message was not sent. The next one may pass: keep sending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PortError {
    /// No room for the message, though the memory was sized for every subscriber the service admits.
    #[error("no shared memory left for `{service}`; does a subscriber hold samples without releasing them?")]
    OutOfMemory {
        /// Service without the instance.
        service: &'static str,
    },
    /// At least one subscriber could not be reached; the others were.
    #[error("not every subscriber of `{service}` was reached ({cause:?}); it reconnects when it restarts")]
    NotDelivered {
        /// Service without the instance.
        service: &'static str,
        /// What iceoryx2 says.
        cause: SendError,
    },
}

/// Sends one type of message on its service. May be moved to another thread.
#[derive(Debug)]
pub struct Publisher<T: Message> {
    pub(crate) port: IceoryxPublisher<Service, T, ()>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(crate) _watch: StillbornWatch,
}

impl<T: Message> Publisher<T> {
    /// Hands `message` to every subscriber.
    ///
    /// Never blocks: a subscriber that is slow, stopped or dead loses its oldest sample instead.
    ///
    /// # Errors
    /// [`PortError`]; the publisher stays usable.
    pub fn send(&self, message: &T) -> Result<(), PortError> {
        let service = T::SERVICE;
        let sample = self.port.loan_uninit().map_err(|error| match error {
            LoanError::OutOfMemory
            | LoanError::ExceedsMaxLoans
            | LoanError::ExceedsMaxLoanSize
            | LoanError::InternalFailure => PortError::OutOfMemory { service },
        })?;
        match sample.write_payload(*message).send() {
            Ok(_receivers) => Ok(()),
            Err(cause) => Err(PortError::NotDelivered { service, cause }),
        }
    }
    /// Hands the last message to readers that came since the last sending; they do not get it before.
    ///
    /// Call it a few times a second on a service that is sent rarely, such as [`messages::Goal`].
    ///
    /// # Errors
    /// [`PortError::NotDelivered`] if a new reader could not be connected.
    pub fn serve_late_joiners(&self) -> Result<(), PortError> {
        self.port.update_connections().map_err(|failure| PortError::NotDelivered {
            service: T::SERVICE,
            cause: SendError::ConnectionError(failure),
        })
    }
}
