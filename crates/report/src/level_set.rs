//! Marching squares on a square grid of samples.

use contour::ContourBuilder;

/// Linear interpolation along an edge needs finite ends; this far from the level the exact value does not matter.
const FAR: f64 = 1e3;

/// Closed rings around the set where `values ≥ threshold`, holes as rings of their own (even-odd rule). A NaN counts as inside.
///
/// `values` has `side` × `side` samples, x fastest. Points are `[x, y]` in samples, from 0 to `side - 1`; where the set meets
/// the border, the ring runs along it.
pub(crate) fn level_rings(values: &[f64], side: usize, threshold: f64) -> Vec<Vec<[f64; 2]>> {
    let above: Vec<f64> = values
        .iter()
        .map(|value| if value.is_nan() { FAR } else { (value - threshold).clamp(-FAR, FAR) })
        .collect();
    let Ok(lines) = ContourBuilder::new(side, side, true).lines(&above, &[0.0]) else {
        return Vec::new();
    };
    // Cells are counted from their corners, half a step before the first sample, and a ring that meets the border is closed
    // half a step outside: brought back onto the border here.
    let last = (side - 1) as f64;
    let onto = |coordinate: f64| (coordinate - 0.5).clamp(0.0, last);
    let rings = lines.into_iter().flat_map(|line| line.into_inner().0.0);
    rings.map(|ring| ring.0.into_iter().map(|point| [onto(point.x), onto(point.y)]).collect()).collect()
}
