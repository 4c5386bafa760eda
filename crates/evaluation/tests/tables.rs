//! Tables on disk: written whole, read back as they were, kept through kills, merged whatever the order.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use evaluation::summary::{markdown, summarise, tables};
use evaluation::{Row, Store, StoreError, TableError, merged, read_table, write_table};
use tempfile::tempdir;

fn row(method: &str, people: u32, seed: u64) -> Row {
    let collided = (seed + u64::from(people)).is_multiple_of(3);
    Row {
        robot: "ground".to_owned(),
        people,
        scenario: format!("seed-{seed:05}"),
        method: method.to_owned(),
        seed,
        settings_hash: format!("{method}-settings"),
        scenario_hash: format!("{seed}-{people}"),
        build_hash: "build".to_owned(),
        kernel: "portable".to_owned(),
        success: !collided,
        success_smaller: true,
        collision: collided,
        collision_smaller: false,
        timeout: false,
        contact_s: collided.then_some(4.5),
        contact_smaller_s: None,
        cause: if collided { "boxed_in".to_owned() } else { String::new() },
        cause_smaller: String::new(),
        min_distance_m: (people > 0).then_some(-0.01 + seed as f64 * 1e-3),
        path_length_m: 15.0 + 0.1 * seed as f64,
        time_s: 20.0 + seed as f64 / 3.0,
        cycles: 5_000,
        interventions: seed,
        intervention_share: 0.1,
        slack_cycles: u64::MAX - seed,
        max_slack: f64::INFINITY,
        min_hard_margin: collided.then_some(-0.5),
        braking_cycles: 2,
        turn_rate_exceeded_share: 0.15,
        acceleration_exceeded_share: f64::MIN_POSITIVE,
        bounds_exceeded_share: -0.0,
        tick_median_us: Some(seed as f64),
        tick_p99_us: None,
        nominal_median_us: Some(100.0),
        nominal_p99_us: Some(200.0),
        cpu_s: Some(0.5),
    }
}

fn many() -> Vec<Row> {
    let seeds = |method: &'static str, people| (1..=20).map(move |seed| row(method, people, seed));
    [("cn_cbf", 5), ("sdf_mpc", 5), ("cn_cbf", 10), ("sdf_mpc", 10)]
        .into_iter()
        .flat_map(|(method, people)| seeds(method, people))
        .collect()
}

fn refs(rows: &[Row]) -> Vec<&Row> {
    rows.iter().collect()
}

#[test]
fn rows_come_back_as_they_were_and_in_order() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t.parquet");
    let mut rows = many();
    rows.reverse();
    write_table(&file, &refs(&rows)).unwrap();
    rows.sort_by_key(Row::key);
    assert_eq!(read_table(&file).unwrap(), rows);
    write_table(&file, &[]).unwrap();
    assert_eq!(read_table(&file).unwrap(), []);
}

#[test]
fn what_is_no_such_table_is_refused() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t.parquet");
    std::fs::write(&file, "PAR1, but not really").unwrap();
    assert!(matches!(read_table(&file), Err(TableError::Parquet { .. })));
    write_table(&file, &refs(&many())).unwrap();
    let bytes = std::fs::read(&file).unwrap();
    std::fs::write(&file, &bytes[..bytes.len() / 2]).unwrap();
    assert!(matches!(read_table(&file), Err(TableError::Parquet { .. })));
    let missing = read_table(&folder.path().join("none")).unwrap_err().to_string();
    assert!(missing.contains("cannot read") && missing.contains("none"), "{missing}");
}

#[test]
fn any_partition_merges_to_the_same_bytes() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let rows = many();
    write_table(&path("whole"), &refs(&rows)).unwrap();
    let whole = std::fs::read(path("whole")).unwrap();
    for count in [2, 3, 7] {
        let slices: Vec<_> = (0..count)
            .map(|index| {
                let slice: Vec<&Row> = rows.iter().skip(index).step_by(count).collect();
                let name = path(&format!("{index}-of-{count}"));
                write_table(&name, &slice).unwrap();
                name
            })
            .rev()
            .collect();
        let together = merged(&slices).unwrap();
        write_table(&path("merged"), &refs(&together)).unwrap();
        assert!(std::fs::read(path("merged")).unwrap() == whole, "{count} slices");
    }
}

#[test]
fn measured_times_leave_no_trace_in_the_tables() {
    let words = |rows: &[Row]| markdown(&tables(&summarise(rows, &[])));
    let rows = many();
    let other: Vec<Row> =
        rows.iter().map(|row| Row { tick_median_us: Some(1e6), cpu_s: None, ..row.clone() }).collect();
    assert_ne!(rows, other);
    assert_eq!(words(&rows), words(&other));
}

#[test]
fn what_contradicts_itself_is_not_merged() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let one = row("cn_cbf", 5, 1);
    write_table(&path("one"), &[&one]).unwrap();
    let same = Row { tick_median_us: Some(9.0), ..one.clone() };
    write_table(&path("same"), &[&same]).unwrap();
    assert_eq!(merged(&[path("one"), path("same")]).unwrap(), std::slice::from_ref(&one));
    for (other, word) in [
        (Row { time_s: 9.0, ..one.clone() }, "the result"),
        (Row { scenario_hash: "other".to_owned(), ..one.clone() }, "the scenario"),
        (Row { build_hash: "other".to_owned(), ..row("cn_cbf", 5, 2) }, "the build"),
        (Row { settings_hash: "other".to_owned(), ..row("cn_cbf", 10, 2) }, "settings"),
        (Row { kernel: "avx512".to_owned(), ..row("cn_cbf", 5, 2) }, "kernel"),
    ] {
        write_table(&path("other"), &[&other]).unwrap();
        let told = merged(&[path("one"), path("other")]).unwrap_err().to_string();
        assert!(told.contains(word), "{word}: {told}");
    }
}

