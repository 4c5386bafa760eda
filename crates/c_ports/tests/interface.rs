//! The C functions, called as C would: what they hand over, what they refuse, what they allocate.

#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
#![expect(unsafe_code, reason = "the functions take raw pointers")]

use std::{
    ffi::{CStr, CString, c_void},
    ptr::{null, null_mut},
    sync::{Mutex, MutexGuard, PoisonError},
};

use allocation_counter::measure;
use bytemuck::Zeroable;
use cncbf::{
    CNCBF_ABI_VERSION, Node, Nominal, Reader, Result, cncbf_abi_version, cncbf_last_error, cncbf_node_close,
    cncbf_node_open, cncbf_nominal_close, cncbf_nominal_open, cncbf_nominal_send, cncbf_nominal_wait,
    cncbf_now_ns, cncbf_reader_close, cncbf_reader_newest, cncbf_reader_open,
};
use messages::{Goal, Message, NominalCommand, ProcessId, RobotState};
use node_runtime::{Domain, ScopedDomain, members};

const MS: u64 = 1_000_000;

/// The environment names the domain and belongs to the whole process: one test at a time.
fn alone() -> (MutexGuard<'static, ()>, ScopedDomain) {
    static ONE: Mutex<()> = Mutex::new(());
    let guard = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    let domain = ScopedDomain::new();
    // SAFETY: whoever reads the environment holds the guard.
    unsafe { std::env::set_var(Domain::VARIABLE, domain.prefix()) };
    (guard, domain)
}

fn last_error() -> String {
    // SAFETY: the library's own text, copied at once.
    unsafe { CStr::from_ptr(cncbf_last_error()) }.to_str().unwrap().to_owned()
}

fn node(name: &str) -> *mut Node {
    let name = CString::new(name).unwrap();
    let mut node = null_mut();
    // SAFETY: live texts and a live place.
    let result = unsafe { cncbf_node_open(c"robot".as_ptr(), name.as_ptr(), &raw mut node) };
    assert_eq!(result, Result::Ok, "{}", last_error());
    node
}

fn reader<T: Message>(node: *const Node) -> *mut Reader {
    let (name, mut reader) = (CString::new(T::TYPE_NAME).unwrap(), null_mut());
    // SAFETY: a live node, a live text and a live place.
    let result = unsafe { cncbf_reader_open(node, name.as_ptr(), &raw mut reader) };
    assert_eq!(result, Result::Ok, "{}", last_error());
    reader
}

/// The newest message, if one has come.
fn newest<T: Message + Zeroable>(reader: *mut Reader) -> Option<T> {
    let mut message = T::zeroed();
    // SAFETY: a live reader of this type and a live message.
    match unsafe { cncbf_reader_newest(reader, (&raw mut message).cast(), size_of::<T>()) } {
        Result::Ok => Some(message),
        Result::Nothing => None,
        other @ (Result::Taken | Result::Misuse | Result::Failed) => panic!("{other:?}: {}", last_error()),
    }
}

fn place(node: *const Node, patience_ns: u64) -> (Result, *mut Nominal) {
    let mut place = null_mut();
    // SAFETY: a live node and a live place.
    (unsafe { cncbf_nominal_open(node, patience_ns, &raw mut place) }, place)
}

fn command(sequence: u64) -> NominalCommand {
    let mut command = NominalCommand { controller: 1001, ..NominalCommand::zeroed() };
    command.stamp.sequence = sequence;
    command
}

#[test]
fn messages_pass_both_ways_and_a_robot_state_wakes() {
    let (_alone, domain) = alone();
    let bridge = node_runtime::Node::open_in(&domain, "robot", ProcessId::Bridge).unwrap();
    let states = bridge.publisher::<RobotState>().unwrap();
    let waker = bridge.waker(ProcessId::Nominal).unwrap();
    let mut commands = bridge.subscriber::<NominalCommand>().unwrap();
    let node = node("nominal_c");
    let reader = reader::<RobotState>(node);
    let (result, place) = place(node, 0);
    assert_eq!(result, Result::Ok, "{}", last_error());
    assert!(members(&domain).unwrap().iter().any(|member| member.name == "robot/nominal_c"));
    assert_eq!(newest::<RobotState>(reader), None);
    // SAFETY: live handles throughout.
    unsafe {
        assert_eq!(cncbf_nominal_wait(place, cncbf_now_ns() + 5 * MS), Result::Nothing);
        let mut sent = RobotState { heading_rad: 0.5, ..RobotState::zeroed() };
        for sequence in 1..=3 {
            sent.stamp.sequence = sequence;
            states.send(&sent).unwrap();
        }
        waker.wake();
        assert_eq!(cncbf_nominal_wait(place, cncbf_now_ns() + 10_000 * MS), Result::Ok);
        assert_eq!(newest::<RobotState>(reader), Some(sent));
        assert_eq!(newest::<RobotState>(reader), None);
        assert_eq!(cncbf_nominal_send(place, &command(7)), Result::Ok);
        assert_eq!(commands.newest(), Some(command(7)));
        // Readers and the place outlive the node that they came from.
        cncbf_node_close(node);
        assert_eq!(cncbf_nominal_send(place, &command(8)), Result::Ok);
        assert_eq!(commands.newest(), Some(command(8)));
        cncbf_nominal_close(place);
        cncbf_reader_close(reader);
    }
    assert!(!members(&domain).unwrap().iter().any(|member| member.name == "robot/nominal_c"));
}

