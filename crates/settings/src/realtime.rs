//! What each process asks of the kernel so that it runs when it should.
//!
//! Only what can be judged from the file alone is checked here. Whether the machine has such processors and this user such
//! rights, the process finds out when it asks.

use serde::{Deserialize, Serialize};

use crate::Settings;
use crate::error::{Checked, invalid};

/// Longest spin before a due time, µs: what is spun is taken from every other thread of the processor.
const MAX_SPIN_US: u64 = 1000;
/// Priorities of SCHED_FIFO.
const FIFO_PRIORITIES: std::ops::RangeInclusive<u8> = 1..=99;

/// Scheduling class of a process' control thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SchedulerKind {
    /// The kernel's default, which shares processor time out fairly.
    Other,
    /// SCHED_FIFO: runs before everything of lower priority, for as long as it wants to.
    Fifo,
}

/// How a process waits for its inputs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WaitKind {
    /// Asleep, until its due time or a wake-up.
    #[default]
    Listener,
    /// Awake, looking all the time: takes a whole processor.
    Spin,
}

/// What one process asks for. What is absent is not asked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProcessRealtime {
    /// Scheduling class of the control thread.
    pub scheduler: SchedulerKind,
    /// Priority, 1 (lowest) to 99; with `fifo` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub priority: Option<u8>,
    /// Processors the control thread may run on, counted from 0; empty means all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub processors: Vec<usize>,
    /// Whether all memory is kept in RAM, touched before the loop begins.
    pub lock_memory: bool,
    /// How much later than asked the kernel may wake the thread in order to save wake-ups, ns. Linux takes 50 000 by itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timer_slack_ns: Option<u64>,
    /// Longest time any processor of the machine may take to leave its sleep state, µs; 0 keeps all of them out of it, which
    /// costs power.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_dma_latency_us: Option<u32>,
    /// How long before a due time the thread is awake and reads the clock, µs.
    #[serde(default)]
    pub spin_us: u64,
    /// How it waits.
    #[serde(default)]
    pub wait: WaitKind,
}

/// The table `[realtime]`: one entry per process, each of which may be absent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RealtimeSettings {
    /// Process 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bridge: Option<ProcessRealtime>,
    /// Process 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<ProcessRealtime>,
    /// Process 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nominal: Option<ProcessRealtime>,
    /// Process 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<ProcessRealtime>,
}

impl RealtimeSettings {
    /// Refuses what no machine could grant, or what would stop the machine; periods are those of `settings`.
    pub(crate) fn validate(&self, settings: &Settings) -> Checked {
        let entries = [
            ("bridge", &self.bridge, settings.simulation.step_ms),
            ("estimator", &self.estimator, settings.estimator.heartbeat_ms),
            ("nominal", &self.nominal, settings.nominal.period_ms),
            ("filter", &self.filter, settings.filter.period_ms),
        ];
        for (process, entry, period_ms) in entries {
            if let Some(entry) = entry {
                entry.validate(process, period_ms)?;
            }
        }
        Ok(())
    }
}

impl ProcessRealtime {
    /// Asks for nothing.
    pub const fn nothing() -> Self {
        Self {
            scheduler: SchedulerKind::Other,
            priority: None,
            processors: Vec::new(),
            lock_memory: false,
            timer_slack_ns: None,
            cpu_dma_latency_us: None,
            spin_us: 0,
            wait: WaitKind::Listener,
        }
    }

