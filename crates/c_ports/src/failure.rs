//! What a function answers, and the text behind it.

use std::{
    cell::RefCell,
    ffi::{CStr, CString, c_char},
    panic::{AssertUnwindSafe, catch_unwind},
};

use node_runtime::{NodeError, PortError};

/// What a function answers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Result {
    /// Done.
    Ok = 0,
    /// Nothing has arrived; time is up.
    Nothing = 1,
    /// Another living program has the nominal controller's place; time is up.
    Taken = 2,
    /// The call is wrong: a null pointer, an unusable name, an unknown type, another size. cncbf_last_error() says which.
    Misuse = 3,
    /// Shared memory failed. cncbf_last_error() says how, and what to do.
    Failed = 4,
}

/// Why a call did not do what it was asked for.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    #[error("{0} is a null pointer")]
    Null(&'static str),
    #[error("{0} is not text in UTF-8")]
    NoText(&'static str),
    #[error(
        "no message of this version is a `{0}`; use the library and the headers of one version, and a CNCBF_…_TYPE_NAME of theirs"
    )]
    UnknownType(String),
    #[error(
        "a {type_name} has {expected} bytes, not {given}; hand over `&message, sizeof message` of its own structure"
    )]
    OtherSize { type_name: &'static str, expected: usize, given: usize },
    #[error(transparent)]
    Node(#[from] NodeError),
    #[error(transparent)]
    Port(#[from] PortError),
    #[error("the place of the nominal controller is taken; stop the one that commands, and it is free")]
    Taken,
    #[error("a defect of this library: {0}")]
    Panic(String),
}

impl Failure {
    fn result(&self) -> Result {
        match self {
            Self::Null(_)
            | Self::NoText(_)
            | Self::UnknownType(_)
            | Self::OtherSize { .. }
            | Self::Node(NodeError::InvalidInstance { .. } | NodeError::InvalidName { .. }) => Result::Misuse,
            Self::Taken | Self::Node(NodeError::Taken { .. }) => Result::Taken,
            Self::Node(_) | Self::Port(_) | Self::Panic(_) => Result::Failed,
        }
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Why the last call of this thread that answered CNCBF_RESULT_TAKEN, _MISUSE or _FAILED did so: one line in English; empty before
/// the first. Never a null pointer. The text belongs to the library and stands until the next such call of the same thread.
#[unsafe(no_mangle)]
pub extern "C" fn cncbf_last_error() -> *const c_char {
    // A thread that ends has no text any more.
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// Runs the body of a function: keeps the text of a failure, and turns a panic into one.
pub(crate) fn answer(body: impl FnOnce() -> std::result::Result<Result, Failure>) -> Result {
    let outcome = catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<&str>().map(ToString::to_string);
        Err(Failure::Panic(text.or(panic.downcast_ref::<String>().cloned()).unwrap_or_default()))
    });
    outcome.unwrap_or_else(|failure| {
        let text = CString::new(failure.to_string().replace('\0', "?")).unwrap_or_default();
        let _ = LAST.try_with(|last| last.replace(text));
        failure.result()
    })
}

/// Runs a body that cannot fail and answers nothing.
pub(crate) fn quietly(body: impl FnOnce()) {
    answer(|| {
        body();
        Ok(Result::Ok)
    });
}

/// The text of an argument.
///
/// # Safety
/// `text` is null or ends in a zero byte.
pub(crate) unsafe fn text<'a>(
    name: &'static str,
    text: *const c_char,
) -> std::result::Result<&'a str, Failure> {
    if text.is_null() {
        return Err(Failure::Null(name));
    }
    // SAFETY: not null, and the caller promises the end.
    unsafe { CStr::from_ptr(text) }.to_str().map_err(|_| Failure::NoText(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last() -> String {
        // SAFETY: the library's own text, read before the next failure.
        unsafe { text("text", cncbf_last_error()) }.unwrap().to_owned()
    }

    #[test]
    fn a_panic_becomes_an_answer_and_a_text() {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        assert_eq!(answer(|| panic!("broken {}", 7)), Result::Failed);
        std::panic::set_hook(hook);
        assert_eq!(last(), "a defect of this library: broken 7");
    }

    #[test]
    fn each_thread_has_a_text_of_its_own() {
        assert_eq!(answer(|| Err(Failure::Null("node"))), Result::Misuse);
        assert_eq!(std::thread::spawn(last).join().unwrap(), "");
        assert_eq!(last(), "node is a null pointer");
    }
}
