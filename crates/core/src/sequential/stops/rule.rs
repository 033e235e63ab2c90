//! The rule that names the drifting transducer: by the trend beyond chance against the other
//! transducer, and the machine's common part. An only transducer is judged by its own trend less that
//! part, beyond what stops wear.

use super::days::Day;
use super::fit::{Fit, fit, likelihood};
use super::parameters::StopParameters;
use super::thermometer::Thermometer;
use crate::sequential::dwell::StopReadings;
use alloc::vec::Vec;
use core::f64::consts::TAU;

const P: &StopParameters = &StopParameters::DEFAULT;

/// Seasons that the mean may have.
const SEASONS: [f64; P.seasons.len()] = P.seasons;

/// Prior standard deviations of the difference's coefficients, m.
const APART: [f64; 4] = [f64::INFINITY, f64::INFINITY, P.season_apart, P.season_apart];

/// Course of a move of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// A ramp since that time, years since 1970.
    Ramp(f64),
    /// A step between the reading at that time and the previous one.
    Step(f64),
}

/// Transducer to blame for a drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// Neither: the readings have not come apart.
    Neither,
    /// C1; where it is the only transducer, C1 or the stop, which has then moved by more than stops wear.
    C1,
    C2,
    Both,
    /// Undecided: the readings have come apart, but it is not known which one has moved.
    Undecided,
}

/// Judgement of one cylinder from its dwells so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    pub blame: Blame,
    /// Moves of the transducers, without what is common to the machine, m.
    pub moved: StopReadings,
    pub course: Course,
}

impl Judgement {
    /// Whether C1 (`which` 0) or C2 (1) is named.
    pub const fn names(&self, which: usize) -> bool {
        match self.blame {
            Blame::C1 => which == 0,
            Blame::C2 => which == 1,
            Blame::Both => true,
            Blame::Neither | Blame::Undecided => false,
        }
    }
}

/// Readings of one cylinder, without what is common.
struct Series {
    days: Vec<Day>,
    /// Differences C1 − C2, m; `None` where there is no C2.
    apart: Option<Vec<f64>>,
    /// Means of C1 and C2, or what C1 alone reads, m.
    mean: Vec<f64>,
    /// Log-likelihood of the mean with each of [`SEASONS`], nats.
    seasons: [f64; SEASONS.len()],
}

impl Series {
    fn new(days: &[Day], thermometer: Option<&Thermometer>, alone: usize) -> Self {
        let less = |day: &Day| {
            let common = thermometer.map_or(Some(0.0), |it| it.on(day.number))?;
            Some(Day { readings: day.readings.less(common), ..*day })
        };
        let days: Vec<Day> = days.iter().filter_map(less).collect();
        let apart = days.iter().map(|day| day.readings.apart()).collect();
        let mean: Vec<f64> = days.iter().map(|day| day.readings.mean()).collect();
        let seasons =
            if thermometer.is_some() { seasons(&days, &mean, alone) } else { [0.0; SEASONS.len()] };
        Self { days, apart, mean, seasons }
    }

    fn courses(&self) -> Vec<Course> {
        let (Some(first), Some(last)) = (self.days.first(), self.days.last()) else {
            return Vec::new();
        };
        let n = self.days.len();
        let mut courses = Vec::new();
        if n >= P.side {
            courses.push(Course::Ramp(first.at));
        }
        let is_single = self.apart.is_none();
        let more = P.more_ramps.into_iter().filter(|_| is_single);
        for ago in P.ramps.into_iter().chain(more) {
            let begin = last.at - ago;
            let before = self.days.iter().filter(|day| day.at <= begin).count();
            if before >= P.side && n - before >= P.side {
                courses.push(Course::Ramp(begin));
            }
        }
        let steepest = if is_single { self.steepest() } else { None };
        for back in P.steps.into_iter().chain(steepest) {
            if n > back
                && self.days[..n - back].iter().map(|day| day.dwells as usize).sum::<usize>()
                    >= P.side
            {
                courses.push(Course::Step(self.days[n - back].at));
            }
        }
        courses
    }

    /// How many readings ago those after that place differ most from those before; `None` with too few.
    fn steepest(&self) -> Option<usize> {
        let n = self.mean.len();
        let middle = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let differ = |place: usize| {
            let (before, after) = self.mean.split_at(place);
            let [before, after] =
                [&before[place.saturating_sub(P.beside)..], &after[..P.beside.min(n - place)]];
            (middle(after) - middle(before)).abs()
        };
        let places = P.side..(n + 1).saturating_sub(P.side);
        let steepest = places.max_by(|one, two| differ(*one).total_cmp(&differ(*two)));
        steepest.map(|place| n - place)
    }

    /// Rows of the fits by `course` up to `end`: a constant, the share of the move, a season and wear.
    fn rows(&self, course: Course, end: f64) -> Vec<[f64; 5]> {
        let share = |day: &Day| match course {
            Course::Ramp(begin) => ((day.at - begin) / (end - begin)).max(0.0),
            Course::Step(at) => f64::from(u8::from(day.at >= at)),
        };
        let row = |day: &Day| {
            let (sin, cos) = libm::sincos(TAU * (day.at - end));
            [1.0, share(day), cos, sin, day.at - end]
        };
        self.days.iter().map(row).collect()
    }

