//! The assignment problem: whom to pair with whom, so that the pairs together gain most.
//!
//! The shortest augmenting paths of Kuhn, Munkres, Jonker and Volgenant, O(n²m). Own code because every cycle needs it and
//! the crates that have it allocate.

use messages::MAX_OBSTACLES;

/// Gains of all pairs and the working memory of their assignment, allocated once.
#[derive(Debug)]
pub(crate) struct Assignment {
    /// By row, then column.
    gains: Vec<[f64; MAX_OBSTACLES]>,
    rows: usize,
    /// At least as many as rows, so that every row finds one; those beyond the real ones gain nothing.
    columns: usize,
    row_prices: [f64; MAX_OBSTACLES],
    column_prices: [f64; MAX_OBSTACLES],
    row_of: [Option<usize>; MAX_OBSTACLES],
}

impl Assignment {
    pub(crate) fn new() -> Self {
        Self {
            gains: vec![[0.0; MAX_OBSTACLES]; MAX_OBSTACLES],
            rows: 0,
            columns: 0,
            row_prices: [0.0; MAX_OBSTACLES],
            column_prices: [0.0; MAX_OBSTACLES],
            row_of: [None; MAX_OBSTACLES],
        }
    }

    /// Begins a problem in which no pair gains anything yet. Each side has at most [`MAX_OBSTACLES`] members.
    pub(crate) fn clear(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns.max(rows));
        self.gains[..rows].iter_mut().for_each(|row| row[..columns.max(rows)].fill(0.0));
    }

    /// States what a pair gains, > 0; a pair of which nothing is stated is not formed.
    pub(crate) fn gain(&mut self, row: usize, column: usize, gain: f64) {
        self.gains[row][column] = gain;
    }

    /// The pairs `(row, column)` that together gain most, by column.
    pub(crate) fn solve(&mut self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.row_prices = [0.0; MAX_OBSTACLES];
        self.column_prices = [0.0; MAX_OBSTACLES];
        self.row_of = [None; MAX_OBSTACLES];
        (0..self.rows).for_each(|row| self.place(row));
        (0..self.columns).filter_map(|column| {
            let row = self.row_of[column]?;
            (self.gains[row][column] > 0.0).then_some((row, column))
        })
    }

    /// Finds a column for one more row: along the path that costs those already placed least, prices being kept such that no
    /// pair costs less than its row and column are paid.
    fn place(&mut self, row: usize) {
        let mut cheapest = [f64::INFINITY; MAX_OBSTACLES];
        let mut reached_from = [None; MAX_OBSTACLES];
        let mut visited = [false; MAX_OBSTACLES];
        let (mut from, mut at) = (None, row);
        let end = loop {
            let (mut step, mut next) = (f64::INFINITY, 0);
            for column in (0..self.columns).filter(|&column| !visited[column]) {
                let cost = -self.gains[at][column] - self.row_prices[at] - self.column_prices[column];
                if cost < cheapest[column] {
                    (cheapest[column], reached_from[column]) = (cost, from);
                }
                if cheapest[column] < step {
                    (step, next) = (cheapest[column], column);
                }
            }
            self.row_prices[row] += step;
            for column in 0..self.columns {
                match self.row_of[column] {
                    Some(owner) if visited[column] => {
                        self.row_prices[owner] += step;
                        self.column_prices[column] -= step;
                    }
                    _ => cheapest[column] -= step,
                }
            }
            visited[next] = true;
            match self.row_of[next] {
                Some(owner) => (from, at) = (Some(next), owner),
                None => break next,
            }
        };
        let mut column = end;
        while let Some(before) = reached_from[column] {
            self.row_of[column] = self.row_of[before];
            column = before;
        }
        self.row_of[column] = Some(row);
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    /// What `tests/judges/estimators_reference.py` had scipy find.
    #[derive(Deserialize)]
    struct Reference {
        assignments: Vec<Stored>,
    }

    #[derive(Deserialize)]
    struct Stored {
        gains: Vec<Vec<f64>>,
        pairs: Vec<(usize, usize)>,
    }

    #[test]
    fn the_pairs_are_scipys() {
        let text = include_str!("../../tests/data/estimators_reference.json");
        let reference: Reference = serde_json::from_str(text).unwrap();
        assert_eq!(reference.assignments.len(), 7);
        let mut assignment = Assignment::new();
        for Stored { gains, mut pairs } in reference.assignments {
            assignment.clear(gains.len(), gains[0].len());
            for (row, of_row) in gains.iter().enumerate() {
                of_row.iter().enumerate().for_each(|(column, &gain)| assignment.gain(row, column, gain));
            }
            let mut found: Vec<_> = assignment.solve().collect();
            found.sort_unstable();
            pairs.sort_unstable();
            assert_eq!(found, pairs);
        }
    }

    #[test]
    fn nobody_is_paired_for_nothing() {
        let mut assignment = Assignment::new();
        assignment.clear(0, 5);
        assert_eq!(assignment.solve().count(), 0);
        assignment.clear(5, 0);
        assert_eq!(assignment.solve().count(), 0);
        assignment.clear(3, 2);
        assignment.gain(2, 0, 0.1);
        assert_eq!(assignment.solve().collect::<Vec<_>>(), [(2, 0)]);
    }
}
