//! When the filter looks for a way through the crowd, and what it does until it looks again. The search is `barrier`'s.

use barrier::{AnticipatingRobot, Anticipation, AnticipationHorizon, BarrierObstacle};
use messages::Goal;
use settings::Settings;

use crate::filter::Pair;
use crate::pace::Paces;

/// A double integrator whose limit the settings do not name may be this many times faster than it cruises.
const SPRINT: f64 = 2.0;

/// The anticipation with its pace.
pub(crate) struct Anticipating {
    search: Anticipation,
    paces: Paces,
    period_ns: u64,
    searched_ns: Option<u64>,
    /// The control of the manoeuvre under way; the nominal controller's way is the best without one.
    held: Option<[f64; 2]>,
}

impl Anticipating {
    /// The anticipation of `settings`, if they ask for one.
    pub(crate) fn of(settings: &Settings, pair: &Pair) -> Option<Self> {
        let asked = settings.filter.anticipation.as_ref()?;
        let horizon = AnticipationHorizon {
            horizon_s: asked.horizon_s,
            moments: asked.moments,
            clearance_m: asked.clearance_m,
            clearance_growth_mps: asked.clearance_growth_mps,
            risk_weight: asked.risk_weight,
            turn_share: asked.turn_share,
            trust_s: asked.trust_s,
            negligible_risk_s: asked.negligible_risk_s,
            cruise_speed_mps: asked.cruise_speed_mps,
        };
        let robot = match pair {
            Pair::Unicycle(pair) => AnticipatingRobot::Unicycle { control: pair.control },
            Pair::DoubleIntegrator(pair) => AnticipatingRobot::DoubleIntegrator {
                control: pair.control,
                max_speed_mps: asked.robot_max_speed_mps.unwrap_or(SPRINT * asked.cruise_speed_mps),
            },
        };
        Some(Self {
            search: Anticipation::new(robot, horizon),
            paces: Paces::new(settings.obstacle.max_speed_mps),
            period_ns: asked.period_ms * 1_000_000,
            searched_ns: None,
            held: None,
        })
    }

    /// The control to wish for at `x` in place of the nominal one; `None` where that one is the best there is.
    ///
    /// Without a goal nothing says where the robot wants to be, so the nominal controller is taken at its word.
    pub(crate) fn wish(
        &mut self,
        x: &[f64; 4],
        goal: Option<&Goal>,
        obstacles: &[BarrierObstacle],
        track_ids: &[u64],
        now_ns: u64,
    ) -> Option<[f64; 2]> {
        let goal = goal.filter(|goal| goal.is_finite())?;
        let elapsed_ns = self.searched_ns.and_then(|searched_ns| now_ns.checked_sub(searched_ns));
        if elapsed_ns.is_none_or(|elapsed_ns| elapsed_ns >= self.period_ns) {
            let elapsed_s = elapsed_ns.unwrap_or(0) as f64 * 1e-9;
            let paces_mps = self.paces.of(track_ids, obstacles, elapsed_s);
            self.held = self.search.choose(x, goal.position_in_odom_m, obstacles, paces_mps, elapsed_s);
            self.searched_ns = Some(now_ns);
        }
        self.held
    }
}