    /// Moves of the difference and of the mean by `course`, up to `end`.
    fn fits(&self, course: Course, end: f64, prior: Prior) -> Option<Fits> {
        let rows = self.rows(course, end);
        let apart = match &self.apart {
            Some(apart) => Some(fit(&without_wear(&rows), apart, APART, P.apart)?),
            None => None,
        };
        let mean = fit(&rows, &self.mean, prior.of_mean(), P.together[prior.alone])?;
        Some(Fits { apart, mean })
    }

    /// The likeliest of `courses`. The one that lies furthest beyond chance may be another, which
    /// fits worse: a ramp that began half a year ago, say, and a season that no difference has.
    fn likeliest(
        &self,
        courses: &[(Course, Fits)],
        end: f64,
        prior: Prior,
    ) -> Option<(Course, Fits)> {
        let scatters = courses.iter().map(|(_, fits)| fits.telling().scatter);
        let scatter = scatters.fold(f64::INFINITY, f64::min);
        let likelihoods =
            courses.iter().map(|it| (self.likelihood((it.0, end), prior, scatter), it));
        let likeliest = likelihoods.max_by(|(one, _), (two, _)| one.total_cmp(two));
        likeliest.map(|(_, it)| *it)
    }

    /// Log-likelihood of the difference, or of what C1 alone reads, by a course up to its end, nats, where it
    /// scatters by `variance`, m²; except for what is the same for all courses.
    fn likelihood(&self, (course, end): (Course, f64), prior: Prior, variance: f64) -> f64 {
        let rows = self.rows(course, end);
        let likelihood = match &self.apart {
            Some(apart) => likelihood(&without_wear(&rows), apart, APART, variance),
            None => likelihood(&rows, &self.mean, prior.of_mean(), variance),
        };
        likelihood.unwrap_or(f64::NEG_INFINITY)
    }
}

/// Fits of a cylinder's readings by a course.
#[derive(Clone, Copy, Debug)]
struct Fits {
    /// That of C1 − C2; `None` where there is no C2.
    apart: Option<Fit>,
    /// That of their mean, or of C1 alone.
    mean: Fit,
}

impl Fits {
    /// That of what no temperature and no stop moves: the difference. What C1 alone reads is the nearest to it.
    fn telling(&self) -> Fit {
        self.apart.unwrap_or(self.mean)
    }

    fn moved(&self) -> StopReadings {
        match self.apart {
            Some(apart) => StopReadings::both(
                [1.0, -1.0].map(|sign| self.mean.moved + sign * 0.5 * apart.moved),
            ),
            None => StopReadings::single(self.mean.moved),
        }
    }

    /// Takes by how much the other cylinders have moved.
    fn widen(&mut self, others: [Option<f64>; 2]) {
        let fits = [self.apart.as_mut(), Some(&mut self.mean)];
        for (fit, other) in fits.into_iter().zip(others) {
            if let Some((fit, other)) = fit.zip(other) {
                fit.variance = fit.variance.max(other);
            }
        }
    }
}

/// Rows of the difference, which stops that wear do not move.
fn without_wear(rows: &[[f64; 5]]) -> Vec<[f64; 4]> {
    rows.iter().map(|[one, share, cos, sin, _]| [*one, *share, *cos, *sin]).collect()
}

/// Judges every cylinder of a machine by the days on which it was read; `counts` are the
/// resolutions of each one's readings, m. `None` where too little was read.
pub(super) fn judge(cylinders: &[Vec<Day>], counts: &[f64]) -> Vec<Option<Judgement>> {
    let thermometer =
        if cylinders.len() >= P.cylinders { Thermometer::of(cylinders) } else { None };
    let alone = usize::from(thermometer.is_none());
    let series: Vec<Series> =
        cylinders.iter().map(|days| Series::new(days, thermometer.as_ref(), alone)).collect();
    (0..series.len()).map(|i| cylinder(&series, i, counts[i], alone)).collect()
}

