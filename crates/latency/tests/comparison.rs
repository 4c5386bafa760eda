//! Profiles against a baseline and against budgets.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod made_up;

use latency::{
    Across, Budget, Comparison, Hop, Judged, Outcome, ProfileFigures, Quantity, Statistic, compare, judge,
};
use made_up::{conditions, repeats};

const END_TO_END: Quantity = Quantity::Hop(Hop::EndToEnd);

fn judged(text: &str, figures: &ProfileFigures, comparison: Option<&Comparison>) -> Judged {
    let budgets: [Budget; 1] = [text.parse().unwrap()];
    judge(&budgets, figures, comparison).unwrap().remove(0)
}

#[test]
fn a_profile_compared_with_itself_shows_no_sure_change() {
    let figures = repeats(4, 1.0);
    let comparison = compare(&figures, &figures, Across::Refuse).unwrap();
    assert!(comparison.has_intervals() && comparison.differences.is_empty());
    for of in &comparison.quantities {
        for change in &of.changes {
            assert_eq!((change.share().unwrap_or(0.0), change.is_sure()), (0.0, false), "{}", of.quantity);
        }
    }
    assert_eq!(judged("end_to_end.p99<=+0%", &figures, Some(&comparison)).outcome, Outcome::Kept);
}

#[test]
fn a_slower_stack_is_surely_slower_by_what_it_is() {
    let (old, new) = (repeats(4, 1.0), repeats(5, 1.5));
    let comparison = compare(&old, &new, Across::Refuse).unwrap();
    let change = comparison.change(END_TO_END, Statistic::P50).unwrap();
    let share = change.share().unwrap();
    assert!((share - 0.5).abs() < 0.02, "{share}");
    let [low, high] = change.ratio.unwrap();
    assert!(change.is_sure() && low <= share && share <= high, "{low} {share} {high}");
    assert_eq!(judged("end_to_end.p50<=+30%", &new, Some(&comparison)).outcome, Outcome::Broken);
    assert_eq!(judged("end_to_end.p50<=+70%", &new, Some(&comparison)).outcome, Outcome::Kept);
    let text = comparison.to_string();
    assert!(text.contains("bootstrap over 4 and 5 repeats") && text.contains("]*"), "{text}");
    assert_eq!(
        comparison,
        compare(&old, &new, Across::Refuse).unwrap(),
        "the same figures, the same intervals"
    );
}

#[test]
fn a_growth_within_what_repeats_differ_by_is_unclear_not_broken() {
    // One of four repeats on either side is much slower: the pooled p99 hangs on how often it is drawn.
    let mixed = |slow: f64| {
        let mut all = repeats(3, 1.0).repeats;
        all.extend(repeats(1, slow).repeats);
        ProfileFigures::new(conditions(), all)
    };
    let (old, new) = (mixed(2.0), mixed(2.4));
    let comparison = compare(&old, &new, Across::Refuse).unwrap();
    let share = comparison.change(END_TO_END, Statistic::P99).unwrap().share().unwrap();
    assert!(share > 0.05, "{share}");
    let found = judged("end_to_end.p99<=+5%", &new, Some(&comparison));
    assert_eq!((found.outcome, found.fails()), (Outcome::Unclear, false), "{found}");
}

#[test]
fn without_enough_repeats_there_is_no_interval_and_it_says_so() {
    let (old, new) = (repeats(2, 1.0), repeats(4, 1.5));
    let comparison = compare(&old, &new, Across::Refuse).unwrap();
    assert!(!comparison.has_intervals());
    assert!(comparison.to_string().contains("No intervals can be given: 2 and 4 repeats"), "{comparison}");
    let found = judged("end_to_end.p50<=+30%", &new, Some(&comparison));
    assert_eq!(found.outcome, Outcome::Broken);
    assert!(found.measured.contains("no interval"), "{found}");
}

#[test]
fn other_conditions_are_refused_with_the_list_or_marked() {
    let new = repeats(3, 1.0);
    let mut old = new.clone();
    old.conditions.machine.cpu_model = "Other".to_owned();
    old.conditions.machine.cores = 64;
    old.conditions.machine.kernel = "Linux 5".to_owned();
    old.conditions.tool_version = "0.0.9".to_owned();
    old.conditions.recording.sha256 = "other".to_owned();
    old.conditions.rate = 2.0;
    old.conditions.load = "cpu".to_owned();
    old.conditions.wait = "spin".to_owned();
    old.conditions.transport = "dds".to_owned();
    old.conditions.settings_sha256 = "other".to_owned();
    old.repeats[0].rights[0].granted.clear();
    let refused = compare(&old, &new, Across::Refuse).unwrap_err();
    let text = refused.to_string();
    for what in [
        "processor: Other then, Imaginary Processor 9000 now",
        "cores: 64",
        "kernel",
        "tool version: 0.0.9",
        "recording",
        "rate: 2 then, 1 now",
        "load",
        "wait",
        "transport: dds",
        "settings",
        "granted rights",
        "--across",
    ] {
        assert!(text.contains(what), "{what} is missing in {text}");
    }
    assert_eq!(refused.differences.len(), 11);
    let marked = compare(&old, &new, Across::Mark).unwrap();
    assert_eq!(marked.differences, refused.differences);
    assert!(marked.to_string().starts_with("Not comparable without reserve"), "{marked}");

    let mut renamed = new.clone();
    renamed.conditions.recording.file_name = "copy.mcap".to_owned();
    assert!(compare(&renamed, &new, Across::Refuse).is_ok(), "the contents count, not the name");
}

#[test]
fn absolute_budgets_hold_the_figure_itself() {
    let figures = repeats(2, 1.0);
    let p99_ns = figures.hop(Hop::EndToEnd).unwrap().statistic_ns(Statistic::P99).unwrap();
    for (text, outcome) in [
        (format!("end_to_end.p99<={p99_ns}ns"), Outcome::Kept),
        (format!("end_to_end.p99<={}ns", p99_ns - 1), Outcome::Broken),
        ("deadline_misses<=0".to_owned(), Outcome::Kept),
        ("resident<=60MB".to_owned(), Outcome::Kept),
        ("resident<=59.9MB".to_owned(), Outcome::Broken),
        ("minor_faults<=0".to_owned(), Outcome::Kept),
        ("filter_loop_lateness.max<=1ns".to_owned(), Outcome::Broken),
        ("estimator_loop_lateness.max<=1s".to_owned(), Outcome::Unmeasured),
    ] {
        let found = judged(&text, &figures, None);
        assert_eq!(found.outcome, outcome, "{found}");
    }
}

#[test]
fn a_gate_that_measured_nothing_fails_and_a_growth_needs_a_baseline() {
    let nothing = ProfileFigures::new(conditions(), Vec::new());
    for text in ["end_to_end.p99<=1s", "deadline_misses<=0", "major_faults<=0", "resident<=1GB"] {
        let found = judged(text, &nothing, None);
        assert_eq!((found.outcome, found.fails()), (Outcome::Unmeasured, true), "{text}");
    }
    let growth: [Budget; 1] = ["end_to_end.p99<=+10%".parse().unwrap()];
    let refused = judge(&growth, &nothing, None).unwrap_err();
    assert!(refused.to_string().contains("--baseline"), "{refused}");
}