#[test]
fn the_place_is_one_and_free_again_when_it_is_given_back() {
    let (_alone, _domain) = alone();
    let (first, second) = (node("first"), node("second"));
    let (result, taken) = place(first, 0);
    assert_eq!(result, Result::Ok, "{}", last_error());
    let began_ns = cncbf_now_ns();
    let (result, none) = place(second, 30 * MS);
    assert_eq!((result, none), (Result::Taken, null_mut()));
    assert!(cncbf_now_ns() - began_ns >= 30 * MS && last_error().contains("is taken"), "{}", last_error());
    // SAFETY: a live place.
    unsafe { cncbf_nominal_close(taken) };
    let (result, taken) = place(second, 0);
    assert_eq!(result, Result::Ok, "{}", last_error());
    // SAFETY: live handles.
    unsafe {
        cncbf_nominal_close(taken);
        cncbf_node_close(first);
        cncbf_node_close(second);
    }
}

#[test]
fn misuse_is_refused_and_explained() {
    let (_alone, _domain) = alone();
    let node = node("misuse");
    let reader = reader::<Goal>(node);
    let mut goal = Goal::zeroed();
    let told = |result: Result, what: &str| {
        assert!(result == Result::Misuse && last_error().contains(what), "{result:?}: {}", last_error());
    };
    let name = c"x".as_ptr();
    let mut nobody = std::ptr::dangling_mut::<Node>();
    let mut nothing: *mut Reader = null_mut();
    let place = (&raw mut goal).cast::<c_void>();
    // SAFETY: null pointers are what is tested; the others are alive.
    unsafe {
        told(cncbf_node_open(null(), name, &raw mut nobody), "instance is a null pointer");
        told(cncbf_node_open(name, null(), &raw mut nobody), "name is a null pointer");
        told(cncbf_node_open(name, name, null_mut()), "node is a null pointer");
        told(cncbf_node_open(c"a/b".as_ptr(), name, &raw mut nobody), "cannot name an instance");
        assert!(nobody.is_null(), "a failed call leaves a null pointer");
        told(cncbf_node_open(name, c"a b".as_ptr(), &raw mut nobody), "cannot name a program");
        told(cncbf_node_open(c"\xff".as_ptr(), name, &raw mut nobody), "instance is not text in UTF-8");
        told(cncbf_reader_open(null(), name, &raw mut nothing), "node is a null pointer");
        told(cncbf_reader_open(node, name, &raw mut nothing), "no message of this version is a `x`");
        told(cncbf_reader_open(node, name, null_mut()), "reader is a null pointer");
        told(cncbf_reader_newest(null_mut(), place, size_of::<Goal>()), "reader is a null pointer");
        told(cncbf_reader_newest(reader, null_mut(), size_of::<Goal>()), "message is a null pointer");
        told(cncbf_reader_newest(reader, place, 8), "cncbf/Goal/v1 has 64 bytes, not 8");
        told(cncbf_nominal_open(null(), 0, null_mut()), "node is a null pointer");
        told(cncbf_nominal_open(node, 0, null_mut()), "place is a null pointer");
        told(cncbf_nominal_wait(null_mut(), 0), "place is a null pointer");
        told(cncbf_nominal_send(null_mut(), null()), "place is a null pointer");
        cncbf_node_close(null_mut());
        cncbf_reader_close(null_mut());
        cncbf_nominal_close(null_mut());
        cncbf_reader_close(reader);
        cncbf_node_close(node);
    }
    assert_eq!(cncbf_abi_version(), CNCBF_ABI_VERSION);
}

#[test]
fn reading_waiting_and_sending_allocate_nothing() {
    let (_alone, domain) = alone();
    let bridge = node_runtime::Node::open_in(&domain, "robot", ProcessId::Bridge).unwrap();
    let states = bridge.publisher::<RobotState>().unwrap();
    let mut commands = bridge.subscriber::<NominalCommand>().unwrap();
    let node = node("quiet");
    let reader = reader::<RobotState>(node);
    let (_, place) = place(node, 0);
    let mut round = |sequence| {
        let state = RobotState::zeroed();
        states.send(&state).unwrap();
        measure(|| {
            assert_eq!(newest(reader), Some(state));
            // SAFETY: live handles.
            unsafe {
                cncbf_nominal_wait(place, cncbf_now_ns());
                assert_eq!(cncbf_nominal_send(place, &command(sequence)), Result::Ok);
            }
            assert_eq!(commands.newest(), Some(command(sequence)));
        })
        .count_total
    };
    // Connections are made in the first.
    round(1);
    assert_eq!((2..100).map(&mut round).sum::<u64>(), 0);
    // SAFETY: live handles.
    unsafe {
        cncbf_nominal_close(place);
        cncbf_reader_close(reader);
        cncbf_node_close(node);
    }
}
