//! One figure of many runs: a value for every method over the number of people, each with its interval.

use plotters::prelude::*;

use crate::PlotError;
use crate::plot::{Axis, failed, trimmed};
use crate::theme::Role;

const SIZE: (u32, u32) = (1500, 620);
const FONT: f64 = 27.0;
/// Room for the names, pixels.
const LEGEND: u32 = 330;
/// Above the first name and below the last one together, and between two where there is room, pixels.
const LEGEND_MARGINS: usize = 110;
const LEGEND_APART: usize = 44;
/// Width over which the methods of one crowd size are spread, in units of the distance between two sizes.
const SPREAD: f64 = 0.5;
const ROLES: [Role; 7] =
    [Role::Blue, Role::Purple, Role::Orange, Role::Green, Role::Red, Role::Grey, Role::Ink];

/// A value with the bounds of its interval.
pub type Bounded = (f64, [f64; 2]);

/// One method's values.
#[derive(Debug, Clone, PartialEq)]
pub struct DensitySeries {
    /// Name of the method.
    pub name: String,
    /// Its value for each crowd size of the figure, where it has one.
    pub values: Vec<Option<Bounded>>,
}

/// A value over the number of people.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityFigure {
    /// What is shown, with its unit.
    pub title: String,
    /// Crowd sizes along the axis.
    pub people: Vec<u32>,
    /// The methods.
    pub series: Vec<DensitySeries>,
    /// Range of the axis; nothing means what the values need.
    pub range: Option<[f64; 2]>,
}

/// Draws `figure` as a picture that stands by itself, names included.
///
/// # Errors
/// [`PlotError`] if it cannot be drawn.
pub fn density_svg(figure: &DensityFigure) -> Result<String, PlotError> {
    let mut text = String::new();
    let last = figure.people.len().saturating_sub(1) as f64;
    let range = figure.range.unwrap_or_else(|| needed(figure));
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&Role::Paper.color()).map_err(failed)?;
        let (left, right) = root.split_horizontally(SIZE.0 - LEGEND);
        let mut chart = ChartBuilder::on(&left)
            .caption(&figure.title, ("sans-serif", FONT * 1.1).into_font().color(&Role::Ink.color()))
            .margin(16)
            .x_label_area_size(70)
            .y_label_area_size(90)
            .build_cartesian_2d(Axis::whole(-0.5..last + 0.5), Axis::round(range[0]..range[1], 6))
            .map_err(failed)?;
        let label = ("sans-serif", FONT).into_font().color(&Role::Faint.color());
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(Role::Grid.color().stroke_width(2))
            .axis_style(Role::Grid.color().stroke_width(2))
            .label_style(label.clone())
            .axis_desc_style(label)
            .x_desc("people")
            .x_labels(20)
            .y_labels(20)
            .x_label_formatter(&|index| people_at(figure, *index))
            .y_label_formatter(&|value| trimmed(*value))
            .draw()
            .map_err(failed)?;
        let apart = LEGEND_APART.min((SIZE.1 as usize - LEGEND_MARGINS) / figure.series.len().max(1));
        for (index, (y, series)) in (90..).step_by(apart).zip(&figure.series).enumerate() {
            let role = ROLES[index % ROLES.len()];
            // Where colours come round again, marks are hollow.
            let style = if (index / ROLES.len()).is_multiple_of(2) {
                role.color().filled()
            } else {
                role.color().stroke_width(3)
            };
            let shift = SPREAD * ((index as f64 + 0.5) / figure.series.len() as f64 - 0.5);
            let values = series.values.iter().enumerate();
            for (place, &(value, [low, high])) in
                values.filter_map(|(place, value)| Some((place as f64 + shift, value.as_ref()?)))
            {
                let interval = PathElement::new([(place, low), (place, high)], role.color().stroke_width(3));
                chart.draw_series([interval]).map_err(failed)?;
                let mark = Circle::new((place, value), 8, style);
                chart.draw_series([mark]).map_err(failed)?;
            }
            right.draw(&Circle::new((14, y), 8, style)).map_err(failed)?;
            let name = ("sans-serif", FONT).into_font().color(&Role::Ink.color());
            right.draw(&Text::new(series.name.clone(), (34, y - 13), name)).map_err(failed)?;
        }
        root.present().map_err(failed)?;
    }
    Ok(text)
}

/// The crowd size at a place of the axis.
fn people_at(figure: &DensityFigure, place: f64) -> String {
    let index = place.round().max(0.0) as usize;
    figure.people.get(index).map_or_else(String::new, u32::to_string)
}

/// The range that shows every interval with some room.
fn needed(figure: &DensityFigure) -> [f64; 2] {
    let values = figure.series.iter().flat_map(|series| series.values.iter().flatten());
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, bounds)| {
        (low.min(bounds[0]), high.max(bounds[1]))
    });
    if low > high {
        return [0.0, 1.0];
    }
    let room = if high > low { 0.1 * (high - low) } else { 0.5 };
    [low - room, high + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_stands_within_the_picture_however_many_there_are() {
        for methods in [1, 13, 20] {
            let series = |index: usize| DensitySeries {
                name: format!("method_{index}"),
                values: vec![Some((50.0, [40.0, 60.0]))],
            };
            let figure = DensityFigure {
                title: "success, %".to_owned(),
                people: vec![5],
                series: (0..methods).map(series).collect(),
                range: None,
            };
            let svg = density_svg(&figure).expect("a picture");
            let names: Vec<f64> = svg
                .split("<text ")
                .filter(|text| text.contains("method_"))
                .filter_map(|text| text.split("y=\"").nth(1)?.split('"').next()?.parse().ok())
                .collect();
            assert_eq!(names.len(), methods);
            assert!(names.iter().all(|&y| y < f64::from(SIZE.1) - 10.0), "{names:?}");
        }
    }
}
