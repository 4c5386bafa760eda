//! How the settings of one method are judged, and their line in the stored table. Not here: what is tried (`grids`).
//!
//! One criterion for every method, CN-CBF included. Of the settings that are **fast enough** the one with the most
//! successes at the full radius wins; of several the one with more successes at the smaller radius, then the faster,
//! then the earlier in the grid. A setting is fast enough if its time to the goal is at most 1.10 times that of CN-CBF as
//! published, or at most as long as that of the method itself as published, whichever allows more: so the published
//! setting always is, and tuning never trades success for speed. Times are compared in pairs: the median, over the
//! scenarios in which both reached the goal without contact at the full radius, of one time over the other.

/// How much longer than CN-CBF as published a setting may take.
const TIME_RATIO_LIMIT: f64 = 1.10;

/// One setting of one method with what became of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    /// What is set, `section.key=value`.
    pub(crate) sets: Vec<String>,
    /// Scenarios it was run in, from the first seed on.
    pub(crate) runs: usize,
    /// Those without contact at the full radius.
    pub(crate) successes: usize,
    /// Those without contact at the smaller radius.
    pub(crate) successes_smaller: usize,
    /// Median time of the former, s.
    pub(crate) time_s: Option<f64>,
    /// Median of the time over that of CN-CBF as published, where both succeeded.
    pub(crate) time_ratio: Option<f64>,
}

/// Places in `candidates` of those with the most runs, best first. The published setting is the first candidate.
pub(crate) fn ranking(candidates: &[Candidate]) -> Vec<usize> {
    let published_ratio = candidates.first().and_then(|published| published.time_ratio);
    let limit = published_ratio.unwrap_or(0.0).max(TIME_RATIO_LIMIT);
    let runs = candidates.iter().map(|candidate| candidate.runs).max().unwrap_or(0);
    let mut places: Vec<usize> = (0..candidates.len()).filter(|&at| candidates[at].runs == runs).collect();
    // The sort is stable: of equals the earlier stays ahead.
    places.sort_by(|&one, &other| {
        let [one, other] = [&candidates[one], &candidates[other]];
        let ratio = |candidate: &Candidate| candidate.time_ratio.unwrap_or(f64::INFINITY);
        let fast = |candidate: &Candidate| ratio(candidate) <= limit;
        let key = |candidate: &Candidate| (fast(candidate), candidate.successes, candidate.successes_smaller);
        key(other).cmp(&key(one)).then(ratio(one).total_cmp(&ratio(other)))
    });
    places
}

/// Names of the columns of [`Candidate::line`].
pub(crate) const HEADER: &str =
    "robot,method,people,first_seed,settings,runs,success,success_smaller,time_s,time_ratio,winner";

impl Candidate {
    /// Its line in the table, of a `method` of `robot` among `people` people from `first_seed` on.
    pub(crate) fn line(
        &self,
        robot: &str,
        method: &str,
        people: u32,
        first_seed: u64,
        winner: bool,
    ) -> String {
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
        let Self { sets, runs, successes, successes_smaller, time_s, time_ratio } = self;
        format!(
            "{robot},{method},{people},{first_seed},{},{runs},{successes},{successes_smaller},{},{},{}",
            sets.join(" "),
            number(*time_s),
            number(*time_ratio),
            u8::from(winner)
        )
    }
}
