//! When the joint look-ahead decides in place of the CBF-QP, and what then. The search itself is `barrier`'s.

use barrier::{BarrierObstacle, Escape, HalfSpace, JointEscape, JointHorizon, JointRobot, QpSolution};
use settings::{JointSettings, JointUse, Settings};

use crate::filter::{Pair, beside};

/// The joint look-ahead with its settings.
pub(crate) struct Joint {
    search: JointEscape,
    when: JointUse,
    margin_m: f64,
    period_s: f64,
}

impl Joint {
    /// The look-ahead of `settings`, if they ask for one.
    pub(crate) fn of(settings: &Settings, pair: &Pair) -> Option<Self> {
        let joint: &JointSettings = settings.filter.joint.as_ref()?;
        let horizon = JointHorizon {
            horizon_s: joint.horizon_s,
            moments: joint.moments,
            levels: joint.levels,
            disturbance_share: joint.disturbance_share,
            max_person_speed_mps: settings.obstacle.max_speed_mps,
            max_robot_speed_mps: joint.robot_max_speed_mps.unwrap_or(f64::INFINITY),
            switch_s: joint.switch_s,
        };
        let robot = match pair {
            Pair::Unicycle(pair) => JointRobot::Unicycle {
                control: pair.control,
                turn_rate_radps: pair.disturbance.max[0].max(-pair.disturbance.min[0]),
            },
            Pair::DoubleIntegrator(pair) => {
                JointRobot::DoubleIntegrator { control: pair.control, disturbance: pair.disturbance }
            }
        };
        Some(Self {
            search: JointEscape::new(robot, horizon),
            when: joint.when,
            margin_m: joint.margin_m,
            period_s: settings.filter.period_ms as f64 * 1e-3,
        })
    }

    /// What to do at `x` in place of `solution`, the QP's answer to `row`; `None` where that one may pass.
    pub(crate) fn overrule(
        &mut self,
        x: &[f64; 4],
        obstacles: &[BarrierObstacle],
        row: &HalfSpace<2>,
        solution: &QpSolution<2>,
    ) -> Option<QpSolution<2>> {
        let infeasible = solution.hard_margin < 0.0;
        let asked = match self.when {
            JointUse::Infeasible => infeasible,
            JointUse::Gatekeeper => self.closes(x, obstacles, solution),
            JointUse::Either => infeasible || self.closes(x, obstacles, solution),
        };
        if !asked {
            return None;
        }
        let Escape { u, .. } = self.search.escape(x, &solution.u, obstacles, self.margin_m);
        Some(beside(row, u, solution))
    }

    /// Whether the QP's control leaves no manoeuvre that keeps clear of everybody.
    fn closes(&mut self, x: &[f64; 4], obstacles: &[BarrierObstacle], solution: &QpSolution<2>) -> bool {
        !self.search.remains_after(x, &solution.u, self.period_s, obstacles, self.margin_m)
    }
}
