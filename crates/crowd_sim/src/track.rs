//! A recorded track, made continuous: where somebody was and how fast, at any time between its first and its last.
//!
//! Cubic Hermite pieces between the recorded positions. Velocities at those are the slopes of the parabola through a position
//! and its two neighbours (at the ends: the straight line to the only one), so that velocity is continuous and a person who
//! walks steadily is given exactly that velocity.

/// Slack with which a moment counts as the first or last of a track, s: the crowd's ticks are sums of rounded numbers.
const SLACK_S: f64 = 1e-6;

/// A track with the place in it that was asked for last.
#[derive(Debug, Clone)]
pub(crate) struct Track {
    times_s: Vec<f64>,
    positions_m: Vec<[f64; 2]>,
    /// Slopes at the recorded times, m/s.
    velocities_mps: Vec<[f64; 2]>,
    /// Index of the piece that the last moment fell into. Moments rise, so that looking on from here is enough.
    piece: usize,
}

impl Track {
    /// From times (s, rising) and as many positions (m), as validated by the scenario.
    pub(crate) fn new(times_s: &[f64], positions_m: &[[f64; 2]]) -> Self {
        let slope = |i: usize| -> [f64; 2] {
            let dt_s = times_s[i + 1] - times_s[i];
            [0, 1].map(|k| (positions_m[i + 1][k] - positions_m[i][k]) / dt_s)
        };
        let pieces = times_s.len().saturating_sub(1);
        let velocities_mps = (0..times_s.len()).map(|i| match (i.checked_sub(1), i < pieces) {
            (None, false) => [0.0, 0.0],
            (None, true) => slope(i),
            (Some(before), false) => slope(before),
            (Some(before), true) => {
                let [earlier_s, later_s] = [times_s[i] - times_s[before], times_s[i + 1] - times_s[i]];
                let ([a, b], total_s) = ([slope(before), slope(i)], earlier_s + later_s);
                [0, 1].map(|k| (a[k] * later_s + b[k] * earlier_s) / total_s)
            }
        });
        let velocities_mps = velocities_mps.collect();
        Self { times_s: times_s.to_vec(), positions_m: positions_m.to_vec(), velocities_mps, piece: 0 }
    }

    /// Position (m) and velocity (m/s) at `time_s`, which is not smaller than in the call before; `None` before the first
    /// and after the last recorded time.
    pub(crate) fn at(&mut self, time_s: f64) -> Option<([f64; 2], [f64; 2])> {
        let (first_s, last_s) = (*self.times_s.first()?, *self.times_s.last()?);
        if time_s < first_s - SLACK_S || time_s > last_s + SLACK_S {
            return None;
        }
        let time_s = time_s.clamp(first_s, last_s);
        while self.piece + 2 < self.times_s.len() && self.times_s[self.piece + 1] <= time_s {
            self.piece += 1;
        }
        let (i, j) = (self.piece, self.piece + 1);
        let dt_s = self.times_s[j] - self.times_s[i];
        let s = (time_s - self.times_s[i]) / dt_s;
        // Hermite's basis and its derivative, for the ends' positions p, q and their slopes m, n times dt.
        let (p, q, m, n) =
            (self.positions_m[i], self.positions_m[j], self.velocities_mps[i], self.velocities_mps[j]);
        let position_m = [0, 1].map(|k| {
            let rise = q[k] - p[k];
            p[k] + s * s * (3.0 - 2.0 * s) * rise
                + dt_s * (s * (1.0 - s) * (1.0 - s) * m[k] - s * s * (1.0 - s) * n[k])
        });
        let velocity_mps = [0, 1].map(|k| {
            6.0 * s * (1.0 - s) * (q[k] - p[k]) / dt_s
                + (1.0 - s) * (1.0 - 3.0 * s) * m[k]
                + s * (3.0 * s - 2.0) * n[k]
        });
        Some((position_m, velocity_mps))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_met_exactly_inside_and_its_velocity_too() {
        let at = |t: f64| [1.0 + 0.5 * t - 0.2 * t * t, -2.0 * t + 0.3 * t * t];
        let times_s = [0.0, 0.4, 0.5, 1.1, 1.5, 2.0];
        let mut track = Track::new(&times_s, &times_s.map(at));
        // The first and the last piece lean on a one-sided slope.
        for k in 0..=110 {
            let t = 0.4 + 0.01 * f64::from(k);
            let (position_m, velocity_mps) = track.at(t).expect("within");
            for (found, expected) in position_m
                .into_iter()
                .zip(at(t))
                .chain(velocity_mps.into_iter().zip([0.5 - 0.4 * t, -2.0 + 0.6 * t]))
            {
                assert!((found - expected).abs() < 1e-12, "{found} is not {expected} at {t}");
            }
        }
    }

    #[test]
    fn velocity_is_the_derivative_of_position_and_has_no_jumps() {
        let positions_m = [[0.0, 0.0], [0.3, 0.1], [0.2, 0.5], [0.2, 0.5], [1.0, -0.4]];
        let mut track = Track::new(&[0.0, 0.1, 0.25, 0.4, 1.0], &positions_m);
        let mut before: Option<([f64; 2], [f64; 2])> = None;
        for tick in 0..=100_000 {
            let now = track.at(f64::from(tick) * 1e-5).expect("within");
            if let Some(before) = before {
                for k in 0..2 {
                    let difference = (now.0[k] - before.0[k]) / 1e-5;
                    let mean = 0.5 * (now.1[k] + before.1[k]);
                    assert!((difference - mean).abs() < 1e-4 && (now.1[k] - before.1[k]).abs() < 5e-3);
                }
            }
            before = Some(now);
        }
    }

    #[test]
    fn nobody_is_there_before_or_after() {
        let mut track = Track::new(&[1.0, 2.0], &[[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(track.at(0.99), None);
        assert_eq!(track.at(1.0 - 1e-9), Some(([0.0, 0.0], [1.0, 0.0])));
        assert_eq!(track.at(1.5).map(|(position_m, _)| position_m), Some([0.5, 0.0]));
        assert_eq!(track.at(2.0 + 1e-9).map(|(position_m, _)| position_m), Some([1.0, 0.0]));
        assert_eq!(track.at(2.01), None);
    }
}
