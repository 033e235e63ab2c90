//! The cycles around warnings.

use std::collections::VecDeque;
use tertius_core::monitor::Record;

/// Number of cycles that are shown before a warning.
pub const BEFORE: usize = 50;
/// Number of cycles that are shown after a warning.
pub const AFTER: usize = 100;

/// Least number of cycles after a warning in a zoom of the greatest length.
const LEAST_AFTER: usize = 25;

/// Length of the longest zoom, cycles; warnings closer together share one.
pub const LONGEST: usize = 500;

/// Most zooms; further warnings are counted.
pub const ZOOMS: usize = 40;

/// One cylinder in one cycle, for a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Time on the figures' axis, s.
    pub t: f64,
    /// C1 and Ĉ2, m.
    pub readings: [Option<f64>; 2],
    /// Estimates of both observers, m; that of C2 is corrected as C2 is.
    pub estimates: [Option<f64>; 2],
    /// R1 and R2 where they are judged, and R3, m.
    pub residuals: [Option<f64>; 3],
    /// Whether neither FDE1 nor FDE2 judged.
    pub gated: bool,
}

/// A stretch of one cylinder around one or several warnings.
#[derive(Clone, Debug, PartialEq)]
pub struct Zoom {
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub moments: Vec<Moment>,
    /// Warnings: their index in the order of raise, from 0, and their time.
    pub warnings: Vec<(usize, f64)>,
}

/// Newest cycles of one cylinder, and the zoom that is still open.
#[derive(Clone, Debug, Default)]
pub struct Watch {
    newest: VecDeque<Moment>,
    open: Option<(Zoom, usize)>,
}

/// All zooms.
#[derive(Clone, Debug, Default)]
pub struct Zooms {
    watches: Vec<Watch>,
    done: Vec<Zoom>,
    begun: usize,
    left_out: u64,
}

impl Moment {
    /// A moment of which nothing is known.
    pub const fn nothing(t: f64) -> Self {
        let (readings, estimates, residuals) = ([None; 2], [None; 2], [None; 3]);
        Self { t, readings, estimates, residuals, gated: true }
    }

    /// A moment with the `residuals` that are judged; `correct` converts C2 to Ĉ2.
    pub fn new(
        t: f64,
        record: &Record,
        residuals: [Option<f64>; 3],
        correct: impl Fn(f64) -> f64,
    ) -> Self {
        let [first, second] = record.estimates;
        Self {
            t,
            readings: [record.c1, record.c2_corrected],
            estimates: [first, second.map(correct)],
            residuals,
            gated: record.gated,
        }
    }
}

impl Zooms {
    /// Zooms for `count` cylinders.
    pub fn new(count: usize) -> Self {
        Self { watches: vec![Watch::default(); count], ..Self::default() }
    }

    /// Takes the next cycle of the cylinder `number` (from 1).
    pub fn moment(&mut self, number: u8, moment: Moment) {
        let Some(watch) = self.watches.get_mut(usize::from(number).wrapping_sub(1)) else { return };
        if watch.newest.len() > BEFORE {
            watch.newest.pop_front();
        }
        watch.newest.push_back(moment);
        let Some((zoom, left)) = &mut watch.open else { return };
        zoom.moments.push(moment);
        *left -= 1;
        if *left == 0 {
            self.done.extend(watch.open.take().map(|(zoom, _)| zoom));
        }
    }

    /// Breaks all curves at `t`, where the bus was lost or the time jumped.
    pub fn interrupt(&mut self, t: f64) {
        for number in 1..=self.watches.len() {
            self.moment(number as u8, Moment::nothing(t));
        }
    }

    /// Notes that a warning of the cylinder `number` is raised at `t`, the `order`-th of all (from
    /// 0).
    pub fn warning(&mut self, number: u8, order: usize, t: f64) {
        let Some(watch) = self.watches.get_mut(usize::from(number).wrapping_sub(1)) else { return };
        if let Some((zoom, left)) = &mut watch.open {
            let room = LONGEST.saturating_sub(zoom.moments.len());
            if room >= LEAST_AFTER {
                zoom.warnings.push((order, t));
                // As far as there is room; what is left already was within it.
                *left = (*left).max(AFTER.min(room));
                return;
            }
        }
        if self.begun == ZOOMS {
            self.left_out += 1;
            return;
        }
        self.begun += 1;
        self.done.extend(watch.open.take().map(|(zoom, _)| zoom));
        let moments = watch.newest.iter().copied().collect();
        let zoom = Zoom { cylinder: number, moments, warnings: vec![(order, t)] };
        watch.open = Some((zoom, AFTER));
    }

    /// Number of warnings that no zoom shows.
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// All zooms, in the order of their first warnings.
    pub fn finish(self) -> Vec<Zoom> {
        let open = self.watches.into_iter().filter_map(|watch| Some(watch.open?.0));
        let mut all: Vec<Zoom> = self.done.into_iter().chain(open).collect();
        all.sort_by_key(|zoom| zoom.warnings.first().map(|(order, _)| *order));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(k: usize) -> Moment {
        Moment {
            t: k as f64,
            readings: [None; 2],
            estimates: [None; 2],
            residuals: [Some(1.0); 3],
            gated: false,
        }
    }

    fn run(cycles: usize, warnings: &[usize]) -> Zooms {
        let mut zooms = Zooms::new(2);
        for k in 0..cycles {
            zooms.moment(1, moment(k));
            zooms.moment(2, moment(k));
            for (order, _) in warnings.iter().enumerate().filter(|(_, at)| **at == k) {
                zooms.warning(1, order, k as f64);
            }
        }
        zooms
    }

    #[test]
    fn a_zoom_has_the_time_before_and_after_its_warning() {
        let zooms = run(1000, &[200]).finish();
        let [zoom] = &zooms[..] else { panic!("{}", zooms.len()) };
        assert_eq!((zoom.cylinder, zoom.moments.len()), (1, BEFORE + 1 + AFTER));
        assert_eq!((zoom.moments[0].t, zoom.moments[BEFORE].t), (150.0, 200.0));
        // At the edges of a recording there is less.
        assert_eq!(run(30, &[10]).finish()[0].moments.len(), 30);
    }

    #[test]
    fn near_warnings_share_a_zoom_and_far_ones_do_not() {
        let zooms = run(2000, &[200, 200, 290, 900]).finish();
        let orders: Vec<Vec<usize>> = zooms
            .iter()
            .map(|zoom| zoom.warnings.iter().map(|(order, _)| *order).collect())
            .collect();
        assert_eq!(orders, [vec![0, 1, 2], vec![3]]);
        assert_eq!(zooms[0].moments.last().map(|moment| moment.t), Some(390.0));
    }

    /// However many warnings come however close together, zooms are few and short, and every
    /// warning is counted.
    #[test]
    fn zooms_are_bounded_and_the_rest_is_counted() {
        let warnings: Vec<usize> = (0..30_000).collect();
        let zooms = run(30_000, &warnings);
        let left_out = zooms.left_out();
        let zooms = zooms.finish();
        assert_eq!(zooms.len(), ZOOMS);
        assert!(zooms.iter().all(|zoom| zoom.moments.len() <= LONGEST));
        let shown: usize = zooms.iter().map(|zoom| zoom.warnings.len()).sum();
        assert_eq!(shown as u64 + left_out, 30_000);
    }
}
