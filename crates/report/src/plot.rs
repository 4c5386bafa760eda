//! The report's plots as inline SVG: which curves they show. How they are drawn lies in the modules below.

mod axis;
mod gantt;
mod latency;
mod over_time;
mod series;
mod timeline;

pub(crate) use axis::{Axis, trimmed};
pub(crate) use gantt::{Gantt, GanttBar, GanttMark};
pub(crate) use latency::latency_plot;
pub(crate) use over_time::{TimedRepeat, latency_over_time};
pub(crate) use series::worst_by_column;
use series::{Curve, curve};
use timeline::TimePlot;
pub(crate) use timeline::failed;

use messages::SafeCommand;

use crate::spans::{Rung, Span};
use crate::theme::Role;
use crate::{RunRecord, words};

/// A plot could not be drawn: an internal inconsistency, since it is drawn into memory.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("plot could not be drawn ({reason}); please report this together with the recording")]
pub struct PlotError {
    /// What plotters said.
    pub reason: String,
}

/// A drawn plot with its caption and legend.
pub(crate) struct Figure {
    pub(crate) title: String,
    pub(crate) legend: Vec<(Role, &'static str)>,
    pub(crate) svg: String,
}

/// Values of h beyond this say "far away" and would flatten what matters, m.
const LARGEST_H_SHOWN_M: f64 = 4.0;

/// All plots over time, in the order they are shown.
pub(crate) fn time_figures(record: &RunRecord, spans: &[Span]) -> Result<Vec<Figure>, PlotError> {
    let kind = record.safe_commands.first().map_or(0, |command| command.control_kind);
    let components = words::control_components(kind);
    let barrier = |pick: fn(&SafeCommand) -> f64| {
        move |command: &SafeCommand| {
            if Rung::of_code(command.status).has_barrier() { pick(command) } else { f64::NAN }
        }
    };
    let drawing = |title: String, unit: &str, largest: f64, curves: Vec<(Role, &'static str, Curve)>| {
        let legend = curves.iter().map(|(role, name, _)| (*role, *name)).collect();
        let curves = curves.iter().map(|(role, _, curve)| (*role, curve)).collect();
        let plot = TimePlot { duration_s: record.duration_s(), spans, unit, largest, curves };
        plot.draw().map(|svg| Figure { title, legend, svg })
    };

    let mut figures = vec![drawing(
        "Barrier h and distance to the nearest obstacle (SDF), m".to_owned(),
        "m",
        LARGEST_H_SHOWN_M,
        vec![
            (Role::Green, "SDF", curve(record, barrier(|command| command.sdf_m))),
            (Role::Blue, "h", curve(record, barrier(|command| command.h_m))),
        ],
    )?];
    for (index, (name, unit)) in components.into_iter().enumerate() {
        let wanted = curve(record, |command| {
            if Rung::of_code(command.status).has_barrier() { command.nominal[index] } else { f64::NAN }
        });
        let sent = curve(record, |command| command.control[index]);
        let mut title = format!("Control: {name}, {unit}");
        title[..1].make_ascii_uppercase();
        let curves = vec![(Role::Grey, "wanted, u_nom", wanted), (Role::Blue, "sent, u", sent)];
        figures.push(drawing(title, unit, f64::INFINITY, curves)?);
    }
    figures.push(drawing(
        "Slack and hard margin of the CBF condition, m/s".to_owned(),
        "m/s",
        LARGEST_H_SHOWN_M,
        vec![
            (
                Role::Purple,
                "hard margin: below zero no admissible control satisfies the condition",
                curve(record, barrier(|command| command.hard_margin_mps)),
            ),
            (Role::Red, "slack", curve(record, barrier(|command| command.slack_mps))),
        ],
    )?);
    Ok(figures)
}
