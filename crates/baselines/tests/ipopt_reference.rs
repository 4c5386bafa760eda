//! The planners against IPOPT's stored answers.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;
mod reference;

use std::collections::BTreeMap;

use baselines::MethodKind;

#[test]
fn dump() {
    let mut all: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for (i, problem) in reference::problems().iter().enumerate() {
        let output = common::plan(&problem.parameters(), problem.start, [0.0; 2], &problem.people);
        let outcome = problem.outcome(&output);
        *all.entry(problem.kind.name().into()).or_default().entry(format!("{outcome:?}")).or_default() += 1;
        if !matches!(outcome, reference::Outcome::SameBest | reference::Outcome::BothInfeasible)
            || output.iterations > 12
        {
            eprintln!(
                "{i} {} {outcome:?} {:?} it {} cost {} slack {:.2e} u {:?} ipopt {:?}",
                problem.kind,
                output.verdict,
                output.iterations,
                output.cost,
                output.slack,
                output.control,
                problem.minima
            );
        }
    }
    eprintln!("{all:#?}");
    let _ = MethodKind::ALL;
}
