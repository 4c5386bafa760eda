//! A verification as text: each figure with the sentence that says what it means.
//!
//! Not here: the figures. Layout: a line per figure, value first.

use std::fmt::{Display, Formatter, Result};

use crate::condition::ConditionRecord;
use crate::rollout::{DisturbancePolicy, HOLD_S, NominalPolicy};
use crate::scenario::ScenarioRecord;
use crate::statistics::{ErrorSummary, Share};
use crate::structural::StructuralRecord;
use crate::value_error::ValueErrorRecord;
use crate::verification::Verification;

impl Display for Verification {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        if self.kernel.is_empty() {
            return writeln!(f, "nothing is verified; run `cncbf verify MODEL`");
        }
        writeln!(f, "judged with kernel {}", self.kernel)?;
        if let Some(structural) = &self.structural {
            write!(f, "\n{structural}")?;
        }
        if let Some(value_error) = &self.value_error {
            write!(f, "\n{value_error}")?;
        }
        if let Some(condition) = &self.condition {
            write!(f, "\n{condition}")?;
        }
        if let Some(scenario) = &self.scenario {
            write!(f, "\n{scenario}")?;
        }
        if let Some(affine) = &self.affine {
            write!(f, "\n(e) proof on a box: {affine}")?;
        }
        Ok(())
    }
}

/// A figure and its meaning.
fn line(f: &mut Formatter<'_>, figure: &str, meaning: &str) -> Result {
    writeln!(f, "  {figure:>22}  {meaning}")
}

impl Display for StructuralRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let verdict = if self.holds { "holds" } else { "BROKEN" };
        writeln!(f, "(a) structure: {verdict}")?;
        writeln!(f, "  {}", self.argument)?;
        let of = |count: u64, states: u64| format!("{count} of {states}");
        line(
            f,
            &of(self.above_failure_function, self.states),
            "states with h > l, as the kernel computes them",
        )?;
        line(
            f,
            &of(self.failure_called_safe, self.states_in_failure),
            "states in contact that are called safe",
        )?;
        let bound = format!("{:.1} m", self.residual_bound_m);
        line(f, &bound, "bound on the residual over all states: it is always finite")
    }
}

impl Display for ValueErrorRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "(b) error against the truth: {}", self.truth)?;
        errors(f, &self.error, "all states outside the failure disc")?;
        let near = format!("states with |V| < {} m", self.near_zero_band_m);
        errors(f, &self.near_zero, &near)?;
        share(
            f,
            &self.shell_called_safe,
            "of the states that cannot avoid contact (V < 0 < l) are called safe",
        )?;
        let worst = format!("{:.3} m", self.shell_called_safe_worst_m);
        line(f, &worst, "lowest true value among them: how deep a contact may be that h does not see")?;
        share(f, &self.safe_called_unsafe, "of the safe states are called unsafe: room given away")?;
        if self.states_not_covered > 0 {
            line(f, &self.states_not_covered.to_string(), "states lie outside the truth and count nowhere")?;
        }
        Ok(())
    }
}

fn errors(f: &mut Formatter<'_>, errors: &ErrorSummary, which: &str) -> Result {
    let millimetres = |metres: f64| format!("{:.1}", 1e3 * metres);
    let sizes = [errors.mean_m, errors.p99_m, errors.max_m].map(millimetres).join(" / ");
    line(f, &format!("{sizes} mm"), &format!("mean / p99 / largest |h - V|, {which} ({})", errors.states))?;
    line(f, &format!("{} mm", millimetres(errors.bias_m)), "mean h - V there: below zero is cautious")
}

fn share(f: &mut Formatter<'_>, share: &Share, meaning: &str) -> Result {
    let percent = |share: f64| format!("{:.4}", 1e2 * share);
    let interval =
        format!("{} .. {} %, {} of {}", percent(share.low), percent(share.high), share.count, share.of);
    line(f, &format!("{} %", percent(share.share)), &format!("{meaning} (95 %: {interval})"))
}

