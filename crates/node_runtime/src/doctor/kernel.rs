//! Kernel, clock source, processor frequency and processor share.

use rustix::system::uname;

use super::{Finding, line_of};

const CLOCK_SOURCE: &str = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
const GOVERNOR: &str = "/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";
const CGROUP_QUOTA: &str = "/sys/fs/cgroup/cpu.max";
const WAKE_UP_LATENCY: &str = "/dev/cpu_dma_latency";

pub(super) fn probe() -> Vec<Finding> {
    let name = uname();
    let release = name.release().to_string_lossy().into_owned();
    let version = name.version().to_string_lossy().into_owned();
    let realtime = version.contains("PREEMPT_RT") || line_of("/sys/kernel/realtime").as_deref() == Some("1");
    vec![
        preemption(&release, realtime),
        clock_source(line_of(CLOCK_SOURCE).as_deref()),
        governor(line_of(GOVERNOR).as_deref()),
        wake_up_latency(rustix::fs::access(WAKE_UP_LATENCY, rustix::fs::Access::WRITE_OK).is_ok()),
        cores(std::thread::available_parallelism().map_or(1, std::num::NonZero::get)),
        quota(line_of(CGROUP_QUOTA).as_deref()),
    ]
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

fn governor(governor: Option<&str>) -> Finding {
    match governor {
        Some("performance") => Finding::good("processor frequency governor performance"),
        Some(other) => Finding::note(
            format!("processor frequency governor {other}"),
            "`cpupower frequency-set -g performance` spares the time to speed up after each sleep",
        ),
        None => Finding::good("no processor frequency governor (a virtual machine, or a fixed frequency)"),
    }
}

fn wake_up_latency(writable: bool) -> Finding {
    if writable {
        Finding::good(format!("{WAKE_UP_LATENCY} can be held, which keeps the processor out of deep sleep"))
    } else {
        Finding::note(
            format!("{WAKE_UP_LATENCY} cannot be held"),
            "give this user write access by a udev rule; deep sleep adds up to some 100 µs to a wake-up",
        )
    }
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

/// `text` is `cpu.max` of control groups, version 2: quota and period in µs, or `max`.
fn quota(text: Option<&str>) -> Finding {
    let share = text.and_then(|line| {
        let (quota, period) = line.split_once(' ')?;
        Some(quota.parse::<f64>().ok()? / period.parse::<f64>().ok()?)
    });
    match share {
        Some(share) => Finding::warning(
            format!("a control group stops this program after {share:.1} processors' worth of each period"),
            "remove the CPU limit of the container; a throttled filter sleeps through whole periods",
        ),
        None => Finding::good("no processor quota"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Severity;
    use super::*;

    #[test]
    fn a_quota_is_told_from_none() {
        assert_eq!(quota(Some("max 100000")).severity, Severity::Good);
        assert_eq!(quota(None).severity, Severity::Good);
        let throttled = quota(Some("150000 100000"));
        assert_eq!(throttled.severity, Severity::Warning);
        assert!(throttled.what.contains("1.5"), "{throttled:?}");
    }

    #[test]
    fn slow_clocks_and_governors_are_named() {
        assert_eq!(clock_source(Some("hpet")).severity, Severity::Warning);
        assert_eq!(clock_source(Some("tsc")).severity, Severity::Good);
        assert!(governor(Some("powersave")).what.contains("powersave"));
        assert_eq!(preemption("6.1", true).severity, Severity::Good);
        assert_eq!(preemption("6.1", false).severity, Severity::Note);
    }
}
