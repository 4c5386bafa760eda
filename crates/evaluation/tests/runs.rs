//! Closed loops of every kind of method: the same on every run, judged at both radii from one run, resumed and sliced.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use std::sync::atomic::{AtomicU64, Ordering};

use evaluation::summary::{markdown, summarise, tables};
use evaluation::{
    Campaign, CampaignError, Partition, Robot, Row, Scenario, Store, Variant, VariantError, merged, run,
};
use tempfile::tempdir;

/// A short way among few people: every run takes milliseconds.
const SHORT: [&str; 3] =
    ["simulation.goal=[1.0, 0.0, 0.0]", "simulation.timeout_s=8.0", "simulation.start_clearance_m=1.5"];

fn variant(robot: Robot, name: &str, sets: &[&str]) -> Variant {
    let sets: Vec<String> = SHORT.iter().chain(sets).map(|set| (*set).to_owned()).collect();
    Variant::named(robot, name, &sets).unwrap()
}

fn one(robot: Robot, name: &str, people: u32, seed: u64) -> Row {
    let row = run(&Scenario::random(seed, people), &variant(robot, name, &[]), "build", &|| false).unwrap();
    row.unwrap()
}

fn campaign(names: &[&str], partition: Partition) -> Campaign {
    Campaign {
        variants: names.iter().map(|name| variant(Robot::Quadrotor, name, &[])).collect(),
        scenarios: Scenario::random_set(1, 3, &[3, 6]),
        partition,
        build_hash: "build".to_owned(),
        jobs: Some(2),
        keep_times: true,
    }
}

#[test]
fn every_method_drives_alone_to_its_goal() {
    for robot in Robot::ALL {
        for name in Variant::names(robot) {
            let row = one(robot, name, 0, 1);
            assert!(row.success && row.success_smaller && !row.timeout, "{row:?}");
            assert_eq!((row.min_distance_m, row.cause.as_str(), row.slack_cycles), (None, "", 0), "{row:?}");
            // From (−2, 0) to within 0.3 m of (1, 0).
            assert!((2.69..3.0).contains(&row.path_length_m) && row.interventions == 0, "{row:?}");
            assert_eq!((row.robot.as_str(), row.method.as_str()), (robot.name(), name));
        }
    }
}

#[test]
fn a_run_depends_on_nothing_but_its_arguments() {
    for (robot, name) in [(Robot::Ground, "cn_cbf"), (Robot::Ground, "sdf_mpc"), (Robot::Quadrotor, "c3bf")] {
        let [first, second] = [0, 1].map(|_| one(robot, name, 8, 3));
        assert!(first.tick_median_us.is_some() && first.cpu_s.is_some());
        assert_eq!(first.without_times(), second.without_times());
    }
    let distance_m = |seed| one(Robot::Ground, "cn_cbf", 8, seed).min_distance_m;
    assert_ne!(distance_m(3), distance_m(4));
}

#[test]
fn both_radii_are_judged_in_one_run() {
    // The whole way, which not everybody survives without a filter.
    let nobody = Variant::named(Robot::Quadrotor, "no_filter", &[]).unwrap();
    let rows: Vec<Row> = (1..=16)
        .map(|seed| run(&Scenario::random(seed, 4), &nobody, "build", &|| false).unwrap().unwrap())
        .collect();
    assert!(rows.iter().any(|row| row.collision) && rows.iter().any(|row| row.success));
    for row in rows {
        assert_eq!(row.success, row.success_smaller && !row.collision, "{row:?}");
        assert_eq!(row.collision, row.contact_s.is_some());
        assert_eq!(row.cause, if row.collision { "not_filtered" } else { "" });
        let distance_m = row.min_distance_m.unwrap();
        assert_eq!(row.collision, distance_m < 0.0 || row.contact_s.is_some(), "{row:?}");
        assert_eq!(row.collision_smaller, distance_m <= -0.05, "{row:?}");
        if let (Some(full_s), Some(smaller_s)) = (row.contact_s, row.contact_smaller_s) {
            assert!(full_s <= smaller_s && smaller_s == row.time_s, "{row:?}");
        }
    }
}

#[test]
fn a_person_at_the_start_appeared_inside() {
    let sets = [
        "simulation.start_clearance_m=0.0",
        "simulation.arena_min_m=[-2.3, -0.3]",
        "simulation.arena_max_m=[-1.7, 0.3]",
    ];
    let variant = variant(Robot::Quadrotor, "cn_cbf", &sets);
    let row = run(&Scenario::random(1, 1), &variant, "build", &|| false).unwrap().unwrap();
    assert!(row.collision_smaller && !row.success && !row.timeout);
    assert_eq!((row.cause.as_str(), row.cause_smaller.as_str()), ("appeared_inside", "appeared_inside"));
}

