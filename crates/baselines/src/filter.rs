//! The filters: the nominal acceleration, corrected by one softened row for each obstacle.

use barrier::{HalfSpace, largest_margin};
use dynamics::InputBox;
use messages::MAX_OBSTACLES;

use crate::inputs::{Inputs, NoControl};
use crate::method::{Method, MethodOutput, Verdict};
use crate::pair_rows::{PairRow, PairState};
use crate::parameters::FilterParameters;
use crate::setup::MethodSetupError;
use crate::soft_rows_qp::SoftRowsQp;
use crate::surroundings::{Surroundings, pose_at};

/// A filter of the comparison.
pub(crate) struct RowFilter<R> {
    row: R,
    qp: SoftRowsQp,
    control: InputBox<2>,
    surroundings: Surroundings,
    rows: Vec<HalfSpace<2>>,
}

impl<R: PairRow> RowFilter<R> {
    pub(crate) fn new(
        parameters: &FilterParameters,
        row: R,
        control: InputBox<2>,
        robot_radius_m: f64,
    ) -> Result<Self, MethodSetupError> {
        parameters.validate()?;
        Ok(Self {
            row,
            qp: SoftRowsQp::new(control, parameters.slack_weight),
            control,
            surroundings: Surroundings::new(parameters.sight, robot_radius_m),
            rows: Vec::with_capacity(MAX_OBSTACLES),
        })
    }
}

impl<R: PairRow> Method for RowFilter<R> {
    fn step(&mut self, inputs: &Inputs<'_>, now_ns: u64) -> Result<MethodOutput, NoControl> {
        let state = inputs.sound_robot_state()?;
        let u_nom = inputs.sound_acceleration()?;
        let obstacles = inputs.sound_obstacles()?;
        let [x, y, _] = pose_at(state, now_ns);
        let [vx, vy] = state.velocity_in_odom_mps();
        let seen = self.surroundings.look(obstacles, [x, y], now_ns);
        self.rows.clear();
        for obstacle in seen {
            self.rows.push(self.row.row(&PairState {
                position_m: [obstacle.position_m[0] - x, obstacle.position_m[1] - y],
                velocity_mps: [obstacle.velocity_mps[0] - vx, obstacle.velocity_mps[1] - vy],
                obstacle_acceleration_mps2: obstacle.acceleration_mps2,
                contact_m: obstacle.contact_m,
            }));
        }
        let solution = self.qp.solve(&u_nom, &self.rows);
        let margin = largest_margin(&self.control, &self.rows);
        let verdict = if !solution.solved || margin.is_nan() {
            Verdict::SolverFailed
        } else if margin >= 0.0 {
            Verdict::Feasible
        } else {
            Verdict::Infeasible
        };
        Ok(MethodOutput {
            control: solution.control,
            verdict,
            demands_met: verdict == Verdict::Feasible,
            slack: solution.largest_slack,
            hard_feasibility_margin: margin,
            cost: (0..2).map(|k| (solution.control[k] - u_nom[k]).powi(2)).sum(),
            iterations: solution.iterations,
            obstacle_count: self.rows.len() as u32,
        })
    }

    fn reset(&mut self) {}
}
