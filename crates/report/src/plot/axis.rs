//! An axis of numbers with chosen marks, and how its numbers read.

use core::ops::Range;

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::Ranged;

/// A linear axis. What lies beyond it runs along its edge instead of leaving the plot.
pub(crate) struct Axis {
    pub(super) range: Range<f64>,
    pub(super) marks: Vec<f64>,
}

impl Axis {
    /// Marks at multiples of 1, 2 or 5 times a power of ten, at most `count` or so.
    pub(crate) fn round(range: Range<f64>, count: usize) -> Self {
        let ideal = (range.end - range.start) / count as f64;
        let power = 10f64.powf(ideal.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
        let step = steps.into_iter().find(|step| *step >= ideal).unwrap_or(ideal);
        let (first, last) = ((range.start / step).ceil() as i64, (range.end / step).floor() as i64);
        Self { marks: (first..=last).map(|index| index as f64 * step).collect(), range }
    }

    /// Marks at every whole number.
    pub(crate) fn whole(range: Range<f64>) -> Self {
        let marks = (range.start.ceil() as i32..=range.end.floor() as i32).map(f64::from).collect();
        Self { range, marks }
    }
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let share = (value - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (share.clamp(0.0, 1.0) * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.marks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// A number without trailing zeros, to three decimals.
pub(crate) fn trimmed(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_round_and_labels_short() {
        assert_eq!(Axis::round(-0.2..1.1, 5).marks, [0.0, 0.5, 1.0]);
        assert_eq!(Axis::whole(-1.2..2.0).marks, [-1.0, 0.0, 1.0, 2.0]);
        assert_eq!([0.5, -0.0, 2.0, 1.25].map(trimmed), ["0.5", "0", "2", "1.25"]);
    }
}
