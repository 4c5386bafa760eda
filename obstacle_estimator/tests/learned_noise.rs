//! Nobody need know how noisy perception is: it is learnt from the sightings, and what is learnt is worth having.

mod support;
#[path = "support/walks.rs"]
mod walks;

use messages::{Detection, DetectionFlags};
use obstacle_estimator::Estimator;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use settings::{EstimatorSettings, LearnedNoiseSettings, NoiseSettings};
use support::{LEARNED, NOISE, close, feed, imm, learning, of, seen, settings};
use walks::{Manner, Sight, State, errors, walks};

const NOISES_M: [f64; 5] = [0.01, 0.02, 0.05, 0.10, 0.15];

fn believed_m(estimator: &Estimator) -> f64 {
    estimator.position_sd_m().expect("a filter believes something")
}

/// Where somebody is seen: noise of `sd_m` on each axis.
fn noisy(state: &State, sd_m: f64, random: &mut Pcg64) -> [f64; 2] {
    state.position_m.map(|at| {
        let noise: f64 = StandardNormal.sample(random);
        at + sd_m * noise
    })
}

/// The same sighting with a covariance of `variance_m2` on each axis.
fn with_covariance(detection: Detection, variance_m2: f64) -> Detection {
    Detection {
        position_covariance_m2: [variance_m2, 0.0, variance_m2],
        flags: DetectionFlags::HAS_COVARIANCE,
        ..detection
    }
}

/// What became of people who were shown by hand.
struct Shown {
    estimator: Estimator,
    /// Root mean square of each person's velocity error from `from_ms` on, m/s.
    velocity_mps: Vec<f64>,
    most_tracks: usize,
}

/// Shows people who walk from goal to goal for 20 s, as `see(at_ms, person, state)` has it. Named people are matched by name, anonymous ones
/// count for `most_tracks` alone; both from `from_ms` on.
fn show(
    settings: EstimatorSettings,
    people: usize,
    interval_ms: usize,
    from_ms: u64,
    mut see: impl FnMut(u64, u64, &State) -> Option<Detection>,
) -> Shown {
    let walks = &walks(Manner::Goals, 20, 3)[..people];
    let mut estimator = Estimator::new(settings);
    let (mut squares, mut samples, mut most_tracks) = (vec![0.0; people], vec![0_u32; people], 0);
    for step in (0..walks[0].len()).step_by(interval_ms / 10) {
        let at_ms = step as u64 * 10;
        let frame: Vec<Detection> =
            (0..people).filter_map(|i| see(at_ms, i as u64 + 1, &walks[i][step])).collect();
        let answer = feed(&mut estimator, at_ms, &frame);
        if at_ms < from_ms {
            continue;
        }
        most_tracks = most_tracks.max(answer.as_slice().len());
        for person in answer.as_slice().iter().filter(|person| person.track_id <= people as u64) {
            let i = person.track_id as usize - 1;
            let (found, truth) = (person.velocity_in_odom_mps, walks[i][step].velocity_mps);
            squares[i] += (found[0] - truth[0]).powi(2) + (found[1] - truth[1]).powi(2);
            samples[i] += 1;
        }
    }
    let root = |(square, n): (&f64, &u32)| (square / f64::from((*n).max(1))).sqrt();
    Shown { estimator, velocity_mps: squares.iter().zip(&samples).map(root).collect(), most_tracks }
}

#[test]
fn the_noise_is_found_whatever_people_do() {
    for manner in [Manner::Goals, Manner::Turns] {
        let people = walks(manner, 10, 3);
        for (interval_ms, dropout) in [(50, 0.0), (50, 0.1), (100, 0.0)] {
            for position_sd_m in NOISES_M {
                let sight = Sight { interval_ms, position_sd_m, dropout, latency_ms: 0 };
                let found =
                    errors(&learning(), &people, sight, 5).believed_sd_m.expect("it believes something");
                // 512 residuals, neighbours of which share sightings; turns at 10 Hz add up to a centimetre.
                let most_m = 1.2 * position_sd_m + if interval_ms == 100 { 0.01 } else { 0.003 };
                assert!((0.8 * position_sd_m..most_m).contains(&found), "{found} m, {manner:?} {sight:?}");
            }
        }
    }
}

