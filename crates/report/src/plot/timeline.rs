//! One plot over time: curves, the zero line, and shades where the filter was not simply filtering.

use core::fmt::Display;
use core::ops::Range;

use plotters::prelude::*;

use super::axis::{Axis, trimmed};
use super::series::{COLUMNS, Curve, worst_by_column};
use super::{PlotError, Role};
use crate::spans::{Rung, Span};
use crate::theme::rung_role;

/// Drawn at twice the size it is shown at, because plotters rounds to whole pixels.
const SIZE: (u32, u32) = (2360, 400);
const FONT: f64 = 29.0;

/// What to draw.
pub(super) struct TimePlot<'a> {
    pub(super) duration_s: f64,
    pub(super) spans: &'a [Span],
    /// Unit of the values.
    pub(super) unit: &'a str,
    /// Values beyond, up or down, run along the edge.
    pub(super) largest: f64,
    pub(super) curves: Vec<(Role, &'a Curve)>,
}

/// Lets `?` take every error of plotters, whatever it is generic over.
pub(crate) fn failed(error: impl Display) -> PlotError {
    PlotError { reason: error.to_string() }
}

impl TimePlot<'_> {
    pub(super) fn draw(&self) -> Result<String, PlotError> {
        let end_s = self.duration_s.max(1e-3);
        let values = self.value_range();
        let mut text = String::new();
        let pixels;
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            let mut chart = ChartBuilder::on(&root)
                .margin_right(24)
                .margin_top(14)
                .x_label_area_size(46)
                .y_label_area_size(96)
                .build_cartesian_2d(Axis::round(0.0..end_s, 16), Axis::round(values.clone(), 5))
                .map_err(failed)?;
            pixels = chart.plotting_area().get_pixel_range();
            chart
                .draw_series(worst_by_column(self.spans, end_s, COLUMNS).into_iter().filter_map(|span| {
                    let shade = match span.rung {
                        Rung::Filtered => return None,
                        Rung::Relaxed | Rung::Braking | Rung::Stopped | Rung::Silent => {
                            rung_role(span.rung).color()
                        }
                    };
                    let corners = [(span.start_s, values.start), (span.end_s, values.end)];
                    Some(Rectangle::new(corners, shade.mix(0.22).filled()))
                }))
                .map_err(failed)?;
            let label = ("sans-serif", FONT).into_font().color(&Role::Faint.color());
            chart
                .configure_mesh()
                .disable_x_mesh()
                .light_line_style(TRANSPARENT)
                .bold_line_style(Role::Grid.color().stroke_width(2))
                .axis_style(Role::Grid.color().stroke_width(2))
                .label_style(label)
                .x_labels(20)
                .y_labels(20)
                .x_label_formatter(&|time_s| format!("{} s", trimmed(*time_s)))
                .y_label_formatter(&|value| trimmed(*value))
                .draw()
                .map_err(failed)?;
            chart
                .draw_series([PathElement::new(
                    [(0.0, 0.0), (end_s, 0.0)],
                    Role::Faint.color().stroke_width(2),
                )])
                .map_err(failed)?;
            for (role, curve) in &self.curves {
                let pieces =
                    curve.iter().map(|piece| PathElement::new(piece.clone(), role.color().stroke_width(3)));
                chart.draw_series(pieces).map_err(failed)?;
            }
            root.present().map_err(failed)?;
        }
        let label = format!("plot over time, {}", self.unit);
        let clickable =
            format!("data-left=\"{}\" data-right=\"{}\" data-end=\"{end_s}\"", pixels.0.start, pixels.0.end);
        Ok(inline(&text, SIZE, &label, &clickable))
    }

    /// The finite values, the zero line among them, with some room.
    fn value_range(&self) -> Range<f64> {
        let points = self.curves.iter().flat_map(|(_, curve)| curve.iter().flatten());
        let (low, high) =
            points.fold((0.0_f64, 0.0_f64), |(low, high), &(_, value)| (low.min(value), high.max(value)));
        let (low, high) = (low.max(-self.largest), high.min(self.largest));
        let room = if high > low { 0.07 * (high - low) } else { 1.0 };
        low - room..high + room
    }
}

/// Makes a picture of fixed size fill the width it is given, and tells scripts and screen readers about it.
pub(super) fn inline(svg: &str, size: (u32, u32), label: &str, attributes: &str) -> String {
    let fixed = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
    let fluid = format!("<svg class=\"plot\" role=\"img\" aria-label=\"{label}\" {attributes} ");
    svg.replacen(&fixed, &fluid, 1)
}
