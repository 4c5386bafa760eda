//! Runs one method through random scenarios on one thread and prints each run, then simulated seconds per second.
//!
//! `cargo run --release -p evaluation --example speed -- ROBOT METHOD PEOPLE RUNS [SECTION.KEY=VALUE ...]`

use evaluation::{Robot, Scenario, Variant, run, short_hash};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [robot, method, people, runs, sets @ ..] = arguments.as_slice() else {
        return Err("usage: speed ROBOT METHOD PEOPLE RUNS [SECTION.KEY=VALUE ...]".into());
    };
    let robot = Robot::ALL.into_iter().find(|known| known.name() == robot).ok_or("ground or quadrotor")?;
    let variant = Variant::named(robot, method, sets)?;
    let (mut simulated_s, mut cpu_s, mut successes, mut smaller) = (0.0, 0.0, 0, 0);
    for scenario in Scenario::random_set(1, runs.parse()?, &[people.parse()?]) {
        let Some(row) = run(&scenario, &variant, &short_hash(b"example"), &|| false)? else { continue };
        println!(
            "{} success {} {} contact {:?} {:?} cause {:?} {:?} distance {:.3?} time {:.2} s tick {:.1?} µs nominal {:.1?} µs",
            row.scenario,
            row.success,
            row.success_smaller,
            row.contact_s,
            row.contact_smaller_s,
            row.cause,
            row.cause_smaller,
            row.min_distance_m,
            row.time_s,
            row.tick_median_us,
            row.nominal_median_us
        );
        println!(
            "  interventions {} {:.2} slack {} {:.2} margin {:?} braking {} beyond {:.2} {:.2} {:.2}",
            row.interventions,
            row.intervention_share,
            row.slack_cycles,
            row.max_slack,
            row.min_hard_margin,
            row.braking_cycles,
            row.turn_rate_exceeded_share,
            row.acceleration_exceeded_share,
            row.bounds_exceeded_share
        );
        simulated_s += row.time_s;
        cpu_s += row.cpu_s.unwrap_or(0.0);
        successes += u64::from(row.success);
        smaller += u64::from(row.success_smaller);
    }
    println!("{successes} and {smaller} of {runs}; {:.0} simulated s per s", simulated_s / cpu_s);
    Ok(())
}
