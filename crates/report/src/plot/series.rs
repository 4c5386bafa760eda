//! From thousands of samples to what a screen can show: two extremes per pixel column, gaps kept.

use messages::SafeCommand;

use crate::RunRecord;
use crate::spans::{PERIODS_UNTIL_SILENT, Rung, Span};

/// Pixel columns of a plot over time.
pub(super) const COLUMNS: usize = 2200;

/// A curve over time in unbroken pieces of `(s, value)`, thinned to two points a column.
pub(super) type Curve = Vec<Vec<(f64, f64)>>;

/// The curve of one figure of the commands. It breaks where the figure is not finite and where the filter was silent.
pub(super) fn curve(record: &RunRecord, value_of: impl Fn(&SafeCommand) -> f64) -> Curve {
    let column_s = record.duration_s().max(1e-3) / COLUMNS as f64;
    let longest_gap_s = (PERIODS_UNTIL_SILENT * record.filter_period_ns) as f64 * 1e-9;
    let mut pieces = vec![Piece::default()];
    let mut last_s = f64::NEG_INFINITY;
    for command in &record.safe_commands {
        let (time_s, value) = (record.seconds(command.ledger.filter_woke_ns), value_of(command));
        if !value.is_finite() {
            last_s = f64::NEG_INFINITY;
            continue;
        }
        if time_s - last_s > longest_gap_s {
            pieces.push(Piece::default());
        }
        last_s = time_s;
        let column = (time_s / column_s) as i64;
        if let Some(piece) = pieces.last_mut() {
            piece.push(column, (time_s, value));
        }
    }
    pieces.into_iter().map(Piece::finish).filter(|piece| !piece.is_empty()).collect()
}

/// One unbroken piece under construction.
#[derive(Default)]
struct Piece {
    points: Vec<(f64, f64)>,
    column: Option<Column>,
}

/// The extremes within one pixel column.
struct Column {
    index: i64,
    low: (f64, f64),
    high: (f64, f64),
}

impl Piece {
    fn push(&mut self, index: i64, point: (f64, f64)) {
        match &mut self.column {
            Some(column) if column.index == index => {
                if point.1 < column.low.1 {
                    column.low = point;
                }
                if point.1 > column.high.1 {
                    column.high = point;
                }
            }
            _ => {
                self.close_column();
                self.column = Some(Column { index, low: point, high: point });
            }
        }
    }

    fn close_column(&mut self) {
        let Some(Column { low, high, .. }) = self.column.take() else { return };
        let (first, second) = if low.0 <= high.0 { (low, high) } else { (high, low) };
        self.points.push(first);
        if first != second {
            self.points.push(second);
        }
    }

    fn finish(mut self) -> Vec<(f64, f64)> {
        self.close_column();
        self.points
    }
}

/// The spans as a screen of `columns` columns can show them: each column takes the worst rung that touches it, so that
/// a single relaxed cycle stays visible.
pub(crate) fn worst_by_column(spans: &[Span], duration_s: f64, columns: usize) -> Vec<Span> {
    let column_s = duration_s.max(1e-3) / columns as f64;
    let badness = |rung: Rung| Rung::ALL.iter().position(|&other| other == rung);
    let mut worst: Vec<Option<Rung>> = vec![None; columns];
    for span in spans {
        let first = ((span.start_s / column_s) as usize).min(columns - 1);
        let last = ((span.end_s / column_s).ceil() as usize).clamp(first + 1, columns);
        for slot in &mut worst[first..last] {
            if slot.is_none_or(|other| badness(other) < badness(span.rung)) {
                *slot = Some(span.rung);
            }
        }
    }
    let mut merged: Vec<Span> = Vec::new();
    for (index, rung) in worst.into_iter().enumerate() {
        let Some(rung) = rung else { continue };
        let (start_s, end_s) = (index as f64 * column_s, (index + 1) as f64 * column_s);
        match merged.last_mut() {
            Some(last) if last.rung == rung => last.end_s = end_s,
            _ => merged.push(Span { rung, start_s, end_s }),
        }
    }
    merged
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_relaxed_cycle_in_a_long_run_keeps_its_column() {
        let spans =
            [(Rung::Filtered, 0.0, 50.0), (Rung::Relaxed, 50.0, 50.004), (Rung::Filtered, 50.004, 100.0)]
                .map(|(rung, start_s, end_s)| Span { rung, start_s, end_s });
        let shown = worst_by_column(&spans, 100.0, 100);
        let rungs: Vec<_> = shown.iter().map(|span| span.rung).collect();
        assert_eq!(rungs, [Rung::Filtered, Rung::Relaxed, Rung::Filtered]);
        assert_eq!((shown[1].start_s, shown[1].end_s), (50.0, 51.0));
    }

    #[test]
    fn thinning_keeps_the_extremes_in_their_order() {
        let mut piece = Piece::default();
        for (index, value) in [3.0, 9.0, -4.0, 1.0].into_iter().enumerate() {
            piece.push(7, (index as f64, value));
        }
        piece.push(8, (4.0, 2.0));
        assert_eq!(piece.finish(), [(1.0, 9.0), (2.0, -4.0), (4.0, 2.0)]);
    }
}
