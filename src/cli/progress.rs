//! A progress bar for long recordings, on a terminal only.

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
        let total = progress.total.filter(|total| *total >= WORTH_A_BAR);
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

    pub fn finish(&self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}
