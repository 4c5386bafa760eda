//! How sure a figure's change is: bootstrap over repeats.
//!
//! Values within one repeat depend on one another (the machine's state, the neighbours), repeats hardly do. Hence whole
//! repeats are drawn with replacement, on each side by itself, and the figure of what was drawn together is taken anew. With
//! few repeats the interval is too narrow rather than too wide; below [`FEWEST_REPEATS`] there is none.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use statrs::statistics::{Data, OrderStatistics};

use crate::{Latencies, Statistic};

/// Fewest repeats of each side that give an interval.
pub const FEWEST_REPEATS: usize = 3;

/// How often repeats are drawn.
pub const RESAMPLES: usize = 2_000;

/// Share of the drawn changes within the interval.
pub const CONFIDENCE: f64 = 0.95;

/// The same figures give the same intervals.
const SEED: u64 = 0x636e_6362_6600_0001;

/// Change of one statistic between two sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Interval {
    /// Bounds of new − old, ns.
    pub(crate) difference_ns: [f64; 2],
    /// Bounds of new / old − 1; nothing where an old figure is zero.
    pub(crate) ratio: Option<[f64; 2]>,
}

/// Intervals of the change of every statistic, in the order of [`Statistic::ALL`]; nothing where a side has too few
/// repeats that measured anything.
pub(crate) fn intervals(old: &[&Latencies], new: &[&Latencies]) -> Option<[Interval; 6]> {
    let (old, new) = (Repeats::of(old), Repeats::of(new));
    if old.len() < FEWEST_REPEATS || new.len() < FEWEST_REPEATS {
        return None;
    }
    let mut random = Pcg64::seed_from_u64(SEED);
    let mut differences = [const { Vec::new() }; 6];
    let mut ratios = [const { Vec::new() }; 6];
    for _ in 0..RESAMPLES {
        let (then, now) = (old.draw(&mut random), new.draw(&mut random));
        for index in 0..Statistic::ALL.len() {
            let (then, now) = (then[index] as f64, now[index] as f64);
            differences[index].push(now - then);
            ratios[index].push(if then > 0.0 { now / then - 1.0 } else { f64::NAN });
        }
    }
    Some(core::array::from_fn(|index| Interval {
        difference_ns: bounds(core::mem::take(&mut differences[index])),
        ratio: ratios[index]
            .iter()
            .all(|ratio| ratio.is_finite())
            .then(|| bounds(core::mem::take(&mut ratios[index]))),
    }))
}

/// The middle [`CONFIDENCE`] of the values.
fn bounds(values: Vec<f64>) -> [f64; 2] {
    let mut values = Data::new(values);
    let tail = (1.0 - CONFIDENCE) / 2.0;
    [values.quantile(tail), values.quantile(1.0 - tail)]
}

/// The non-empty buckets of several repeats side by side, so that drawing costs little.
struct Repeats {
    /// Highest value of each bucket, ns, rising.
    values_ns: Vec<u64>,
    /// How many values each repeat has in each bucket.
    counts: Vec<Vec<u64>>,
    /// Exact extremes of each repeat, ns.
    extremes_ns: Vec<(u64, u64)>,
}

impl Repeats {
    fn of(repeats: &[&Latencies]) -> Self {
        let measured: Vec<_> = repeats.iter().filter(|latencies| latencies.count() > 0).collect();
        let mut values_ns: Vec<u64> = measured
            .iter()
            .flat_map(|latencies| latencies.values.iter_recorded().map(|step| step.value_iterated_to()))
            .map(|value_ns| measured[0].values.highest_equivalent(value_ns))
            .collect();
        values_ns.sort_unstable();
        values_ns.dedup();
        let counts = measured
            .iter()
            .map(|latencies| values_ns.iter().map(|&value_ns| latencies.values.count_at(value_ns)).collect())
            .collect();
        let extremes_ns = measured.iter().map(|latencies| (latencies.min_ns, latencies.max_ns)).collect();
        Self { values_ns, counts, extremes_ns }
    }

    fn len(&self) -> usize {
        self.counts.len()
    }

    /// Draws as many repeats as there are, and takes the figures of all of them together, ns.
    fn draw(&self, random: &mut Pcg64) -> [u64; 6] {
        let mut times = vec![0_u64; self.len()];
        for _ in 0..self.len() {
            times[random.random_range(0..self.len())] += 1;
        }
        self.figures_ns(&times)
    }

