//! Many rows over a box of two controls, each with a slack of its own, the largest slack minimised first. Not here: the one
//! row of the paper (`qp`), and the rows' sum of squared slacks, which the paper's rivals minimise (`baselines`).

use dynamics::InputBox;

use crate::minimax::{largest_margin, worst_at};
use crate::polygon::Polygon;
use crate::qp::{HalfSpace, QpError, QpSolution};

/// The lexicographic program
///
/// ```text
/// first   t* = min max_i δ_i        then   min ‖u − u_nom‖²
/// both under   a_i·u + b_i ≥ −δ_i,   0 ≤ δ_i ≤ t*,   u ∈ box
/// ```
///
/// so rows that can all be met are met, and where they cannot the worst of them is met best. A linear program in three
/// variables and the projection onto a polygon, solved without iterations but for the halving of `t*`, which is exact to
/// 1e-10 of its range. The solution exists and is unique; it depends continuously on the rows only where they can be met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowsQp {
    control: InputBox<2>,
}

impl RowsQp {
    /// Sets up the program for a box of controls.
    pub fn new(control: InputBox<2>) -> Self {
        Self { control }
    }

    /// Returns the solution for `u_nom` inside or outside the box, with the largest slack as [`QpSolution::slack`] and
    /// `max_u min_i (a_i·u + b_i)` as [`QpSolution::hard_margin`], `+∞` without rows. At most one row more than
    /// [`crate::MAX_OBSTACLES`]. Allocates nothing.
    ///
    /// # Errors
    /// * [`QpError::NonFinite`] if the nominal control or a row is not finite.
    pub fn solve(&self, u_nom: &[f64; 2], rows: &[HalfSpace<2>]) -> Result<QpSolution<2>, QpError> {
        if !u_nom.iter().all(|component| component.is_finite()) {
            return Err(QpError::NonFinite { quantity: "the nominal control" });
        }
        if !rows.iter().all(HalfSpace::is_finite) {
            return Err(QpError::NonFinite { quantity: "an obstacle's row" });
        }
        let hard_margin = largest_margin(&self.control, rows);
        if hard_margin.is_nan() {
            return Err(QpError::NonFinite { quantity: "the rows' margin" });
        }
        let demanded = hard_margin.min(0.0);
        let wish = self.control.clamp(u_nom);
        let active = worst_at(rows, &wish) < demanded;
        // Half-spaces that touch in one point may miss each other by rounding: the polygon may be empty, the looser is not.
        let loosest = demanded - 1e-9 * (1.0 + demanded.abs());
        let nearest = |demanded| Polygon::cut_by(&self.control, rows, demanded).nearest_to(u_nom);
        let u = if active { nearest(demanded).or_else(|| nearest(loosest)).unwrap_or(wish) } else { wish };
        let u = self.control.clamp(&u);
        let slack = (-worst_at(rows, &u)).max(0.0);
        Ok(QpSolution { u, slack, hard_margin, multiplier: 0.0, active })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MAX_OBSTACLES;
    use rand::{RngExt, SeedableRng};

    fn quadrotor() -> InputBox<2> {
        InputBox::new([-2.0; 2], [2.0; 2]).unwrap()
    }

    fn row(normal: [f64; 2], offset: f64) -> HalfSpace<2> {
        HalfSpace { normal, offset }
    }

    #[test]
    fn without_rows_and_with_rows_that_hold_the_nominal_control_is_clipped() {
        let qp = RowsQp::new(quadrotor());
        let free = qp.solve(&[3.0, -0.5], &[]).unwrap();
        assert_eq!((free.u, free.slack, free.active), ([2.0, -0.5], 0.0, false));
        assert_eq!(free.hard_margin, f64::INFINITY);
        let held = qp.solve(&[0.5, -0.5], &[row([1.0, 0.0], 0.0), row([0.0, -1.0], 0.0)]).unwrap();
        assert_eq!((held.u, held.slack, held.active), ([0.5, -0.5], 0.0, false));
    }

    #[test]
    fn rows_that_can_be_met_are_met_at_the_nearest_control() {
        // u₁ ≥ 1 and u₁ + u₂ ≥ 1.5: from the origin the corner (1, 0.5) is nearest.
        let rows = [row([1.0, 0.0], -1.0), row([1.0, 1.0], -1.5)];
        let solution = RowsQp::new(quadrotor()).solve(&[0.0; 2], &rows).unwrap();
        assert!((solution.u[0] - 1.0).abs() < 1e-12 && (solution.u[1] - 0.5).abs() < 1e-12, "{solution:?}");
        assert!(solution.slack < 1e-12 && solution.active && solution.hard_margin > 0.99, "{solution:?}");
    }

    #[test]
    fn opposed_rows_share_the_least_largest_slack_and_leave_the_other_axis_to_the_nominal_control() {
        // u₁ ≥ 1 and 3 u₁ ≤ −3: slacks 1 − u₁ and 3 u₁ + 3 are equal, 1.5, at u₁ = −0.5.
        let rows = [row([1.0, 0.0], -1.0), row([-3.0, 0.0], -3.0)];
        let solution = RowsQp::new(quadrotor()).solve(&[1.7, 0.3], &rows).unwrap();
        assert!((solution.u[0] + 0.5).abs() < 1e-8 && (solution.u[1] - 0.3).abs() < 1e-8, "{solution:?}");
        assert!((solution.slack - 1.5).abs() < 1e-8 && (solution.hard_margin + 1.5).abs() < 1e-8);
    }

    #[test]
    fn what_is_not_finite_is_refused_by_name() {
        let qp = RowsQp::new(quadrotor());
        let error = qp.solve(&[f64::NAN, 0.0], &[]).unwrap_err();
        assert_eq!(error, QpError::NonFinite { quantity: "the nominal control" });
        let error = qp.solve(&[0.0; 2], &[row([0.0, f64::INFINITY], 0.0)]).unwrap_err();
        assert_eq!(error, QpError::NonFinite { quantity: "an obstacle's row" });
    }

    /// No control of a fine grid meets the worst row better, and none that meets it as well lies nearer to the wish.
    #[test]
    fn no_control_of_a_fine_grid_is_better() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(7);
        let (mut met, mut unmet) = (0, 0);
        for case in 0..60 {
            let count = [1, 2, 3, 5, 15, MAX_OBSTACLES + 1][case % 6];
            let mut within = |bound: f64| rng.random_range(-bound..bound);
            let rows: Vec<_> = (0..count).map(|_| row([within(1.5), within(1.5)], within(2.0))).collect();
            let wish = [within(2.5), within(2.5)];
            let solution = RowsQp::new(quadrotor()).solve(&wish, &rows).unwrap();
            let distance = |u: &[f64; 2]| (u[0] - wish[0]).hypot(u[1] - wish[1]);
            let missed = |u: &[f64; 2]| (-worst_at(&rows, u)).max(0.0);
            assert!((missed(&solution.u) - solution.slack).abs() < 1e-12);
            assert!((solution.slack - (-solution.hard_margin).max(0.0)).abs() < 1e-7, "{solution:?}");
            for i in 0..=200 {
                for j in 0..=200 {
                    let u = [f64::from(i) * 0.02 - 2.0, f64::from(j) * 0.02 - 2.0];
                    assert!(missed(&u) >= solution.slack - 1e-8, "{u:?} {solution:?}");
                    if missed(&u) <= solution.slack {
                        assert!(distance(&u) >= distance(&solution.u) - 1e-6, "{u:?} {solution:?}");
                    }
                }
            }
            met += usize::from(solution.slack < 1e-9);
            unmet += usize::from(solution.slack > 1e-3);
        }
        assert!(met > 5 && unmet > 5, "the cases are too tame: {met} {unmet}");
    }
}
