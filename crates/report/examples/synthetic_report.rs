//! Writes the page and the picture of a made-up run, to look at them: `cargo run -p report --example synthetic_report DIR`.
//!
//! Optional second and third arguments: duration in s (30) and number of people (10).

#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

use std::path::PathBuf;

use report::{BarrierGrid, Moment, Verdict, ZeroLevel, birds_eye_svg, explain, html, trace_zero_levels};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = PathBuf::from(arguments.first().ok_or("give the folder to write to")?);
    let duration_s = arguments.get(1).map_or(Ok(30.0), |text| text.parse())?;
    let people = arguments.get(2).map_or(Ok(10), |text| text.parse())?;

    let record = synthetic::run(duration_s, people);
    let mut grid_at = |moment: &Moment<'_>| -> Option<BarrierGrid> {
        let time_s = record.seconds(moment.time_ns);
        let velocity = moment.robot_state?.velocity_in_odom_mps();
        let h_m = |position| synthetic::h_m(position, velocity, people, time_s).0;
        BarrierGrid::around(moment.robot_state?.position_in_odom_m, 6.0, 61, h_m).ok()
    };
    let levels = trace_zero_levels(&record, &mut grid_at);
    let verdict = Verdict::of(&record);
    let page = html(&record, &levels)?;
    println!("{verdict}\n\npage: {:.2} MB, {} zero levels", page.len() as f64 / 1e6, levels.len());
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("report.html"), page)?;

    let lowest = record.safe_commands.iter().min_by(|a, b| a.h_m.total_cmp(&b.h_m));
    let time_s = lowest.map_or(0.0, |command| record.seconds(command.ledger.filter_woke_ns));
    let level = lowest.and_then(|command| record.moment_at(command.ledger.filter_woke_ns));
    let level = level.and_then(|moment| grid_at(&moment).map(|grid| ZeroLevel::of(moment.time_ns, &grid)));
    std::fs::write(folder.join("birds_eye.svg"), birds_eye_svg(&record, time_s, level.as_ref()))?;
    print!("\n{}", explain(&record, time_s)?);
    Ok(())
}