    /// The figures of every repeat taken so many `times`, ns.
    fn figures_ns(&self, times: &[u64]) -> [u64; 6] {
        let drawn = || (0..self.len()).filter(|&repeat| times[repeat] > 0);
        let min_ns = drawn().map(|repeat| self.extremes_ns[repeat].0).min().unwrap_or(0);
        let max_ns = drawn().map(|repeat| self.extremes_ns[repeat].1).max().unwrap_or(0);
        let count_of = |bucket: usize| -> u64 {
            drawn().map(|repeat| times[repeat] * self.counts[repeat][bucket]).sum()
        };
        let total: u64 = (0..self.values_ns.len()).map(count_of).sum();
        let ranks =
            Statistic::ALL.map(|statistic| (statistic.quantile() * total as f64).ceil().max(1.0) as u64);
        let mut figures_ns = [max_ns; 6];
        let (mut passed, mut next) = (0, 0);
        for (bucket, &value_ns) in self.values_ns.iter().enumerate() {
            passed += count_of(bucket);
            // The last one is the maximum, which is exact.
            while next + 1 < ranks.len() && passed >= ranks[next] {
                figures_ns[next] = value_ns.clamp(min_ns, max_ns);
                next += 1;
            }
        }
        figures_ns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(from_ns: u64, step_ns: u64) -> Latencies {
        let mut latencies = Latencies::new();
        for index in 0..5_000 {
            latencies.record_between(0, from_ns + index * step_ns);
        }
        latencies
    }

    #[test]
    fn each_repeat_taken_once_gives_the_pooled_figures() {
        let repeats = [ramp(1_000, 7), ramp(50, 1), ramp(90_000, 1_001)];
        let mut pooled = Latencies::new();
        for repeat in &repeats {
            pooled.merge(repeat);
        }
        let found = Repeats::of(&repeats.each_ref()).figures_ns(&[1, 1, 1]);
        for (statistic, found_ns) in Statistic::ALL.into_iter().zip(found) {
            assert_eq!(Some(found_ns), pooled.statistic_ns(statistic), "{}", statistic.label());
        }
    }

    #[test]
    fn a_repeat_taken_twice_counts_twice() {
        let repeats = [ramp(1_000, 7), ramp(50, 1), ramp(90_000, 1_001)];
        let mut pooled = Latencies::new();
        for index in [0, 0, 2] {
            pooled.merge(&repeats[index]);
        }
        let found = Repeats::of(&repeats.each_ref()).figures_ns(&[2, 0, 1]);
        let expected = Statistic::ALL.map(|statistic| pooled.statistic_ns(statistic).unwrap_or(0));
        assert_eq!(found, expected);
    }

    #[test]
    fn bounds_are_those_of_all_draws_counted_out() {
        let old = [ramp(1_000, 1), ramp(1_400, 1), ramp(2_600, 1)];
        let new = [ramp(1_300, 1), ramp(1_500, 2), ramp(3_000, 1)];
        // Every one of the 27 ways to draw three of three, on each side.
        let all = |repeats: &[Latencies; 3]| -> Vec<f64> {
            let repeats = Repeats::of(&repeats.each_ref());
            let mut medians = Vec::new();
            for code in 0..27_usize {
                let mut times = [0; 3];
                for drawn in [code % 3, code / 3 % 3, code / 9] {
                    times[drawn] += 1;
                }
                medians.push(repeats.figures_ns(&times)[0] as f64);
            }
            medians
        };
        let then = all(&old);
        let mut changes: Vec<f64> =
            all(&new).iter().flat_map(|now| then.iter().map(move |then| now - then)).collect();
        changes.sort_by(f64::total_cmp);
        let exact = |share: f64| changes[(share * changes.len() as f64) as usize];
        let [low, high] =
            intervals(&old.each_ref(), &new.each_ref()).expect("enough repeats")[0].difference_ns;
        assert!((exact(0.015)..=exact(0.035)).contains(&low), "{low}: {} to {}", exact(0.015), exact(0.035));
        assert!(
            (exact(0.965)..=exact(0.985)).contains(&high),
            "{high}: {} to {}",
            exact(0.965),
            exact(0.985)
        );
    }

    #[test]
    fn equal_repeats_give_an_interval_without_width_and_too_few_give_none() {
        let (old, new) = (ramp(1_000, 1), ramp(2_000, 1));
        let found = intervals(&[&old; 3], &[&new; 4]).expect("enough repeats");
        let max = found[5];
        assert_eq!(max.difference_ns, [1_000.0, 1_000.0]);
        assert_eq!(max.ratio, Some([6_999.0 / 5_999.0 - 1.0; 2]));
        assert_eq!(intervals(&[&old; 2], &[&new; 4]), None);
        let empty = Latencies::new();
        assert_eq!(intervals(&[&old, &old, &empty], &[&new; 4]), None, "an empty repeat measured nothing");
    }

    #[test]
    fn the_interval_covers_the_spread_between_repeats() {
        let old = [ramp(1_000, 1), ramp(1_100, 1), ramp(1_200, 1), ramp(1_300, 1)];
        let same = intervals(&old.each_ref(), &old.each_ref()).expect("enough repeats")[0];
        let [low, high] = same.difference_ns;
        assert!(low < 0.0 && high > 0.0 && high - low < 600.0, "{low} to {high}");
    }
}