#[test]
fn what_is_stopped_has_no_row() {
    let stopped = run(&Scenario::random(1, 5), &variant(Robot::Ground, "cn_cbf", &[]), "build", &|| true);
    assert!(stopped.unwrap().is_none());
}

#[test]
fn methods_and_settings_that_there_are_not_are_refused() {
    let told = |name: &str, set: &str| {
        let sets: Vec<String> = if set.is_empty() { Vec::new() } else { vec![set.to_owned()] };
        Variant::named(Robot::Ground, name, &sets).unwrap_err()
    };
    let unknown = told("c3bf", "").to_string();
    assert!(
        unknown.contains("ground") && unknown.contains("sdf_mpc") && unknown.contains("NAME=FILE.toml"),
        "{unknown}"
    );
    assert!(told("cn_cbf", "filter.nonsense=1").to_string().contains("nonsense"));
    assert!(matches!(told("cn_cbf", "nonsense"), VariantError::Override(_)));
    let other = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/quadrotor.toml");
    assert!(matches!(told(&format!("mine={other}"), ""), VariantError::OtherRobot { .. }));
    assert!(matches!(told("mine=nowhere.toml", ""), VariantError::Settings(_)));
}

#[test]
fn a_stopped_campaign_goes_on_where_it_was() {
    let folder = tempdir().unwrap();
    let campaign = campaign(&["cn_cbf", "c3bf"], Partition::WHOLE);
    let whole = {
        let mut store = Store::open(&folder.path().join("whole")).unwrap();
        let done = campaign.run(&mut store, &|| false, &|_| {}).unwrap();
        assert_eq!((done.known, done.added, done.stopped), (0, 12, false));
        store.finish().unwrap()
    };
    let file = folder.path().join("resumed");
    let count = AtomicU64::new(0);
    let mut store = Store::open(&file).unwrap();
    let stop = || count.load(Ordering::Relaxed) >= 5;
    let done =
        campaign.run(&mut store, &stop, &|progress| count.store(progress.done, Ordering::Relaxed)).unwrap();
    assert!(done.stopped && (5..=6).contains(&done.added), "{done:?}");
    // Killed: nothing was finished.
    drop(store);
    let mut store = Store::open(&file).unwrap();
    let rest = campaign.run(&mut store, &|| false, &|_| {}).unwrap();
    assert_eq!((rest.known, rest.added, rest.stopped), (done.added, 12 - done.added, false));
    let bare = |rows: Vec<Row>| rows.into_iter().map(Row::without_times).collect::<Vec<_>>();
    assert_eq!(bare(store.finish().unwrap()), bare(whole));
}

#[test]
fn slices_make_the_same_tables_as_the_whole() {
    let folder = tempdir().unwrap();
    let rows_of = |partition, name: &str| {
        let mut store = Store::open(&folder.path().join(name)).unwrap();
        campaign(&["ho_cbf", "cn_cbf"], partition).run(&mut store, &|| false, &|_| {}).unwrap();
        store.finish().unwrap()
    };
    let words = |rows: &[Row]| markdown(&tables(&summarise(rows, &[])));
    let whole = words(&rows_of(Partition::WHOLE, "whole"));
    for count in [2, 4] {
        let files: Vec<_> = (1..=count)
            .map(|index| {
                let name = format!("{index}-of-{count}");
                rows_of(Partition::slice(index, count).unwrap(), &name);
                folder.path().join(name)
            })
            .collect();
        assert_eq!(words(&merged(&files).unwrap()), whole);
    }
}

#[test]
fn what_has_changed_is_not_gone_on_with() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t");
    let begin = campaign(&["cn_cbf"], Partition::WHOLE);
    let mut store = Store::open(&file).unwrap();
    begin.run(&mut store, &|| false, &|_| {}).unwrap();
    let mut refused = |changed: Campaign, word: &str| {
        let error = changed.run(&mut store, &|| false, &|_| panic!("something was computed")).unwrap_err();
        let told = error.to_string();
        assert!(
            matches!(error, CampaignError::Changed { .. }) && told.contains(word) && told.contains("--out"),
            "{told}"
        );
    };
    refused(Campaign { build_hash: "other".to_owned(), ..campaign(&["cn_cbf"], Partition::WHOLE) }, "build");
    let variants = vec![variant(Robot::Quadrotor, "cn_cbf", &["filter.alpha_per_s=3.0"])];
    refused(Campaign { variants, ..campaign(&[], Partition::WHOLE) }, "settings");
    // Another method adds to what is there.
    let more =
        campaign(&["cn_cbf", "no_filter"], Partition::WHOLE).run(&mut store, &|| false, &|_| {}).unwrap();
    assert_eq!((more.known, more.added), (6, 6));
}
