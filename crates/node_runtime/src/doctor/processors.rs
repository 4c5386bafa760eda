//! The processors: how many, how fast they change speed and wake up, and with whom they are shared.

use std::path::{Path, PathBuf};

use super::{Finding, line_of, quota};
use crate::realtime::allowed_processors;

const PROCESSORS: &str = "/sys/devices/system/cpu";
const WAKE_UP_LATENCY: &str = "/dev/cpu_dma_latency";
/// Runnable threads per processor, on average, above which a machine counts as busy.
const BUSY: f64 = 0.5;

pub(super) fn probe() -> Vec<Finding> {
    let folder = Path::new(PROCESSORS);
    let device = rustix::fs::access(WAKE_UP_LATENCY, rustix::fs::Access::WRITE_OK).is_ok();
    vec![
        cores(allowed_processors().len()),
        governors(&governor_of_each(folder)),
        threads_per_core(line_of(folder.join("smt/active")).as_deref()),
        isolated(line_of(folder.join("isolated")).as_deref()),
        sleep_states(slowest_wake_up_us(folder), device),
        quota::probe(),
        other_work(line_of("/proc/loadavg").as_deref(), allowed_processors().len()),
    ]
}

fn cores(count: usize) -> Finding {
    if count >= 4 {
        Finding::good(format!("{count} processors for this program"))
    } else {
        Finding::note(
            format!("{count} processors for this program"),
            "the four processes share them; close what else needs time",
        )
    }
}

/// `text` is `/proc/loadavg`: runnable threads on average over a minute come first.
fn other_work(text: Option<&str>, processors: usize) -> Finding {
    match text.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok()) {
        Some(load) if load > BUSY * processors as f64 => Finding::note(
            format!(
                "load average {load:.1} on {processors} processors: this machine is busy with other work"
            ),
            "the lateness below includes it; end that work to see the machine itself",
        ),
        Some(load) => Finding::good(format!("load average {load:.1} on {processors} processors")),
        None => Finding::note("how busy this machine is, is unknown", "mount /proc to have it checked"),
    }
}

/// Frequency governor of every processor that has one.
fn governor_of_each(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| line_of(entry.path().join("cpufreq/scaling_governor"))).collect()
}

fn governors(of_each: &[String]) -> Finding {
    let slow: Vec<_> = of_each.iter().filter(|governor| *governor != "performance").collect();
    match slow.first() {
        None if of_each.is_empty() => {
            Finding::good("no processor frequency governor (a virtual machine, or a fixed frequency)")
        }
        None => Finding::good(format!("frequency governor performance on all {} processors", of_each.len())),
        Some(governor) => Finding::note(
            format!("frequency governor {governor} on {} of {} processors", slow.len(), of_each.len()),
            "`cpupower frequency-set -g performance` spares the time to speed up after each sleep",
        ),
    }
}

fn threads_per_core(active: Option<&str>) -> Finding {
    match active {
        Some("1") => Finding::note(
            "two threads share each core (SMT)",
            "work on the other thread of its core slows the filter by up to half; `echo off > /sys/devices/system/cpu/smt/control`, \
             or keep the sibling of its processor free",
        ),
        Some(_) | None => Finding::good("one thread per core (no SMT)"),
    }
}

fn isolated(list: Option<&str>) -> Finding {
    match list {
        Some("") | None => Finding::note(
            "no processor is kept free of other work",
            "boot with `isolcpus=N nohz_full=N` and name N in `processors` of [realtime], if the robot has processors to spare",
        ),
        Some(list) => {
            Finding::good(format!("processors {list} are kept free; name them in `processors` of [realtime]"))
        }
    }
}

/// Time to leave the deepest sleep state of the first processor, µs, if it has any.
fn slowest_wake_up_us(folder: &Path) -> Option<u64> {
    let states: Vec<PathBuf> =
        std::fs::read_dir(folder.join("cpu0/cpuidle")).ok()?.flatten().map(|entry| entry.path()).collect();
    states.iter().filter_map(|state| line_of(state.join("latency"))?.parse().ok()).max()
}

fn sleep_states(slowest_us: Option<u64>, device: bool) -> Finding {
    let what = match slowest_us {
        Some(slowest_us) => format!("processors take up to {slowest_us} us to leave their deepest sleep"),
        None => "the kernel tells nothing of sleep states".to_owned(),
    };
    if device {
        Finding::good(format!("{what}; {WAKE_UP_LATENCY} can keep them out of it"))
    } else if slowest_us.is_some_and(|slowest_us| slowest_us <= 10) {
        Finding::good(what)
    } else {
        Finding::note(
            format!("{what}; {WAKE_UP_LATENCY} cannot be held"),
            "give this user write access by a udev rule; deep sleep adds up to some 100 us to a wake-up",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;

    #[test]
    fn one_slow_governor_among_fast_ones_is_seen() {
        let all = |governor: &str| vec![governor.to_owned(); 3];
        assert_eq!(governors(&all("performance")).severity, Severity::Good);
        let mixed = [all("performance"), all("powersave")].concat();
        let finding = governors(&mixed);
        assert_eq!(finding.severity, Severity::Note);
        assert!(finding.what.contains("powersave on 3 of 6"), "{finding:?}");
        assert_eq!(governors(&[]).severity, Severity::Good);
    }

    #[test]
    fn shared_cores_and_isolated_ones_are_told() {
        assert_eq!(threads_per_core(Some("1")).severity, Severity::Note);
        assert_eq!(threads_per_core(Some("0")).severity, Severity::Good);
        assert_eq!(isolated(Some("")).severity, Severity::Note);
        assert!(isolated(Some("2-3")).what.contains("2-3"));
    }

    #[test]
    fn a_machine_that_is_busy_already_is_told_so() {
        let busy = other_work(Some("3.56 3.47 3.49 2/310 4711"), 2);
        assert_eq!(busy.severity, Severity::Note);
        assert!(busy.what.contains("load average 3.6 on 2 processors"), "{busy:?}");
        assert_eq!(other_work(Some("0.21 0.30 0.28 1/99 1234"), 2).severity, Severity::Good);
        assert_eq!(other_work(None, 2).severity, Severity::Note);
    }

    #[test]
    fn deep_sleep_matters_where_it_cannot_be_forbidden() {
        assert_eq!(sleep_states(Some(200), false).severity, Severity::Note);
        assert_eq!(sleep_states(Some(200), true).severity, Severity::Good);
        assert_eq!(sleep_states(Some(1), false).severity, Severity::Good);
    }
}
