//! The filter's answers to the composite's known weaknesses, where the settings ask for one: from the obstacles of a cycle to
//! its condition and its control. Not here: the published way (`filter`), and people treated jointly (`joint`).

use barrier::{
    BarrierConstraint, BarrierObstacle, CbfQp, CompositeBarrier, CompositeSample, HalfSpace, ObstacleInput,
    QpSolution, RowsQp, SoftminOffset,
};
use dynamics::{InputBox, RobotObstaclePair};
use messages::{MAX_OBSTACLES, Reason};
use settings::{Composition, FilterSettings};

use crate::appearance::Appearance;

/// In [`Composition::CompositeAndPairs`], whose own conditions join the composite's: those of this many smallest values.
const PAIRS_BESIDE_COMPOSITE: usize = 2;

/// What deviates from the published composite. Holds every buffer it needs: nothing allocates after construction.
pub(crate) struct Options {
    input: ObstacleInput,
    composition: Composition,
    offset: SoftminOffset,
    appearance: Option<Appearance>,
    alpha_per_s: f64,
    constraints: Vec<BarrierConstraint>,
    rows: Vec<HalfSpace<2>>,
}

impl Options {
    /// The options of `settings`; none if they are those of the paper.
    pub(crate) fn of(settings: &FilterSettings) -> Option<Self> {
        let input = match settings.obstacle_input {
            settings::ObstacleInput::Measured => ObstacleInput::Measured,
            settings::ObstacleInput::WorstCase => ObstacleInput::WorstCase,
        };
        let offset = match settings.softmin_offset {
            settings::SoftminOffset::Keep => SoftminOffset::Keep,
            settings::SoftminOffset::Remove => SoftminOffset::Remove,
            settings::SoftminOffset::RemoveBound => SoftminOffset::RemoveBound,
        };
        let published = input == ObstacleInput::Measured
            && offset == SoftminOffset::Keep
            && settings.composition == Composition::Composite
            && settings.appearance_ramp_s.is_none();
        (!published).then(|| Self {
            input,
            composition: settings.composition,
            offset,
            appearance: settings.appearance_ramp_s.map(|ramp_s| Appearance::new(ramp_s, settings.beta_per_m)),
            alpha_per_s: settings.alpha_per_s,
            constraints: Vec::with_capacity(MAX_OBSTACLES),
            rows: Vec::with_capacity(MAX_OBSTACLES + 1),
        })
    }

    /// Computes every obstacle's own condition at the robot state `x`, newcomers' as the ramp says.
    ///
    /// # Errors
    /// [`Reason::NonFiniteBarrier`] if the input or a value is not finite.
    pub(crate) fn look<const NX: usize, P: RobotObstaclePair<NX>>(
        &mut self,
        barrier: &mut CompositeBarrier,
        pair: &P,
        x: &[f64; NX],
        obstacles: &[BarrierObstacle],
    ) -> Result<(), Reason> {
        barrier
            .evaluate_pairs(pair, x, obstacles, self.input, &mut self.constraints)
            .map_err(|_| Reason::NonFiniteBarrier)
    }

    /// Solves for the control nearest to `u_nom` under the conditions that [`Options::look`] found.
    ///
    /// The sample is what the command reports as the condition: the composite's, or with rows alone that of the obstacle with
    /// the smallest value. Slack and hard margin are those of all conditions together.
    ///
    /// # Errors
    /// [`Reason::NonFiniteBarrier`] if something is not finite.
    pub(crate) fn decide(
        &mut self,
        barrier: &mut CompositeBarrier,
        qp: &CbfQp<2>,
        u_nom: &[f64; 2],
        track_ids: &[u64],
        now_ns: u64,
    ) -> Result<(CompositeSample, QpSolution<2>), Reason> {
        let control: &InputBox<2> = qp.control();
        if let Some(appearance) = &mut self.appearance {
            appearance.apply(track_ids, &mut self.constraints, control, now_ns);
        }
        let composite =
            barrier.compose(&self.constraints, self.offset).map_err(|_| Reason::NonFiniteBarrier)?;
        self.rows.clear();
        let sample = match self.composition {
            Composition::Composite => composite,
            Composition::Rows => {
                let alpha_per_s = self.alpha_per_s;
                self.rows.extend(self.constraints.iter().map(|constraint| constraint.row(alpha_per_s)));
                match composite {
                    CompositeSample::Unconstrained => composite,
                    CompositeSample::Constrained(of_all) => CompositeSample::Constrained(BarrierConstraint {
                        sdf: of_all.sdf,
                        outside_domain: of_all.outside_domain,
                        ..self.constraints[of_all.critical]
                    }),
                }
            }
            Composition::CompositeAndPairs => {
                self.rows.extend(composite.row(self.alpha_per_s));
                self.constraints.sort_unstable_by(|a, b| a.h.total_cmp(&b.h));
                let nearest = self.constraints.iter().take(PAIRS_BESIDE_COMPOSITE);
                self.rows.extend(nearest.map(|constraint| constraint.row(self.alpha_per_s)));
                composite
            }
        };
        let solution = match self.composition {
            Composition::Composite => qp.solve(u_nom, sample.row(self.alpha_per_s).as_ref()),
            Composition::Rows | Composition::CompositeAndPairs => {
                RowsQp::new(*control).solve(u_nom, &self.rows)
            }
        };
        if let Some(appearance) = &mut self.appearance {
            appearance.note(sample.h());
        }
        Ok((sample, solution.map_err(|_| Reason::NonFiniteBarrier)?))
    }
}

/// The part of `control` (accelerations, m/s²) with which a double integrator at `velocity_mps` does not exceed `limit_mps` on
/// either axis within `period_s`; where it is too fast already, the strongest braking or what suffices.
pub(crate) fn within_speed_limit(
    control: &InputBox<2>,
    velocity_mps: [f64; 2],
    limit_mps: f64,
    period_s: f64,
) -> InputBox<2> {
    let within = |k: usize, acceleration: f64| acceleration.clamp(control.min[k], control.max[k]);
    InputBox {
        min: [0, 1].map(|k| within(k, (-limit_mps - velocity_mps[k]) / period_s)),
        max: [0, 1].map(|k| within(k, (limit_mps - velocity_mps[k]) / period_s)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_from_its_limit_the_robot_may_do_everything_and_at_it_only_slow_down() {
        let control = InputBox { min: [-2.0; 2], max: [2.0; 2] };
        let at = |velocity| within_speed_limit(&control, velocity, 2.0, 0.004);
        assert_eq!(at([1.5, -1.9]), control);
        let limited = at([2.0, -2.0]);
        assert_eq!((limited.min, limited.max), ([-2.0, 0.0], [0.0, 2.0]));
        let nearly = at([1.998, 0.0]);
        assert!((nearly.max[0] - 0.5).abs() < 1e-9 && nearly.min[0] == -2.0, "{nearly:?}");
        let beyond = at([2.004, -5.0]);
        assert!((beyond.max[0] + 1.0).abs() < 1e-9, "{beyond:?}");
        assert_eq!((beyond.min[1], beyond.max[1]), (2.0, 2.0), "as strong as it can");
    }
}
