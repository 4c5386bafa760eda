//! What a profile leaves behind: files for machines and people, tables for whoever watches.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use anyhow::Context;
use latency::{Comparison, Judged, ProfileFigures, RunMessages, write_hlog};
use report::ProfilePage;
use serde::Serialize;

use super::repeat::RepeatNotes;
use crate::cli::ProfileArgs;

/// Everything that came of a profile. As JSON it is the profile that can serve as a baseline, and what else was seen.
#[derive(Serialize)]
pub(super) struct Outcome<'a> {
    #[serde(flatten)]
    pub(super) figures: &'a ProfileFigures,
    /// How often the recording is played in a row in each run.
    pub(super) passes: u32,
    pub(super) notes: &'a [RepeatNotes],
    /// What the options mean for the figures.
    pub(super) cautions: Vec<String>,
    /// What went otherwise than it was meant to.
    pub(super) remarks: Vec<String>,
    pub(super) comparison: Option<&'a Comparison>,
    #[serde(rename = "budgets")]
    pub(super) judged: &'a [Judged],
}

impl Outcome<'_> {
    /// Writes `profile.json`, `profile.hlog` and `profile.html` into `folder`. The page shows the worst moments of `runs`.
    pub(super) fn write(&self, folder: &Path, runs: &[RunMessages]) -> anyhow::Result<()> {
        let create = |name: &str| {
            let path = folder.join(name);
            File::create(&path)
                .with_context(|| format!("cannot write {}", path.display()))
                .map(BufWriter::new)
        };
        let mut json = create("profile.json")?;
        serde_json::to_writer_pretty(&mut json, self)?;
        json.write_all(b"\n")?;
        json.flush()?;
        let mut hlog = create("profile.hlog")?;
        write_hlog(self.figures, &mut hlog)?;
        hlog.flush()?;
        let title = format!("cncbf profile: {}", self.figures.conditions.recording.file_name);
        let page = report::profile_html(&ProfilePage {
            title: &title,
            figures: self.figures,
            runs,
            comparison: self.comparison,
            judged: self.judged,
            warnings: &self.remarks,
            notes: &[self.cautions.clone(), self.loads()].concat(),
        })?;
        let mut html = create("profile.html")?;
        html.write_all(page.as_bytes())?;
        html.flush()?;
        Ok(())
    }

    /// What the load generator did in each repeat.
    fn loads(&self) -> Vec<String> {
        let loads = self.notes.iter().enumerate().filter_map(|(index, note)| Some((index + 1, note.load?)));
        loads.map(|(repeat, load)| format!("load of repeat {repeat}: {load}")).collect()
    }

    /// Prints the tables, or JSON if asked; the rest goes to standard error.
    pub(super) fn print(&self, args: &ProfileArgs, folder: &Path) -> anyhow::Result<()> {
        if args.json {
            println!("{}", serde_json::to_string_pretty(self)?);
        } else {
            println!("{}", self.figures);
            if self.figures.repeats.len() > 1 {
                println!("\n{}", self.figures.repeats_table());
            }
            if let Some(comparison) = self.comparison {
                println!("\n{comparison}");
            }
            if !self.judged.is_empty() {
                println!();
                self.judged.iter().for_each(|judged| println!("{judged}"));
            }
        }
        for load in self.loads() {
            eprintln!("{load}");
        }
        for remark in &self.remarks {
            eprintln!("warning: {remark}");
        }
        eprintln!("figures    {}", folder.join("profile.json").display());
        eprintln!("histograms {}", folder.join("profile.hlog").display());
        eprintln!("report     {}", folder.join("profile.html").display());
        if let Some(trace) = &args.trace {
            eprintln!("trace      {} (open it in ui.perfetto.dev)", trace.display());
        }
        Ok(())
    }
}
