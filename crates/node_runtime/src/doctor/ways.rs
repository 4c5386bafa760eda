//! The same wait for the same due times in several ways, side by side.

use std::time::Duration;

use super::{Lateness, measure_wake_up_lateness};
use crate::realtime::{Grant, Request, Scheduler, try_out};

/// Length of one turn of one way. Ways take turns, so that a slow minute of the machine meets all of them.
const TURN: Duration = Duration::from_millis(500);

/// One way to wait for a due time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Way {
    /// Its name in tables and JSON.
    pub name: String,
    /// What the thread asks of the kernel.
    pub request: Request,
    /// How long before a due time it is awake.
    pub spin: Duration,
}

impl Way {
    /// The ways that show what each measure brings: none, timer slack, a spin, and what only privileged programs get.
    pub fn standard() -> Vec<Self> {
        let way =
            |name: &str, request: Request, spin: Duration| Self { name: name.to_owned(), request, spin };
        let slack = Request { timer_slack_ns: Some(1), ..Request::nothing() };
        let fifo = Request {
            scheduler: Scheduler::Fifo { priority: 80 },
            cpu_dma_latency_us: Some(0),
            ..slack.clone()
        };
        vec![
            way("as any program", Request::nothing(), Duration::ZERO),
            way("timer slack 1 ns", slack.clone(), Duration::ZERO),
            way("timer slack 1 ns, awake 200 us early", slack, Duration::from_micros(200)),
            way("fifo, cpu dma latency 0", fifo, Duration::ZERO),
        ]
    }
}

/// What was measured of one way.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WayLateness {
    /// [`Way::name`].
    pub name: String,
    /// What the kernel did not grant, so that the way was measured without it.
    pub refused: Vec<Grant>,
    /// How late it was.
    pub lateness: Lateness,
}

/// Measures `ways` for `duration` in all, with a wake-up every `period`. `progress` is told the share that is done.
///
/// Each turn runs on a thread of its own, whose rights end with it.
pub fn measure_ways(
    ways: &[Way],
    duration: Duration,
    period: Duration,
    mut progress: impl FnMut(f64),
) -> Vec<WayLateness> {
    let count = ways.len().max(1) as f64;
    let rounds = (duration.as_secs_f64() / (count * TURN.as_secs_f64())).round().max(1.0);
    let turn = duration.div_f64(count * rounds).max(period);
    let mut samples_ns = vec![Vec::new(); ways.len()];
    let mut refused = vec![Vec::new(); ways.len()];
    for round in 0..rounds as usize {
        for (index, way) in ways.iter().enumerate() {
            let measured = try_out(&way.request, |grants| {
                let refused: Vec<_> = grants.iter().filter(|grant| !grant.granted).cloned().collect();
                (refused, measure_wake_up_lateness(turn, period, way.spin))
            });
            if let Some((without, late_ns)) = measured {
                refused[index] = without;
                samples_ns[index].extend(late_ns);
            }
            progress((round as f64 + (index + 1) as f64 / count) / rounds);
        }
    }
    let results = ways.iter().zip(refused).zip(&mut samples_ns);
    results
        .map(|((way, refused), samples_ns)| WayLateness {
            name: way.name.clone(),
            refused,
            lateness: Lateness::of(samples_ns, period),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_gets_the_same_share_of_the_time() {
        let ways = Way::standard();
        let period = Duration::from_millis(2);
        let mut last = 0.0;
        let measured = measure_ways(&ways, Duration::from_millis(80), period, |share| {
            assert!(share > last && share <= 1.0);
            last = share;
        });
        assert!((last - 1.0).abs() < 1e-9, "progress ended at {last}");
        assert_eq!(measured.len(), ways.len());
        for (way, measured) in ways.iter().zip(measured) {
            assert_eq!(measured.name, way.name);
            assert_eq!(measured.lateness.count, 10);
        }
    }
}
