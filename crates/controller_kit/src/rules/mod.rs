//! What is asked of a nominal controller, rule by rule: pure functions of what was seen.

mod manners;
mod timing;
mod wire;

use settings::Settings;

use crate::check::Plan;
use crate::findings::Check;
use crate::observations::{Observations, Phase};
use crate::robot;

/// Judges everything, in the order of the script.
pub(crate) fn judge(seen: &Observations, plan: &Plan<'_>) -> Vec<Check> {
    let settings = plan.settings;
    vec![
        manners::speaks(seen, plan.patience_s),
        manners::late_start(seen),
        manners::stays(seen),
        timing::rate(seen, &settings.filter),
        timing::age(seen, &settings.nominal),
        wire::stamps(seen),
        wire::codes(seen, robot::kind(settings)),
        wire::finite(seen),
        manners::first_goal(seen, settings.nominal.goal_tolerance_m),
        manners::halt(seen),
        manners::goal_change(seen),
        timing::silence(seen, settings),
        manners::resumes(seen),
        manners::recovers(seen),
        manners::ends(seen),
    ]
}

/// What is worth knowing and breaks no rule.
pub(crate) fn notes(seen: &Observations, settings: &Settings) -> Vec<String> {
    let mut notes = Vec::new();
    let driving: Vec<_> = seen.during(Phase::Driving).filter(|heard| heard.drives()).collect();
    let outside = driving.iter().filter(|heard| {
        let control = heard.command.control;
        (0..2)
            .any(|k| control[k] < settings.robot.control_min[k] || control[k] > settings.robot.control_max[k])
    });
    let outside = outside.count();
    if outside > 0 {
        notes.push(format!(
            "{outside} of {} commands lay outside the robot's box {:?} to {:?}; the filter holds it",
            driving.len(),
            settings.robot.control_min,
            settings.robot.control_max
        ));
    }
    let blind = seen.during(Phase::NotANumber).filter(|heard| heard.drives()).count();
    if blind > 0 {
        notes.push(format!(
            "{blind} commands to drive while the robot state held a NaN; the filter brakes then whatever they say"
        ));
    }
    notes
}

/// Why a rule has nothing to judge: the candidate never spoke.
pub(crate) const SILENT: &str = "not run: it never spoke";
