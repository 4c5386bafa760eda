//! The choices whose price a profile shows: how processes wait, what begins a filter cycle, what carries the messages.

use std::os::unix::process::CommandExt;
use std::process::Command;

use anyhow::Context;
use node_runtime::Transport;
use settings::{FilterTrigger, ProcessRealtime, RealtimeSettings, SchedulerKind, Settings, WaitKind};

use crate::cli::{ProfileArgs, TransportName, TriggerName, WaitName};

/// Writes the choices of the command line into the settings.
pub(super) fn apply(args: &ProfileArgs, settings: &mut Settings) {
    if let Some(trigger) = args.trigger {
        settings.filter.trigger = match trigger {
            TriggerName::Timer => FilterTrigger::Timer,
            TriggerName::Event => FilterTrigger::Event,
            TriggerName::Both => FilterTrigger::Both,
        };
    }
    match args.wait {
        Some(WaitName::Spin) => spin(settings),
        Some(WaitName::Listener) => {
            for process in processes(&mut settings.realtime).into_iter().flatten() {
                process.wait = WaitKind::Listener;
            }
        }
        None => {}
    }
}

/// Has every process look all the time. At the default scheduler: a FIFO thread that never sleeps would be stopped by the
/// kernel for tens of milliseconds.
fn spin(settings: &mut Settings) {
    settings.realtime.get_or_insert(RealtimeSettings {
        bridge: None,
        estimator: None,
        nominal: None,
        filter: None,
    });
    for process in processes(&mut settings.realtime) {
        let process = process.get_or_insert(ProcessRealtime::nothing());
        process.scheduler = SchedulerKind::Other;
        process.priority = None;
        process.wait = WaitKind::Spin;
    }
}

fn processes(realtime: &mut Option<RealtimeSettings>) -> Vec<&mut Option<ProcessRealtime>> {
    match realtime {
        Some(RealtimeSettings { bridge, estimator, nominal, filter }) => {
            vec![bridge, estimator, nominal, filter]
        }
        None => Vec::new(),
    }
}

/// How the processes wait, in one word.
pub(super) fn wait_label(settings: &Settings) -> &'static str {
    let mut settings = settings.realtime.clone();
    let processes = processes(&mut settings);
    let spinning = processes
        .iter()
        .filter(|process| process.as_ref().is_some_and(|process| process.wait == WaitKind::Spin));
    match spinning.count() {
        0 => "listener",
        all if all == processes.len() => "spin",
        _ => "mixed",
    }
}

/// What begins a filter cycle, in one word.
pub(super) fn trigger_label(settings: &Settings) -> &'static str {
    match settings.filter.trigger {
        FilterTrigger::Timer => "timer",
        FilterTrigger::Event => "event",
        FilterTrigger::Both => "both",
    }
}

/// What carries the messages. Another transport than that of the environment is put there, for this process and its children
/// alike, by starting this program anew in its own place.
pub(super) fn transport(chosen: Option<TransportName>) -> anyhow::Result<Transport> {
    let current = Transport::from_env()?;
    match chosen.map(TransportName::transport) {
        Some(other) if other != current => {
            let program = std::env::current_exe().context("cannot find this program's own file")?;
            let mut anew = Command::new(program);
            anew.args(std::env::args_os().skip(1)).env(Transport::VARIABLE, other.to_string());
            Err(anew.exec()).context("cannot start this program anew with another transport")
        }
        Some(_) | None => Ok(current),
    }
}
