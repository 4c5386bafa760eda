//! What a loop has to say to people, said by somebody else: a log line may wait for a disk or a terminal.

use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};

use messages::Reason;

/// How often the thread looks whether something changed. A state shorter than this may go unsaid; the counters of
/// [`messages::Health`] miss none.
const LOOK_PERIOD: Duration = Duration::from_millis(50);

/// A process' present state as one [`Reason`], told to the log by a thread of its own whenever it changes.
///
/// Posting neither blocks nor allocates.
#[derive(Debug)]
pub struct Notices {
    board: Arc<Board>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Board {
    reason: AtomicU32,
    stop: AtomicBool,
}

impl Notices {
    /// Begins with [`Reason::None`]; `say` logs every change. Where the system refuses a thread, nothing is said.
    pub fn start(say: fn(Reason)) -> Self {
        let board =
            Arc::new(Board { reason: AtomicU32::new(Reason::None.code()), stop: AtomicBool::new(false) });
        let (watched, span) = (Arc::clone(&board), tracing::Span::current());
        let thread = std::thread::Builder::new()
            .name("cncbf-notices".to_owned())
            .spawn(move || span.in_scope(|| watched.tell(say)));
        if let Err(error) = &thread {
            tracing::warn!(%error, "changes of state will not be logged");
        }
        Self { board, thread: thread.ok() }
    }

    /// Says how things stand now.
    pub fn post(&self, reason: Reason) {
        self.board.reason.store(reason.code(), Ordering::Relaxed);
    }
}

impl Board {
    fn tell(&self, say: fn(Reason)) {
        let mut told = Reason::None;
        loop {
            // Looked at before the state: what was posted before the stop is still said.
            let last = self.stop.load(Ordering::Acquire);
            let posted = Reason::try_from(self.reason.load(Ordering::Relaxed)).unwrap_or(told);
            if posted != told {
                say(posted);
                told = posted;
            }
            if last {
                return;
            }
            std::thread::park_timeout(LOOK_PERIOD);
        }
    }
}

impl Drop for Notices {
    fn drop(&mut self) {
        self.board.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.thread().unpark();
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    static SAID: Mutex<Vec<Reason>> = Mutex::new(Vec::new());

    #[test]
    fn a_change_is_said_once_and_the_last_one_even_at_the_end() {
        let notices = Notices::start(|reason| SAID.lock().unwrap().push(reason));
        notices.post(Reason::None);
        drop(notices);
        assert_eq!(*SAID.lock().unwrap(), []);
        let notices = Notices::start(|reason| SAID.lock().unwrap().push(reason));
        notices.post(Reason::NoGoal);
        notices.post(Reason::SolverFailed);
        drop(notices);
        assert_eq!(SAID.lock().unwrap().last(), Some(&Reason::SolverFailed));
    }
}
