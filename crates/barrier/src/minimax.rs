//! Whether rows could be met at all: the largest margin that some control in a box has in its worst row. Exact up to the
//! tolerance, without a solver: halving of the margin, and for each a polygon cut by every row.

use dynamics::InputBox;

use crate::polygon::Polygon;
use crate::qp::HalfSpace;

/// The margin is known to this share of its first bracket.
const RELATIVE_TOLERANCE: f64 = 1e-10;

/// `max over u in the box of min_i (a_i·u + b_i)`, unit of the rows; `+∞` without rows, NaN where a row is not finite.
///
/// Never above the true value. At most one row more than [`crate::MAX_OBSTACLES`]. Allocates nothing.
pub fn largest_margin(control: &InputBox<2>, rows: &[HalfSpace<2>]) -> f64 {
    let support = |row: &HalfSpace<2>| {
        let best = |k: usize| (row.normal[k] * control.min[k]).max(row.normal[k] * control.max[k]);
        row.offset + best(0) + best(1)
    };
    let mut high = rows.iter().map(support).fold(f64::INFINITY, f64::min);
    let middle = std::array::from_fn(|k| 0.5 * (control.min[k] + control.max[k]));
    let mut low = worst_at(rows, &middle);
    if rows.is_empty() {
        return high;
    }
    if !(low.is_finite() && high.is_finite()) {
        return f64::NAN;
    }
    let tolerance = RELATIVE_TOLERANCE * (1.0 + high - low);
    while high - low > tolerance {
        let margin = 0.5 * (low + high);
        if Polygon::cut_by(control, rows, margin).is_empty() {
            high = margin;
        } else {
            low = margin;
        }
    }
    low
}

/// `min_i (a_i·u + b_i)`; `+∞` without rows.
pub(crate) fn worst_at(rows: &[HalfSpace<2>], u: &[f64; 2]) -> f64 {
    rows.iter().map(|row| row.value(u)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MAX_OBSTACLES;

    fn quadrotor() -> InputBox<2> {
        InputBox::new([-2.0, -2.0], [2.0, 2.0]).unwrap()
    }

    #[test]
    fn one_row_has_its_support() {
        let row = HalfSpace { normal: [1.0, -0.5], offset: -1.0 };
        assert!((largest_margin(&quadrotor(), &[row]) - 2.0).abs() < 1e-8);
    }

    #[test]
    fn opposed_rows_meet_in_the_middle() {
        // u₁ ≥ 1 + t and u₁ ≤ −1 − t: t = −1 at best, although each alone has a margin of 1.
        let rows = [[1.0, 0.0], [-1.0, 0.0]].map(|normal| HalfSpace { normal, offset: -1.0 });
        assert!((largest_margin(&quadrotor(), &rows) + 1.0).abs() < 1e-8);
    }

    #[test]
    fn no_row_is_no_bound() {
        assert_eq!(largest_margin(&quadrotor(), &[]), f64::INFINITY);
    }

    #[test]
    fn a_row_that_is_not_finite_has_no_margin() {
        let row = HalfSpace { normal: [f64::NAN, 0.0], offset: 0.0 };
        assert!(largest_margin(&quadrotor(), &[row]).is_nan());
    }

    #[test]
    fn many_rows_agree_with_a_fine_grid() {
        let rows: Vec<_> = (0..MAX_OBSTACLES)
            .map(|i| {
                let angle = i as f64 * 2.4;
                let normal = [1.3 * angle.cos(), 0.7 * angle.sin()];
                HalfSpace { normal, offset: 0.4 * (i as f64 * 1.7).sin() - 0.3 }
            })
            .collect();
        let mut best = f64::NEG_INFINITY;
        for i in 0..=400 {
            for j in 0..=400 {
                let u = [f64::from(i) * 0.01 - 2.0, f64::from(j) * 0.01 - 2.0];
                best = best.max(worst_at(&rows, &u));
            }
        }
        let margin = largest_margin(&quadrotor(), &rows);
        // A grid point lies within 0.005 of the best control in each component, and no slope exceeds 1.3 + 0.7.
        assert!(margin >= best - 1e-8 && margin <= best + 0.01, "{margin} {best}");
    }
}
