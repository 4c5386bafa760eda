//! Scenarios of a file have crowds of all sizes: their rows under one, so that a method gets one line over the whole file.

use std::collections::BTreeMap;

use evaluation::{Row, Scenario};

/// `rows` with the mean crowd size (rounded) in place of their own, if every scenario has one crowd size and there are several
/// of these. Drawn scenarios are not taken: they come back at every crowd size.
pub(super) fn pooled(rows: &[Row]) -> Option<Vec<Row>> {
    let mut sizes: BTreeMap<(&str, &str), u32> = BTreeMap::new();
    for row in rows {
        let people = *sizes.entry((&row.robot, &row.scenario)).or_insert(row.people);
        if people != row.people || row.scenario == Scenario::random(row.seed, row.people).name {
            return None;
        }
    }
    let first = *sizes.values().next()?;
    if sizes.values().all(|people| *people == first) {
        return None;
    }
    let mean = sizes.values().map(|people| f64::from(*people)).sum::<f64>() / sizes.len() as f64;
    Some(rows.iter().map(|row| Row { people: mean.round() as u32, ..row.clone() }).collect())
}
