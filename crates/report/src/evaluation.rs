//! One self-contained page about many runs: figures over the number of people, and tables.

use core::fmt::Write as _;

use crate::HtmlError;
use crate::density::{DensityFigure, density_svg};
use crate::html::{STYLE, escaped, fill};
use crate::profile::table;

const PAGE: &str = include_str!("assets/evaluation.html");
const TABLE_STYLE: &str = include_str!("assets/profile.css");

/// A table in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EvaluationTable {
    /// What it shows.
    pub title: String,
    /// Headings of the columns.
    pub headings: Vec<String>,
    /// Cells, one per heading in each row.
    pub rows: Vec<Vec<String>>,
}

/// What a page about many runs shows.
#[derive(Debug, Clone, Copy)]
pub struct EvaluationPage<'a> {
    /// Heading, for example the command that ran.
    pub title: &'a str,
    /// What a reader has to know to make the same runs.
    pub subtitle: &'a str,
    /// Figures over the number of people.
    pub figures: &'a [DensityFigure],
    /// Tables.
    pub tables: &'a [EvaluationTable],
}

/// Makes the page of many runs.
///
/// # Errors
/// [`HtmlError`] if a figure could not be drawn.
pub fn evaluation_html(page: &EvaluationPage<'_>) -> Result<String, HtmlError> {
    let mut figures = String::new();
    for figure in page.figures {
        let svg = density_svg(figure)?;
        let title = escaped(&figure.title);
        let _ = write!(figures, "<figure role=\"img\" aria-label=\"{title}\">{}</figure>", fluid(&svg));
    }
    let tables = page.tables.iter().fold(String::new(), |mut text, of| {
        let shown = table(of.headings.iter().map(String::as_str), of.rows.iter().cloned());
        let _ = write!(
            text,
            "<section><h2>{}</h2><div class=\"dense\">{shown}</div></section>",
            escaped(&of.title)
        );
        text
    });
    Ok(fill(PAGE, |name| match name {
        "title" => escaped(page.title),
        "subtitle" => escaped(page.subtitle),
        "style" => format!("{STYLE}\n{TABLE_STYLE}"),
        "figures" => figures.clone(),
        "tables" => tables.clone(),
        _ => String::new(),
    }))
}

/// A picture as wide as its place.
fn fluid(svg: &str) -> String {
    svg.replacen("<svg ", "<svg class=\"plot\" ", 1)
}
