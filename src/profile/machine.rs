//! What decides how long things take on this machine.

use latency::Machine;
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

/// Asks the kernel.
pub(super) fn machine() -> Machine {
    let what = RefreshKind::nothing()
        .with_cpu(CpuRefreshKind::nothing())
        .with_memory(MemoryRefreshKind::nothing().with_ram());
    let system = System::new_with_specifics(what);
    let kernel = rustix::system::uname();
    Machine {
        cpu_model: system.cpus().first().map_or_else(|| "unknown".to_owned(), |cpu| cpu.brand().to_owned()),
        cores: std::thread::available_parallelism().map_or(1, |cores| cores.get() as u32),
        kernel: format!("{} {}", kernel.sysname().to_string_lossy(), kernel.release().to_string_lossy()),
        preempt_rt: kernel.version().to_string_lossy().contains("PREEMPT_RT"),
        governor: line_of("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        clock_source: line_of("/sys/devices/system/clocksource/clocksource0/current_clocksource"),
        memory_bytes: system.total_memory(),
    }
}

/// The first line of a small file of the kernel, if it can be read.
fn line_of(path: &str) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().next().map(|line| line.trim().to_owned())
}
