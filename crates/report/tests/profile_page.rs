//! The page of a profile: self-contained, complete, and whole with nothing to show.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../latency/tests/made_up/mod.rs"]
mod made_up;

use latency::{Across, Budget, ProfileFigures, RunMessages, compare, judge};
use made_up::{Plan, conditions, profile};
use report::{ProfilePage, profile_html};

fn page_of(figures: &ProfileFigures, runs: &[RunMessages]) -> String {
    let page = ProfilePage {
        title: "cncbf profile",
        figures,
        runs,
        comparison: None,
        judged: &[],
        warnings: &[],
        notes: &[],
    };
    profile_html(&page).unwrap()
}

fn assert_self_contained(page: &str) {
    let without_namespaces = page.replace("http://www.w3.org/2000/svg", "");
    for outside in ["http://", "https://", "src=", "@import", "url(", "<link", "fetch(", "<script"] {
        assert!(!without_namespaces.contains(outside), "{outside} reaches out of the page");
    }
    assert!(!page.contains("NaN") && !page.contains("{{"));
}

#[test]
fn three_repeats_give_curves_timelines_and_ten_worst_moments() {
    let plans = [
        Plan { overslept: 700, ..Plan::quiet(2_500, 1) },
        Plan { first_frame: 200, ..Plan::quiet(2_500, 2) },
        Plan::quiet(2_500, 3),
    ];
    let (figures, runs) = profile(&plans);
    let page = page_of(&figures, &runs);
    assert_self_contained(&page);
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    assert_eq!(page.matches("<figure class=\"moment\">").count(), 10);
    assert_eq!(page.matches("class=\"plot\"").count(), 5 + 2 + 10);
    assert!(page.contains("crowd &amp; &lt;people&gt;.mcap") && !page.contains("<people>"));
    assert!(page.contains("Detection to command: p50"), "the headline");
    assert!(page.contains("Not in these figures: the start-up"));
    assert!(page.contains("fifo, memory lock"), "refused rights");
    assert!(
        page.contains("\nestimator\n</text>") && !page.contains("\nrecorder\n</text>"),
        "rows with cycle records"
    );
    // The latest cycle is the one that overslept, and its own record says that it skipped.
    let latest = page.split("The latest cycles of the filter").nth(1).unwrap();
    let first = latest.split("<figure").nth(1).unwrap();
    assert!(first.contains("</b> late<span>repeat 1") && first.contains("3 skipped"), "{first}");
}

#[test]
fn budgets_and_a_baseline_give_the_verdict_and_their_tables() {
    let (old, _) = profile(&[1, 2, 3].map(|seed| Plan::quiet(800, seed)));
    let (new, _) = profile(&[4, 5, 6].map(|seed| Plan { slowness: 1.6, ..Plan::quiet(800, seed) }));
    let comparison = compare(&old, &new, Across::Refuse).unwrap();
    let page = |texts: &[&str]| {
        let budgets: Vec<Budget> = texts.iter().map(|text| text.parse().unwrap()).collect();
        let judged = judge(&budgets, &new, Some(&comparison)).unwrap();
        let comparison = Some(&comparison);
        profile_html(&ProfilePage {
            title: "t",
            figures: &new,
            runs: &[],
            comparison,
            judged: &judged,
            warnings: &[],
            notes: &[],
        })
        .unwrap()
    };
    let broken = page(&["end_to_end.p50<=+10%", "deadline_misses<=0"]);
    assert!(broken.contains("<header class=\"bad\">") && broken.contains("1 of 2 budgets broken"));
    assert!(broken.contains("end_to_end.p50&lt;=+10%") && broken.contains("Against the baseline"));
    assert!(broken.contains("<td class=\"worse\">"));
    assert_self_contained(&broken);
    let kept = page(&["deadline_misses<=0", "end_to_end.p50<=1s"]);
    assert!(kept.contains("<header class=\"good\">") && kept.contains("All 2 budgets kept"));
}

#[test]
fn warnings_and_notes_stand_before_the_figures_and_every_loop_has_all_percentiles() {
    let (figures, runs) = profile(&[Plan::quiet(800, 1)]);
    let warnings = ["repeat 1: rate 50 was <not> held".to_owned()];
    let notes = ["load of repeat 1: cpu, 2 threads".to_owned()];
    let page = ProfilePage {
        title: "t",
        figures: &figures,
        runs: &runs,
        comparison: None,
        judged: &[],
        warnings: &warnings,
        notes: &notes,
    };
    let page = profile_html(&page).unwrap();
    assert_self_contained(&page);
    let (before, after) = page.split_once("<dl class=\"tiles\">").unwrap();
    assert!(before.contains("<li class=\"worse\">repeat 1: rate 50 was &lt;not&gt; held</li>"), "{before}");
    assert!(before.contains("load of repeat 1: cpu, 2 threads"), "{before}");
    assert!(after.contains(" 1 repeat,") || before.contains(" 1 repeat,"));
    // Hops, lateness of loops, durations of loops.
    assert_eq!(after.matches("<th scope=\"col\">p99.99</th>").count(), 3);
    for heading in ["restarts", "CPU, s", "gave up", "pushed off", "from disk"] {
        assert!(after.contains(&format!("<th scope=\"col\">{heading}</th>")), "no column {heading}");
    }
    assert!(!page_of(&figures, &runs).contains("aria-label=\"Remarks\""), "nothing to say");
}

#[test]
fn nothing_measured_makes_a_page_too() {
    let page = page_of(&ProfileFigures::new(conditions(), Vec::new()), &[]);
    assert_self_contained(&page);
    assert!(page.contains("No detection reached a command") && page.contains("No cycle records"));
    assert!(page.contains("No messages are at hand"));

    let empty = RunMessages::default();
    let repeat = latency::RepeatFigures::of(made_up::PERIOD_NS, &empty, 0);
    let page = page_of(&ProfileFigures::new(conditions(), vec![repeat]), &[empty]);
    assert_self_contained(&page);
}
