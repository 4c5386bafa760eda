//! The CBF-QP: one half-space, a box, one slack, solved exactly. Not here: where the half-space comes from
//! (`composite`) and what the robot does with slack or without a solution (`cbf_filter`).

use dynamics::InputBox;

/// The controls `u` with `normal · u + offset ≥ 0`.
///
/// For the filter `normal = L_g h` and `offset = L_f h + ∂h/∂t + α·h`, both giving m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace<const N: usize> {
    /// `a`, m/s per unit of each control.
    pub normal: [f64; N],
    /// `b`, m/s.
    pub offset: f64,
}

impl<const N: usize> HalfSpace<N> {
    /// `a·u + b`, m/s: negative for controls outside.
    pub fn value(&self, u: &[f64; N]) -> f64 {
        (0..N).map(|k| self.normal[k] * u[k]).sum::<f64>() + self.offset
    }

    /// Whether no component is a NaN or an infinity.
    pub(crate) fn is_finite(&self) -> bool {
        self.normal.iter().all(|component| component.is_finite()) && self.offset.is_finite()
    }
}

/// The CBF-QP of the paper (eq. `cbf_qp`), softened by one slack as the authors' code does:
///
/// ```text
/// min  ½‖u − u_nom‖² + ½ w s²      s.t.  a·u + b ≥ −s,  u ∈ box,  s ≥ 0
/// ```
///
/// Strictly convex, hence always solvable and with one solution. The slack is zero only where the row
/// already holds at the clipped nominal control; where it is active and can be met, the slack is the
/// multiplier over `w`, a millionth of the correction for `w = 10⁶`. Whether the row could be met at all is
/// said by [`QpSolution::hard_margin`], not by the slack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CbfQp<const N: usize> {
    control: InputBox<N>,
    slack_weight: f64,
}

/// The solution of one [`CbfQp`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QpSolution<const N: usize> {
    /// The control, inside the box.
    pub u: [f64; N],
    /// `s`, m/s: by how much the row is violated.
    pub slack: f64,
    /// `max over the box of a·u + b`, m/s. The row without slack is feasible if and only if this is ≥ 0.
    /// `+∞` without a row.
    pub hard_margin: f64,
    /// Multiplier λ of the row; zero where the row does not change the control, and with several rows
    /// ([`crate::RowsQp`]), which have one each.
    pub multiplier: f64,
    /// Whether the row, or one of them, changed the control (λ > 0).
    pub active: bool,
}

/// Why a CBF-QP was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum QpError {
    /// A NaN or an infinity.
    #[error("{quantity} is not finite; brake, no command follows from it")]
    NonFinite {
        /// What was not finite.
        quantity: &'static str,
    },
    /// The slack's weight must be positive.
    #[error("the slack needs a weight > 0, not {weight}; the authors' code uses 1e6")]
    SlackWeight {
        /// Weight given.
        weight: f64,
    },
}

impl<const N: usize> CbfQp<N> {
    /// Sets up the problem for the box of controls and the slack's weight `w`.
    ///
    /// # Errors
    /// * [`QpError::SlackWeight`] unless the weight is positive and finite.
    pub fn new(control: InputBox<N>, slack_weight: f64) -> Result<Self, QpError> {
        if slack_weight > 0.0 && slack_weight.is_finite() {
            Ok(Self { control, slack_weight })
        } else {
            Err(QpError::SlackWeight { weight: slack_weight })
        }
    }

    /// Returns the same problem with another box of controls.
    #[must_use]
    pub fn within(&self, control: InputBox<N>) -> Self {
        Self { control, ..*self }
    }

    /// Returns the box of controls.
    pub fn control(&self) -> &InputBox<N> {
        &self.control
    }

    /// Returns the one minimiser. A nominal control outside the box is taken as it is; the solution lies
    /// inside. Without a row the nominal control is clipped to the box.
    ///
    /// # Errors
    /// * [`QpError::NonFinite`] if the nominal control, the row or the result is not finite.
    pub fn solve(&self, u_nom: &[f64; N], row: Option<&HalfSpace<N>>) -> Result<QpSolution<N>, QpError> {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        if !finite(u_nom) {
            return Err(QpError::NonFinite { quantity: "the nominal control" });
        }
        let Some(row) = row else {
            let u = self.control.clamp(u_nom);
            return Ok(QpSolution {
                u,
                slack: 0.0,
                hard_margin: f64::INFINITY,
                multiplier: 0.0,
                active: false,
            });
        };
        if !(finite(&row.normal) && row.offset.is_finite()) {
            return Err(QpError::NonFinite { quantity: "the barrier's row" });
        }
        let multiplier = self.multiplier(u_nom, row);
        let u = self.control_at(u_nom, row, multiplier);
        let slack = multiplier / self.slack_weight;
        let hard_margin = row.offset + self.support(&row.normal);
        if !(multiplier.is_finite() && hard_margin.is_finite()) {
            return Err(QpError::NonFinite { quantity: "the solution of the CBF-QP" });
        }
        Ok(QpSolution { u, slack, hard_margin, multiplier, active: multiplier > 0.0 })
    }