impl Display for ConditionRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let alpha = self.settings.alpha_per_s;
        writeln!(
            f,
            "(c) CBF condition C = max_u min_d grad h . zeta + alpha h, alpha = {alpha} 1/s, worst admissible obstacle"
        )?;
        let (band, violate) = (self.band_m, "violate it");
        share(f, &self.violated_safe, &format!("of the states with h >= 0 {violate}"))?;
        share(f, &self.violated_band_above, &format!("of those with 0 <= h < {band} m {violate}"))?;
        share(f, &self.violated_band, &format!("of those with |h| < {band} m {violate}"))?;
        let z = self.worst_state;
        let place =
            format!("z = [{:.3}, {:.3}, {:.3}, {:.3}], h = {:.3} m", z[0], z[1], z[2], z[3], self.worst_h_m);
        let worst = format!("{:.3} m/s", self.worst_mps);
        let sampled = self.worst_sampled_mps;
        line(f, &worst, &format!("lowest C found with h >= 0, at {place}; {sampled:.3} without the search"))?;
        let covers = if self.inflation_covers {
            "as much more radius covers it: C >= -epsilon was met below zero too"
        } else {
            "epsilon/alpha; no cover: C falls below -epsilon for h < 0 as well"
        };
        line(f, &format!("{:.3} m", self.inflation_m), covers)?;
        match self.violation_free_inflation_m {
            Some(metres) => {
                line(f, &format!("{metres:.3} m"), "more radius leave no sampled state that violates")
            }
            None => line(f, "none", "no radius inflation up to 0.5 m leaves the samples without a violation"),
        }
    }
}

impl Display for ScenarioRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        let settings = &self.settings;
        let nominal = match settings.nominal {
            NominalPolicy::TowardObstacle => "the robot drives at the obstacle".to_owned(),
            NominalPolicy::LowersBarrier => "the robot wants what lowers h fastest".to_owned(),
            NominalPolicy::Random => format!("the robot wants random controls, held {HOLD_S} s"),
        };
        let disturbance = match settings.disturbance {
            DisturbancePolicy::LowersBarrier => "the obstacle does what lowers h fastest".to_owned(),
            DisturbancePolicy::Random => format!("the obstacle acts at random, held {HOLD_S} s"),
            DisturbancePolicy::Zero => "the obstacle keeps course and speed".to_owned(),
        };
        let (horizon, hertz) = (settings.horizon_s, settings.period_s.recip());
        writeln!(f, "(d) scenario certificate: {nominal}; {disturbance}; {horizon} s at {hertz:.0} Hz")?;
        writeln!(f, "  {}", self.statement)?;
        writeln!(
            f,
            "  contact deeper than {} m; P is bounded with confidence 1 - {:e}:",
            settings.tolerance_m, settings.beta
        )?;
        writeln!(
            f,
            "  {:>12} {:>9} {:>9} {:>12} {:>19} {:>12}",
            "start h >=", "rollouts", "contact", "P <=", "contact in the box", "P <="
        )?;
        for row in &self.rows {
            let (level, of, all, inside) = (row.level_m, row.rollouts, row.failures, row.failures_in_box);
            let (epsilon, in_box) = (row.epsilon, row.epsilon_in_box);
            writeln!(f, "  {level:>10.2} m {of:>9} {all:>9} {epsilon:>12.3e} {inside:>19} {in_box:>12.3e}")?;
        }
        for depth in &self.depths {
            let meaning = format!("rollouts came closer than R by more than {} m", depth.deeper_than_m);
            line(f, &depth.rollouts.to_string(), &meaning)?;
        }
        let closest = format!("{:.3} m", self.closest.clearance_m);
        line(f, &closest, "smallest clearance of any rollout; below zero is contact")?;
        line(f, &self.left_box.to_string(), "rollouts left the trained box at some time")?;
        if self.without_answer > 0 {
            line(
                f,
                &self.without_answer.to_string(),
                "rollouts had no finite answer; they count as failures",
            )?;
        }
        match self.highest_failing_start_m {
            Some(metres) => line(f, &format!("{metres:.3} m"), "highest h a failing rollout began with"),
            None => line(f, "none", "of the rollouts failed"),
        }
    }
}
