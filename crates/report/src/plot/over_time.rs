//! Latencies over time, several repeats in one plot.

use plotters::prelude::*;

use super::axis::{Axis, trimmed};
use super::latency::{ROLES, duration, logarithm};
use super::timeline::{failed, inline};
use super::{Figure, PlotError, Role};

/// Drawn at twice the size it is shown at, because plotters rounds to whole pixels.
const SIZE: (u32, u32) = (2360, 440);
const FONT: f64 = 29.0;
/// Columns in which only the largest value is drawn.
const COLUMNS: usize = 1100;

/// One repeat.
pub(crate) struct TimedRepeat {
    pub(crate) name: &'static str,
    /// Where its time begins, ns.
    pub(crate) start_ns: u64,
    /// `(when, how long)`, ns, in the order of time.
    pub(crate) lengths: Vec<(u64, u64)>,
}

/// Draws the largest value of each column, and a line at `limit_ns` unless that is zero.
pub(crate) fn latency_over_time(
    title: &str,
    repeats: &[TimedRepeat],
    limit_ns: u64,
) -> Result<Figure, PlotError> {
    let seconds = |repeat: &TimedRepeat, at_ns: u64| at_ns.saturating_sub(repeat.start_ns) as f64 / 1e9;
    let end_s = repeats
        .iter()
        .filter_map(|repeat| repeat.lengths.last().map(|last| seconds(repeat, last.0)))
        .fold(1e-3, f64::max);
    let curves: Vec<_> = repeats
        .iter()
        .zip(ROLES)
        .map(|(repeat, role)| {
            let points = repeat.lengths.iter().map(|&(at_ns, length_ns)| (seconds(repeat, at_ns), length_ns));
            (role, repeat.name, largest_by_column(points, end_s))
        })
        .collect();
    let all = curves.iter().flat_map(|(_, _, points)| points).map(|point| point.1);
    let all = all.chain((limit_ns > 0).then(|| logarithm(limit_ns)));
    let (low, high) =
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let (low, high) =
        if low <= high { (low.floor(), high.ceil().max(low.floor() + 1.0)) } else { (0.0, 1.0) };

    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin_right(24)
            .margin_top(14)
            .x_label_area_size(46)
            .y_label_area_size(120)
            .build_cartesian_2d(Axis::round(0.0..end_s, 16), Axis::whole(low..high))
            .map_err(failed)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(Role::Grid.color().stroke_width(2))
            .axis_style(Role::Grid.color().stroke_width(2))
            .label_style(("sans-serif", FONT).into_font().color(&Role::Faint.color()))
            .x_labels(20)
            .y_labels(20)
            .x_label_formatter(&|time_s| format!("{} s", trimmed(*time_s)))
            .y_label_formatter(&|power| duration(*power))
            .draw()
            .map_err(failed)?;
        if limit_ns > 0 {
            let level = logarithm(limit_ns);
            let line = PathElement::new([(0.0, level), (end_s, level)], Role::Faint.color().stroke_width(3));
            chart.draw_series([line]).map_err(failed)?;
        }
        for (role, _, points) in &curves {
            let path = PathElement::new(points.clone(), role.color().stroke_width(2));
            chart.draw_series((points.len() > 1).then_some(path)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Figure {
        title: title.to_owned(),
        legend: curves.iter().map(|(role, name, _)| (*role, *name)).collect(),
        svg: inline(&text, SIZE, title, ""),
    })
}

/// `(s, log10 µs)` of the largest length in each column that has any.
fn largest_by_column(points: impl Iterator<Item = (f64, u64)>, end_s: f64) -> Vec<(f64, f64)> {
    let mut largest: Vec<(usize, f64, u64)> = Vec::new();
    for (at_s, length_ns) in points {
        let column = (at_s / end_s * COLUMNS as f64) as usize;
        match largest.last_mut() {
            Some(last) if last.0 == column => {
                if length_ns > last.2 {
                    *last = (column, at_s, length_ns);
                }
            }
            _ => largest.push((column, at_s, length_ns)),
        }
    }
    largest.into_iter().map(|(_, at_s, length_ns)| (at_s, logarithm(length_ns))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_keeps_its_largest_value_where_it_lies() {
        let points = [(0.0, 1_000), (1e-5, 9_000_000), (2e-5, 2_000), (5.0, 1_000)];
        let found = largest_by_column(points.into_iter(), 10.0);
        assert_eq!(found.len(), 2);
        assert_eq!(found[0], (1e-5, logarithm(9_000_000)));
    }
}
