//! The verdict as terminal text.

use core::fmt;

use crate::display::{number, or_unknown, percent};
use crate::{Rung, Verdict};

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |name: &str, value: &str| writeln!(f, "{name:<22}{value}");
        line("verdict", &self.headline())?;
        if let Some(shadow) = &self.shadow {
            line("shadow", &shadow.sentence())?;
        }
        let count =
            |value: Option<u64>| value.map_or_else(|| crate::display::UNKNOWN.to_owned(), |n| n.to_string());
        line("collisions", &count(self.collisions.map(u64::from)))?;
        line("smallest clearance", &or_unknown(self.min_clearance_m, " m"))?;
        line("smallest h", &or_unknown(self.min_h_m, " m"))?;
        line("smallest SDF", &or_unknown(self.min_sdf_m, " m"))?;
        let interventions = &self.interventions;
        line(
            if self.shadow.is_some() { "would-be changes" } else { "interventions" },
            &format!(
                "{} in {} of the time, largest |u - u_nom| {}",
                interventions.count,
                percent(interventions.time_share),
                number(interventions.largest_correction, 3)
            ),
        )?;
        line(
            "slack",
            &format!(
                "at most {} m/s, {} infeasible cycles",
                number(self.max_slack_mps, 4),
                self.infeasible_cycles
            ),
        )?;
        let shares = Rung::ALL
            .iter()
            .map(|&rung| (rung, self.time_shares.share(rung)))
            .filter(|(_, share)| *share > 0.0);
        let shares: Vec<_> =
            shares.map(|(rung, share)| format!("{} {}", rung.label(), percent(share))).collect();
        line("time", &shares.join(", "))?;
        if self.commanders.len() > 1 {
            line("commanders", &self.commanders_in_order())?;
        }
        line("path length", &or_unknown(self.path_length_m, " m"))?;
        let arrival = self
            .time_to_goal_s
            .map_or_else(String::new, |time_s| format!(", at the goal after {time_s:.2} s"));
        line("duration", &format!("{:.2} s{arrival}", self.duration_s))?;
        line("distance to goal", &or_unknown(self.goal_distance_m, " m"))?;
        line(
            "inputs",
            &format!("{} used, {} refused", count(self.accepted_inputs), count(self.refused_inputs)),
        )?;
        write!(f, "{}", self.latency)
    }
}

impl Verdict {
    /// Who commanded, and when each of them began, s after the beginning of the run.
    pub(crate) fn commanders_in_order(&self) -> String {
        let told = self.commanders.iter().map(|segment| {
            let since_s = segment.start_ns.saturating_sub(self.start_ns) as f64 * 1e-9;
            let gap_ms = segment.gap_ns as f64 * 1e-6;
            match segment.gap_ns {
                0 => format!("{} from {since_s:.2} s", segment.name),
                _ => format!("{} from {since_s:.2} s (after {gap_ms:.0} ms without a command)", segment.name),
            }
        });
        told.collect::<Vec<_>>().join(", ")
    }
}
