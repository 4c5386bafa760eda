//! The planners against IPOPT on 200 stored problems: who finds what, and at what cost in processor time.
//!
//! ```text
//! python tests/judges/casadi_baselines_reference.py          # renews IPOPT's times on this machine
//! cargo run --release -p baselines --example against_ipopt
//! ```
//!
//! Both solve cold, from the same policy; processor time, so other load matters little. Construction is left out on both
//! sides.

#![allow(clippy::unwrap_used, reason = "a demonstration may panic")]

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/reference/mod.rs"]
mod reference;

use std::collections::BTreeMap;

use baselines::{
    DcbfParameters, Inputs, MethodKind, MethodOutput, MethodParameters, PlannerParameters, RntcParameters,
};
use reference::{Outcome, Problem};
use rustix::time::{ClockId, clock_gettime};

/// Solves of each problem; the fastest counts.
const REPETITIONS: usize = 3;

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn parameters(kind: MethodKind, search_again: bool) -> Option<MethodParameters> {
    let planner = PlannerParameters { search_again, ..PlannerParameters::published() };
    Some(match kind {
        MethodKind::SdfMpc => MethodParameters::SdfMpc(planner),
        MethodKind::DcbfMpc => {
            MethodParameters::DcbfMpc(DcbfParameters { planner, ..DcbfParameters::published() })
        }
        MethodKind::VoMpc => MethodParameters::VoMpc(planner),
        MethodKind::RntcMpc => {
            MethodParameters::RntcMpc(RntcParameters { planner, ..RntcParameters::published() })
        }
        MethodKind::C3bf | MethodKind::HoCbf => return None,
    })
}

/// The answer to a problem and the processor time of the fastest of several cold solves, ms.
fn solve(method: &mut dyn baselines::Method, problem: &Problem) -> (MethodOutput, f64) {
    let (state, goal) = (common::robot(problem.start), common::goal([0.0; 2]));
    let obstacles = common::crowd(&problem.people);
    let inputs =
        Inputs { robot_state: Some(&state), obstacles: Some(&obstacles), goal: Some(&goal), nominal: None };
    let mut fastest_ms = f64::INFINITY;
    let mut output = None;
    for _ in 0..REPETITIONS {
        method.reset();
        let begun_ms = cpu_ms();
        output = Some(method.step(&inputs, common::NOW_NS).unwrap());
        fastest_ms = fastest_ms.min(cpu_ms() - begun_ms);
    }
    (output.unwrap(), fastest_ms)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn main() {
    let (settings, model, problems) = (common::ground_robot(), common::model(), reference::problems());
    for search_again in [true, false] {
        println!("search_again = {search_again}; times in ms of processor, ours / IPOPT's");
        for kind in MethodKind::ALL {
            let Some(parameters) = parameters(kind, search_again) else { continue };
            let mut method = parameters.build(&settings, Some(&model)).unwrap();
            let mut outcomes: BTreeMap<Outcome, usize> = BTreeMap::new();
            let (mut ours, mut theirs, mut programs, mut faster) = (Vec::new(), Vec::new(), Vec::new(), 0);
            for problem in problems.iter().filter(|problem| problem.kind == kind) {
                let (output, taken_ms) = solve(method.as_mut(), problem);
                *outcomes.entry(problem.outcome(&output)).or_default() += 1;
                faster += usize::from(taken_ms < problem.first_cpu_ms);
                ours.push(taken_ms);
                theirs.push(problem.first_cpu_ms);
                programs.push(f64::from(output.iterations));
            }
            println!(
                "{kind:9} median {:6.2} / {:6.2}   mean {:6.2} / {:6.2}   largest {:6.1} / {:6.1}   faster on {faster} \
                 of {}   programs {:.0} median, {:.1} mean   {outcomes:?}",
                median(&mut ours),
                median(&mut theirs),
                mean(&ours),
                mean(&theirs),
                ours[ours.len() - 1],
                theirs[theirs.len() - 1],
                ours.len(),
                median(&mut programs),
                mean(&programs),
            );
        }
    }
}
