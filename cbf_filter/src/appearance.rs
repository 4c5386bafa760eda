//! Obstacles that come into sight begin to count little by little, so that `h` does not jump. Not here: the barrier itself.

use barrier::BarrierConstraint;
use dynamics::InputBox;
use messages::MAX_OBSTACLES;

/// How far above `h` a newcomer's raised value begins, in units of 1/β: its weight then is at most e⁻⁵, and `h` moves by less
/// than 0.7 % of 1/β.
const UNSEEN_BETAS: f64 = 5.0;

/// The ramp: for `ramp_s` after it appeared, obstacle `i` counts with the weight
///
/// ```text
/// s_i = exp(−β r_i),   r_i = r_i(0) · (1 − age/ramp_s) ≥ 0,   r_i(0) = h + 5/β − h̄_i    (h as it was without it)
/// ```
///
/// in the softmin, that is with the value `h̄_i + r_i`, whose rate has the part `dr_i/dt`. In this form the ramp lowers `h` at
/// a bounded rate; a weight that grows linearly from zero would lower it without bound.
///
/// Nobody dangerous is hidden: an obstacle counts in full, from then on, as soon as `h̄_i ≤ 0`, or as some admissible control
/// would at the present rate bring it there before the ramp ends. The jump of `h` that comes with this is wanted. Everybody
/// counts in full in the first cycle, in the first with anybody in it, and where `h` did not exceed the newcomer's own value.
pub(crate) struct Appearance {
    ramp_s: f64,
    beta_per_m: f64,
    /// Who was in sight in the last cycle, and a buffer for who is now.
    known: Vec<Known>,
    next: Vec<Known>,
    /// The smallest value of the last cycle, m; `+∞` where nobody was in sight.
    last_h: f64,
}

/// Someone in sight.
#[derive(Debug, Clone, Copy)]
struct Known {
    track_id: u64,
    appeared_ns: u64,
    /// `r_i(0)`, m; zero once the obstacle counts in full.
    raise_m: f64,
}

impl Appearance {
    pub(crate) fn new(ramp_s: f64, beta_per_m: f64) -> Self {
        Self {
            ramp_s,
            beta_per_m,
            known: Vec::with_capacity(MAX_OBSTACLES),
            next: Vec::with_capacity(MAX_OBSTACLES),
            last_h: f64::INFINITY,
        }
    }

    /// Raises the values of newcomers among `constraints`, one for each of `track_ids`. `control` is what the robot may do.
    pub(crate) fn apply(
        &mut self,
        track_ids: &[u64],
        constraints: &mut [BarrierConstraint],
        control: &InputBox<2>,
        now_ns: u64,
    ) {
        self.next.clear();
        for (&track_id, constraint) in track_ids.iter().zip(constraints) {
            let mut known = self.recall(track_id, constraint.h, now_ns);
            let age_s = now_ns.saturating_sub(known.appeared_ns) as f64 * 1e-9;
            let left_s = self.ramp_s - age_s;
            let soonest = constraint.h + left_s * slowest_rate(constraint, control);
            if left_s <= 0.0 || constraint.h <= 0.0 || soonest <= 0.0 {
                known.raise_m = 0.0;
            }
            if known.raise_m > 0.0 {
                let rate_mps = -known.raise_m / self.ramp_s;
                constraint.h += known.raise_m * left_s / self.ramp_s;
                constraint.drift += rate_mps;
                constraint.dh_dt += rate_mps;
            }
            self.next.push(known);
        }
        std::mem::swap(&mut self.known, &mut self.next);
    }

    /// Notes what `h` came to, m, for those who appear in the next cycle.
    pub(crate) fn note(&mut self, h: f64) {
        self.last_h = h;
    }

    /// What is known of a track; a new one begins its ramp now.
    fn recall(&self, track_id: u64, h_bar: f64, now_ns: u64) -> Known {
        let known = self.known.iter().find(|known| known.track_id == track_id);
        known.copied().unwrap_or_else(|| {
            let gap_m = self.last_h + UNSEEN_BETAS / self.beta_per_m - h_bar;
            let raise_m = if gap_m.is_finite() { gap_m.max(0.0) } else { 0.0 };
            Known { track_id, appeared_ns: now_ns, raise_m }
        })
    }
}

