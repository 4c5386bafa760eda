//! The planners in single cycles: empty worlds, symmetry, impossible demands, softness, refusals.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use baselines::{
    DcbfParameters, Inputs, MethodKind, MethodOutput, MethodParameters, NoControl, PlannerParameters,
    RntcParameters, Verdict,
};
use messages::Obstacle;
use optimal_control::{UnicycleMpc, UnicycleMpcSettings};

const PLANNERS: [MethodKind; 4] =
    [MethodKind::SdfMpc, MethodKind::DcbfMpc, MethodKind::VoMpc, MethodKind::RntcMpc];
const GOAL: [f64; 2] = [8.0, 0.0];

fn published(kind: MethodKind, start: [f64; 3], people: &[Obstacle]) -> MethodOutput {
    common::plan(&MethodParameters::published(kind), start, GOAL, people)
}

#[test]
fn with_nobody_in_sight_every_planner_is_the_nominal_one() {
    let mut settings = UnicycleMpcSettings::paper();
    settings.sqp.iteration_limit = 60;
    let start = [0.0, 1.0, -0.4];
    let mut nominal = UnicycleMpc::new(&settings).unwrap();
    nominal.plan(&start, &[GOAL[0], GOAL[1], 0.0], 0.0).unwrap();
    let expected = nominal.controls()[0];
    for kind in PLANNERS {
        let output = published(kind, start, &[common::person([0.0, 20.0], [0.0, -1.0])]);
        assert_eq!((output.verdict, output.obstacle_count), (Verdict::Feasible, 0), "{kind}");
        assert_eq!(output.hard_feasibility_margin, f64::INFINITY);
        assert!(
            (0..2).all(|k| (output.control[k] - expected[k]).abs() < 1e-3),
            "{kind}: {output:?} {expected:?}"
        );
    }
}

#[test]
fn somebody_in_the_way_is_evaded_or_waited_for() {
    let people = [common::person([1.8, 0.15], [-0.3, 0.0])];
    for kind in PLANNERS {
        // Turned away far enough to be outside the cone, from which nobody could turn at once.
        let start = [0.0, 0.0, 0.8];
        let free = published(kind, start, &[]);
        let output = published(kind, start, &people);
        assert_eq!(output.verdict, Verdict::Feasible, "{kind}: {output:?}");
        assert!(output.hard_feasibility_margin > -1e-4 && output.slack < 1e-4, "{kind}: {output:?}");
        assert!(output.cost > free.cost * 1.001, "{kind}: {output:?} {free:?}");
    }
}

#[test]
fn a_world_in_the_mirror_is_answered_in_the_mirror() {
    let people = [common::person([2.0, 0.4], [-0.5, -0.1]), common::person([1.0, -1.5], [0.2, 0.3])];
    let mirrored = people.map(|person| {
        let ([x, y], [vx, vy]) = (person.position_in_odom_m, person.velocity_in_odom_mps);
        common::person([x, -y], [vx, -vy])
    });
    for kind in [MethodKind::SdfMpc, MethodKind::DcbfMpc, MethodKind::VoMpc] {
        let output = published(kind, [0.0, 0.2, 0.1], &people);
        let other = published(kind, [0.0, -0.2, -0.1], &mirrored);
        assert_eq!(output.verdict, other.verdict, "{kind}");
        assert!((output.cost / other.cost - 1.0).abs() < 1e-3, "{kind}: {output:?} {other:?}");
        assert!((output.control[1] + other.control[1]).abs() < 0.01, "{kind}: {output:?} {other:?}");
    }
}

#[test]
fn a_robot_that_cannot_stop_before_somebody_is_told_so_and_still_drives() {
    // 0.25 m/s at least, 3 cm to go.
    let people = [common::person([0.73, 0.0], [-1.0, 0.0])];
    for kind in PLANNERS {
        let output = published(kind, [0.0; 3], &people);
        assert_eq!(output.verdict, Verdict::Infeasible, "{kind}: {output:?}");
        assert!(output.slack > 0.01 && output.hard_feasibility_margin == -output.slack, "{kind}: {output:?}");
        let [speed, yaw_rate] = output.control;
        assert!((0.25..=1.0).contains(&speed) && (-0.8..=0.8).contains(&yaw_rate), "{kind}: {output:?}");
    }
}

#[test]
fn contact_now_is_infeasible_where_the_published_problem_demands_distance_now() {
    // Inside by a centimetre, and parting.
    let people = [common::person([-0.69, 0.0], [-1.0, 0.0])];
    for (kind, expected) in
        [(MethodKind::SdfMpc, Verdict::Infeasible), (MethodKind::DcbfMpc, Verdict::Feasible)]
    {
        let output = published(kind, [0.0; 3], &people);
        assert_eq!(output.verdict, expected, "{output:?}");
    }
}

#[test]
fn a_smaller_price_buys_a_shorter_way_through() {
    let people = [common::person([1.5, 0.1], [0.0, 0.0])];
    let soft = PlannerParameters { violation_weight: 200.0, ..PlannerParameters::published() };
    let hard = published(MethodKind::SdfMpc, [0.0; 3], &people);
    let output = common::plan(&MethodParameters::SdfMpc(soft), [0.0; 3], GOAL, &people);
    assert!(output.slack > 0.01 && output.cost < hard.cost, "{output:?} {hard:?}");
}