#[test]
fn what_is_learnt_is_nearly_as_good_as_what_is_known_and_better_than_a_guess() {
    for manner in [Manner::Goals, Manner::Turns] {
        let people = walks(manner, 20, 1);
        for (position_sd_m, guessed_m) in [(0.02, 0.15), (0.15, 0.02)] {
            let sight = Sight { interval_ms: 50, position_sd_m, dropout: 0.1, latency_ms: 0 };
            let with = |position_sd_m, learned| {
                let noise = Some(NoiseSettings { position_sd_m, learned, ..NOISE });
                errors(&EstimatorSettings { noise, ..imm() }, &people, sight, 5).velocity_mps
            };
            let (known, guessed) = (with(position_sd_m, None), with(guessed_m, None));
            let learnt = with(guessed_m, Some(LEARNED));
            assert!(learnt < 1.1 * known, "learnt {learnt}, known {known}, {manner:?} {sight:?}");
            assert!(guessed > 1.2 * learnt, "learnt {learnt}, guessed {guessed}, {manner:?} {sight:?}");
        }
    }
}

/// Nobody tells the estimator that positions are exact, but from then on it does what the paper does.
#[test]
fn exact_positions_are_differenced_as_published() {
    let (mut learning, mut published) = (Estimator::new(learning()), Estimator::new(settings()));
    for (k, at_ms) in (0..6_000).step_by(50).enumerate() {
        let t = at_ms as f64 * 1e-3;
        let people: Vec<Detection> =
            (0..10).map(|i| seen(i + 1, [t + i as f64, 3.0 + (0.5 * t + i as f64).sin()])).collect();
        let (ours, theirs) = (feed(&mut learning, at_ms, &people), feed(&mut published, at_ms, &people));
        if k < 20 {
            continue;
        }
        for (ours, theirs) in ours.as_slice().iter().zip(theirs.as_slice()) {
            assert_eq!(ours.position_in_odom_m, theirs.position_in_odom_m);
            assert!(
                close(ours.velocity_in_odom_mps[1], theirs.velocity_in_odom_mps[1]),
                "{ours:?} {theirs:?}"
            );
            assert!(close(ours.heading_rate_radps, theirs.heading_rate_radps), "{ours:?} {theirs:?}");
        }
    }
    assert!(believed_m(&learning) < 0.002, "{}", believed_m(&learning));
}

#[test]
fn missing_sightings_and_missing_names_do_not_keep_exact_positions_from_being_known() {
    let with_dropout = |settings| {
        let mut random = Pcg64::new(1, 1);
        show(settings, 10, 50, 2_000, |_, person, state| {
            (random.random::<f64>() >= 0.1).then(|| seen(person, state.position_m))
        })
    };
    let (named, published) = (with_dropout(learning()), with_dropout(settings()));
    for (ours, theirs) in named.velocity_mps.iter().zip(&published.velocity_mps) {
        assert!(*ours < 1.1 * theirs + 0.02, "{:?} {:?}", named.velocity_mps, published.velocity_mps);
    }
    let anonymous = show(learning(), 6, 50, 0, |_, _, state| Some(seen(0, state.position_m)));
    assert_eq!((anonymous.most_tracks, anonymous.estimator.counts().tracks_dropped), (6, 0));
}

/// Noise that keeps itself from being seen, since belief in exact positions takes it for jumps, is learnt all the same.
#[test]
fn noise_that_sets_in_is_learnt() {
    for (name, interval_ms, sd_m) in
        [(1, 10, 0.15), (1, 20, 0.15), (1, 50, 0.15), (0, 50, 0.15), (0, 50, 0.05)]
    {
        let mut random = Pcg64::new(2, 2);
        let shown = show(learning(), 6, interval_ms, 12_000, |at_ms, person, state| {
            Some(seen(name * person, noisy(state, if at_ms < 8_000 { 0.0 } else { sd_m }, &mut random)))
        });
        let (found, counts) = (believed_m(&shown.estimator), shown.estimator.counts());
        assert!((0.8 * sd_m..1.3 * sd_m).contains(&found), "{name} {interval_ms} {found} {counts:?}");
        assert!(shown.most_tracks <= 7 && counts.tracks_teleported < 10, "{} {counts:?}", shown.most_tracks);
    }
}

