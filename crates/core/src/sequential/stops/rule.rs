//! The rule that names the drifting transducer: by the trend beyond chance against the other
//! transducer, and the machine's common part.

use super::StopParameters;
use super::days::Day;
use super::fit::{Fit, fit, likelihood};
use super::thermometer::Thermometer;
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
    /// Moves of C1 and C2, without what is common to the machine, m.
    pub moved: [f64; 2],
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
    /// Differences C1 − C2, m.
    apart: Vec<f64>,
    /// Means of C1 and C2, m.
    mean: Vec<f64>,
    /// Log-likelihood of the mean with each of [`SEASONS`], nats.
    seasons: [f64; SEASONS.len()],
}

impl Series {
    fn new(days: &[Day], thermometer: Option<&Thermometer>, alone: usize) -> Self {
        let less = |day: &Day| {
            let common = thermometer.map_or(Some(0.0), |it| it.on(day.number))?;
            Some(Day { readings: day.readings.map(|reading| reading - common), ..*day })
        };
        let days: Vec<Day> = days.iter().filter_map(less).collect();
        let apart = days.iter().map(|day| day.readings[0] - day.readings[1]).collect();
        let mean: Vec<f64> =
            days.iter().map(|day| 0.5 * (day.readings[0] + day.readings[1])).collect();
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
        for ago in P.ramps {
            let begin = last.at - ago;
            let before = self.days.iter().filter(|day| day.at <= begin).count();
            if before >= P.side && n - before >= P.side {
                courses.push(Course::Ramp(begin));
            }
        }
        for back in P.steps {
            if n > back
                && self.days[..n - back].iter().map(|day| day.dwells as usize).sum::<usize>()
                    >= P.side
            {
                courses.push(Course::Step(self.days[n - back].at));
            }
        }
        courses
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
    fn fits(&self, course: Course, end: f64, prior: Prior) -> Option<[Fit; 2]> {
        let free = f64::INFINITY;
        let rows = self.rows(course, end);
        let apart = fit(&without_wear(&rows), &self.apart, APART, P.apart)?;
        let Prior { season, alone } = prior;
        let wear = P.wear[alone];
        let mean = fit(&rows, &self.mean, [free, free, season, season, wear], P.together[alone])?;
        Some([apart, mean])
    }

    /// The likeliest of `courses`. The one that lies furthest beyond chance may be another, which
    /// fits worse: a ramp that began half a year ago, say, and a season that no difference has.
    fn likeliest(&self, courses: &[(Course, [Fit; 2])], end: f64) -> Option<(Course, [Fit; 2])> {
        let scatters = courses.iter().map(|(_, [apart, _])| apart.scatter);
        let scatter = scatters.fold(f64::INFINITY, f64::min);
        let likelihoods = courses.iter().map(|it| (self.likelihood(it.0, end, scatter), it));
        let likeliest = likelihoods.max_by(|(one, _), (two, _)| one.total_cmp(two));
        likeliest.map(|(_, it)| *it)
    }

    /// Log-likelihood of the difference by `course` up to `end`, nats, where it scatters by `variance`, m²;
    /// except for what is the same for all courses.
    fn likelihood(&self, course: Course, end: f64, variance: f64) -> f64 {
        let rows = without_wear(&self.rows(course, end));
        likelihood(&rows, &self.apart, APART, variance).unwrap_or(f64::NEG_INFINITY)
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
    let beyond = P.beyond * (1.0 + P.few / nu);
    let mut beyond_chance: Vec<(Course, [Fit; 2])> = Vec::new();
    let mut judged = None;
    for course in own.courses() {
        let Some([mut apart, mut mean]) = own.fits(course, end, prior) else { continue };
        if let Course::Step(_) = course {
            mean.variance += P.common_step * P.common_step;
        }
        judged.get_or_insert((course, [apart, mean]));
        let size = apart.moved.abs();
        if size < P.least.max(P.counts * count)
            || size - count < beyond * libm::sqrt(apart.variance)
        {
            continue;
        }
        if let Some([a, m]) = others(series, which, course, end, prior) {
            apart.variance = apart.variance.max(a);
            mean.variance = mean.variance.max(m);
        }
        if size - count > beyond * libm::sqrt(apart.variance) {
            beyond_chance.push((course, [apart, mean]));
        }
    }
    let moved =
        |[apart, mean]: [Fit; 2]| [mean.moved + 0.5 * apart.moved, mean.moved - 0.5 * apart.moved];
    let Some((course, fits)) = own.likeliest(&beyond_chance, end) else {
        let (course, fits) = judged?;
        return Some(Judgement { blame: Blame::Neither, moved: moved(fits), course });
    };
    Some(Judgement { blame: blame(fits, count), moved: moved(fits), course })
}

/// Prior knowledge of the mean.
#[derive(Clone, Copy, Debug)]
struct Prior {
    season: f64,
    alone: usize,
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

fn blame([apart, mean]: [Fit; 2], count: f64) -> Blame {
    let [one, two] =
        [mean.moved + 0.5 * apart.moved, mean.moved - 0.5 * apart.moved].map(|b| b * b);
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
/// itself drift.
fn others(
    series: &[Series],
    which: usize,
    course: Course,
    end: f64,
    prior: Prior,
) -> Option<[f64; 2]> {
    let others = series.iter().enumerate().filter(|(i, it)| *i != which && it.days.len() >= P.side);
    let fits: Vec<[Fit; 2]> = others.filter_map(|(_, it)| it.fits(course, end, prior)).collect();
    (fits.len() + 1 >= P.cylinders).then(|| {
        [0, 1].map(|part| {
            let mut squares: Vec<f64> =
                fits.iter().map(|fits| fits[part].moved * fits[part].moved).collect();
            squares.sort_unstable_by(f64::total_cmp);
            squares.pop();
            P.trimmed * squares.iter().sum::<f64>() / squares.len() as f64
        })
    })
}