#[test]
fn every_row_is_on_disk_when_it_was_added() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t.parquet");
    let rows = many();
    // Not finished, as by a kill; more rows than are gathered at once.
    let mut store = Store::open(&file).unwrap();
    for row in &rows[..70] {
        store.add(row.clone()).unwrap();
    }
    drop(store);
    std::fs::write(folder.path().join("t.parquet.parts/00000099.parquet.tmp"), "cut o").unwrap();
    let mut store = Store::open(&file).unwrap();
    assert_eq!(store.rows().count(), 70);
    assert_eq!(store.row(&rows[69].key()), Some(&rows[69]));
    for row in &rows[70..] {
        store.add(row.clone()).unwrap();
    }
    let mut sorted = rows.clone();
    sorted.sort_by_key(Row::key);
    assert_eq!(store.finish().unwrap(), sorted);
    assert_eq!(read_table(&file).unwrap(), sorted);
    let left: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["t.parquet"]);
}

#[test]
fn a_gathering_that_was_cut_off_loses_and_doubles_nothing() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t.parquet");
    let rows = many();
    let mut store = Store::open(&file).unwrap();
    for row in &rows[..3] {
        store.add(row.clone()).unwrap();
    }
    drop(store);
    // The table was renamed into place, the parts were not removed yet.
    write_table(&file, &refs(&rows[..3])).unwrap();
    assert_eq!(Store::open(&file).unwrap().finish().unwrap().len(), 3);
}

#[test]
fn two_writers_are_one_too_many() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("t.parquet");
    let _first = Store::open(&file).unwrap();
    assert!(matches!(Store::open(&file), Err(StoreError::Locked { .. })));
    let nowhere = folder.path().join("no/such/folder/t.parquet");
    assert!(matches!(Store::open(&nowhere), Err(StoreError::Unwritable { .. })));
}

#[test]
fn a_summary_counts_what_is_there() {
    let summary = summarise(&many(), &["cn_cbf".to_owned()]);
    assert_eq!(summary.lines.len(), 8);
    let line = &summary.lines[0];
    assert_eq!((line.method.as_str(), line.people, line.runs), ("cn_cbf", 5, 20));
    // Seeds 1 to 20 with (seed + 5) divisible by three: 1, 4, …, 19.
    assert_eq!((line.successes, line.collisions, line.timeouts), (13, 7, 0));
    assert_eq!(line.causes, [("boxed_in".to_owned(), 7)]);
    assert_eq!(summary.lines[1].successes, 20);
    assert_eq!(summary.pairs.len(), 4);
    let pair = &summary.pairs[0];
    assert_eq!((pair.method.as_str(), pair.reference.as_str(), pair.scenarios), ("sdf_mpc", "cn_cbf", 20));
    assert_eq!((pair.only_reference, pair.only_method, pair.p), (0, 0, 1.0));
    assert_eq!(pair.time_ratio.unwrap().median, 1.0);
    assert_eq!((pair.both, pair.difference, pair.path_ratio.unwrap().median), (13, 0.0, 1.0));
    assert!(pair.difference_interval[0] < 0.0 && pair.difference_interval[1] > 0.0);
}

#[test]
fn every_table_is_told_for_both_radii_with_causes_and_finding() {
    let rows: Vec<Row> = many()
        .into_iter()
        .map(|row| match row.method.as_str() {
            // The rival succeeds where the reference does and in five scenarios less.
            "sdf_mpc" if row.seed <= 6 => {
                Row { success: false, collision: true, cause: "filter_fault".to_owned(), ..row }
            }
            _ => row,
        })
        .collect();
    let told = tables(&summarise(&rows, &[]));
    let of = |end: &str, radius: &str| {
        told.iter().find(|table| table.title.ends_with(end) && table.title.contains(radius)).unwrap()
    };
    let causes = of("contacts by cause", "equal to the filter's");
    assert_eq!(
        causes.headings,
        [
            "people",
            "method",
            "runs",
            "contacts",
            "not_filtered",
            "appeared_inside",
            "bounds_exceeded",
            "boxed_in",
            "filter_fault"
        ]
    );
    // Of seeds 1 to 20 at 5 people seven collide; the rival also has 2, 3, 5 and 6, and its own cause for 1 and 4.
    assert_eq!(causes.rows[0][2..], ["20", "7", "0", "0", "0", "7", "0"]);
    assert_eq!(causes.rows[1][2..], ["20", "11", "0", "0", "0", "5", "6"]);
    assert!(of("contacts by cause", "5 cm smaller").rows.iter().all(|row| row[3] == "0"));
    let finding = of("the paper's finding", "equal to the filter's");
    assert_eq!(finding.rows[0][..4], ["5", "cn_cbf", "sdf_mpc", "+20.0"]);
    assert_eq!(of("the paper's finding", "5 cm smaller").rows[0][8], "level");
    for table in &told {
        assert!(table.rows.iter().all(|row| row.len() == table.headings.len()), "{}", table.title);
    }
}
