//! One self-contained page for a profile: figures, percentile curves, and what ran around the worst moments.

mod rows;
mod tables;
mod worst;

use core::fmt::Write as _;

use latency::{Comparison, Hop, Judged, Latencies, LoopFigures, ProfileFigures, RunMessages, SHOWN};

use crate::html::{STYLE, escaped, figure, fill};
use crate::plot::{Figure, TimedRepeat, latency_over_time, latency_plot};
use crate::{HtmlError, PlotError};

pub(crate) use rows::table;

const PAGE: &str = include_str!("assets/profile.html");
const PROFILE_STYLE: &str = include_str!("assets/profile.css");

/// What a page about a profile shows.
#[derive(Debug, Clone, Copy)]
pub struct ProfilePage<'a> {
    /// Heading, for example the command that ran.
    pub title: &'a str,
    /// The figures.
    pub figures: &'a ProfileFigures,
    /// The messages behind them, one entry per repeat in the same order. Without them the page has no plots over time and no
    /// worst moments.
    pub runs: &'a [RunMessages],
    /// The comparison with a baseline, if there is one.
    pub comparison: Option<&'a Comparison>,
    /// Budgets and what became of them.
    pub judged: &'a [Judged],
    /// What went otherwise than it was meant to, for example a rate that was not held.
    pub warnings: &'a [String],
    /// What else a reader has to know, for example which load ran beside it.
    pub notes: &'a [String],
}

/// Makes the page of a profile.
///
/// # Errors
/// [`HtmlError`] if a plot could not be drawn.
pub fn profile_html(page: &ProfilePage<'_>) -> Result<String, HtmlError> {
    let figures = page.figures;
    let (class, headline) = verdict(page);
    let curves = percentile_plots(figures)?.iter().map(figure).collect::<String>();
    let over_time = time_plots(page)?.iter().map(figure).collect::<String>();
    let worst = worst::sections(page);
    Ok(fill(PAGE, |name| match name {
        "title" => escaped(page.title),
        "style" => format!("{STYLE}\n{PROFILE_STYLE}"),
        "outcome" => class.to_owned(),
        "headline" => escaped(&headline),
        "subtitle" => escaped(&subtitle(figures)),
        "remarks" => tables::remarks(page.warnings, page.notes),
        "tiles" => tables::tiles(figures),
        "budgets" => tables::budgets(page.judged),
        "comparison" => page.comparison.map(tables::comparison).unwrap_or_default(),
        "hops" => tables::hops(figures),
        "negative" => tables::negative(figures),
        "start_up" => tables::start_up(figures),
        "curves" => curves.clone(),
        "over_time" => over_time.clone(),
        "repeats" => tables::repeats(figures),
        "loops" => tables::loops(figures),
        "worst" => worst.clone(),
        "memory" => tables::memory(figures),
        "machine" => tables::machine(&figures.conditions),
        "rights" => tables::rights(figures),
        _ => String::new(),
    }))
}

/// Colour class and one line that says how it went. Without budgets nothing is good or bad.
fn verdict(page: &ProfilePage<'_>) -> (&'static str, String) {
    let broken = page.judged.iter().filter(|judged| judged.fails()).count();
    let unclear = page.judged.iter().filter(|judged| judged.outcome == latency::Outcome::Unclear).count();
    let of = page.judged.len();
    if broken > 0 {
        return ("bad", format!("{broken} of {of} budgets broken"));
    }
    if unclear > 0 {
        return ("open", format!("No budget broken, {unclear} of {of} unclear"));
    }
    if of > 0 {
        return ("good", if of == 1 { "Budget kept".to_owned() } else { format!("All {of} budgets kept") });
    }
    let end_to_end = page.figures.summary().hop(Hop::EndToEnd);
    if end_to_end.count == 0 {
        return ("open", "No detection reached a command".to_owned());
    }
    let text = format!(
        "Detection to command: p50 {}, p99 {}, largest {}",
        rows::time(end_to_end.p50_ns),
        rows::time(end_to_end.p99_ns),
        rows::time(end_to_end.max_ns)
    );
    ("", text)
}

