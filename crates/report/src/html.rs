//! One self-contained page: figures, playback seen from above, plots, settings. Nothing is fetched, nothing is stored.

use core::fmt::Write as _;

use latency::{Hop, LatencySummary, Recorder, Statistic};

use crate::display::{number, or_unknown, percent};
use crate::playback::playback_data;
use crate::plot::{Figure, latency_plot, time_figures};
use crate::spans::rung_spans;
use crate::theme::rung_role;
use crate::{Outcome, PlotError, RunRecord, Rung, Verdict, ZeroLevel};

const PAGE: &str = include_str!("assets/page.html");
pub(crate) const STYLE: &str = include_str!("assets/style.css");
const SCRIPT: &str = include_str!("assets/playback.js");

/// Why a page could not be made.
#[derive(Debug, thiserror::Error)]
pub enum HtmlError {
    /// A plot could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

/// Makes the page of a run.
///
/// `zero_levels` come from [`crate::trace_zero_levels`] on the same record; without them the playback shows none.
///
/// # Errors
/// [`HtmlError`] if a plot could not be drawn.
pub fn html(record: &RunRecord, zero_levels: &[ZeroLevel]) -> Result<String, HtmlError> {
    let verdict = Verdict::of(record);
    let spans = rung_spans(record);
    let recorder = Recorder::of(record.filter_period_ns, &record.safe_commands);
    let plots = time_figures(record, &spans)?.iter().map(figure).collect::<String>();
    let path_hops =
        [Hop::EndToEnd, Hop::Bridge, Hop::BridgeToEstimator, Hop::Estimator, Hop::EstimatorToFilter];
    let filter_hops = [
        Hop::FilterLateness,
        Hop::FilterCompute,
        Hop::RobotStateToFilter,
        Hop::Nominal,
        Hop::NominalToFilter,
    ];
    let named = |hops: [Hop; 5]| hops.map(|hop| (hop.label(), recorder.latencies(hop)));
    let latency_plots = figure(&latency_plot("Detections to command, by percentile", &named(path_hops))?)
        + &figure(&latency_plot("Filter and its other inputs, by percentile", &named(filter_hops))?);
    let data = playback_data(record, &spans, zero_levels).to_string().replace('<', "\\u003c");

    Ok(fill(PAGE, |name| match name {
        "title" => escaped(&record.title),
        "style" => STYLE.to_owned(),
        "outcome" => outcome_class(verdict.outcome).to_owned(),
        "headline" => escaped(&verdict.headline()),
        "subtitle" => subtitle(record, &verdict),
        "tiles" => tiles(&verdict),
        "rungs" => rung_legend(&verdict),
        "plots" => plots.clone(),
        "latency_plots" => latency_plots.clone(),
        "latency_table" => latency_table(&verdict),
        "settings" => escaped(&record.settings),
        "model" => escaped(&record.model),
        "data" => data.clone(),
        "script" => SCRIPT.to_owned(),
        _ => String::new(),
    }))
}

/// Replaces each `{{name}}` of `template` once. What is put in is not looked at again.
pub(crate) fn fill(template: &str, mut value_of: impl FnMut(&str) -> String) -> String {
    let mut page = String::with_capacity(1 << 20);
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        page.push_str(before);
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        page.push_str(&value_of(name));
        rest = after;
    }
    page.push_str(rest);
    page
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const fn outcome_class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Reached => "good",
        Outcome::Collision => "bad",
        Outcome::NotReached | Outcome::Unknown => "open",
    }
}

fn subtitle(record: &RunRecord, verdict: &Verdict) -> String {
    let most = record.obstacles.iter().map(|message| message.as_slice().len()).max().unwrap_or(0);
    let people = match most {
        0 => "no obstacles".to_owned(),
        1 => "1 obstacle at a time".to_owned(),
        _ => format!("up to {most} obstacles at a time"),
    };
    let cycles = verdict.latency.counts.cycles;
    let mut subtitle = format!("{:.1} s, {people}, {cycles} filter cycles", verdict.duration_s);
    if verdict.commanders.len() > 1 {
        let _ = write!(subtitle, "; commanded by {}", escaped(&verdict.commanders_in_order()));
    }
    if let Some(shadow) = &verdict.shadow {
        let _ = write!(subtitle, "; {}", escaped(&shadow.sentence()));
    }
    subtitle
}

