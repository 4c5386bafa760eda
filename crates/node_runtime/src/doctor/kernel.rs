//! The kernel: preemption, clock, throttling of real-time threads, and what it does with memory behind a program's back.

use rustix::{system::uname, thread::current_timer_slack};

use super::{Finding, line_of};

const CLOCK_SOURCE: &str = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
const RT_RUNTIME: &str = "/proc/sys/kernel/sched_rt_runtime_us";
const RT_PERIOD: &str = "/proc/sys/kernel/sched_rt_period_us";
const HUGE_PAGES: &str = "/sys/kernel/mm/transparent_hugepage/enabled";

pub(super) fn probe() -> Vec<Finding> {
    let release = uname().release().to_string_lossy().into_owned();
    vec![
        preemption(&release, is_realtime()),
        host(is_virtual()),
        clock_source(line_of(CLOCK_SOURCE).as_deref()),
        throttling(line_of(RT_RUNTIME).as_deref(), line_of(RT_PERIOD).as_deref()),
        timer_slack(current_timer_slack().ok()),
        huge_pages(line_of(HUGE_PAGES).as_deref()),
        swap(std::fs::read_to_string("/proc/swaps").ok().as_deref()),
    ]
}

/// Whether the kernel is fully preemptible.
pub(super) fn is_realtime() -> bool {
    uname().version().to_string_lossy().contains("PREEMPT_RT")
        || line_of("/sys/kernel/realtime").as_deref() == Some("1")
}

/// Whether the machine is somebody else's guest, as far as it says so.
pub(super) fn is_virtual() -> bool {
    let flags = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    flags.split_whitespace().any(|flag| flag == "hypervisor")
        || std::path::Path::new("/sys/hypervisor/type").exists()
}

fn preemption(release: &str, realtime: bool) -> Finding {
    if realtime {
        Finding::good(format!("kernel {release} with PREEMPT_RT"))
    } else {
        Finding::note(
            format!("kernel {release} without PREEMPT_RT"),
            "expect rare wake-ups that are milliseconds late; boot a PREEMPT_RT kernel on the robot",
        )
    }
}

fn host(guest: bool) -> Finding {
    if guest {
        Finding::note(
            "this is a virtual machine",
            "its host may stop it at any time, which no setting in here prevents; drive a robot from real hardware",
        )
    } else {
        Finding::good("no sign of a virtual machine")
    }
}

fn clock_source(source: Option<&str>) -> Finding {
    match source {
        Some(fast @ ("tsc" | "arch_sys_counter" | "kvm-clock" | "hyperv_clocksource_tsc_page")) => {
            Finding::good(format!("clock source {fast}, read without a system call"))
        }
        Some(slow) => Finding::warning(
            format!("clock source {slow} needs a system call, about a microsecond, for every reading"),
            "choose tsc in /sys/devices/system/clocksource, or boot with `clocksource=tsc tsc=reliable`",
        ),
        None => Finding::note("the clock source is unknown", "mount /sys to have it checked"),
    }
}

/// `runtime` and `period` in µs; a runtime of -1 lets real-time threads take everything.
fn throttling(runtime: Option<&str>, period: Option<&str>) -> Finding {
    let number = |text: Option<&str>| text?.parse::<f64>().ok();
    match (number(runtime), number(period)) {
        (Some(runtime_us), Some(period_us)) if runtime_us >= 0.0 && period_us > 0.0 => {
            let share = 100.0 - 100.0 * runtime_us / period_us;
            Finding::good(format!(
                "real-time threads leave others {share:.0} % of a processor, so that one that never sleeps cannot freeze the machine"
            ))
        }
        (Some(_), _) => Finding::note(
            "real-time threads may take all of a processor (sched_rt_runtime_us is -1)",
            "one that never sleeps freezes its processor; `sysctl kernel.sched_rt_runtime_us=950000` keeps a way in",
        ),
        (None, _) => {
            Finding::note("the throttling of real-time threads is unknown", "mount /proc to have it checked")
        }
    }
}

fn timer_slack(slack_ns: Option<u64>) -> Finding {
    match slack_ns {
        Some(slack_ns) if slack_ns <= 1000 => Finding::good(format!("timer slack {slack_ns} ns")),
        Some(slack_ns) => Finding::note(
            format!("timer slack {} us: sleeps end up to that much later than asked", slack_ns / 1000),
            "`timer_slack_ns = 1` in [realtime], which needs no rights and real-time classes imply",
        ),
        None => Finding::note("the timer slack is unknown", "a sandbox forbids prctl; allow it"),
    }
}

fn huge_pages(mode: Option<&str>) -> Finding {
    match mode {
        Some(mode) if mode.contains("[always]") => Finding::note(
            "transparent huge pages for every program",
            "the kernel may stop a thread to put pages together; `echo madvise > /sys/kernel/mm/transparent_hugepage/enabled`",
        ),
        Some(_) => Finding::good("transparent huge pages only for programs that ask"),
        None => Finding::good("no transparent huge pages"),
    }
}

/// `text` is `/proc/swaps`: a heading, then one line for each swap space.
fn swap(text: Option<&str>) -> Finding {
    match text.map(|text| text.lines().skip(1).count()) {
        Some(0) | None => Finding::good("no swap"),
        Some(spaces) => Finding::note(
            format!("{spaces} swap spaces: memory that is not locked may be on a disk when it is needed"),
            "`lock_memory = true` in [realtime], or `swapoff -a` on the robot",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;

    #[test]
    fn what_spoils_real_time_is_named() {
        assert_eq!(clock_source(Some("hpet")).severity, Severity::Warning);
        assert_eq!(clock_source(Some("tsc")).severity, Severity::Good);
        assert_eq!(preemption("6.1", true).severity, Severity::Good);
        assert_eq!(preemption("6.1", false).severity, Severity::Note);
        assert_eq!(host(true).severity, Severity::Note);
        assert!(timer_slack(Some(50_000)).what.contains("50 us"));
        assert_eq!(timer_slack(Some(0)).severity, Severity::Good);
        assert_eq!(huge_pages(Some("[always] madvise never")).severity, Severity::Note);
        assert_eq!(huge_pages(Some("always [madvise] never")).severity, Severity::Good);
    }

    #[test]
    fn throttling_is_told_as_a_share() {
        assert!(throttling(Some("950000"), Some("1000000")).what.contains("others 5 %"));
        assert_eq!(throttling(Some("-1"), Some("1000000")).severity, Severity::Note);
        assert_eq!(throttling(None, None).severity, Severity::Note);
    }

    #[test]
    fn swap_is_told_from_none() {
        let heading = "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n";
        assert_eq!(swap(Some(heading)).severity, Severity::Good);
        assert_eq!(swap(Some(&format!("{heading}/dev/sda2 partition 1 0 -2\n"))).severity, Severity::Note);
    }
}
