//! Convex polygons of two controls: a box cut by half-spaces, and the point of one nearest to another point. Not here: which
//! cuts (`minimax`, `rows_qp`).

use dynamics::InputBox;

use crate::MAX_OBSTACLES;
use crate::qp::HalfSpace;

/// Corners of a box cut by the rows of every obstacle and one more: each cut adds one at most.
const CORNERS: usize = 4 + MAX_OBSTACLES + 1;

/// A convex polygon of controls, counter-clockwise; without corners it is empty.
#[derive(Clone, Copy)]
pub(crate) struct Polygon {
    corners: [[f64; 2]; CORNERS],
    count: usize,
}

impl Polygon {
    /// The part of the box in which every row has at least `margin`.
    pub(crate) fn cut_by(control: &InputBox<2>, rows: &[HalfSpace<2>], margin: f64) -> Self {
        let (min, max) = (control.min, control.max);
        let mut polygon = Self { corners: [[0.0; 2]; CORNERS], count: 4 };
        polygon.corners[..4].copy_from_slice(&[min, [max[0], min[1]], max, [min[0], max[1]]]);
        for row in rows {
            // A row that every corner meets takes nothing away.
            if polygon.corners().iter().any(|corner| row.value(corner) < margin) {
                polygon = polygon.cut(row, margin);
            }
            if polygon.is_empty() {
                break;
            }
        }
        polygon
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The point of the edge that is nearest to `u`, a point outside of the polygon; none if the polygon is empty.
    pub(crate) fn nearest_to(&self, u: &[f64; 2]) -> Option<[f64; 2]> {
        let distance = |point: &[f64; 2]| (point[0] - u[0]).hypot(point[1] - u[1]);
        (0..self.count)
            .map(|index| nearest_on(&self.corners[index], &self.corners[(index + 1) % self.count], u))
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.count]
    }

    /// What is left where `row ≥ margin`.
    fn cut(&self, row: &HalfSpace<2>, margin: f64) -> Self {
        let mut left = Self { corners: [[0.0; 2]; CORNERS], count: 0 };
        for index in 0..self.count {
            let (from, to) = (self.corners[index], self.corners[(index + 1) % self.count]);
            let (f, t) = (row.value(&from) - margin, row.value(&to) - margin);
            if f >= 0.0 {
                left.push(from);
            }
            if (f >= 0.0) != (t >= 0.0) {
                let share = f / (f - t);
                left.push(std::array::from_fn(|k| from[k] + share * (to[k] - from[k])));
            }
        }
        left
    }

    fn push(&mut self, corner: [f64; 2]) {
        // Rounding could make a corner too many out of an edge of no length; it adds nothing.
        if self.count < CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

/// The point between `from` and `to` nearest to `u`.
fn nearest_on(from: &[f64; 2], to: &[f64; 2], u: &[f64; 2]) -> [f64; 2] {
    let along = [to[0] - from[0], to[1] - from[1]];
    let length_squared = along[0] * along[0] + along[1] * along[1];
    if length_squared == 0.0 {
        return *from;
    }
    let share = ((u[0] - from[0]) * along[0] + (u[1] - from[1]) * along[1]) / length_squared;
    let share = share.clamp(0.0, 1.0);
    [from[0] + share * along[0], from[1] + share * along[1]]
}
