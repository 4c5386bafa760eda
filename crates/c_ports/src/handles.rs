//! The functions that C calls, and what their handles hold.

use std::{
    ffi::{c_char, c_void},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use messages::{NominalCommand, ProcessId};
use node_runtime::{Clock, Publisher, RealClock, WakeUp, Woken};

use crate::{
    Result,
    failure::{Failure, answer, quietly, text},
    kind::{AnyReader, Place, reader},
};

/// Version of this interface. It grows with every change that a program compiled against an older header would notice.
pub const CNCBF_ABI_VERSION: u32 = 1;

/// Keeps a membership alive. Locked, because whoever drops it last may be another thread than the one that opens ports.
type Membership = Arc<Mutex<node_runtime::Node>>;

/// Membership of a program in a stack.
#[derive(Debug)]
pub struct Node(Membership);

impl Node {
    fn lock(&self) -> MutexGuard<'_, node_runtime::Node> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads one kind of message.
pub struct Reader {
    // Declared, hence dropped, before the node it belongs to.
    port: Box<dyn AnyReader>,
    _node: Membership,
}

/// The nominal controller's place. Its holder alone writes nominal commands.
#[derive(Debug)]
pub struct Nominal {
    // Dropped in this order: who gets the place finds the wake-up free too.
    wake_up: WakeUp,
    commands: Publisher<NominalCommand>,
    _node: Membership,
}

// What the header promises: a handle may pass from thread to thread.
const fn passes_between_threads<T: Send>() {}
const _: () = {
    passes_between_threads::<Node>();
    passes_between_threads::<Reader>();
    passes_between_threads::<Nominal>();
};

/// The version of this interface that the library has; a program compares it with CNCBF_ABI_VERSION, which its header has.
#[unsafe(no_mangle)]
pub extern "C" fn cncbf_abi_version() -> u32 {
    CNCBF_ABI_VERSION
}

/// The stack clock, CLOCK_MONOTONIC, ns: what stamps are made of.
#[unsafe(no_mangle)]
pub extern "C" fn cncbf_now_ns() -> u64 {
    RealClock.now_ns()
}

/// Joins the stack `instance` ("cncbf" where nobody named it), which need not run yet, as `name`, by which others see this program.
/// Both are 1 to 64 of the characters a-z A-Z 0-9 _ -. The environment variable CNCBF_IPC_PREFIX chooses the group of stacks, as
/// for every process.
///
/// Fills in `node`, which belongs to the caller until cncbf_node_close().
///
/// # Safety
/// The texts are null or end in a zero byte; `node` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_node_open(
    instance: *const c_char,
    name: *const c_char,
    node: *mut *mut Node,
) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let (instance, name) = unsafe { (text("instance", instance)?, text("name", name)?) };
        // SAFETY: as the caller promises.
        let node = unsafe { result_place("node", node) }?;
        let opened = node_runtime::Node::open_as(instance, ProcessId::Nominal, name)?;
        *node = Box::into_raw(Box::new(Node(Arc::new(Mutex::new(opened)))));
        Ok(Result::Ok)
    })
}

/// Gives the membership back. Readers and the place opened from it may live longer. A null pointer is allowed.
///
/// # Safety
/// `node` is null or came from `cncbf_node_open` and has not been closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_node_close(node: *mut Node) {
    // SAFETY: as the caller promises.
    unsafe { close(node) }
}

/// Opens a reader of the messages of `type_name`, a CNCBF_..._TYPE_NAME of cncbf_messages.h. Writers and readers may start in any
/// order.
///
/// Fills in `reader`, which belongs to the caller until cncbf_reader_close().
///
/// # Safety
/// `node` is null or alive; the text is null or ends in a zero byte; `opened` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_reader_open(
    node: *const Node,
    type_name: *const c_char,
    reader: *mut *mut Reader,
) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let node = unsafe { node.as_ref() }.ok_or(Failure::Null("node"))?;
        // SAFETY: as the caller promises.
        let (type_name, opened) = unsafe { (text("type_name", type_name)?, result_place("reader", reader)?) };
        let port = self::reader(&node.lock(), type_name)?;
        *opened = Box::into_raw(Box::new(Reader { port, _node: Arc::clone(&node.0) }));
        Ok(Result::Ok)
    })
}

