//! The 200 problems that IPOPT solved, and how an answer of ours compares.

#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(dead_code, unreachable_pub, reason = "every test takes what it needs")]

use baselines::{MethodKind, MethodOutput, Verdict};
use messages::Obstacle;
use serde_json::Value;

use crate::common;

/// Costs that differ by less are the same minimum.
pub const SAME_COST: f64 = 1e-3;

/// One stored problem with IPOPT's answers.
pub struct Problem {
    pub kind: MethodKind,
    pub start: [f64; 3],
    pub people: Vec<Obstacle>,
    /// Processor time that IPOPT took from its first start, ms.
    pub first_cpu_ms: f64,
    /// Whether IPOPT was feasible from that start.
    pub first_feasible: bool,
    /// Cost and first control of every feasible local minimum that IPOPT found from eleven starts, cheapest first.
    pub minima: Vec<(f64, [f64; 2])>,
}

/// How an answer of ours stands to IPOPT's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// The cheapest plan IPOPT knows from any start.
    SameBest,
    /// Another of IPOPT's local minima.
    SameLocal,
    /// Feasible and cheaper than anything IPOPT found.
    Cheaper,
    /// Feasible and dearer than IPOPT's best, at none of its minima.
    Dearer,
    /// Both say that there is no plan.
    BothInfeasible,
    /// Only IPOPT found a plan.
    OnlyIpopt,
    /// Only we found a plan.
    OnlyOurs,
}

fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

pub fn problems() -> Vec<Problem> {
    let path = common::root().join("tests/data/baselines_casadi_reference.json");
    let document: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let problems = document["problems"].as_array().unwrap();
    let read = |problem: &Value| Problem {
        kind: problem["method"].as_str().unwrap().parse().unwrap(),
        start: numbers(&problem["start"]),
        people: problem["obstacles"].as_array().unwrap().iter().map(person).collect(),
        first_cpu_ms: problem["first_cpu_ms"].as_f64().unwrap(),
        first_feasible: problem["first_cost"].is_number(),
        minima: problem["minima"]
            .as_array()
            .unwrap()
            .iter()
            .map(|minimum| (minimum["cost"].as_f64().unwrap(), numbers(&minimum["first_control"])))
            .collect(),
    };
    problems.iter().map(read).collect()
}

fn person(value: &Value) -> Obstacle {
    let [x, y, vx, vy, heading_rad, speed_mps] = numbers(value);
    Obstacle { heading_rad, speed_mps, ..common::person([x, y], [vx, vy]) }
}

impl Problem {
    /// Whether our first control is that of the cheapest plan IPOPT knows.
    pub fn same_first_control(&self, output: &MethodOutput) -> bool {
        self.minima
            .first()
            .is_some_and(|(_, first)| (0..2).all(|k| (output.control[k] - first[k]).abs() < 1e-3))
    }

    pub fn outcome(&self, output: &MethodOutput) -> Outcome {
        let feasible = output.verdict == Verdict::Feasible;
        match self.minima.first() {
            None if feasible => Outcome::OnlyOurs,
            None => Outcome::BothInfeasible,
            Some(_) if !feasible => Outcome::OnlyIpopt,
            Some(&(best, _)) => {
                let same = |cost: f64| (output.cost - cost).abs() <= SAME_COST * cost;
                if same(best) {
                    Outcome::SameBest
                } else if self.minima.iter().any(|&(cost, _)| same(cost)) {
                    Outcome::SameLocal
                } else if output.cost < best {
                    Outcome::Cheaper
                } else {
                    Outcome::Dearer
                }
            }
        }
    }
}
