//! What the processes of a running stack asked of the kernel and were granted, as they tell themselves.

use std::time::Duration;

use messages::{Health, ProcessId};

use crate::{Clock, Domain, Node, NodeError, RealClock, clock::nanoseconds, members, realtime::Right};

/// How long to listen: processes report five times a second.
const PATIENCE: Duration = Duration::from_secs(1);
const PAUSE: Duration = Duration::from_millis(20);
/// The processes that report.
const REPORTING: [ProcessId; 4] =
    [ProcessId::Bridge, ProcessId::Estimator, ProcessId::Nominal, ProcessId::Filter];

/// A process that runs now.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunningProcess {
    /// Which one.
    pub process: ProcessId,
    /// Its operating-system id.
    pub pid: u32,
    /// What it asked for.
    pub asked: Vec<Right>,
    /// What it was granted.
    pub granted: Vec<Right>,
    /// Cycles so far.
    pub cycles: u64,
    /// Due times that passed without a cycle.
    pub missed_deadlines: u64,
    /// Largest lateness so far, ns.
    pub max_lateness_ns: u64,
}

/// Listens to the stack `instance` for a second at most. Empty if none runs.
///
/// # Errors
/// [`NodeError`] if the stack cannot be joined, for example because it is of another version.
pub fn running(domain: &Domain, instance: &str) -> Result<Vec<RunningProcess>, NodeError> {
    let names: Vec<_> = members(domain)
        .unwrap_or_default()
        .into_iter()
        .filter(|member| member.alive)
        .map(|member| member.name)
        .collect();
    let expected =
        REPORTING.iter().filter(|process| names.contains(&format!("{instance}/{process}"))).count();
    if expected == 0 {
        return Ok(Vec::new());
    }
    let node = Node::open_in(domain, instance, ProcessId::Recorder)?;
    let mut reports = node.subscriber_all::<Health>()?;
    let mut found: Vec<RunningProcess> = Vec::new();
    let give_up_ns = RealClock.now_ns() + nanoseconds(PATIENCE);
    while processes(&found) < expected && RealClock.now_ns() < give_up_ns {
        reports.drain(|health| {
            if let Ok(process) = ProcessId::try_from(health.process) {
                // Of one process there may be two: the nominal controller that runs, and one that waits for its place.
                found.retain(|known| known.pid != health.pid);
                found.push(described(process, health));
            }
        });
        std::thread::sleep(PAUSE);
    }
    found.sort_by_key(|process| process.process.code());
    Ok(found)
}

/// How many processes were heard of.
fn processes(found: &[RunningProcess]) -> usize {
    REPORTING.iter().filter(|process| found.iter().any(|known| known.process == **process)).count()
}

fn described(process: ProcessId, health: &Health) -> RunningProcess {
    RunningProcess {
        process,
        pid: health.pid,
        asked: Right::of(health.realtime_asked).collect(),
        granted: Right::of(health.realtime_granted).collect(),
        cycles: health.cycles,
        missed_deadlines: health.missed_deadlines,
        max_lateness_ns: health.max_lateness_ns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HealthReporter, ScopedDomain};
    use messages::RealtimeFlags;

    #[test]
    fn a_running_process_tells_what_it_was_granted() {
        let domain = ScopedDomain::new();
        assert_eq!(running(&domain, "demo").unwrap(), []);
        let node = Node::open_in(&domain, "demo", ProcessId::Filter).unwrap();
        let mut health = HealthReporter::new(&node).unwrap();
        health.realtime(RealtimeFlags::FIFO | RealtimeFlags::TIMER_SLACK, RealtimeFlags::TIMER_SLACK);
        let found = std::thread::scope(|scope| {
            let asking = scope.spawn(|| running(&domain, "demo").unwrap());
            while !asking.is_finished() {
                health.report_now(RealClock.now_ns());
                std::thread::sleep(PAUSE);
            }
            asking.join().unwrap()
        });
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].process, ProcessId::Filter);
        assert_eq!(found[0].pid, std::process::id());
        assert_eq!(found[0].asked, [Right::Fifo, Right::TimerSlack]);
        assert_eq!(found[0].granted, [Right::TimerSlack]);
        assert_eq!(running(&domain, "another").unwrap(), []);
    }
}
