//! Slices through a value function and the barrier that learned it, as one picture.
//!
//! Its colours are fixed, on a light ground of its own, so that it reads on light and dark pages alike.

use svg::Document;
use svg::node::element::path::Data;
use svg::node::element::{Circle, Group, Line, Path, Rectangle, Text};

use crate::level_set::level_rings;
use crate::theme::Role;

/// Side of one panel, pixels.
const PANEL: f64 = 260.0;
/// Room left of the panels, above, between and below them, pixels.
const LEFT: f64 = 58.0;
const TOP: f64 = 86.0;
const GAP: [f64; 2] = [26.0, 84.0];
const BOTTOM: f64 = 70.0;

/// Lower ends of the colour bands of V and h, m, with their colours: unsafe in reds, safe in blues that fade with the distance.
const LEVELS_M: [(f64, &str); 9] = [
    (f64::NEG_INFINITY, "#8F2D0C"),
    (-0.5, "#C4582B"),
    (-0.25, "#E8946A"),
    (-0.1, "#F7D3C1"),
    (0.0, "#D6E6F2"),
    (0.25, "#B5D2E8"),
    (0.5, "#8DB9DA"),
    (1.0, "#649EC9"),
    (2.0, "#3F83B7"),
];

/// The same for h - V, m: reds where the barrier over-states safety, greens where it is cautious.
const ERRORS_M: [(f64, &str); 9] = [
    (f64::NEG_INFINITY, "#0B5F47"),
    (-0.1, "#2E8B6D"),
    (-0.05, "#74B69F"),
    (-0.02, "#BFE0D4"),
    (-0.01, "#F4F6F7"),
    (0.01, "#F9D9C8"),
    (0.02, "#EBA27E"),
    (0.05, "#CC6436"),
    (0.1, "#8F2D0C"),
];

/// One plane through the state space.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelSlice {
    /// Where the plane lies, e.g. `heading 3.14 rad, speed 1.5 m/s`.
    pub caption: String,
    /// Barrier h, m: `side` × `side` samples, first axis fastest.
    pub barrier_m: Vec<f64>,
    /// Value V, m, sampled alike, where it is known.
    pub value_m: Option<Vec<f64>>,
}

/// Everything one picture shows.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFigure {
    /// What it is about.
    pub title: String,
    /// Lower ends of the two axes, m.
    pub min_m: [f64; 2],
    /// Upper ends of the two axes, m.
    pub max_m: [f64; 2],
    /// Samples along each axis, at least 2.
    pub side: usize,
    /// Names of the two axes with their unit.
    pub axis_names: [&'static str; 2],
    /// Radius of the failure set around the origin, m.
    pub failure_radius_m: f64,
    /// One row each.
    pub slices: Vec<ModelSlice>,
}