fn subtitle(figures: &ProfileFigures) -> String {
    let conditions = &figures.conditions;
    let mut text = format!(
        "{} at rate {}, {}, load {}, filter trigger {}, wait {}, transport {}",
        conditions.recording.file_name,
        conditions.rate,
        figures.repeats_in_words(),
        conditions.load,
        conditions.trigger,
        conditions.wait,
        conditions.transport
    );
    if conditions.closed_loop {
        text.push_str(", closed loop");
    }
    let _ = write!(text, ", cncbf {}", conditions.tool_version);
    text
}

/// The percentile curves of hops, loops and repeats.
fn percentile_plots(figures: &ProfileFigures) -> Result<Vec<Figure>, PlotError> {
    let hops = |wanted: &[Hop]| -> Vec<(&'static str, &Latencies)> {
        wanted.iter().filter_map(|&hop| Some((hop.label(), figures.hop(hop)?))).collect()
    };
    let loops = |pick: fn(&LoopFigures) -> &Latencies| -> Vec<(&'static str, &Latencies)> {
        let all = figures.pooled.loops.iter().map(|of| (of.process.label(), pick(of)));
        all.filter(|(_, latencies)| latencies.count() > 0).collect()
    };
    let path = [Hop::EndToEnd, Hop::Bridge, Hop::BridgeToEstimator, Hop::Estimator, Hop::EstimatorToFilter];
    let filter = [
        Hop::FilterLateness,
        Hop::FilterCompute,
        Hop::FilterHandOver,
        Hop::RobotStateToFilter,
        Hop::NominalToFilter,
    ];
    let repeats: Vec<_> = figures
        .repeats
        .iter()
        .zip(REPEATS)
        .filter_map(|(repeat, name)| {
            let of = repeat.hops.iter().find(|of| of.hop == Hop::EndToEnd)?;
            Some((name, &of.latencies))
        })
        .collect();
    let mut plots = vec![
        latency_plot("Detections to command, by percentile", &hops(&path))?,
        latency_plot("Filter and its other inputs, by percentile", &hops(&filter))?,
    ];
    if repeats.len() > 1 {
        plots.push(latency_plot("End to end of each repeat, by percentile", &repeats)?);
    }
    if !figures.pooled.loops.is_empty() {
        plots.push(latency_plot("Lateness of each loop's timer, by percentile", &loops(|of| &of.lateness))?);
        plots.push(latency_plot("Duration of each loop's cycles, by percentile", &loops(|of| &of.duration))?);
    }
    Ok(plots)
}

/// Names of the repeats that plots can tell apart.
const REPEATS: [&str; 5] = ["repeat 1", "repeat 2", "repeat 3", "repeat 4", "repeat 5"];

/// The filter's lateness and the path's length over time.
fn time_plots(page: &ProfilePage<'_>) -> Result<Vec<Figure>, PlotError> {
    if page.runs.is_empty() {
        return Ok(Vec::new());
    }
    let period_ns = page.figures.conditions.filter_period_ns;
    Ok(vec![
        latency_over_time(
            "Lateness of the filter's timer over time",
            &timed(page, worst::Measured::lateness),
            period_ns,
        )?,
        latency_over_time("Detection to command over time", &timed(page, worst::Measured::end_to_end), 0)?,
    ])
}

/// One kind of length of every repeat whose messages are at hand, over time.
fn timed<'a>(
    page: &ProfilePage<'a>,
    lengths: fn(&worst::Measured<'a>) -> Vec<(u64, u64)>,
) -> Vec<TimedRepeat> {
    worst::measured(page)
        .zip(REPEATS)
        .map(|(run, name)| TimedRepeat { name, start_ns: run.start_ns, lengths: lengths(&run) })
        .collect()
}

/// The figures that comparison tables show, as headings.
fn shown() -> impl Iterator<Item = &'static str> {
    SHOWN.into_iter().map(latency::Statistic::label)
}
