//! A progress bar for what takes longer than a moment.

use indicatif::{ProgressBar, ProgressStyle};

use crate::common::someone_watches;

/// A bar on standard error where a person watches, nothing elsewhere.
pub(crate) struct Bar(Option<ProgressBar>);

impl Bar {
    /// A bar of `total` units, headed by `what`.
    pub(crate) fn new(what: &'static str, total: u64) -> Self {
        let style = ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3} %  {eta} left  {msg}");
        Self(someone_watches().then(|| {
            let bar = ProgressBar::new(total).with_prefix(what);
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar
        }))
    }

    /// A line of status without an end in sight.
    pub(crate) fn status() -> Self {
        let style = ProgressStyle::with_template("{spinner} {wide_msg}");
        Self(someone_watches().then(|| {
            let bar = ProgressBar::new_spinner();
            if let Ok(style) = style {
                bar.set_style(style);
            }
            bar
        }))
    }

    /// Moves to `position`; the message is made only if someone sees it.
    pub(crate) fn set(&self, position: u64, message: impl FnOnce() -> String) {
        if let Some(bar) = &self.0 {
            bar.set_position(position);
            bar.set_message(message());
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
