//! The picture of a model: what is drawn lies where it belongs.

#![allow(clippy::unwrap_used)] // helpers of tests may panic as tests do

use report::{ModelFigure, ModelSlice, model_figure_svg};

const SIDE: usize = 81;

/// Distance to a disc of radius 1.5 m over ±4 m; every sample of V lies 3 cm higher.
fn figure(with_value: bool) -> ModelFigure {
    let coordinate = |step: usize| -4.0 + 8.0 * step as f64 / (SIDE - 1) as f64;
    let barrier_m: Vec<f64> = (0..SIDE * SIDE)
        .map(|index| coordinate(index % SIDE).hypot(coordinate(index / SIDE)) - 1.5)
        .collect();
    let value_m = with_value.then(|| barrier_m.iter().map(|h| h + 0.03).collect());
    ModelFigure {
        title: "a disc".to_owned(),
        min_m: [-4.0; 2],
        max_m: [4.0; 2],
        side: SIDE,
        axis_names: ["x, m", "y, m"],
        failure_radius_m: 0.7,
        slices: vec![ModelSlice { caption: "only one".to_owned(), barrier_m, value_m }],
    }
}

/// Points of the stroked paths: the zero levels.
fn stroked_points(svg: &str) -> Vec<[f64; 2]> {
    let curves = svg.split("<path").skip(1).filter(|path| path.contains("stroke-width"));
    let numbers = curves.flat_map(|path| {
        let data = path.split(" d=\"").nth(1).unwrap().split('"').next().unwrap();
        data.split(['M', 'L', ' ']).filter(|pair| !pair.is_empty()).collect::<Vec<_>>()
    });
    let pairs =
        numbers.map(|pair| pair.split(',').map(|number| number.parse().unwrap()).collect::<Vec<f64>>());
    pairs.map(|pair| [pair[0], pair[1]]).collect()
}

#[test]
fn the_zero_level_is_drawn_where_the_barrier_is_zero() {
    let svg = model_figure_svg(&figure(false));
    let circle = svg.split("<circle").nth(1).unwrap();
    let attribute = |name: &str| -> f64 {
        circle.split(&format!(" {name}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap()
    };
    let (centre, failure_px) = ([attribute("cx"), attribute("cy")], attribute("r"));
    let points = stroked_points(&svg);
    assert!(points.len() > 50);
    for [x, y] in points {
        let radius_m = (x - centre[0]).hypot(y - centre[1]) / failure_px * 0.7;
        assert!((radius_m - 1.5).abs() < 0.01, "{radius_m} m");
    }
}

#[test]
fn with_a_value_there_are_three_panels_and_the_error() {
    let svg = model_figure_svg(&figure(true));
    assert_eq!(svg.matches("<circle").count(), 3);
    assert!(svg.contains("h - V, m"));
    assert!(!model_figure_svg(&figure(false)).contains("h - V"));
}
