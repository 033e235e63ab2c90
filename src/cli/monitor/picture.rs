//! What is known of the machine at present, and of its last minutes.

use super::news::{News, Sizes, WatchedCylinder, WatchedMachine, WatchedOverview};
use crate::appliance::telemetry::lamp::Lamp;
use crate::config::{MachineNames, visible};
use std::collections::VecDeque;
use std::time::Duration;

/// Time without news after which nothing is known, as on the page.
pub const SILENCE: Duration = Duration::from_secs(3);

/// Time that the charts go back, s.
pub const MINUTES: f64 = 300.0;

/// Most bins that are kept of a cylinder: half a second each.
const MOST_BINS: usize = 640;

/// Most cylinders that are followed; no machine has as many.
const MOST_CYLINDERS: usize = 64;

/// Everything that a source has told. Times are those since the start of this program.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    pub machine: WatchedMachine,
    /// The newest overview, and when it came.
    newest: Option<(WatchedOverview, Duration)>,
    /// Why nothing is known, and since when.
    lost: Option<(String, Duration)>,
    trends: Vec<VecDeque<Sizes>>,
}

impl Picture {
    /// Takes what was told at `at`.
    pub fn take(&mut self, news: News, at: Duration) {
        match news {
            News::Machine(machine) => {
                self.trends.resize_with(machine.limits_m.len().min(MOST_CYLINDERS), VecDeque::new);
                self.machine = machine;
            }
            News::Overview(overview) => (self.newest, self.lost) = (Some((overview, at)), None),
            News::History(number, bins) => {
                let trend = number.checked_sub(1).and_then(|index| self.trends.get_mut(index));
                trend.into_iter().for_each(VecDeque::clear);
                bins.into_iter().for_each(|bin| self.follow(bin));
            }
            News::Trends(bins) => bins.into_iter().for_each(|bin| self.follow(bin)),
            News::Lost(reason) => {
                let since = self.lost.as_ref().map_or(at, |(_, since)| *since);
                self.lost = Some((visible(&reason).into_owned(), since));
            }
        }
    }

    fn follow(&mut self, bin: Sizes) {
        let Some(trend) = bin.cylinder.checked_sub(1).and_then(|it| self.trends.get_mut(it)) else {
            return;
        };
        if let Some(newest) = trend.back() {
            if bin.time < newest.time {
                // The clock was set back.
                trend.clear();
            } else if bin.time == newest.time {
                return;
            }
        }
        trend.push_back(bin);
        while trend.len() > MOST_BINS {
            trend.pop_front();
        }
    }

    /// The newest overview, however old it is.
    pub fn overview(&self) -> Option<&WatchedOverview> {
        self.newest.as_ref().map(|(overview, _)| overview)
    }

    /// Time since the newest overview came.
    pub fn silence(&self, now: Duration) -> Option<Duration> {
        self.newest.as_ref().map(|(_, at)| now.saturating_sub(*at))
    }

    /// Why nothing is known now, and for how long; `None` where what was told holds.
    pub fn blindness(&self, now: Duration) -> Option<(&str, Duration)> {
        if let Some((reason, since)) = &self.lost {
            return Some((reason, now.saturating_sub(*since)));
        }
        match self.silence(now) {
            None => Some(("nothing was told yet", now)),
            Some(time) if time > SILENCE => Some(("nothing was told any more", time)),
            Some(_) => None,
        }
    }

    /// Age of the newest frame that the overview is of; `None` if there was none, or nothing is known.
    pub fn age(&self, now: Duration) -> Option<Duration> {
        let frame = self.overview()?.seconds_since_frame?;
        Some(Duration::try_from_secs_f64(frame).ok()? + self.silence(now)?)
    }

    /// The cylinders as they are now: all unknown where nothing is known of now.
    pub fn cylinders(&self, now: Duration) -> Vec<WatchedCylinder> {
        let overview = self.overview().filter(|_| self.blindness(now).is_none());
        let known = overview.map_or(&[][..], |overview| &overview.cylinders);
        let count = self.machine.limits_m.len().max(known.len()).min(MOST_CYLINDERS);
        let of = |number: usize| {
            let cylinder = known.iter().find(|it| it.number == number).cloned();
            cylinder.unwrap_or_else(|| WatchedCylinder { number, ..WatchedCylinder::default() })
        };
        (1..=count).map(of).collect()
    }