/// Exact eyes for most, bad ones for somebody: who brings a covariance, who stands where it is hard to see, who jumps at times.
#[test]
fn nobody_is_differenced_for_the_others_exactness() {
    let published = |random: &mut Pcg64, sd_m| {
        show(settings(), 1, 50, 2_000, |_, person, state| Some(seen(person, noisy(state, sd_m, random))))
            .velocity_mps[0]
    };
    for (says_so, sd_m) in [(true, 0.2), (false, 0.05)] {
        let mut random = Pcg64::new(3, 3);
        let shown = show(learning(), 20, 50, 2_000, |_, person, state| {
            let own = if person == 1 { sd_m } else { 0.0 };
            let detection = seen(person, noisy(state, own, &mut random));
            Some(if person == 1 && says_so { with_covariance(detection, sd_m * sd_m) } else { detection })
        });
        let differenced_mps = published(&mut Pcg64::new(3, 3), sd_m);
        assert!(shown.velocity_mps[0] < 0.5 * differenced_mps, "{:?} {differenced_mps}", shown.velocity_mps);
        assert!(shown.velocity_mps[1] < 0.2, "{:?}", shown.velocity_mps);
    }
    let mut random = Pcg64::new(4, 4);
    let shown = show(learning(), 20, 50, 2_000, |_, person, state| {
        let jump_m = if person == 1 && random.random::<f64>() < 0.02 { 0.3 } else { 0.0 };
        Some(seen(person, [state.position_m[0] + jump_m, state.position_m[1]]))
    });
    // Differences of such a jump are 6 m/s twice, at 2 % of the sightings: 1.2 m/s.
    assert!(shown.velocity_mps[0] < 0.5, "{:?}", shown.velocity_mps);
}

#[test]
fn a_covariance_keeps_a_sighting_from_being_differenced() {
    let mut estimator = Estimator::new(learning());
    for k in 0..60_u64 {
        let at_m = |person: u64| [0.05 * k as f64, person as f64 + (0.1 * k as f64).sin()];
        let mut people: Vec<Detection> = (1..=10).map(|person| seen(person, at_m(person))).collect();
        if k % 2 == 0 {
            people[0] = with_covariance(people[0], 1e-4);
        }
        let answer = feed(&mut estimator, 50 * k, &people);
        if k > 20 {
            assert_ne!(of(&answer, 1).position_in_odom_m, at_m(1));
            assert_eq!(of(&answer, 2).position_in_odom_m, at_m(2));
        }
    }
}

/// A longer interval makes a difference more exact, but a missing frame is no reason to change over for one frame.
#[test]
fn a_missing_frame_changes_nothing_over_to_differences() {
    let mut random = Pcg64::new(6, 6);
    let walks = &walks(Manner::Goals, 10, 3)[..10];
    let mut estimator = Estimator::new(learning());
    for (k, step) in (0..1_000).step_by(5).enumerate() {
        let seen_m: Vec<[f64; 2]> = walks.iter().map(|walk| noisy(&walk[step], 0.001, &mut random)).collect();
        let people: Vec<Detection> = (0..10).map(|i| seen(i as u64 + 1, seen_m[i])).collect();
        if k % 7 == 0 {
            continue;
        }
        let answer = feed(&mut estimator, step as u64 * 10, &people);
        for (i, at_m) in seen_m.iter().enumerate().filter(|_| k > 40) {
            assert_ne!(of(&answer, i as u64 + 1).position_in_odom_m, *at_m);
        }
    }
}