    /// `u(λ) = clip(u_nom + λ a)`: minimises the Lagrangian over the box.
    fn control_at(&self, u_nom: &[f64; N], row: &HalfSpace<N>, multiplier: f64) -> [f64; N] {
        self.control.clamp(&std::array::from_fn(|k| u_nom[k] + multiplier * row.normal[k]))
    }

    /// Largest `a·u` over the box.
    fn support(&self, normal: &[f64; N]) -> f64 {
        (0..N).map(|k| (normal[k] * self.control.min[k]).max(normal[k] * self.control.max[k])).sum()
    }

    /// Finds the multiplier: the root λ ≥ 0 of `φ(λ) = a·u(λ) + b + λ/w`, or zero where `φ(0) ≥ 0`.
    ///
    /// φ rises with slope `1/w + Σ a_k²` over the components that the box does not hold, so it is linear
    /// between the at most 2N multipliers at which a component enters or leaves its interval. The walk goes
    /// from one to the next until the root lies before it.
    fn multiplier(&self, u_nom: &[f64; N], row: &HalfSpace<N>) -> f64 {
        let a = &row.normal;
        // Component k moves while λ lies between entry and exit.
        let (mut entry, mut exit) = ([f64::INFINITY; N], [f64::INFINITY; N]);
        for k in 0..N {
            let (near, far) = if a[k] > 0.0 {
                (self.control.min[k], self.control.max[k])
            } else {
                (self.control.max[k], self.control.min[k])
            };
            if a[k] != 0.0 {
                entry[k] = (near - u_nom[k]) / a[k];
                exit[k] = (far - u_nom[k]) / a[k];
            }
        }
        let mut from = 0.0;
        loop {
            let u = self.control_at(u_nom, row, from);
            let residual = (0..N).map(|k| a[k] * u[k]).sum::<f64>() + row.offset + from / self.slack_weight;
            if residual >= 0.0 {
                return from;
            }
            let mut slope = 1.0 / self.slack_weight;
            let mut next = f64::INFINITY;
            for k in 0..N {
                if entry[k] <= from && from < exit[k] {
                    slope += a[k] * a[k];
                }
                for breakpoint in [entry[k], exit[k]] {
                    if breakpoint > from && breakpoint < next {
                        next = breakpoint;
                    }
                }
            }
            let root = from - residual / slope;
            if root > next {
                from = next;
            } else {
                // Also the way out for a NaN, which the caller refuses.
                return root;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ground_robot() -> CbfQp<2> {
        CbfQp::new(InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap(), 1e6).unwrap()
    }

    #[test]
    fn without_a_row_the_nominal_control_is_clipped() {
        let solution = ground_robot().solve(&[2.0, -0.1], None).unwrap();
        assert_eq!(solution.u, [1.0, -0.1]);
        assert_eq!((solution.slack, solution.active), (0.0, false));
        assert_eq!(solution.hard_margin, f64::INFINITY);
    }

    #[test]
    fn a_row_that_holds_changes_nothing() {
        let row = HalfSpace { normal: [-1.0, 0.0], offset: 0.9 };
        let solution = ground_robot().solve(&[0.8, 0.3], Some(&row)).unwrap();
        assert_eq!((solution.u, solution.multiplier), ([0.8, 0.3], 0.0));
        assert!((solution.hard_margin - 0.65).abs() < 1e-15);
    }

    #[test]
    fn a_feasible_row_is_met_up_to_the_tiny_slack() {
        let row = HalfSpace { normal: [-1.0, 0.0], offset: 0.5 };
        let solution = ground_robot().solve(&[0.8, 0.3], Some(&row)).unwrap();
        assert!((solution.u[0] - 0.5).abs() < 1e-6 && solution.u[1] == 0.3, "{solution:?}");
        assert!((solution.slack - 0.3e-6).abs() < 1e-11 && solution.active, "{solution:?}");
    }

    #[test]
    fn an_infeasible_row_gives_the_best_corner_and_says_so() {
        let row = HalfSpace { normal: [-1.0, 0.5], offset: -1.0 };
        let solution = ground_robot().solve(&[0.8, 0.3], Some(&row)).unwrap();
        assert_eq!(solution.u, [0.25, 0.8]);
        assert!((solution.hard_margin + 0.85).abs() < 1e-15);
        assert!((solution.slack - 0.85).abs() < 1e-12);
    }

    #[test]
    fn a_row_without_normal_only_asks_for_slack() {
        let row = HalfSpace { normal: [0.0, 0.0], offset: -0.2 };
        let solution = ground_robot().solve(&[0.8, 0.3], Some(&row)).unwrap();
        assert_eq!(solution.u, [0.8, 0.3]);
        assert!((solution.slack - 0.2).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_is_refused_by_name() {
        let row = HalfSpace { normal: [f64::NAN, 0.0], offset: 0.0 };
        let error = ground_robot().solve(&[0.5, 0.0], Some(&row)).unwrap_err();
        assert_eq!(error, QpError::NonFinite { quantity: "the barrier's row" });
        let error = ground_robot().solve(&[f64::INFINITY, 0.0], None).unwrap_err();
        assert_eq!(error, QpError::NonFinite { quantity: "the nominal control" });
    }

    #[test]
    fn a_slack_without_weight_is_refused() {
        let control = *ground_robot().control();
        assert_eq!(CbfQp::new(control, 0.0), Err(QpError::SlackWeight { weight: 0.0 }));
    }
}
