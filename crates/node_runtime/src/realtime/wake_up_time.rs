//! What lies between a due time and a running thread: timer slack, and sleep states of the processors.

use std::{
    fs::File,
    io::{Read, Write},
    num::NonZeroU64,
};

use rustix::thread::{current_timer_slack, set_current_timer_slack};

use super::granted::{Grant, Right};

/// Where the kernel takes wishes for short wake-up times; each holds while its file is open.
const CPU_DMA_LATENCY: &str = "/dev/cpu_dma_latency";

/// Asks for a timer slack of the calling thread. Real-time classes have none at all, which the kernel reports as 0.
pub(super) fn ask_timer_slack(slack_ns: u64) -> Grant {
    let asked = format!("{slack_ns} ns");
    let refusal = set_current_timer_slack(NonZeroU64::new(slack_ns)).err();
    match (current_timer_slack(), refusal) {
        (Ok(got_ns), None) if got_ns <= slack_ns => {
            Grant::granted(Right::TimerSlack, asked, format!("{got_ns} ns"))
        }
        (Ok(got_ns), _) => Grant::refused(
            Right::TimerSlack,
            asked,
            format!("{got_ns} ns"),
            "a sandbox forbids prctl(PR_SET_TIMERSLACK); allow it",
        ),
        (Err(error), _) => Grant::refused(
            Right::TimerSlack,
            asked,
            error.to_string(),
            "a sandbox forbids prctl(PR_GET_TIMERSLACK); allow it",
        ),
    }
}

/// Asks that no processor takes longer than `latency_us` to wake up, and reads back what the kernel holds to.
pub(super) fn hold_cpu_dma_latency(latency_us: u32) -> (Grant, Option<File>) {
    let asked = format!("{latency_us} us");
    match hold(latency_us) {
        Ok((file, held_us)) if i64::from(held_us) <= i64::from(latency_us) => {
            (Grant::granted(Right::CpuDmaLatency, asked, format!("{held_us} us held")), Some(file))
        }
        Ok((_, held_us)) => (
            Grant::refused(
                Right::CpuDmaLatency,
                asked,
                format!("{held_us} us held"),
                "the kernel takes the wish and does not follow it; boot with `idle=poll`, or do without",
            ),
            None,
        ),
        Err(error) => (
            Grant::refused(
                Right::CpuDmaLatency,
                asked,
                format!("{CPU_DMA_LATENCY}: {error}"),
                "give this user the device by a udev rule (KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"), \
                 or the container --device /dev/cpu_dma_latency",
            ),
            None,
        ),
    }
}

/// The open file and what the kernel now holds to, µs. Both are 32-bit numbers in the machine's byte order.
fn hold(latency_us: u32) -> std::io::Result<(File, i32)> {
    let mut file = File::options().read(true).write(true).open(CPU_DMA_LATENCY)?;
    file.write_all(&latency_us.to_ne_bytes())?;
    let mut held = [0; 4];
    file.read_exact(&mut held)?;
    Ok((file, i32::from_ne_bytes(held)))
}