/// Perception that repeats itself between two looks, or that rounds, shows people who do not move at all for a while.
#[test]
fn old_and_rounded_positions_are_not_taken_for_exact_ones() {
    let repeated = |t: f64| 1.2 * (t / 0.2).floor() * 0.2;
    let rounded = |t: f64| (1.2 * t / 0.1).floor() * 0.1;
    let standing = |t: f64| if t < 20.0 { rounded(20.0) } else { rounded(t) };
    let ways: [(&str, &dyn Fn(f64) -> f64); 3] =
        [("repeated", &repeated), ("rounded", &rounded), ("standing, then rounded", &standing)];
    let noise = Some(NoiseSettings { position_sd_m: 0.005, learned: Some(LEARNED), ..NOISE });
    for (what, way) in ways {
        let mut estimator = Estimator::new(EstimatorSettings { noise, ..imm() });
        let mut fastest_mps = 0.0_f64;
        for at_ms in (0..30_000).step_by(50) {
            let position_m = [way(at_ms as f64 * 1e-3), 2.0];
            let person = of(&feed(&mut estimator, at_ms, &[seen(1, position_m)]), 1);
            if at_ms > 24_000 {
                fastest_mps = fastest_mps.max(person.speed_mps);
            }
        }
        assert!(believed_m(&estimator) > 0.02, "{what}: {}", believed_m(&estimator));
        // Differences would see 4.8 and 2 m/s.
        assert!(fastest_mps < 1.5, "{what}: {fastest_mps} m/s");
    }
}

#[test]
fn a_few_sightings_and_sightings_with_a_covariance_change_no_belief() {
    let mut estimator = Estimator::new(learning());
    for k in 0..30_u64 {
        feed(&mut estimator, 50 * k, &[seen(1, [0.05 * k as f64 + 0.3 * (k % 2) as f64, 0.0])]);
    }
    assert!(close(believed_m(&estimator), NOISE.position_sd_m), "{}", believed_m(&estimator));

    let mut estimator = Estimator::new(learning());
    for k in 0..300_u64 {
        let sighting = seen(1, [0.05 * k as f64 + 0.3 * (k % 2) as f64, 0.0]);
        feed(&mut estimator, 50 * k, &[with_covariance(sighting, 0.04)]);
    }
    assert!(close(believed_m(&estimator), NOISE.position_sd_m), "{}", believed_m(&estimator));
}

#[test]
fn one_bad_frame_changes_little_and_a_rate_too_low_to_learn_from_undoes_what_was_learnt() {
    let mut random = Pcg64::new(5, 5);
    let mut bad = show(learning(), 20, 50, 0, |at_ms, person, state| {
        let slipped_m = if at_ms == 19_700 { 0.5 } else { 0.0 };
        let [x, y] = noisy(state, 0.02, &mut random);
        Some(seen(person, [x + slipped_m, y]))
    });
    assert!((0.016..0.03).contains(&believed_m(&bad.estimator)), "{}", believed_m(&bad.estimator));
    for k in 0..40_u64 {
        feed(&mut bad.estimator, 20_000 + 200 * k, &[seen(1, [0.2 * k as f64, 0.0])]);
    }
    assert!(close(believed_m(&bad.estimator), NOISE.position_sd_m), "{}", believed_m(&bad.estimator));
}

#[test]
fn no_noise_takes_the_belief_beyond_its_bounds() {
    let bounds = LearnedNoiseSettings { least_sd_m: 0.03, most_sd_m: 0.08, difference_sd_mps: 0.0 };
    let noise = Some(NoiseSettings { learned: Some(bounds), ..NOISE });
    let people = walks(Manner::Turns, 5, 3);
    for (position_sd_m, expected_m) in [(0.0, 0.03), (0.3, 0.08)] {
        let sight = Sight { interval_ms: 50, position_sd_m, dropout: 0.0, latency_ms: 0 };
        let found = errors(&EstimatorSettings { noise, ..imm() }, &people, sight, 5).believed_sd_m;
        assert_eq!(found, Some(expected_m));
    }
}
