//! The message that makes the hop.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;
use messages::{Message, Obstacles};

/// 2 KiB. It travels on a service whose messages wake the filter over every transport.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("cncbf/Hop/v1")]
pub(crate) struct Hop {
    /// When it was handed to the transport, ns.
    pub(crate) sent_ns: u64,
    /// Whether it counts: 0 while the way warms up.
    pub(crate) counts: u64,
    pub(crate) rest: [u64; 254],
}

impl Message for Hop {
    const SERVICE: &'static str = Obstacles::SERVICE;
    const TYPE_NAME: &'static str = "cncbf/Hop/v1";
}

/// Where a message is handed over.
pub(crate) trait Sending {
    fn send(&mut self, message: &Hop) -> Result<(), crate::Failure>;
}

/// Where it arrives.
pub(crate) trait Receiving {
    /// Sleeps until the next message, or for a second.
    fn wait(&mut self) -> Result<Option<Hop>, crate::Failure>;
}
