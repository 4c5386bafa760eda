//! What the measured lateness means, in plain words.

use std::time::Duration;

use super::{Lateness, WayLateness, kernel};

/// Deadline below which nothing is promised on a kernel without PREEMPT_RT, ms. Its longest stretches that nothing can
/// interrupt are not bounded by anything; what was met in practice, under every scheduling class, stayed a few times below.
const UNPROMISED_MS: f64 = 20.0;
/// A way is worth naming if the worst 1 % of the settings' own way is later than this times its worst 1 %.
const MUCH_BETTER: f64 = 2.0;

/// What this machine can hold.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Whether 999 of 1000 cycles began within a period of their due time.
    pub held: bool,
    /// The same in sentences, the most important first.
    pub sentences: Vec<String>,
}

/// Judges a rate of one cycle per `period` by `own`, the way that the settings ask for, and compares with the `other` ways.
pub fn judge(own: &WayLateness, others: &[WayLateness], period: Duration) -> Verdict {
    judge_on(own, others, period, kernel::is_realtime(), kernel::is_virtual())
}

fn judge_on(
    own: &WayLateness,
    others: &[WayLateness],
    period: Duration,
    realtime: bool,
    guest: bool,
) -> Verdict {
    let Lateness { count, p999_ns, max_ns, later_than_a_period, .. } = own.lateness;
    let period_ms = period.as_secs_f64() * 1e3;
    let rate_hz = 1e3 / period_ms;
    let held = ms(p999_ns) <= period_ms;
    let answer = if held { "held" } else { "not held" };
    let mut sentences = vec![if p999_ns < max_ns {
        format!(
            "{rate_hz:.0} Hz: {answer}; 99.9 % of {count} wake-ups came within {:.2} ms, the worst {:.2} ms late.",
            ms(p999_ns),
            ms(max_ns)
        )
    } else {
        format!("{rate_hz:.0} Hz: {answer}; the worst of {count} wake-ups came {:.2} ms late.", ms(max_ns))
    }];
    if later_than_a_period > 0 {
        sentences.push(format!(
"Later than a whole period of {period_ms:.0} ms, at the price of a cycle each: {later_than_a_period} wake-ups."
        ));
    }
    if !held {
        let fitting_hz = (0.5e3 / ms(p999_ns)).floor().max(1.0);
        sentences.push(format!(
            "Raise filter.period_ms to {:.0} or more ({fitting_hz:.0} Hz), or take other work off this machine.",
            1e3 / fitting_hz
        ));
    }
    sentences.push(promise(realtime, guest, ms(max_ns)));
    if !own.refused.is_empty() {
        let names: Vec<_> = own.refused.iter().map(|grant| grant.what.label()).collect();
        sentences.push(format!("Measured without what the kernel did not grant: {}.", names.join(", ")));
    }
    // A way that was measured without what it asks for shows nothing that [realtime] could bring.
    let best = others
        .iter()
        .filter(|way| way.lateness.count > 0 && way.refused.is_empty())
        .min_by_key(|way| way.lateness.p99_ns);
    if let Some(best) = best
        && ms(own.lateness.p99_ns) > MUCH_BETTER * ms(best.lateness.p99_ns)
    {
        sentences.push(format!(
            "Punctual here was \"{}\": late by {:.3} ms at p99 instead of {:.3} ms; [realtime] can ask for it.",
            best.name,
            ms(best.lateness.p99_ns),
            ms(own.lateness.p99_ns)
        ));
    }
    sentences.push("Other work changes these figures: measure again with the robot's own load.".to_owned());
    Verdict { held, sentences }
}

/// What may be counted on, beyond what happened to be measured.
fn promise(realtime: bool, guest: bool, worst_ms: f64) -> String {
    let floor_ms = UNPROMISED_MS.max((2.0 * worst_ms).ceil());
    match (realtime, guest) {
        (true, false) => format!(
            "The kernel has PREEMPT_RT: a deadline of {:.1} ms, twice the worst, can be promised if it holds for hours under load (--seconds).",
            2.0 * worst_ms
        ),
        (true, true) => format!(
            "No deadline below {floor_ms:.0} ms can be promised: the machine is virtual, and its host may stop it at any time."
        ),
        (false, false) => format!("No deadline below {floor_ms:.0} ms can be promised without PREEMPT_RT."),
        (false, true) => format!(
            "No deadline below {floor_ms:.0} ms can be promised without PREEMPT_RT, and on a virtual machine not even that for certain."
        ),
    }
}

fn ms(ns: u64) -> f64 {
    ns as f64 * 1e-6
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(4);

    fn way(name: &str, [p99_us, p999_us, max_us]: [u64; 3], later_than_a_period: usize) -> WayLateness {
        let lateness = Lateness {
            count: 1000,
            p50_ns: 10_000,
            p99_ns: p99_us * 1000,
            p999_ns: p999_us * 1000,
            max_ns: max_us * 1000,
            later_than_a_period,
        };
        WayLateness { name: name.to_owned(), refused: Vec::new(), lateness }
    }

    #[test]
    fn a_quiet_machine_holds_its_rate_and_still_promises_nothing() {
        let own = way("own", [300, 900, 3200], 0);
        let verdict = judge_on(&own, &[way("other", [200, 800, 2000], 0)], PERIOD, false, false);
        assert!(verdict.held);
        let text = verdict.sentences.join("\n");
        assert!(
            text.contains(
                "250 Hz: held; 99.9 % of 1000 wake-ups came within 0.90 ms, the worst 3.20 ms late"
            ),
            "{text}"
        );
        assert!(text.contains("No deadline below 20 ms can be promised without PREEMPT_RT"), "{text}");
        assert!(!text.contains("Punctual"), "a third better is not worth a word: {text}");
        let few = judge_on(&way("own", [300, 3200, 3200], 0), &[], PERIOD, false, false);
        assert!(few.sentences[0].contains("held; the worst of 1000 wake-ups came 3.20 ms late"), "{few:?}");
    }

    #[test]
    fn a_busy_machine_is_told_so_with_a_rate_that_fits() {
        let own = way("own", [5000, 8000, 30_000], 40);
        let verdict = judge_on(&own, &[way("fifo", [100, 200, 300], 0)], PERIOD, false, true);
        assert!(!verdict.held);
        let text = verdict.sentences.join("\n");
        for expected in [
            "not held",
            "price of a cycle each: 40 wake-ups",
            "to 16 or more (62 Hz)",
            "below 60 ms",
            "\"fifo\"",
        ] {
            assert!(text.contains(expected), "no `{expected}` in {text}");
        }
    }

    #[test]
    fn a_way_that_lacked_a_right_is_not_recommended() {
        let own = way("own", [5000, 8000, 30_000], 40);
        let mut fifo = way("fifo", [100, 200, 300], 0);
        fifo.refused = vec![crate::realtime::Grant {
            what: crate::realtime::Right::Fifo,
            asked: "SCHED_FIFO 80".to_owned(),
            got: "SCHED_OTHER".to_owned(),
            granted: false,
            advice: "ask".to_owned(),
        }];
        let verdict = judge_on(&own, &[fifo, way("slack", [200, 300, 400], 0)], PERIOD, false, false);
        let text = verdict.sentences.join("\n");
        assert!(text.contains("Punctual here was \"slack\"") && !text.contains("\"fifo\""), "{text}");
    }

    #[test]
    fn a_real_time_kernel_may_promise_unless_it_is_a_guest() {
        assert!(promise(true, false, 0.08).contains("0.2 ms"));
        assert!(promise(true, true, 0.08).contains("host"));
    }
}
