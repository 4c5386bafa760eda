//! The planners against IPOPT's stored answers to 200 problems.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;
mod reference;

use std::collections::BTreeMap;

use baselines::MethodParameters;
use reference::Outcome;

/// Measured: feasibility agrees on all 200; of the 168 with a plan ours is IPOPT's best of seven starts on 165. The other
/// three are a dearer local minimum that IPOPT knows too (RNTC-MPC, another side of two people) and two plans of VO-MPC
/// that end on an edge of its cut cones, where no derivative leads on.
#[test]
fn cost_and_feasibility_agree_with_ipopts() {
    let mut counts: BTreeMap<Outcome, usize> = BTreeMap::new();
    let (mut same_first, mut binding) = (0, 0);
    for (index, problem) in reference::problems().iter().enumerate() {
        let parameters = MethodParameters::published(problem.kind);
        let output = common::plan(&parameters, problem.start, [0.0; 2], &problem.people);
        let outcome = problem.outcome(&output);
        *counts.entry(outcome).or_default() += 1;
        same_first += usize::from(problem.same_first_control(&output));
        binding += usize::from(output.hard_feasibility_margin.abs() < 1e-3);
        // IPOPT searched from seven starts: a plan far below its best would mean another problem was solved.
        assert!(outcome != Outcome::Cheaper, "{index} {}: {output:?} {:?}", problem.kind, problem.minima);
        assert!(outcome != Outcome::OnlyOurs, "{index} {}: {output:?}", problem.kind);
        assert!(outcome != Outcome::OnlyIpopt, "{index} {}: {output:?}", problem.kind);
    }
    let count = |outcome| counts.get(&outcome).copied().unwrap_or(0);
    assert_eq!(counts.values().sum::<usize>(), 200);
    assert_eq!(count(Outcome::BothInfeasible), 32, "{counts:?}");
    assert!(count(Outcome::SameBest) >= 165, "{counts:?}");
    assert!(binding >= 46, "{binding} plans touch a demand");
    assert!(same_first >= 160, "{same_first} {counts:?}");
}
