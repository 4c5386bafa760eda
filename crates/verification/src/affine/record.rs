//! What a certificate says and what it does not, as plain data for a model's metadata.

use barrier::{DynamicsKind, InputEncoding, Model};
use serde::{Deserialize, Serialize};

use super::cell::StateBox;
use super::onboard::OnboardDeviation;
use super::question::subject_sha256;
use super::search::{Search, Witness, share};

/// The answer to the question asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// `C ≥ −ε` at every state of the region with `h̄ ≥ 0 < ℓ`.
    Proven,
    /// A state of the region violates it; `worst` names one.
    Refuted,
    /// Neither, within the budget.
    Undecided,
}

/// A certificate, or how far it got.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AffineRecord {
    /// Box of relative states the statement is about.
    pub region: StateBox,
    /// `α`, 1/s.
    pub alpha_per_s: f64,
    /// `ε` asked for, m/s.
    pub epsilon_mps: f64,
    /// Whether it holds.
    pub outcome: Outcome,
    /// Smallest `ε` shown to hold on the whole region, m/s; `None` where the budget did not suffice for any.
    pub proven_epsilon_mps: Option<f64>,
    /// `ε/α` of the latter, m: how far h may fall below zero. More radius by as much covers it only if `C ≥ −ε` holds on
    /// `−ε/α ≤ h < 0` too, which this record does not say.
    pub radius_inflation_m: Option<f64>,
    /// Lowest `C` met at the centre of a box: a counterexample where it is below `−ε`.
    pub worst: Option<Witness>,
    /// Boxes examined.
    pub boxes: u64,
    /// Share of the region in failure or with `h̄ < 0`, 0 to 1.
    pub outside_share: f64,
    /// Share proven for the `ε` asked for, 0 to 1.
    pub proven_share: f64,
    /// Share proven for `proven_epsilon_mps` only, as the search settled for it, 0 to 1.
    pub weaker_share: f64,
    /// Share left undecided by the budget, 0 to 1.
    pub undecided_share: f64,
    /// How far the kernel on board is from the exact arithmetic of the statement.
    pub onboard: OnboardDeviation,
    /// SHA-256 of parameters, pair, true boxes and radius ([`subject_sha256`]).
    pub subject_sha256: String,
    /// What the statement covers.
    pub covers: String,
    /// What it does not cover.
    pub does_not_cover: Vec<String>,
}

impl AffineRecord {
    pub(crate) fn new(model: &Model, search: &Search<'_>, onboard: OnboardDeviation) -> Self {
        let (settings, tally) = (search.settings, &search.tally);
        let outside_share = share(tally.outside);
        let proven_share = share(tally.proven);
        let weaker_share = share(tally.aside);
        let open: u64 = search.waiting.iter().chain(&search.stack).map(super::cell::Cell::share).sum();
        let refuted = tally.worst.is_some_and(|worst| worst.condition_mps < -settings.epsilon_mps);
        let outcome = match (refuted, open + tally.aside) {
            (true, _) => Outcome::Refuted,
            (false, 0) => Outcome::Proven,
            (false, _) => Outcome::Undecided,
        };
        let provable = search.provable_epsilon_mps();
        let proven_epsilon_mps = provable.is_finite().then_some(provable);
        debug_assert!((outside_share + proven_share + weaker_share + share(open) - 1.0).abs() < 1e-12);
        Self {
            region: settings.region,
            alpha_per_s: settings.alpha_per_s,
            epsilon_mps: settings.epsilon_mps,
            outcome,
            proven_epsilon_mps,
            radius_inflation_m: proven_epsilon_mps.map(|epsilon| epsilon / settings.alpha_per_s),
            worst: tally.worst,
            boxes: tally.boxes,
            outside_share,
            proven_share,
            weaker_share,
            undecided_share: share(open),
            onboard,
            subject_sha256: subject_sha256(model),
            covers: COVERS.to_owned(),
            does_not_cover: does_not_cover(model),
        }
    }
}

const COVERS: &str = "For every relative state of the region with h >= 0 and l > 0, whatever the one obstacle does \
    within its true box, some control of the robot's true box keeps dh/dt + alpha h >= -proven_epsilon, in continuous \
    time and real arithmetic, for the stored parameters. Bounds are second-order Taylor models with rounding accounted for.";

fn does_not_cover(model: &Model) -> Vec<String> {
    let mut limits = vec![
        "more than one obstacle at a time: the composite can be infeasible where each pair is not".to_owned(),
        "states outside the region, and motion that leaves it".to_owned(),
        "the time between two control cycles, delays, and errors of estimate and of the robot's model"
            .to_owned(),
        "obstacles that exceed the bounds the model was solved for".to_owned(),
        "the single-precision kernel itself: `onboard` holds its measured, not proven, deviation".to_owned(),
    ];
    let grid = &model.metadata().grid;
    if model.weights().encoding() == InputEncoding::Raw && grid.periodic.contains(&true) {
        limits.push("the seam of the angle, across which h of a network with raw inputs jumps".to_owned());
    }
    if model.metadata().dynamics == DynamicsKind::DoubleIntegratorPair {
        limits.push("limits of the robot's own speed, which the relative state does not know".to_owned());
    }
    limits
}

/// Bounds of a search that has hardly begun are astronomic; the record keeps them, people are spared.
const WORTH_TELLING_MPS: f64 = 100.0;

impl std::fmt::Display for AffineRecord {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let epsilon = self.epsilon_mps;
        match self.outcome {
            Outcome::Proven => write!(f, "proven: C >= -{epsilon} m/s on the region")?,
            Outcome::Refuted => write!(f, "refuted: C < -{epsilon} m/s somewhere on the region")?,
            Outcome::Undecided => write!(f, "undecided within the budget: C >= -{epsilon} m/s")?,
        }
        write!(f, " (alpha = {} 1/s, {} boxes", self.alpha_per_s, self.boxes)?;
        writeln!(f, ", undecided share {:.2e})", self.undecided_share)?;
        if let (Some(proven), Some(inflation)) = (self.proven_epsilon_mps, self.radius_inflation_m)
            && proven < WORTH_TELLING_MPS
        {
            writeln!(
                f,
                "  proven on all of it: C >= -{proven:.4} m/s; if it holds down to h = -{inflation:.4} m too, h falls no lower"
            )?;
        }
        if let Some(worst) = self.worst {
            writeln!(
                f,
                "  worst state met: C = {:.4} m/s, h = {:.4} m at {:?}",
                worst.condition_mps, worst.barrier_m, worst.z
            )?;
        }
        Ok(())
    }
}
