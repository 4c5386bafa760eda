//! Dead time of actuators: what is commanded now takes effect later.

use std::collections::VecDeque;

/// Finest spacing of changes that is kept, s. Where commands change more often than that, some of the changes are left out.
const RESOLUTION_S: f64 = 1e-3;
/// A change due within this time is due now, s: sums of rounded steps must not leave splinters.
const SPLINTER_S: f64 = 1e-9;

/// Commands on their way, in the order in which they were given.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DelayLine {
    delay_s: f64,
    now_s: f64,
    /// What takes effect when, s; at most `most` of them.
    waiting: VecDeque<(f64, [f64; 2])>,
    most: usize,
    newest: [f64; 2],
    in_effect: [f64; 2],
}

impl DelayLine {
    /// Nothing is commanded yet, and nothing is in effect.
    pub(crate) fn new(delay_s: f64) -> Self {
        let most = (delay_s / RESOLUTION_S).ceil() as usize + 2;
        let waiting = VecDeque::with_capacity(most);
        Self { delay_s, now_s: 0.0, waiting, most, newest: [0.0; 2], in_effect: [0.0; 2] }
    }

    /// Commands `control` from now on.
    pub(crate) fn command(&mut self, control: [f64; 2]) {
        if control == self.newest {
            return;
        }
        self.newest = control;
        if self.waiting.len() == self.most {
            self.waiting.pop_back();
        }
        self.waiting.push_back((self.now_s + self.delay_s, control));
    }

    /// What is in effect now, and for how much of the next `dt_s` (s).
    pub(crate) fn next(&mut self, dt_s: f64) -> ([f64; 2], f64) {
        while let Some(&(due_s, control)) = self.waiting.front()
            && due_s <= self.now_s + SPLINTER_S
        {
            self.in_effect = control;
            self.waiting.pop_front();
        }
        let until_s = self.waiting.front().map_or(f64::INFINITY, |(due_s, _)| due_s - self.now_s);
        // A step that all but reaches the change takes it along in the next one.
        let lasts_s = if until_s + SPLINTER_S < dt_s { until_s } else { dt_s };
        self.now_s += lasts_s;
        (self.in_effect, lasts_s)
    }
}
