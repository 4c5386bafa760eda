//! Rights of a real-time process: what its control thread asks of the kernel, and what the kernel really grants.
//!
//! [`enter`] is called once, on the control thread, after everything is constructed and before the loop. Nothing here is
//! needed for a process to work: whatever is refused is said, with advice, and done without. How a loop spends its time, and
//! the settings file itself, live elsewhere.
//!
//! # What holds for whom
//! * SCHED_FIFO, the processors and the timer slack hold for the calling thread. Threads that run already (the watch over
//!   shared memory, a transport's own) stay as they are, and threads and processes that this one starts later begin under the
//!   default scheduler: the class is set with `SCHED_RESET_ON_FORK`. (Processors and timer slack are inherited by them.)
//! * Locked memory holds for the whole process, its shared memory included, and is not inherited by children.
//! * `/dev/cpu_dma_latency` holds for the whole machine, as long as [`Granted`] lives.
//!
//! # A FIFO thread must sleep
//! Linux leaves threads of the default class 5 % of each second (`/proc/sys/kernel/sched_rt_runtime_us`, or the fair server
//! of newer kernels). A FIFO thread that never sleeps is taken off its processor for that long in one piece, 50 ms, which is
//! far worse than what the class was meant to cure. Settings hence refuse a FIFO thread that spins all the time, and bound
//! the spin before due times; a loop that has more to do than its processor can bear is made to pause
//! ([`crate::Pacer::sharing_processor`]).

mod granted;
mod memory;
mod processors;
mod request;
mod rights;
mod scheduler;
mod wake_up_time;

pub use granted::{Grant, Granted, Right};
pub(crate) use processors::allowed as allowed_processors;
pub use request::{Request, Scheduler};
pub(crate) use rights::{can_lock_any_amount, can_set_any_priority};
pub(crate) use scheduler::is_realtime;

/// Asks the kernel for what `request` says, on behalf of the calling thread, and logs once what was granted and what not.
///
/// Keep the result for as long as the loop runs. Takes some milliseconds, and with a locked memory as long as the kernel needs
/// to bring all of it in.
pub fn enter(request: &Request) -> Granted {
    let granted = ask(request);
    granted.log();
    granted
}

/// Asks for what `request` says on a thread of its own, does `work` there with the answers, and gives everything back.
///
/// Memory that the process had locked before stays locked. None if the system refuses a thread or `work` panics.
pub fn try_out<T: Send>(request: &Request, work: impl FnOnce(&[Grant]) -> T + Send) -> Option<T> {
    let locked_before = memory::locked_kib().is_some_and(|kib| kib > 0);
    let outcome = std::thread::scope(|scope| {
        let trial = std::thread::Builder::new().name("cncbf-trial".to_owned());
        let trial = trial.spawn_scoped(scope, || work(ask(request).grants()));
        trial.ok().and_then(|trial| trial.join().ok())
    });
    if request.lock_memory && !locked_before {
        memory::unlock();
    }
    outcome
}

/// Asks without a word. The scheduling class comes last, so that the work before does not run with it.
fn ask(request: &Request) -> Granted {
    let mut grants = Vec::new();
    let mut held = None;
    if !request.processors.is_empty() {
        grants.push(processors::ask(&request.processors));
    }
    if let Some(latency_us) = request.cpu_dma_latency_us {
        let (grant, file) = wake_up_time::hold_cpu_dma_latency(latency_us);
        grants.push(grant);
        held = file;
    }
    if let Some(slack_ns) = request.timer_slack_ns {
        grants.push(wake_up_time::ask_timer_slack(slack_ns));
    }
    if request.lock_memory {
        // Before the lock, which then covers what was touched.
        grants.push(memory::prefault());
        grants.push(memory::lock());
    }
    if let Scheduler::Fifo { priority } = request.scheduler {
        grants.push(scheduler::ask_fifo(priority));
    }
    Granted::new(grants, held)
}
