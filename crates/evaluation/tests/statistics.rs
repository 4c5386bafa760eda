//! Intervals and tests against statsmodels and SciPy: `tests/judges/evaluation_statistics_reference.py` made the numbers.
#![allow(clippy::unwrap_used, reason = "a test that panics has failed")]

use evaluation::statistics::{Spread, mcnemar_exact, paired_difference, wilson};
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("../../../tests/data/evaluation_statistics_reference.json")).unwrap()
}

#[test]
fn wilson_intervals_agree_with_statsmodels() {
    let reference = reference();
    let cases = reference["wilson"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        let number = |name: &str| case[name].as_f64().unwrap();
        let [low, high] = wilson(case["successes"].as_u64().unwrap(), case["trials"].as_u64().unwrap());
        assert!((low - number("low")).abs() < 1e-12 && (high - number("high")).abs() < 1e-12, "{case}");
    }
    assert_eq!(wilson(0, 0), [0.0, 1.0]);
}

#[test]
fn paired_tests_agree_with_statsmodels() {
    let reference = reference();
    let cases = reference["mcnemar"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        let p = mcnemar_exact(case["only_first"].as_u64().unwrap(), case["only_second"].as_u64().unwrap());
        assert!((p - case["p"].as_f64().unwrap()).abs() < 1e-12, "{case}: {p}");
    }
}

#[test]
fn paired_differences_agree_with_the_reference() {
    let reference = reference();
    let cases = reference["paired_difference"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        let cells = ["both", "only_first", "only_second", "neither"].map(|name| case[name].as_u64().unwrap());
        let number = |name: &str| case[name].as_f64().unwrap();
        let [both, only_first, only_second, neither] = cells;
        let (difference, [low, high]) = paired_difference(both, only_first, only_second, neither);
        let gaps = [difference - number("difference"), low - number("low"), high - number("high")];
        assert!(gaps.iter().all(|gap| gap.abs() < 1e-12), "{case}: {difference} {low} {high}");
        let (turned, [turned_low, turned_high]) = paired_difference(both, only_second, only_first, neither);
        assert!((turned + difference).abs() < 1e-15 && (turned_low + high).abs() < 1e-12, "{case}");
        assert!((turned_high + low).abs() < 1e-12, "{case}");
    }
    assert_eq!(paired_difference(0, 0, 0, 0), (0.0, [-1.0, 1.0]));
}

#[test]
fn spreads_are_those_of_the_values() {
    assert_eq!(Spread::of(&[]), None);
    let few = Spread::of(&[3.0, 1.0, 2.0]).unwrap();
    assert_eq!((few.count, few.mean, few.median, few.median_interval), (3, 2.0, 2.0, [1.0, 3.0]));
    let even = Spread::of(&[4.0, 1.0, 2.0, 3.0]).unwrap();
    assert_eq!(even.median, 2.5);
    let many: Vec<f64> = (0..101).map(f64::from).collect();
    let spread = Spread::of(&many).unwrap();
    let [low, high] = spread.median_interval;
    // The binomial interval of a median's rank: 50.5 ± 1.96·√101/2.
    assert!(
        spread.median == 50.0 && (37.0..43.0).contains(&low) && (57.0..63.0).contains(&high),
        "{low} {high}"
    );
    assert_eq!(Spread::of(&many), Some(spread), "the same values give the same interval");
}