/// The smallest rate of `h` that an admissible control can bring about, m/s.
fn slowest_rate(constraint: &BarrierConstraint, control: &InputBox<2>) -> f64 {
    let least = |k: usize| (constraint.lg_h[k] * control.min[k]).min(constraint.lg_h[k] * control.max[k]);
    constraint.drift + least(0) + least(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAMP_NS: u64 = 500_000_000;

    fn appearance() -> Appearance {
        Appearance::new(0.5, 4.0)
    }

    fn control() -> InputBox<2> {
        InputBox { min: [-1.0; 2], max: [1.0; 2] }
    }

    /// Someone at `h̄` whose value changes by −0.2 m/s whatever the robot does, and by 0.1 m/s at most through the control.
    fn someone(h: f64) -> BarrierConstraint {
        BarrierConstraint {
            h,
            lg_h: [0.06, -0.04],
            drift: -0.2,
            dh_dt: -0.2,
            sdf: h,
            critical: 0,
            outside_domain: 0,
        }
    }

    /// What the newcomer 2 counts with, beside 1 who is known and at 1 m.
    fn newcomer(appearance: &mut Appearance, h: f64, now_ns: u64) -> BarrierConstraint {
        let mut constraints = [someone(1.0), someone(h)];
        appearance.apply(&[1, 2], &mut constraints, &control(), now_ns);
        assert_eq!(constraints[0], someone(1.0), "who is known counts in full");
        appearance.note(1.0);
        constraints[1]
    }

    fn with_one_known() -> Appearance {
        let mut appearance = appearance();
        appearance.apply(&[1], &mut [someone(1.0)], &control(), 0);
        appearance.note(1.0);
        appearance
    }

    #[test]
    fn in_the_first_cycle_and_without_anybody_before_everybody_counts_in_full() {
        let mut constraints = [someone(2.0), someone(1.5)];
        appearance().apply(&[1, 2], &mut constraints, &control(), 7);
        assert_eq!(constraints, [someone(2.0), someone(1.5)]);
    }

    #[test]
    fn a_newcomer_begins_without_weight_and_counts_in_full_after_the_ramp() {
        let mut appearance = with_one_known();
        let first = newcomer(&mut appearance, 0.8, 1_000);
        assert!((first.h - (1.0 + 5.0 / 4.0)).abs() < 1e-12, "{first:?}");
        let middle = newcomer(&mut appearance, 0.8, 1_000 + RAMP_NS / 2);
        assert!((middle.h - (0.8 + 0.5 * 1.45)).abs() < 1e-9, "{middle:?}");
        // The rate is the slope of what is added.
        assert!((middle.drift - (-0.2 - 1.45 / 0.5)).abs() < 1e-9 && middle.dh_dt == middle.drift);
        for now_ns in [1_000 + RAMP_NS, 1_000 + 3 * RAMP_NS] {
            assert_eq!(newcomer(&mut appearance, 0.8, now_ns), someone(0.8));
        }
    }

    #[test]
    fn who_is_inside_or_could_be_before_the_ramp_ends_counts_in_full_from_then_on() {
        for dangerous in [-0.3, 0.0, 0.5 * 0.3] {
            let mut appearance = with_one_known();
            assert_eq!(newcomer(&mut appearance, dangerous, 1_000), someone(dangerous), "{dangerous}");
            assert_eq!(newcomer(&mut appearance, 2.0, 1_001), someone(2.0), "and stays so");
        }
        let mut appearance = with_one_known();
        assert!(newcomer(&mut appearance, 0.16, 1_000).h > 0.16);
        assert_eq!(newcomer(&mut appearance, 0.1, 2_000), someone(0.1), "as soon as it is dangerous");
    }

    #[test]
    fn who_leaves_and_comes_back_begins_anew_and_who_is_far_above_is_not_raised() {
        let mut appearance = with_one_known();
        newcomer(&mut appearance, 0.8, 0);
        appearance.apply(&[1], &mut [someone(1.0)], &control(), RAMP_NS);
        appearance.note(1.0);
        let again = newcomer(&mut appearance, 0.8, 2 * RAMP_NS);
        assert!((again.h - 2.25).abs() < 1e-12, "{again:?}");
        let mut appearance = with_one_known();
        assert_eq!(newcomer(&mut appearance, 2.5, 0), someone(2.5));
    }
}