fn tiles(verdict: &Verdict) -> String {
    let latency = &verdict.latency;
    let end_to_end = latency.hop(Hop::EndToEnd);
    let milliseconds = |value_ns: u64| format!("{:.2} ms", value_ns as f64 / 1e6);
    let end_to_end_text = if end_to_end.count == 0 {
        crate::display::UNKNOWN.to_owned()
    } else {
        milliseconds(end_to_end.p99_ns)
    };
    let end_to_end_note = if end_to_end.count == 0 {
        String::new()
    } else {
        format!("largest {}", milliseconds(end_to_end.max_ns))
    };
    let goal = match verdict.time_to_goal_s {
        Some(time_s) => (format!("{time_s:.2} s"), String::new()),
        None => match verdict.reached {
            Some(_) => {
                ("not reached".to_owned(), format!("{} away", or_unknown(verdict.goal_distance_m, " m")))
            }
            None => (crate::display::UNKNOWN.to_owned(), String::new()),
        },
    };
    let collisions = match verdict.collisions {
        Some(0) => "no contact".to_owned(),
        Some(1) => "1 contact".to_owned(),
        Some(count) => format!("{count} contacts"),
        None => String::new(),
    };
    let tiles = [
        ("Smallest clearance", or_unknown(verdict.min_clearance_m, " m"), collisions),
        ("Time to goal", goal.0, goal.1),
        ("Path length", or_unknown(verdict.path_length_m, " m"), String::new()),
        (
            "Smallest h",
            or_unknown(verdict.min_h_m, " m"),
            format!("smallest SDF {}", or_unknown(verdict.min_sdf_m, " m")),
        ),
        (
            if verdict.shadow.is_some() { "Would-be changes" } else { "Interventions" },
            verdict.interventions.count.to_string(),
            format!("{} of the time", percent(verdict.interventions.time_share)),
        ),
        (
            "Largest slack",
            format!("{} m/s", number(verdict.max_slack_mps, 3)),
            format!("{} infeasible cycles", verdict.infeasible_cycles),
        ),
        ("Sensor to command, p99", end_to_end_text, end_to_end_note),
        (
            "Deadlines kept",
            verdict.deadlines_kept().map_or_else(
                || crate::display::UNKNOWN.to_owned(),
                |share| format!("{:.3} %", 100.0 * share),
            ),
            format!(
                "{} missed, {} commands lost",
                latency.counts.deadline_misses, latency.counts.lost_commands
            ),
        ),
    ];
    tiles.iter().fold(String::new(), |mut text, (name, value, note)| {
        let note = if note.is_empty() { "&nbsp;" } else { note };
        let _ = write!(text, "<div class=\"tile\"><dt>{name}</dt><dd>{value}</dd><p>{note}</p></div>");
        text
    })
}

fn rung_legend(verdict: &Verdict) -> String {
    Rung::ALL.iter().fold(String::new(), |mut text, &rung| {
        let (color, share) = (rung_role(rung).css(), percent(verdict.time_shares.share(rung)));
        let _ = write!(
            text,
            "<li><i style=\"background:var(--{color})\"></i>{} <b>{share}</b></li>",
            rung.label()
        );
        text
    })
}

pub(crate) fn figure(figure: &Figure) -> String {
    let legend = figure.legend.iter().fold(String::new(), |mut text, (role, name)| {
        let _ = write!(text, "<li><i style=\"background:var(--{})\"></i>{}</li>", role.css(), escaped(name));
        text
    });
    let title = escaped(&figure.title);
    format!(
        "<figure><figcaption><h3>{title}</h3><ul class=\"legend\">{legend}</ul></figcaption>{}</figure>",
        figure.svg
    )
}

fn latency_table(verdict: &Verdict) -> String {
    let rows = verdict.latency.hops.iter();
    rows.map(|hop| latency_row(hop.hop.label(), hop.hop.meaning(), &hop.latency)).collect()
}

/// One row of a table of latencies: name and meaning, count, every statistic in µs.
pub(crate) fn latency_row(name: &str, meaning: &str, latency: &LatencySummary) -> String {
    let mut row = format!(
        "<tr><th scope=\"row\">{}<span>{}{}</span></th><td>{}</td>",
        escaped(name),
        escaped(meaning),
        if latency.negative > 0 { format!(", {} negative", latency.negative) } else { String::new() },
        latency.count
    );
    for statistic in Statistic::ALL {
        let cell = latency
            .statistic_ns(statistic)
            .map_or_else(|| "–".to_owned(), |value_ns| format!("{:.1}", value_ns as f64 / 1e3));
        let _ = write!(row, "<td>{cell}</td>");
    }
    row + "</tr>"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theme::Role;

    #[test]
    fn every_colour_of_the_plots_has_a_light_and_a_dark_tone_in_the_style_sheet() {
        for role in Role::ALL {
            let (name, hex) = (role.css(), role.hex());
            assert!(STYLE.contains(&format!("--{name}: {};", hex.to_lowercase())), "light {name}");
            assert_eq!(STYLE.matches(&format!("--{name}: ")).count(), 2, "light and dark {name}");
            assert!(
                STYLE.contains(&format!("[fill=\"{hex}\"] {{ fill: var(--{name}); }}")),
                "fill of {name}"
            );
            assert!(
                STYLE.contains(&format!("[stroke=\"{hex}\"] {{ stroke: var(--{name}); }}")),
                "stroke of {name}"
            );
        }
    }

    #[test]
    fn every_place_of_the_template_is_filled_and_what_is_put_in_is_left_alone() {
        assert_eq!(fill("a {{x}} b", |name| format!("<{name}>{{{{x}}}}")), "a <x>{{x}} b");
    }
}
