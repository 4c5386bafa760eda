//! Writes the page and the trace of a made-up profile, to look at them: `cargo run -p report --example synthetic_profile DIR`.

#[path = "../../latency/tests/made_up/mod.rs"]
mod made_up;

use std::fs::File;
use std::path::PathBuf;

use latency::{Across, Budget, chrome_trace, compare, judge, write_hlog};
use made_up::{Plan, profile};
use report::{ProfilePage, profile_html};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("give the folder to write to")?);
    std::fs::create_dir_all(&folder)?;
    let (old, _) = profile(&[1, 2, 3].map(|seed| Plan { slowness: 1.4, ..Plan::quiet(5_000, seed) }));
    let plans = [
        Plan { overslept: 1_700, ..Plan::quiet(5_000, 11) },
        Plan { first_frame: 300, ..Plan::quiet(5_000, 12) },
        Plan::quiet(5_000, 13),
    ];
    let (figures, runs) = profile(&plans);
    let comparison = compare(&old, &figures, Across::Mark)?;
    let budgets: Vec<Budget> =
        ["end_to_end.p99<=1ms", "end_to_end.p99<=+10%", "deadline_misses<=0", "resident<=150MB"]
            .iter()
            .map(|text| text.parse())
            .collect::<Result<_, _>>()?;
    let judged = judge(&budgets, &figures, Some(&comparison))?;
    println!("{figures}\n\n{}\n\n{comparison}\n", figures.repeats_table());
    for judged in &judged {
        println!("{judged}");
    }
    let title = "cncbf profile crowd.mcap --baseline old.json";
    let page = ProfilePage {
        title,
        figures: &figures,
        runs: &runs,
        comparison: Some(&comparison),
        judged: &judged,
        warnings: &[],
        notes: &[],
    };
    std::fs::write(folder.join("profile.html"), profile_html(&page)?)?;
    figures.write(File::create(folder.join("profile.json"))?)?;
    write_hlog(&figures, &mut File::create(folder.join("profile.hlog"))?)?;
    chrome_trace(&runs[0], std::io::BufWriter::new(File::create(folder.join("trace.json"))?))?;
    Ok(())
}