fn cylinder(series: &[Series], which: usize, count: f64, alone: usize) -> Option<Judgement> {
    let own = &series[which];
    let end = own.days.last()?.at;
    let prior = Prior { season: season(series, which), alone };
    let nu = P.expected + own.days.len() as f64 - 2.0;
    let [beyond, least] = match own.apart {
        Some(_) => [P.beyond, P.least],
        None => [P.beyond_alone, P.own],
    };
    let beyond = beyond * (1.0 + P.few / nu);
    let mut beyond_chance: Vec<(Course, Fits)> = Vec::new();
    let mut judged = None;
    for course in own.courses() {
        let Some(mut fits) = own.fits(course, end, prior) else { continue };
        // That a stop may have moved makes nobody sound: of an only transducer both are told.
        if matches!(course, Course::Step(_)) && own.apart.is_some() {
            fits.mean.variance += P.common_step * P.common_step;
        }
        judged.get_or_insert((course, fits));
        let size = fits.telling().moved.abs();
        if size < least.max(P.counts * count)
            || size - count < beyond * libm::sqrt(fits.telling().variance)
        {
            continue;
        }
        fits.widen(others(series, which, course, end, prior));
        if size - count > beyond * libm::sqrt(fits.telling().variance) {
            beyond_chance.push((course, fits));
        }
    }
    let Some((course, fits)) = own.likeliest(&beyond_chance, end, prior) else {
        let (course, fits) = judged?;
        return Some(Judgement { blame: Blame::Neither, moved: fits.moved(), course });
    };
    Some(Judgement { blame: blame(&fits, count), moved: fits.moved(), course })
}

/// Prior knowledge of the mean.
#[derive(Clone, Copy, Debug)]
struct Prior {
    season: f64,
    alone: usize,
}

impl Prior {
    /// Standard deviations of the coefficients of the mean, m.
    const fn of_mean(self) -> [f64; 5] {
        let free = f64::INFINITY;
        [free, free, self.season, self.season, P.wear[self.alone]]
    }
}

/// Log-likelihood of the mean with each of [`SEASONS`].
fn seasons(days: &[Day], mean: &[f64], alone: usize) -> [f64; SEASONS.len()] {
    let Some(end) = days.last().map(|day| day.at) else { return Default::default() };
    let row = |day: &Day| {
        let (sin, cos) = libm::sincos(TAU * (day.at - end));
        [1.0, day.at - end, cos, sin]
    };
    let rows: Vec<[f64; 4]> = days.iter().map(row).collect();
    let free = f64::INFINITY;
    let widest = SEASONS[SEASONS.len() - 1];
    let fitted = fit(&rows, mean, [free, P.wear[alone], widest, widest], P.together[alone]);
    let Some(Fit { scatter, .. }) = fitted else { return Default::default() };
    SEASONS.map(|season| {
        likelihood(&rows, mean, [free, P.wear[alone], season, season], scatter).unwrap_or(0.0)
    })
}

/// The largest season that the means of the other cylinders may have. The one with the largest is
/// left out, since it may itself drift.
fn season(series: &[Series], which: usize) -> f64 {
    let others =
        || series.iter().enumerate().filter(|(i, it)| *i != which && it.days.len() >= P.side);
    let swing = |it: &Series| it.seasons[SEASONS.len() - 1] - it.seasons[0];
    let most = others().max_by(|(_, one), (_, two)| swing(one).total_cmp(&swing(two)));
    let most = most.map(|(i, _)| i);
    let mut sums = [0.0; SEASONS.len()];
    for (_, it) in others().filter(|(i, _)| Some(*i) != most) {
        (0..sums.len()).for_each(|i| sums[i] += it.seasons[i]);
    }
    let best = sums.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let place = sums.iter().rposition(|sum| *sum >= best - P.maybe).unwrap_or(0);
    SEASONS[place]
}

fn blame(fits: &Fits, count: f64) -> Blame {
    let StopReadings { c1, c2: Some(c2) } = fits.moved() else { return Blame::C1 };
    let (mean, apart) = (fits.mean, fits.telling());
    let [one, two] = [c1 * c1, c2 * c2];
    // What is rounded to counts is off by up to half a count, evenly.
    let lattice = count * count / 12.0;
    let variance = mean.variance + lattice + 0.25 * (apart.variance + 4.0 * lattice);
    if one.min(two) > (P.both * variance).max(P.part * P.part * one.max(two)).max(P.own * P.own) {
        Blame::Both
    } else if (one - two).abs() > P.named * variance {
        if one > two { Blame::C1 } else { Blame::C2 }
    } else {
        Blame::Undecided
    }
}

/// Moves of the difference and of the mean of the other cylinders by the same course, as variances,
/// m²: healthy ones move by that much. The one with the largest move is left out, since it may
/// itself drift. `None` where too few have them.
fn others(
    series: &[Series],
    which: usize,
    course: Course,
    end: f64,
    prior: Prior,
) -> [Option<f64>; 2] {
    let others = series.iter().enumerate().filter(|(i, it)| *i != which && it.days.len() >= P.side);
    let fits: Vec<Fits> = others.filter_map(|(_, it)| it.fits(course, end, prior)).collect();
    let variance = |moves: &mut dyn Iterator<Item = f64>| {
        let mut squares: Vec<f64> = moves.map(|moved| moved * moved).collect();
        squares.sort_unstable_by(f64::total_cmp);
        (squares.len() + 1 >= P.cylinders).then(|| {
            squares.pop();
            P.trimmed * squares.iter().sum::<f64>() / squares.len() as f64
        })
    };
    [
        variance(&mut fits.iter().filter_map(|it| Some(it.apart?.moved))),
        variance(&mut fits.iter().map(|it| it.mean.moved)),
    ]
}
