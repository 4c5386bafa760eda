//! The filters' quadratic program: many rows, each with a slack of its own, over a box of two controls, solved exactly.
//! Not here: where the rows come from (`pair_rows`), and whether they could be met without slack (`barrier`).

use barrier::HalfSpace;
use dynamics::InputBox;

/// Active sets tried before the search counts as failed; three to six are usual, and each lowers the cost.
const SET_LIMIT: u32 = 100;
/// A step below this share of the control's size is rounding.
const RELATIVE_STEP: f64 = 1e-12;

/// The program of the authors' C3BF and HO-CBF filters:
///
/// ```text
/// min  ‖u − u_nom‖² + w Σ δ_i²      s.t.  a_i·u + b_i ≥ −δ_i,  δ_i ≥ 0,  u ∈ box
/// ```
///
/// With `δ_i = max(0, −(a_i·u + b_i))` it is the minimum of a strictly convex, piecewise quadratic function of `u` alone:
/// hence always solvable and with one solution. Newton's method on the pieces finds it in finitely many steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftRowsQp {
    control: InputBox<2>,
    slack_weight: f64,
}

/// The solution of one [`SoftRowsQp`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoftRowsSolution {
    /// The control, inside the box.
    pub control: [f64; 2],
    /// `max δ_i`, unit of the rows.
    pub largest_slack: f64,
    /// Active sets tried.
    pub iterations: u32,
    /// Whether the search ended at the solution; `false` after too many sets or with input that is not finite.
    pub solved: bool,
}

impl SoftRowsQp {
    /// Sets up the program for a box of controls and the slacks' weight `w`, finite and above zero (checked where
    /// parameters are read).
    pub fn new(control: InputBox<2>, slack_weight: f64) -> Self {
        Self { control, slack_weight }
    }

    /// Solves the program for `u_nom` inside or outside the box and any number of rows. Allocates nothing.
    pub fn solve(&self, u_nom: &[f64; 2], rows: &[HalfSpace<2>]) -> SoftRowsSolution {
        let finite = u_nom.iter().all(|value| value.is_finite())
            && rows.iter().all(|row| (row.normal[0] + row.normal[1] + row.offset).is_finite());
        let mut u = self.control.clamp(u_nom);
        let mut iterations = 0;
        let mut solved = false;
        while finite && !solved && iterations < SET_LIMIT {
            iterations += 1;
            let step = self.piece(u_nom, rows, &u).least_in(&self.room_around(&u));
            let share = self.best_share(u_nom, rows, &u, &step);
            let size = 1.0 + u[0].abs() + u[1].abs();
            solved = step[0].abs() + step[1].abs() <= RELATIVE_STEP * size;
            u = self.control.clamp(&[u[0] + share * step[0], u[1] + share * step[1]]);
        }
        let largest_slack = rows.iter().map(|row| -value(row, &u)).fold(0.0, f64::max);
        SoftRowsSolution { control: u, largest_slack, iterations, solved }
    }

    /// The steps from `u` that stay in the box.
    fn room_around(&self, u: &[f64; 2]) -> InputBox<2> {
        InputBox {
            min: std::array::from_fn(|k| self.control.min[k] - u[k]),
            max: std::array::from_fn(|k| self.control.max[k] - u[k]),
        }
    }

    /// The quadratic function of a step from `u` that the cost is near by. Its slope is taken at `u` itself, so that a
    /// second step on the same piece takes the rounding of the first away.
    fn piece(&self, u_nom: &[f64; 2], rows: &[HalfSpace<2>], u: &[f64; 2]) -> Quadratic {
        let mut piece = Quadratic { hessian: [1.0, 0.0, 1.0], linear: [u[0] - u_nom[0], u[1] - u_nom[1]] };
        for row in rows {
            let missing = value(row, u);
            if missing < 0.0 {
                let ([a, b], w) = (row.normal, self.slack_weight);
                piece.hessian[0] += w * a * a;
                piece.hessian[1] += w * a * b;
                piece.hessian[2] += w * b * b;
                piece.linear[0] += w * a * missing;
                piece.linear[1] += w * b * missing;
            }
        }
        piece
    }

    /// Half the derivative of the cost along `step`, at `share` of it.
    fn slope(
        &self,
        u_nom: &[f64; 2],
        rows: &[HalfSpace<2>],
        u: &[f64; 2],
        step: &[f64; 2],
        share: f64,
    ) -> f64 {
        let at = [u[0] + share * step[0], u[1] + share * step[1]];
        let by_nominal: f64 = (0..2).map(|k| (at[k] - u_nom[k]) * step[k]).sum();
        let by_rows: f64 = rows
            .iter()
            .map(|row| value(row, &at).min(0.0) * (row.normal[0] * step[0] + row.normal[1] * step[1]))
            .sum();
        by_nominal + self.slack_weight * by_rows
    }

    /// The share of `step` in (0, 1] at which the cost is least: its derivative rises, linearly between the shares at
    /// which a row begins or ceases to need slack.
    fn best_share(&self, u_nom: &[f64; 2], rows: &[HalfSpace<2>], u: &[f64; 2], step: &[f64; 2]) -> f64 {
        let slope = |share| self.slope(u_nom, rows, u, step, share);
        let (mut low, mut high) = (0.0, 1.0);
        if slope(high) <= 0.0 {
            return high;
        }
        for row in rows {
            let along = row.normal[0] * step[0] + row.normal[1] * step[1];
            let corner = -value(row, u) / along;
            if corner > low && corner < high {
                if slope(corner) > 0.0 {
                    high = corner;
                } else {
                    low = corner;
                }
            }
        }
        let (falling, rising) = (slope(low), slope(high));
        low + (high - low) * (falling / (falling - rising)).clamp(0.0, 1.0)
    }
}

fn value(row: &HalfSpace<2>, u: &[f64; 2]) -> f64 {
    row.normal[0] * u[0] + row.normal[1] * u[1] + row.offset
}

/// `½ uᵀ H u + lᵀ u`, strictly convex.
struct Quadratic {
    /// `[H₁₁, H₁₂, H₂₂]`.
    hessian: [f64; 3],
    linear: [f64; 2],
}

impl Quadratic {
    fn at(&self, u: &[f64; 2]) -> f64 {
        let [a, b, c] = self.hessian;
        0.5 * (a * u[0] * u[0] + 2.0 * b * u[0] * u[1] + c * u[1] * u[1])
            + self.linear[0] * u[0]
            + self.linear[1] * u[1]
    }

    /// Its one minimiser in the box: inside, or else the best of the four edges.
    fn least_in(&self, control: &InputBox<2>) -> [f64; 2] {
        let [a, b, c] = self.hessian;
        let [l, m] = self.linear;
        let determinant = a * c - b * b;
        let free = [(b * m - c * l) / determinant, (b * l - a * m) / determinant];
        if control.contains(&free) {
            return free;
        }
        let (min, max) = (control.min, control.max);
        let edges = [
            [min[0], (-(m + b * min[0]) / c).clamp(min[1], max[1])],
            [max[0], (-(m + b * max[0]) / c).clamp(min[1], max[1])],
            [(-(l + b * min[1]) / a).clamp(min[0], max[0]), min[1]],
            [(-(l + b * max[1]) / a).clamp(min[0], max[0]), max[1]],
        ];
        edges.into_iter().min_by(|u, v| self.at(u).total_cmp(&self.at(v))).unwrap_or(free)
    }
}
