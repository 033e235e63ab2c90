//! What the parts of the view draw, and where.

use super::marks::Marks;
use crate::cli::monitor::news::WatchedCylinder;
use crate::cli::monitor::picture::Picture;
use crate::cli::monitor::viewer::Viewer;
use ratatui::layout::Rect;
use std::time::Duration;

/// Everything that the parts of the view need.
pub struct Sight<'a> {
    pub viewer: &'a Viewer,
    /// What is shown, and the time that it is of.
    pub picture: &'a Picture,
    pub of: Duration,
    /// The present time.
    pub now: Duration,
    pub cylinders: Vec<WatchedCylinder>,
    pub marks: Marks,
}

impl Sight<'_> {
    pub fn selected(&self) -> Option<&WatchedCylinder> {
        self.cylinders.iter().find(|cylinder| cylinder.number == self.viewer.selected)
    }
}

/// The first `height` lines of `area`, and the others.
pub fn split(area: Rect, height: u16) -> [Rect; 2] {
    let height = height.min(area.height);
    [below(area, 0, height), below(area, height, area.height - height)]
}

/// The `height` lines of `area` that begin with line `from`.
pub fn below(area: Rect, from: u16, height: u16) -> Rect {
    Rect { y: area.y + from, height, ..area }
}
