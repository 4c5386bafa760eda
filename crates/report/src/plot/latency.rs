//! Percentile curves of several distributions in one plot: the tail decides, so the axis counts nines.

use latency::Latencies;
use plotters::prelude::*;

use super::axis::Axis;
use super::timeline::{failed, inline};
use super::{Figure, PlotError, Role};

const SIZE: (u32, u32) = (1160, 620);
const FONT: f64 = 29.0;
pub(super) const ROLES: [Role; 5] = [Role::Blue, Role::Orange, Role::Green, Role::Red, Role::Purple];

/// Shortest latency the logarithmic axis shows, µs; shorter ones run along the lower edge.
const SHORTEST_US: f64 = 0.1;

/// Draws up to five percentile curves, each with its name.
pub(crate) fn latency_plot(title: &str, named: &[(&'static str, &Latencies)]) -> Result<Figure, PlotError> {
    let curves: Vec<_> =
        named.iter().zip(ROLES).map(|(&(name, latencies), role)| (name, role, points(latencies))).collect();
    let all = || curves.iter().flat_map(|(_, _, points)| points);
    let nines = all().map(|point| point.0).fold(1.0_f64, f64::max).ceil();
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &(_, value)| {
        (low.min(value), high.max(value))
    });
    let (low, high) =
        if low <= high { (low.floor(), high.ceil().max(low.floor() + 1.0)) } else { (0.0, 1.0) };

    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin_right(50)
            .margin_top(14)
            .x_label_area_size(46)
            .y_label_area_size(120)
            .build_cartesian_2d(Axis::whole(0.0..nines), Axis::whole(low..high))
            .map_err(failed)?;
        let label = ("sans-serif", FONT).into_font().color(&Role::Faint.color());
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(Role::Grid.color().stroke_width(2))
            .axis_style(Role::Grid.color().stroke_width(2))
            .label_style(label)
            .x_labels(20)
            .y_labels(20)
            .x_label_formatter(&|nines| percentile(*nines))
            .y_label_formatter(&|power| duration(*power))
            .draw()
            .map_err(failed)?;
        for (_, role, points) in &curves {
            let path = PathElement::new(points.clone(), role.color().stroke_width(4));
            chart.draw_series((points.len() > 1).then_some(path)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(Figure {
        title: title.to_owned(),
        legend: curves.iter().map(|(name, role, _)| (*role, *name)).collect(),
        svg: inline(&text, SIZE, title, ""),
    })
}

/// `(nines, log10 µs)` along the percentile curve. The last value, the maximum, ends the curve where its share lies.
fn points(latencies: &Latencies) -> Vec<(f64, f64)> {
    let count = latencies.count().max(2) as f64;
    let nines = |quantile: f64| -(1.0 - quantile.min(1.0 - 1.0 / count)).log10();
    latencies.curve().iter().map(|point| (nines(point.quantile), logarithm(point.value_ns))).collect()
}

/// log10 µs.
pub(super) fn logarithm(value_ns: u64) -> f64 {
    (value_ns as f64 / 1e3).max(SHORTEST_US).log10()
}

fn percentile(nines: f64) -> String {
    match nines.round() as i32 {
        0 => "min".to_owned(),
        1 => "90 %".to_owned(),
        2 => "99 %".to_owned(),
        count => format!("99.{} %", "9".repeat((count - 2) as usize)),
    }
}

/// How a power of ten of a microsecond reads.
pub(super) fn duration(power: f64) -> String {
    match power.round() as i32 {
        power @ ..3 => format!("{} µs", 10f64.powi(power)),
        power @ 3..6 => format!("{} ms", 10f64.powi(power - 3)),
        power => format!("{} s", 10f64.powi(power - 6)),
    }
}
