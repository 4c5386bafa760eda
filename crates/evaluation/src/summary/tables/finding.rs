//! The paper's finding, checked: at every crowd size the reference against whichever of the paper's other methods came closest
//! to it or got ahead of it.

use baselines::MethodKind;

use super::{Pair, Table, interval, median, points, probability, table};

/// One row per crowd size that `pairs`, all of one robot and radius, have. Settings of one's own, tuned rows and the unfiltered
/// robot are no methods that the finding speaks of.
pub(super) fn finding<'a>(title: String, pairs: impl Iterator<Item = &'a Pair>) -> Table {
    let mut strongest: Vec<&Pair> = Vec::new();
    for pair in pairs.filter(|pair| MethodKind::ALL.iter().any(|kind| kind.name() == pair.method)) {
        match strongest.last_mut() {
            Some(known) if known.people == pair.people => {
                if pair.difference < known.difference {
                    *known = pair;
                }
            }
            Some(_) | None => strongest.push(pair),
        }
    }
    table(
        title,
        &[
            "people",
            "reference",
            "strongest of the paper's others",
            "the reference ahead by, points",
            "95 % interval",
            "p (McNemar)",
            "time ratio, median",
            "path ratio, median",
            "the reference is",
        ],
        strongest.into_iter().map(|pair| {
            vec![
                pair.people.to_string(),
                pair.reference.clone(),
                pair.method.clone(),
                points(pair.difference),
                interval(pair.difference_interval.map(points)),
                probability(pair.p),
                median(pair.time_ratio),
                median(pair.path_ratio),
                place(pair).to_owned(),
            ]
        }),
    )
}

/// Where the reference stands, and whether chance alone explains it at 5 %.
fn place(pair: &Pair) -> &'static str {
    let [low, high] = pair.difference_interval;
    if low > 0.0 {
        "first"
    } else if high < 0.0 {
        "behind"
    } else if pair.difference > 0.0 {
        "first, within chance"
    } else if pair.difference < 0.0 {
        "behind, within chance"
    } else {
        "level"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::Radius;

    fn pair(method: &str, people: u32, difference: f64, difference_interval: [f64; 2]) -> Pair {
        Pair {
            robot: "ground".to_owned(),
            people,
            radius: Radius::Full,
            reference: "cn_cbf".to_owned(),
            method: method.to_owned(),
            scenarios: 100,
            both: 50,
            only_reference: 10,
            only_method: 5,
            difference,
            difference_interval,
            p: 0.25,
            time_ratio: None,
            path_ratio: None,
        }
    }

    #[test]
    fn the_strongest_rival_of_each_crowd_size_decides() {
        let pairs = [
            pair("sdf_mpc", 5, 0.30, [0.2, 0.4]),
            pair("dcbf_mpc", 5, 0.08, [-0.01, 0.17]),
            pair("no_filter", 5, -0.5, [-0.6, -0.4]),
            pair("dcbf_mpc_tuned", 5, -0.4, [-0.5, -0.3]),
            pair("dcbf_mpc", 10, 0.23, [0.1, 0.3]),
            pair("vo_mpc", 10, 0.40, [0.3, 0.5]),
            pair("vo_mpc", 15, -0.06, [-0.11, -0.01]),
        ];
        let Table { rows, .. } = finding(String::new(), pairs.iter());
        let told: Vec<_> =
            rows.iter().map(|row| [&row[0], &row[2], &row[3], &row[8]].map(String::as_str)).collect();
        assert_eq!(
            told,
            [
                ["5", "dcbf_mpc", "+8.0", "first, within chance"],
                ["10", "dcbf_mpc", "+23.0", "first"],
                ["15", "vo_mpc", "-6.0", "behind"],
            ]
        );
        assert_eq!(rows[1][4], "+10.0 to +30.0");
    }
}
