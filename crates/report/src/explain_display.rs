//! One moment as terminal text.

use core::fmt;

use crate::display::{number, percent};
use crate::{BarrierTerms, Constraint, CriticalObstacle, Explanation, InputAges, Neighbour, words};

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "At {:.3} s (stack clock {} ns, command {}):",
            self.time_s, self.stack_time_ns, self.sequence
        )?;
        writeln!(f, "  status       {}: {}", self.status.label(), self.status_in_words)?;
        writeln!(f, "  reason       {}: {}", self.reason, self.reason_in_words)?;
        let [since_s, until_s] = self.status_held_s;
        writeln!(f, "  held         from {since_s:.3} s to {until_s:.3} s")?;
        self.write_control(f)?;
        match &self.barrier {
            Some(barrier) => write_barrier(f, barrier)?,
            None => writeln!(f, "  barrier      not evaluated")?,
        }
        let outside = self.outside_domain;
        writeln!(
            f,
            "  obstacles    {} in the composite, {outside} outside the model's domain",
            self.obstacle_count
        )?;
        if let Some(critical) = &self.critical {
            write_critical(f, critical)?;
        }
        write_ages(f, &self.ages)?;
        write_neighbour(f, "1 s before", self.before.as_ref(), "the run had not begun")?;
        write_neighbour(f, "1 s after", self.after.as_ref(), "the run had ended")
    }
}

impl Explanation {
    fn write_control(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for index in 0..2 {
            let (name, unit) = (self.control_components[index], self.control_units[index]);
            let [wanted, sent] = [self.nominal[index], self.control[index]];
            let label = if index == 0 { "control" } else { "" };
            writeln!(
                f,
                "  {label:<13}{name} {wanted:+.3} wanted, {sent:+.3} {unit} sent ({:+.3})",
                sent - wanted
            )?;
        }
        let verb = if self.corrected { "changed" } else { "left as it was" };
        writeln!(f, "               |u - u_nom| {:.3}: the nominal command was {verb}", self.correction)
    }
}

fn write_barrier(f: &mut fmt::Formatter<'_>, barrier: &BarrierTerms) -> fmt::Result {
    writeln!(f, "  barrier      h {} m, SDF {} m", number(barrier.h_m, 3), number(barrier.sdf_m, 3))?;
    let outcome = match barrier.constraint {
        Constraint::Absent => {
            return writeln!(f, "  constraint   absent: no obstacle is near");
        }
        Constraint::Inactive => "inactive: the nominal command satisfied it",
        Constraint::Active => "active: the nominal command violated it and was moved onto its boundary",
        Constraint::Violated => "violated: no admissible command satisfied it, slack took the rest",
    };
    writeln!(
        f,
        "               drift {:+.3}  L_g h·u {:+.3}  α·h {:+.3}  sum {:+.3} m/s (with u_nom {:+.3})",
        barrier.drift_mps,
        barrier.lg_h_u_mps,
        barrier.alpha_h_mps,
        barrier.condition_mps,
        barrier.condition_nominal_mps
    )?;
    writeln!(f, "  constraint   {outcome}")?;
    writeln!(
        f,
        "               slack {} m/s, best any admissible command reaches {} m/s",
        number(barrier.slack_mps, 4),
        number(barrier.hard_margin_mps, 3)
    )
}

fn write_critical(f: &mut fmt::Formatter<'_>, critical: &CriticalObstacle) -> fmt::Result {
    let share = percent(critical.share);
    writeln!(
        f,
        "  because of   track {}, h̄ {} m, {share} of the composite",
        critical.track_id,
        number(critical.h_m, 3)
    )?;
    let Some(place) = &critical.place else {
        return writeln!(f, "               the record does not hold its estimate");
    };
    let [forward, left] = place.position_in_base_m;
    let where_it_is = words::direction(place.position_in_base_m);
    writeln!(
        f,
        "               {} {where_it_is}, {:.2} m between centres ({forward:+.2} forward, {left:+.2} left), {:.2} m between discs",
        place.class, place.distance_m, place.clearance_m
    )?;
    let closing = place.closing_speed_mps.map_or_else(
        || "closing speed unknown".to_owned(),
        |speed| {
            if speed >= 0.0 {
                format!("closing at {speed:.2} m/s")
            } else {
                format!("receding at {:.2} m/s", -speed)
            }
        },
    );
    writeln!(f, "               moving at {:.2} m/s, {closing}, estimate {}", place.speed_mps, place.quality)
}

fn write_ages(f: &mut fmt::Formatter<'_>, ages: &InputAges) -> fmt::Result {
    let age =
        |value: Option<f64>| value.map_or_else(|| "none yet".to_owned(), |age_ms| format!("{age_ms:.1} ms"));
    writeln!(
        f,
        "  input ages   robot state {}, detections {}, nominal command {}",
        age(ages.robot_state_ms),
        age(ages.detections_ms),
        age(ages.nominal_ms)
    )
}

fn write_neighbour(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    neighbour: Option<&Neighbour>,
    absent: &str,
) -> fmt::Result {
    let Some(then) = neighbour else {
        return writeln!(f, "  {name:<13}{absent}");
    };
    let h = if then.status.has_barrier() {
        format!("h {} m", number(then.h_m, 3))
    } else {
        "h not evaluated".to_owned()
    };
    let ([first, second], label) = (then.control, then.status.label());
    let (reason, correction) = (&then.reason, then.correction);
    writeln!(
        f,
        "  {name:<13}{label} ({reason}), {h}, u [{first:.3}, {second:.3}], |u - u_nom| {correction:.3}"
    )
}
