//! A progress bar for what takes long, on a terminal only.

use crate::bus::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;

/// Shorter recordings are done before a bar is read, bytes.
const WORTH_A_BAR: u64 = 8 << 20;

/// A bar, or nothing where nobody would see it.
#[derive(Debug)]
pub struct Bar(Option<ProgressBar>);

impl Bar {
    pub fn new(progress: Progress) -> Self {
        Self::of(progress.total.filter(|total| *total >= WORTH_A_BAR))
    }

    /// A bar of so many things to do.
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

    /// One thing more is done.
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