/// Draws a row per slice: V, h and the error h - V where V is known, h alone elsewhere. The zero level is a line in its panel,
/// that of V is dashed beside that of h, the failure set is the grey disc.
pub fn model_figure_svg(figure: &ModelFigure) -> String {
    let columns: u8 = if figure.slices.iter().any(|slice| slice.value_m.is_some()) { 3 } else { 1 };
    let width = LEFT + f64::from(columns) * (PANEL + GAP[0]);
    let height = TOP + figure.slices.len() as f64 * (PANEL + GAP[1]) + BOTTOM;
    let mut picture = Document::new()
        .set("viewBox", (0.0, 0.0, width, height))
        .set("width", width)
        .set("height", height)
        .set("font-family", "system-ui, sans-serif")
        .set("font-size", 13)
        .set("role", "img")
        .set("aria-label", "slices of value function and barrier")
        .add(Rectangle::new().set("width", width).set("height", height).set("fill", Role::Paper.hex()))
        .add(text(LEFT, 26.0, &figure.title, "start").set("font-size", 17));
    for (row, slice) in figure.slices.iter().enumerate() {
        let y = TOP + row as f64 * (PANEL + GAP[1]);
        let at = |column: usize| [LEFT + column as f64 * (PANEL + GAP[0]), y];
        picture = picture.add(text(LEFT, y - 26.0, &slice.caption, "start").set("fill", Role::Faint.hex()));
        picture = if let Some(value_m) = &slice.value_m {
            let error_m: Vec<f64> = slice.barrier_m.iter().zip(value_m).map(|(h, v)| h - v).collect();
            picture
                .add(panel(figure, at(0), "V, m", &LEVELS_M, value_m, &[(value_m, false)]))
                .add(panel(
                    figure,
                    at(1),
                    "h, m (V = 0 dashed)",
                    &LEVELS_M,
                    &slice.barrier_m,
                    &[(&slice.barrier_m, false), (value_m, true)],
                ))
                .add(panel(figure, at(2), "h - V, m", &ERRORS_M, &error_m, &[(value_m, true)]))
        } else {
            picture.add(panel(
                figure,
                at(0),
                "h, m",
                &LEVELS_M,
                &slice.barrier_m,
                &[(&slice.barrier_m, false)],
            ))
        };
    }
    let legend_y = height - BOTTOM + 24.0;
    picture = picture.add(legend([LEFT, legend_y], "V and h, m", &LEVELS_M));
    if columns == 3 {
        picture = picture.add(legend(
            [LEFT + 1.5 * (PANEL + GAP[0]), legend_y],
            "h - V, m (red: over-states safety)",
            &ERRORS_M,
        ));
    }
    picture.to_string()
}

/// Pixels of a point given in samples, y up to y down, to a tenth.
fn pixel(origin: [f64; 2], side: usize, point: [f64; 2]) -> (f64, f64) {
    let scale = PANEL / (side - 1) as f64;
    let rounded = |value: f64| (value * 10.0).round() / 10.0;
    (rounded(origin[0] + point[0] * scale), rounded(origin[1] + PANEL - point[1] * scale))
}

fn panel(
    figure: &ModelFigure,
    origin: [f64; 2],
    name: &str,
    bands: &[(f64, &str)],
    values: &[f64],
    zero_levels: &[(&Vec<f64>, bool)],
) -> Group {
    let side = figure.side;
    let mut group = Group::new().add(text(origin[0] + PANEL, origin[1] - 6.0, name, "end"));
    for &(threshold, color) in bands {
        // Each band is painted over those below it, so its upper end needs no cutting.
        let rings = if threshold == f64::NEG_INFINITY {
            let last = (side - 1) as f64;
            vec![vec![[0.0, 0.0], [last, 0.0], [last, last], [0.0, last]]]
        } else {
            level_rings(values, side, threshold)
        };
        group = group.add(
            Path::new()
                .set("d", outline(origin, side, &rings))
                .set("fill", color)
                .set("fill-rule", "evenodd"),
        );
    }
    for &(level, dashed) in zero_levels {
        let rings = level_rings(level, side, 0.0);
        let mut curve = Path::new()
            .set("d", zero_curve(origin, side, &rings))
            .set("fill", "none")
            .set("stroke", Role::Ink.hex())
            .set("stroke-width", 1.4);
        if dashed {
            curve = curve.set("stroke-dasharray", "4 3");
        }
        group = group.add(curve);
    }
    let scale = PANEL / (figure.max_m[0] - figure.min_m[0]);
    let centre = [0, 1].map(|axis| -figure.min_m[axis] / (figure.max_m[axis] - figure.min_m[axis]) * PANEL);
    group = group.add(
        Circle::new()
            .set("cx", origin[0] + centre[0])
            .set("cy", origin[1] + PANEL - centre[1])
            .set("r", (figure.failure_radius_m * scale * 10.0).round() / 10.0)
            .set("fill", Role::Ink.hex())
            .set("fill-opacity", 0.25)
            .set("stroke", Role::Ink.hex()),
    );
    group.add(frame(figure, origin))
}

/// The rings as one filled path.
fn outline(origin: [f64; 2], side: usize, rings: &[Vec<[f64; 2]>]) -> Data {
    rings.iter().fold(Data::new(), |data, ring| {
        let data = ring.iter().enumerate().fold(data, |data, (index, &point)| {
            let (x, y) = pixel(origin, side, point);
            if index == 0 { data.move_to((x, y)) } else { data.line_to((x, y)) }
        });
        data.close()
    })
}

