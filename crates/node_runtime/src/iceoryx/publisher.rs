//! The sending end of a service in shared memory.

use iceoryx2::port::{
    LoanError, SendError, publisher::Publisher as IceoryxPublisher, update_connections::UpdateConnections,
};
use messages::Message;

use super::{StillbornWatch, service::Service};
use crate::PortError;

#[derive(Debug)]
pub(crate) struct Publisher<T: Message> {
    pub(super) port: IceoryxPublisher<Service, T, ()>,
    /// Last: iceoryx2 may clean up after the dead while it drops the last port of a process.
    pub(super) _watch: StillbornWatch,
}

impl<T: Message> Publisher<T> {
    pub(crate) fn send(&self, message: &T) -> Result<(), PortError> {
        let service = T::SERVICE;
        let sample = self.port.loan_uninit().map_err(|error| match error {
            LoanError::OutOfMemory
            | LoanError::ExceedsMaxLoans
            | LoanError::ExceedsMaxLoanSize
            | LoanError::InternalFailure => PortError::OutOfMemory { service },
        })?;
        match sample.write_payload(*message).send() {
            Ok(_receivers) => Ok(()),
            Err(error) => Err(PortError::NotDelivered { service, cause: cause(error) }),
        }
    }

    pub(crate) fn serve_late_joiners(&self) -> Result<(), PortError> {
        self.port.update_connections().map_err(|failure| PortError::NotDelivered {
            service: T::SERVICE,
            cause: cause(SendError::ConnectionError(failure)),
        })
    }
}

const fn cause(error: SendError) -> &'static str {
    match error {
        SendError::ConnectionBrokenSinceSenderNoLongerExists => "the publisher is closed",
        SendError::ConnectionCorrupted => "a connection is corrupted",
        SendError::LoanError(_) => "no room for another loan",
        SendError::ConnectionError(_) => "a connection could not be made",
        SendError::UnableToDeliver => "a subscriber's queue refused it",
        SendError::InternalError => "iceoryx2 failed inside",
    }
}