#[test]
fn a_margin_keeps_people_farther_away() {
    let people = [common::person([1.8, 0.3], [0.0, 0.0])];
    let mut parameters = PlannerParameters::published();
    let plain = common::plan(&MethodParameters::SdfMpc(parameters), [0.0; 3], GOAL, &people);
    parameters.sight.margin_m = 0.2;
    let wide = common::plan(&MethodParameters::SdfMpc(parameters), [0.0; 3], GOAL, &people);
    assert!(wide.cost > plain.cost * 1.001, "{wide:?} {plain:?}");
}

#[test]
fn a_smaller_gamma_and_a_larger_terminal_margin_demand_more() {
    let people = [common::person([2.2, 0.3], [-0.6, 0.0])];
    let ahead = [common::person([3.9, 0.2], [-0.5, 0.0])];
    let cost = |parameters| common::plan(&parameters, [0.0; 3], GOAL, &people).cost;
    let dcbf = |gamma| MethodParameters::DcbfMpc(DcbfParameters { gamma, ..DcbfParameters::published() });
    assert!(cost(dcbf(0.1)) > cost(dcbf(1.0)) * 1.001);
    let rntc = |terminal_margin_m| {
        MethodParameters::RntcMpc(RntcParameters { terminal_margin_m, ..RntcParameters::published() })
    };
    let cost = |parameters| common::plan(&parameters, [0.0; 3], GOAL, &ahead).cost;
    assert!(cost(rntc(0.5)) > cost(rntc(0.0)) * 1.001);
}

#[test]
fn one_quadratic_program_is_not_called_the_end_of_a_search() {
    let parameters =
        PlannerParameters { iteration_limit: 1, search_again: false, ..PlannerParameters::published() };
    let people = [common::person([1.8, 0.15], [-0.3, 0.0])];
    let output = common::plan(&MethodParameters::SdfMpc(parameters), [0.0; 3], GOAL, &people);
    assert_eq!((output.verdict, output.iterations), (Verdict::IterationLimit, 1), "{output:?}");
}

#[test]
fn a_search_that_ended_early_says_whether_its_plan_will_do() {
    let parameters =
        PlannerParameters { iteration_limit: 1, search_again: false, ..PlannerParameters::published() };
    let ended_early: Vec<_> = [0.05, 0.15, 0.3, 0.6, 0.8, 1.0]
        .into_iter()
        .map(|y| [common::person([1.8, y], [-0.3, 0.0])])
        .map(|people| common::plan(&MethodParameters::SdfMpc(parameters), [0.0; 3], GOAL, &people))
        .filter(|output| output.verdict == Verdict::IterationLimit)
        .collect();
    for output in &ended_early {
        assert_eq!(output.demands_met, output.slack <= parameters.feasibility_tolerance, "{output:?}");
    }
    for met in [true, false] {
        assert!(ended_early.iter().any(|output| output.demands_met == met), "{met}: {ended_early:?}");
    }
}

#[test]
fn a_plan_is_continued_from_cycle_to_cycle_and_forgotten_on_request() {
    let people = common::crowd(&[common::person([1.8, 0.15], [-0.3, 0.0])]);
    let (state, goal) = (common::robot([0.0; 3]), common::goal(GOAL));
    let inputs =
        Inputs { robot_state: Some(&state), obstacles: Some(&people), goal: Some(&goal), nominal: None };
    let mut method =
        MethodParameters::published(MethodKind::SdfMpc).build(&common::ground_robot(), None).unwrap();
    let first = method.step(&inputs, common::NOW_NS).unwrap();
    let second = method.step(&inputs, common::NOW_NS).unwrap();
    assert!(second.iterations < first.iterations, "{first:?} {second:?}");
    method.reset();
    assert_eq!(method.step(&inputs, common::NOW_NS).unwrap(), first);
}

#[test]
fn missing_and_broken_inputs_are_named() {
    let mut method =
        MethodParameters::published(MethodKind::VoMpc).build(&common::ground_robot(), None).unwrap();
    let (state, goal) = (common::robot([0.0; 3]), common::goal(GOAL));
    let mut obstacles = common::crowd(&[common::person([2.0, 0.0], [0.0, 0.0])]);
    let missing = |input| Err(NoControl::Missing { input });
    let mut inputs = Inputs::default();
    assert_eq!(method.step(&inputs, common::NOW_NS), missing("robot_state"));
    inputs.robot_state = Some(&state);
    assert_eq!(method.step(&inputs, common::NOW_NS), missing("goal"));
    inputs.goal = Some(&goal);
    assert_eq!(method.step(&inputs, common::NOW_NS), missing("obstacles"));
    obstacles.items[0].velocity_in_odom_mps[1] = f64::NAN;
    let inputs = Inputs { obstacles: Some(&obstacles), ..inputs };
    let error = method.step(&inputs, common::NOW_NS);
    assert_eq!(error, Err(NoControl::NonFinite { input: "obstacles" }));
}