/// The rings as lines, without their stretches along the border.
fn zero_curve(origin: [f64; 2], side: usize, rings: &[Vec<[f64; 2]>]) -> Data {
    let last = (side - 1) as f64;
    let on_border = |from: [f64; 2], to: [f64; 2]| {
        (0..2).any(|axis| [0.0, last].iter().any(|&end| from[axis] == end && to[axis] == end))
    };
    let mut data = Data::new();
    for ring in rings {
        let mut pen_down = false;
        for pair in ring.windows(2) {
            if on_border(pair[0], pair[1]) {
                pen_down = false;
                continue;
            }
            if !pen_down {
                data = data.move_to(pixel(origin, side, pair[0]));
                pen_down = true;
            }
            data = data.line_to(pixel(origin, side, pair[1]));
        }
    }
    data
}

/// Border, ticks at whole metres and names of the axes.
fn frame(figure: &ModelFigure, origin: [f64; 2]) -> Group {
    let mut group = Group::new().set("fill", Role::Faint.hex()).set("font-size", 11).add(
        Rectangle::new()
            .set("x", origin[0])
            .set("y", origin[1])
            .set("width", PANEL)
            .set("height", PANEL)
            .set("fill", "none")
            .set("stroke", Role::Grey.hex()),
    );
    for axis in 0..2 {
        let (min, max) = (figure.min_m[axis], figure.max_m[axis]);
        let step = ((max - min) / 6.0).ceil().max(1.0);
        let mut tick = (min / step).ceil() * step;
        while tick <= max {
            let along = (tick - min) / (max - min) * PANEL;
            let (x, y) = if axis == 0 {
                (origin[0] + along, origin[1] + PANEL)
            } else {
                (origin[0], origin[1] + PANEL - along)
            };
            let (dx, dy) = if axis == 0 { (0.0, 4.0) } else { (-4.0, 0.0) };
            group = group.add(
                Line::new()
                    .set("x1", x)
                    .set("y1", y)
                    .set("x2", x + dx)
                    .set("y2", y + dy)
                    .set("stroke", Role::Grey.hex()),
            );
            let label = format!("{tick:.0}");
            group = group.add(if axis == 0 {
                text(x, y + 16.0, &label, "middle")
            } else {
                text(x - 7.0, y + 4.0, &label, "end")
            });
            tick += step;
        }
    }
    let below = text(origin[0] + PANEL / 2.0, origin[1] + PANEL + 30.0, figure.axis_names[0], "middle");
    let turned = format!("rotate(-90 {} {})", origin[0] - 24.0, origin[1] + PANEL / 2.0);
    let beside = text(origin[0] - 24.0, origin[1] + PANEL / 2.0, figure.axis_names[1], "middle");
    let group = group.add(below);
    // Only the first column has room for it.
    if origin[0] <= LEFT { group.add(beside.set("transform", turned)) } else { group }
}

fn legend(origin: [f64; 2], name: &str, bands: &[(f64, &str)]) -> Group {
    const WIDTH: f64 = 38.0;
    let mut group = Group::new().set("font-size", 11).add(text(origin[0], origin[1], name, "start"));
    for (index, &(threshold, color)) in bands.iter().enumerate() {
        let x = origin[0] + index as f64 * WIDTH;
        group = group.add(
            Rectangle::new()
                .set("x", x)
                .set("y", origin[1] + 8.0)
                .set("width", WIDTH)
                .set("height", 12)
                .set("fill", color),
        );
        if threshold.is_finite() {
            group = group.add(text(x, origin[1] + 33.0, &format!("{threshold}"), "middle"));
        }
    }
    group
}

fn text(x: f64, y: f64, content: &str, anchor: &str) -> Text {
    Text::new(content)
        .set("x", (x * 10.0).round() / 10.0)
        .set("y", (y * 10.0).round() / 10.0)
        .set("text-anchor", anchor)
        .set("fill", Role::Ink.hex())
}
