//! A progress bar for long tasks, on a terminal only.

use crate::bus::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;

/// Least size of a recording with a bar, bytes: shorter ones are finished before a bar is read.
const WORTH_A_BAR: u64 = 8 << 20;

/// A bar, or nothing where nobody would see it.
#[derive(Debug)]
pub struct Bar(Option<ProgressBar>);

impl Bar {
    pub fn new(progress: Progress) -> Self {
        Self::of(progress.total.filter(|total| *total >= WORTH_A_BAR))
    }

    /// A bar that counts `things`.
    pub fn counting(things: usize) -> Self {
        Self::of(Some(things as u64))
    }

    fn of(total: Option<u64>) -> Self {
        Self(total.filter(|_| std::io::stderr().is_terminal()).map(|total| {
            let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {eta} left")
                .expect("the template is a constant and sound");
            ProgressBar::new(total).with_style(style)
        }))
    }

    pub fn show(&self, progress: Progress) {
        if let Some(bar) = &self.0 {
            bar.set_position(progress.consumed);
        }
    }

    /// Counts one thing.
    pub fn count(&self) {
        if let Some(bar) = &self.0 {
            bar.inc(1);
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
