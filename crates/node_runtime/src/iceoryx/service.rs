//! The variant of iceoryx2 that the stack uses: its `ipc_threadsafe`, except that a loan costs no allocation.
//!
//! Nothing of it shows in shared memory: it meets iceoryx2's own variants, and clients in other languages, on the same services.

use std::fmt::Debug;

use iceoryx2::service::{Service as IceoryxService, internal::ServiceInternal, ipc_threadsafe};
use iceoryx2_bb_elementary_traits::{testing::abandonable::Abandonable, zero_copy_send::ZeroCopySend};

use super::recycled::Recycled;

/// iceoryx2's inter-process communication with ports that may move between threads.
#[derive(Debug, Clone)]
pub(crate) struct Service;

/// What everything but the sharing inside a process is taken from.
type Base = ipc_threadsafe::Service;

impl IceoryxService for Service {
    type StaticStorage = <Base as IceoryxService>::StaticStorage;
    type ConfigSerializer = <Base as IceoryxService>::ConfigSerializer;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <Base as IceoryxService>::PersistentDynamicStorage<T>;
    type Bag = <Base as IceoryxService>::Bag;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> =
        <Base as IceoryxService>::DynamicStorage<T>;
    type ServiceNameHasher = <Base as IceoryxService>::ServiceNameHasher;
    type SharedMemory = <Base as IceoryxService>::SharedMemory;
    type ResizableSharedMemory = <Base as IceoryxService>::ResizableSharedMemory;
    type Connection = <Base as IceoryxService>::Connection;
    type Event = <Base as IceoryxService>::Event;
    type Monitoring = <Base as IceoryxService>::Monitoring;
    type Reactor = <Base as IceoryxService>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> = Recycled<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> =
        <Base as IceoryxService>::BlackboardMgmt<T>;
    type BlackboardPayload = <Base as IceoryxService>::BlackboardPayload;
    type UniqueId = <Base as IceoryxService>::UniqueId;
}

impl ServiceInternal<Self> for Service {}