    /// How cylinders and transducers are called.
    pub const fn names(&self) -> &MachineNames {
        &self.machine.names
    }

    /// Limits of R1, R2 and R3 of a cylinder, m.
    pub fn limits(&self, number: usize) -> [Option<f64>; 3] {
        let limits = number.checked_sub(1).and_then(|index| self.machine.limits_m.get(index));
        std::array::from_fn(|which| *limits.and_then(|it| it.get(which))?)
    }

    /// The last minutes of a cylinder.
    pub fn trend(&self, number: usize) -> Option<&VecDeque<Sizes>> {
        self.trends.get(number.checked_sub(1)?)
    }
}

/// How bad a cylinder is: its worse lamp, the worst first, and the largest share of a limit.
pub fn badness(cylinder: &WatchedCylinder, limits: [Option<f64>; 3]) -> (usize, f64) {
    let place = |lamp| WORST_FIRST.iter().position(|it| *it == lamp).unwrap_or_default();
    let [c1, c2] = cylinder.transducers.each_ref().map(|it| place(it.lamp));
    let shares = cylinder.residuals_mm.iter().zip(limits).filter_map(|(size, limit)| {
        let (size, limit) = ((*size)?, limit.filter(|limit| *limit > 0.0)?);
        Some(size / (1e3 * limit))
    });
    (c1.min(c2), shares.fold(0.0, f64::max))
}

const WORST_FIRST: [Lamp; 7] = [
    Lamp::Failure,
    Lamp::OutOfSpecification,
    Lamp::CheckFunction,
    Lamp::MaintenanceRequired,
    Lamp::Unknown,
    Lamp::Good,
    Lamp::NotFitted,
];

#[cfg(test)]
mod tests {
    use super::super::view::samples;
    use super::*;

    const fn at(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    #[test]
    fn what_is_not_heard_of_is_unknown_and_its_age_grows() {
        let mut picture = samples::picture(at(10));
        let is_unknown = |picture: &Picture, now| {
            let lamps = picture.cylinders(now);
            let mut lamps = lamps.iter().flat_map(|it| it.transducers.each_ref().map(|it| it.lamp));
            lamps.all(|lamp| lamp == Lamp::Unknown)
        };
        assert!(!is_unknown(&picture, at(10)));
        assert!(!is_unknown(&picture, at(13)));
        assert!(is_unknown(&picture, at(14)), "nothing came for more than three seconds");
        assert!(picture.age(at(14)) >= Some(at(4)));

        picture.take(News::Lost("refused".to_owned()), at(11));
        assert!(is_unknown(&picture, at(11)), "at once, when it is known to be lost");
        picture.take(News::Lost("still refused".to_owned()), at(15));
        assert_eq!(picture.blindness(at(16)), Some(("still refused", at(5))));
        picture.take(News::Overview(samples::overview()), at(17));
        assert!(!is_unknown(&picture, at(17)));
        assert!(Picture::default().cylinders(at(0)).is_empty());
    }

    #[test]
    fn bins_are_bounded_in_order_and_begin_anew_when_the_clock_was_set_back() {
        let mut picture = samples::picture(at(0));
        let bin = |time| Sizes { cylinder: 2, time, residuals: [None; 3] };
        let begin = 1e6;
        let far = (0..4 * MOST_BINS).map(|k| bin(begin + k as f64 / 2.0)).collect();
        picture.take(News::Trends(far), at(1));
        let newest = begin + (4 * MOST_BINS - 1) as f64 / 2.0;
        picture.take(News::Trends(vec![bin(newest)]), at(1));
        let trend = picture.trend(2).expect("it is followed");
        assert_eq!((trend.len(), trend.back().map(|it| it.time)), (MOST_BINS, Some(newest)));
        picture.take(News::Trends(vec![bin(50.0), Sizes { cylinder: 99, ..bin(50.0) }]), at(1));
        assert_eq!(picture.trend(2).map(VecDeque::len), Some(1));
        picture.take(News::History(2, vec![bin(60.0), bin(60.5), bin(61.0)]), at(1));
        assert_eq!(picture.trend(2).map(VecDeque::len), Some(3), "that of the gateway replaces it");
    }
}