/// Copies the newest message that has arrived since the last call into `message`, which has `size` bytes: the size of the structure
/// that belongs to the reader's type name. Never waits. CNCBF_RESULT_NOTHING if none has arrived; `message` is left alone then.
///
/// # Safety
/// `reader` is null or alive and used by no other thread now; `message` is null or may be written to for `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_reader_newest(
    reader: *mut Reader,
    message: *mut c_void,
    size: usize,
) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let reader = unsafe { reader.as_mut() }.ok_or(Failure::Null("reader"))?;
        if message.is_null() {
            return Err(Failure::Null("message"));
        }
        let there = reader.port.newest_into(Place { begin: message.cast(), size })?;
        Ok(if there { Result::Ok } else { Result::Nothing })
    })
}

/// Gives a reader back. A null pointer is allowed.
///
/// # Safety
/// `reader` is null or came from `cncbf_reader_open` and has not been closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_reader_close(reader: *mut Reader) {
    // SAFETY: as the caller promises.
    unsafe { close(reader) }
}

/// Takes the nominal controller's place in the stack. One living program has it at a time; who asks while another one has it waits
/// up to `patience_ns` nanoseconds until it is free, and gets CNCBF_RESULT_TAKEN if it is not. Ask again as often as you like: a
/// program that shall follow another one does so between two looks at its own wish to stop.
///
/// Fills in `place`, which belongs to the caller until cncbf_nominal_close(). Close it when the program ends: the place of a
/// program that was killed stays taken for a tenth of a second after somebody else wants it.
///
/// # Safety
/// `node` is null or alive; `place` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_nominal_open(
    node: *const Node,
    patience_ns: u64,
    place: *mut *mut Nominal,
) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let node = unsafe { node.as_ref() }.ok_or(Failure::Null("node"))?;
        // SAFETY: as the caller promises.
        let place = unsafe { result_place("place", place) }?;
        let give_up_ns = RealClock.now_ns().saturating_add(patience_ns);
        let membership = node.lock();
        let commands = membership.publisher_when_free(|| RealClock.now_ns() >= give_up_ns)?;
        let commands = commands.ok_or(Failure::Taken)?;
        let wake_up = membership.wake_up()?;
        *place = Box::into_raw(Box::new(Nominal { wake_up, commands, _node: Arc::clone(&node.0) }));
        Ok(Result::Ok)
    })
}

/// Sleeps until the bridge has sent a robot state, or until the stack clock shows `due_ns`. CNCBF_RESULT_OK: a robot state is there;
/// several since the last call count as one. CNCBF_RESULT_NOTHING: time is up, or a signal came in between.
///
/// # Safety
/// `place` is null or alive and used by no other thread now.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_nominal_wait(place: *mut Nominal, due_ns: u64) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let place = unsafe { place.as_ref() }.ok_or(Failure::Null("place"))?;
        Ok(match place.wake_up.wait_until(due_ns) {
            Woken::Notified => Result::Ok,
            Woken::TimedOut => Result::Nothing,
        })
    })
}

/// Hands a copy of `command` to the filter and to whoever else reads it. Never waits. Stamp it just before.
///
/// # Safety
/// `place` is null or alive and used by no other thread now; `command` is null or can be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_nominal_send(place: *mut Nominal, command: *const NominalCommand) -> Result {
    answer(|| {
        // SAFETY: as the caller promises.
        let place = unsafe { place.as_ref() }.ok_or(Failure::Null("place"))?;
        // SAFETY: as the caller promises; every pattern of bits is a nominal command.
        let command = unsafe { command.as_ref() }.ok_or(Failure::Null("command"))?;
        place.commands.send(command)?;
        Ok(Result::Ok)
    })
}

/// Gives the place back, so that another program can have it. A null pointer is allowed.
///
/// # Safety
/// `place` is null or came from `cncbf_nominal_open` and has not been closed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cncbf_nominal_close(place: *mut Nominal) {
    // SAFETY: as the caller promises.
    unsafe { close(place) }
}

/// Where a handle is to be written; it reads null until then.
///
/// # Safety
/// `place` is null or may be written to for as long as the result lives.
unsafe fn result_place<'a, T>(
    name: &'static str,
    place: *mut *mut T,
) -> std::result::Result<&'a mut *mut T, Failure> {
    if place.is_null() {
        return Err(Failure::Null(name));
    }
    // SAFETY: not null, and as the caller promises. Written before it is borrowed, for it may hold anything.
    unsafe {
        place.write(std::ptr::null_mut());
        Ok(&mut *place)
    }
}

/// Drops what a handle holds.
///
/// # Safety
/// `handle` is null or came from `Box::into_raw` and has not been dropped.
unsafe fn close<T>(handle: *mut T) {
    if !handle.is_null() {
        // SAFETY: as the caller promises.
        let held = unsafe { Box::from_raw(handle) };
        quietly(|| drop(held));
    }
}