    fn validate(&self, process: &str, period_ms: u64) -> Checked {
        let require = |holds: bool, key: &str, value: &dyn core::fmt::Debug, requirement| {
            if holds {
                Ok(())
            } else {
                Err(invalid(&format!("realtime.{process}.{key}"), &value, requirement))
            }
        };
        match (self.scheduler, self.priority) {
            (SchedulerKind::Fifo, Some(priority)) => {
                require(FIFO_PRIORITIES.contains(&priority), "priority", &priority, "1 to 99")?;
            }
            (SchedulerKind::Fifo, None) => {
                require(false, "priority", &"", "given with scheduler = \"fifo\": 1 (lowest) to 99")?;
            }
            (SchedulerKind::Other, Some(priority)) => {
                require(false, "priority", &priority, "left out unless scheduler = \"fifo\"")?;
            }
            (SchedulerKind::Other, None) => {}
        }
        require(
            self.scheduler == SchedulerKind::Other || self.wait == WaitKind::Listener,
            "wait",
            &self.wait,
            "\"listener\" with scheduler = \"fifo\": a FIFO thread that never sleeps starves its processor until the kernel \
             stops it for up to 50 ms at a time; spin under scheduler = \"other\", or just before due times with spin_us",
        )?;
        // Less than half a period, so that even a FIFO thread leaves its processor to others for most of the time.
        require(
            self.spin_us <= MAX_SPIN_US && self.spin_us * 2 < period_ms.saturating_mul(1000),
            "spin_us",
            &self.spin_us,
            "at most 1000 and less than half the process' period",
        )?;
        require(
            self.timer_slack_ns != Some(0),
            "timer_slack_ns",
            &0,
            "at least 1, or absent: the kernel takes 0 for its own default",
        )?;
        let latency_us = self.cpu_dma_latency_us.unwrap_or(0);
        require(
            i32::try_from(latency_us).is_ok(),
            "cpu_dma_latency_us",
            &latency_us,
            "at most 2147483647, the kernel's own limit",
        )
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::SettingsError;

    const SHIPPED: &str = include_str!("../../../config/ground_robot.toml");

    /// The shipped file with another table in place of its own `[realtime]`.
    fn parse(table: &str) -> Result<Settings, SettingsError> {
        let (before, rest) = SHIPPED.split_once("[realtime]").expect("the shipped file has the table");
        let after = rest.find("\n[").map_or("", |place| &rest[place..]);
        Settings::parse(&format!("{before}{table}\n{after}"), Path::new("test.toml"), Path::new(""))
    }

    #[test]
    fn without_the_table_nothing_is_asked() {
        assert_eq!(parse("").expect("the table may be absent").realtime, None);
        let realtime = parse("[realtime]").expect("each process may be absent").realtime.expect("a table");
        assert_eq!(realtime, RealtimeSettings { bridge: None, estimator: None, nominal: None, filter: None });
    }

    #[test]
    fn what_is_absent_is_not_asked_for() {
        let settings =
            parse("[realtime]\nfilter = { scheduler = \"other\", lock_memory = false }").expect("valid");
        let filter = settings.realtime.clone().expect("a table").filter.expect("an entry");
        let nothing = ProcessRealtime {
            scheduler: SchedulerKind::Other,
            priority: None,
            processors: Vec::new(),
            lock_memory: false,
            timer_slack_ns: None,
            cpu_dma_latency_us: None,
            spin_us: 0,
            wait: WaitKind::Listener,
        };
        assert_eq!(filter, nothing);
        let again =
            Settings::parse(&settings.to_toml().expect("TOML"), Path::new("test.toml"), Path::new(""));
        assert_eq!(again.expect("its own output is valid"), settings);
    }

    #[test]
    fn every_key_survives_a_round_trip() {
        let settings = parse(
            "[realtime]\nnominal = { scheduler = \"fifo\", priority = 99, processors = [1, 3], lock_memory = true, \
             timer_slack_ns = 1, cpu_dma_latency_us = 20, spin_us = 1000, wait = \"listener\" }",
        )
        .expect("valid");
        let nominal =
            settings.realtime.as_ref().and_then(|realtime| realtime.nominal.clone()).expect("an entry");
        assert_eq!((nominal.priority, nominal.processors.as_slice()), (Some(99), &[1, 3][..]));
        let again =
            Settings::parse(&settings.to_toml().expect("TOML"), Path::new("test.toml"), Path::new(""));
        assert_eq!(again.expect("its own output is valid"), settings);
    }

    #[test]
    fn what_would_stop_the_machine_or_means_nothing_is_refused_with_its_reason() {
        for (process, entry, key, reason) in [
            ("filter", "scheduler = \"fifo\", priority = 80, wait = \"spin\"", "wait", "starves"),
            ("bridge", "scheduler = \"fifo\", priority = 0", "priority", "1 to 99"),
            ("bridge", "scheduler = \"fifo\", priority = 100", "priority", "1 to 99"),
            ("estimator", "scheduler = \"fifo\"", "priority", "given"),
            ("nominal", "scheduler = \"other\", priority = 3", "priority", "left out"),
            ("bridge", "scheduler = \"other\", spin_us = 1001", "spin_us", "1000"),
            ("filter", "scheduler = \"other\", timer_slack_ns = 0", "timer_slack_ns", "default"),
            (
                "filter",
                "scheduler = \"other\", cpu_dma_latency_us = 2147483648",
                "cpu_dma_latency_us",
                "limit",
            ),
        ] {
            let message = parse(&format!("[realtime]\n{process} = {{ {entry}, lock_memory = true }}"))
                .expect_err(entry)
                .to_string();
            assert!(message.contains(&format!("realtime.{process}.{key}")), "{entry}: {message}");
            assert!(message.contains(reason), "{entry}: {message}");
        }
    }

    #[test]
    fn a_spin_of_half_a_period_is_refused() {
        let entry = |spin_us: u64| ProcessRealtime { spin_us, ..ProcessRealtime::nothing() };
        assert!(entry(499).validate("filter", 1).is_ok());
        assert!(entry(500).validate("filter", 1).is_err());
        assert!(entry(1000).validate("filter", 4).is_ok());
    }

    #[test]
    fn an_unknown_key_is_named() {
        let message = parse("[realtime]\nfilter = { scheduler = \"other\", lock_memory = true, nice = -5 }")
            .expect_err("unknown key")
            .to_string();
        assert!(message.contains("nice"), "{message}");
    }
}
