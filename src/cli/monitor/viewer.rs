//! What a person looks at, and the keys.

use super::news::News;
use super::picture::{Picture, badness};
use crate::config::visible;
use std::time::Duration;

/// A wish of the person at the keyboard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    Up,
    Down,
    Sort,
    Freeze,
    Zoom,
    Help,
    /// Back from the help or the zoom.
    Back,
}

/// The picture, and how it is looked at.
#[derive(Debug)]
pub struct Viewer {
    /// What is watched, for people.
    pub source: String,
    live: Picture,
    /// The picture that stands still, and since when.
    frozen: Option<(Picture, Duration)>,
    /// Number of the selected cylinder, from 1.
    pub selected: usize,
    /// Whether the worst cylinder is first.
    pub worst_first: bool,
    pub is_zoomed: bool,
    pub is_helped: bool,
}

impl Viewer {
    /// A viewer of `source`, of which nothing is known yet.
    pub fn new(source: String) -> Self {
        Self {
            source: visible(&source).into_owned(),
            live: Picture::default(),
            frozen: None,
            selected: 1,
            worst_first: false,
            is_zoomed: false,
            is_helped: false,
        }
    }

    /// Takes what was told at `at`, also while the picture stands still.
    pub fn take(&mut self, news: News, at: Duration) {
        self.live.take(news, at);
    }

    /// The picture that is shown, and the time that it is of: `now`, or that since which it stands still.
    pub fn shown(&self, now: Duration) -> (&Picture, Duration) {
        self.frozen.as_ref().map_or((&self.live, now), |(picture, since)| (picture, *since))
    }

    /// How long the picture has stood still.
    pub fn frozen_for(&self, now: Duration) -> Option<Duration> {
        self.frozen.as_ref().map(|(_, since)| now.saturating_sub(*since))
    }

    /// Numbers of the cylinders in the order in which they are shown.
    pub fn order(&self, now: Duration) -> Vec<usize> {
        let (picture, now) = self.shown(now);
        let mut cylinders = picture.cylinders(now);
        if self.worst_first {
            cylinders.sort_by(|one, other| {
                let [one, other] =
                    [one, other].map(|it| (badness(it, picture.limits(it.number)), it.number));
                let ((lamp, share), number) = one;
                let ((lamp2, share2), number2) = other;
                lamp.cmp(&lamp2).then(share2.total_cmp(&share)).then(number.cmp(&number2))
            });
        }
        cylinders.iter().map(|cylinder| cylinder.number).collect()
    }

    /// Does what was wished at `now`.
    pub fn wish(&mut self, wish: Wish, now: Duration) {
        match wish {
            Wish::Up => self.step(now, usize::wrapping_sub),
            Wish::Down => self.step(now, usize::wrapping_add),
            Wish::Sort => self.worst_first = !self.worst_first,
            Wish::Freeze => {
                self.frozen = match self.frozen.take() {
                    Some(_) => None,
                    None => Some((self.live.clone(), now)),
                };
            }
            Wish::Zoom => self.is_zoomed = !self.is_zoomed,
            Wish::Help => self.is_helped = !self.is_helped,
            Wish::Back if self.is_helped => self.is_helped = false,
            Wish::Back => self.is_zoomed = false,
        }
    }

    /// Selects a neighbour; at the ends there is none.
    fn step(&mut self, now: Duration, to: fn(usize, usize) -> usize) {
        let order = self.order(now);
        let place = order.iter().position(|number| *number == self.selected);
        let next = place.and_then(|place| order.get(to(place, 1)));
        if let Some(number) = next.or_else(|| order.first().filter(|_| place.is_none())) {
            self.selected = *number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::view::samples;
    use super::*;

    const NOW: Duration = Duration::from_secs(20);

    #[test]
    fn keys_select_sort_freeze_and_go_back() {
        let mut viewer = samples::viewer(NOW);
        viewer.wish(Wish::Up, NOW);
        assert_eq!(viewer.selected, 1, "there is none above");
        (0..9).for_each(|_| viewer.wish(Wish::Down, NOW));
        assert_eq!(viewer.selected, 6, "there is none below");
        viewer.wish(Wish::Sort, NOW);
        assert_eq!(viewer.order(NOW), [3, 5, 4, 2, 6, 1]);
        assert_eq!(viewer.selected, 6, "the same cylinder, wherever it stands now");
        viewer.wish(Wish::Up, NOW);
        assert_eq!(viewer.selected, 2);
        for wish in [Wish::Zoom, Wish::Help, Wish::Back] {
            viewer.wish(wish, NOW);
        }
        assert!(viewer.is_zoomed && !viewer.is_helped);
        viewer.wish(Wish::Back, NOW);
        assert!(!viewer.is_zoomed);
    }

    #[test]
    fn a_frozen_picture_stands_still_and_the_live_one_goes_on() {
        let mut viewer = samples::viewer(NOW);
        let later = NOW + Duration::from_secs(60);
        viewer.wish(Wish::Freeze, NOW);
        viewer.take(News::Lost("gone".to_owned()), later);
        let (picture, of) = viewer.shown(later);
        assert_eq!((of, picture.blindness(of)), (NOW, None));
        assert_eq!(viewer.frozen_for(later), Some(Duration::from_secs(60)));
        viewer.wish(Wish::Freeze, later);
        let (picture, of) = viewer.shown(later);
        assert!(of == later && picture.blindness(of).is_some());
        assert_eq!(viewer.frozen_for(later), None);
    }
}
