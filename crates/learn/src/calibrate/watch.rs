//! Evidence against a healthy machine in its own recording, and the levels of the sequential
//! detectors that follow.

use super::{Cuts, Division, Halves};
use crate::extremes::{Asked, Maxima, false_alarms, levels};
use crate::survey::{Lull, Row, Surveyor};
use tertius_core::sequential::{Design, ExcursionLimits, Input, Sequential};
use tertius_core::time::Timestamp;
use tertius_core::verdict::Jump;

/// Judged time of which only the largest evidence counts, s, so that a longer burst is one event.
const BLOCK: f64 = 10.0;

/// Least evidence of a block that is kept, nats.
const WORTH_TELLING: f64 = 15.0;

/// Most blocks that are kept.
const MOST: usize = 2000;

/// Reads the recording with the sequential detectors of all cylinders that have one.
#[derive(Clone, Debug)]
pub struct Watch {
    sample_time: f64,
    /// Largest of the least levels of all designs, nats.
    least_level: f64,
    /// Parts that are not judged. The baseline continues across them, so that a fault of which only
    /// the beginning is cut out remains one.
    cuts: Option<Cuts>,
    /// Detectors by cylinder.
    watched: Vec<Option<Watched>>,
}

#[derive(Clone, Debug)]
struct Watched {
    /// The detector before it has seen anything.
    fresh: Sequential,
    detector: Sequential,
    lull: Lull,
    /// References from the halves of a recording, where each half is judged by the other.
    halves: Option<(Division, Halves)>,
    /// The half that the detector uses now.
    half: Option<usize>,
    maxima: Maxima,
    worst: Option<Sight>,
    /// Largest evidence of each block that is worth reporting.
    sights: Vec<Sight>,
    /// Beginning of the newest of these blocks, s.
    begun: f64,
}

/// The largest evidence of a time, and its circumstances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    pub nats: f64,
    /// Time since the recording's first frame, s.
    pub t: f64,
    pub at: Timestamp,
    /// Reading of C1, m.
    pub length: f64,
    /// Width of its window, samples.
    pub width: usize,
    /// Whether the scatter grew; otherwise the mean moved.
    pub scatter: bool,
}

/// Level h of one cylinder, and objections to it.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnLevel {
    /// Required level; `None` with too little judged time.
    pub asked: Option<Asked>,
    /// Largest evidence.
    pub worst: Option<Sight>,
    /// Blocks with evidence worth reporting, in the order of time.
    pub sights: Vec<Sight>,
}

/// Level h of all cylinders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Level h, nats: at least the largest evidence seen, and what spikes reach
    /// (`sequential::wild`).
    pub nats: f64,
    /// Largest evidence seen, nats.
    pub worst: f64,
    /// Time that all detectors together have judged, h.
    pub hours: f64,
    /// Whether every cylinder agrees with the theory of healthy evidence.
    pub sound: bool,
}

/// A design, and the references by which the halves of a recording judge each other.
type Crossed<'a> = (&'a Design, Option<(Division, Halves)>);

impl Watch {
    /// A watch by these `designs`, of readings every `sample_time` seconds.
    pub fn new<'a>(
        designs: impl IntoIterator<Item = Option<&'a Design>>,
        sample_time: f64,
    ) -> Self {
        let all = designs.into_iter().map(|design| Some((design?, None))).collect();
        Self::of(all, None, sample_time)
    }

    /// A watch of a recording whose halves judge each other, without the parts cut out.
    pub fn crossed<'a>(
        designs: impl IntoIterator<Item = Option<(&'a Design, &'a Halves)>>,
        division: &Division,
        cuts: &Cuts,
        sample_time: f64,
    ) -> Self {
        let crossed = |(design, halves): (&'a Design, &Halves)| {
            (design, Some((division.clone(), halves.clone())))
        };
        let all = designs.into_iter().map(|both| both.map(crossed)).collect();
        Self::of(all, Some(cuts.clone()), sample_time)
    }

    fn of(all: Vec<Option<Crossed<'_>>>, cuts: Option<Cuts>, sample_time: f64) -> Self {
        let least = |(design, _): &Crossed<'_>| design.outliers.least_level();
        let least_level = all.iter().flatten().map(least).fold(0.0, f64::max);
        let watched = |(design, halves): Crossed<'_>| Watched::new(design, sample_time, halves);
        let watched = all.into_iter().map(|one| one.map(watched)).collect();
        Self { sample_time, least_level, cuts, watched }
    }

    /// The level that each cylinder needs for `per_year` false alarms a year of all together;
    /// `None` without a detector.
    pub fn levels(&self, per_year: f64) -> Vec<Option<OwnLevel>> {
        let by_tail = self.watched.iter().flatten().filter(|one| one.limits().is_none());
        let maxima: Vec<_> = by_tail.map(|one| &one.maxima).collect();
        let mut asked = levels(&maxima, per_year, self.sample_time, self.least_level).into_iter();
        let mut own = |watched: &Watched| {
            let worst = watched.worst;
            let asked = match watched.limits() {
                // They were computed for the rate, and are not learnt from the tail of what they judge.
                Some(limits) => {
                    let seconds = watched.maxima.cycles() as f64 * self.sample_time;
                    let worst = worst.map_or(0.0, |sight| sight.nats);
                    Some(Asked::given(limits.level, worst, seconds))
                }
                None => asked.next().flatten(),
            };
            OwnLevel { asked, worst, sights: watched.sights.clone() }
        };
        self.watched.iter().map(|watched| watched.as_ref().map(&mut own)).collect()
    }

    /// How the readings of this cylinder have moved apart in the newest row.
    pub fn jump(&self, cylinder: u8) -> Option<Jump> {
        self.watched[usize::from(cylinder) - 1].as_ref()?.detector.jump()
    }

    /// One level for all cylinders that is reached `per_year` times a year, all cylinders together;
    /// `None` where no cylinder has a detector, or one has judged for too short a time.
    pub fn level(&self, per_year: f64) -> Option<Level> {
        let levels = self.levels(per_year);
        let asked: Vec<Asked> =
            levels.iter().flatten().map(|own| own.asked).collect::<Option<_>>()?;
        let worst = levels.iter().flatten().filter_map(|own| own.worst);
        let worst = worst.map(|sight| sight.nats).fold(0.0, f64::max);
        let nats = asked.iter().map(Asked::level).reduce(f64::max)?;
        Some(Level {
            nats: nats.max(worst),
            worst,
            hours: asked.iter().map(|asked| asked.seconds).sum::<f64>() / 3600.0,
            sound: asked.iter().all(Asked::is_sound),
        })
    }
}

impl OwnLevel {
    /// The level, nats, where there were enough data.
    pub fn nats(&self) -> Option<f64> {
        self.asked.as_ref().map(Asked::level)
    }

    /// Remark on a tail that falls too slowly; `None` for any other.
    pub fn remark(&self) -> Option<String> {
        let asked = self.asked.filter(|asked| asked.is_sound())?;
        asked.slower.map(|slope| {
            format!(
                "large evidence is more frequent than in theory (its tail falls by {slope:.2} a \
                 nat, not by 1), as when readings are sometimes off for a fraction of a second: at \
                {:.1} nats expect about {}",
                asked.level(),
                false_alarms(asked.per_year().ceil())
            )
        })
    }

    /// The largest evidence, if it contradicts the theory.
    pub fn contradiction(&self) -> Option<Sight> {
        self.worst.filter(|_| self.asked.is_some_and(|asked| !asked.is_sound()))
    }

    /// Times with evidence beyond the level, s.
    pub fn beyond(&self) -> impl Iterator<Item = f64> + '_ {
        let level = self.nats().unwrap_or(f64::INFINITY);
        self.sights.iter().filter(move |sight| sight.nats > level).map(|sight| sight.t)
    }
}

impl Watched {
    fn new(design: &Design, sample_time: f64, halves: Option<(Division, Halves)>) -> Self {
        // With a finite level an alarm would hide what comes after it.
        let design = Design { level: f64::INFINITY, ..design.clone() };
        let fresh = Sequential::new(design);
        Self {
            detector: fresh.clone(),
            fresh,
            lull: Lull::default(),
            halves,
            half: None,
            maxima: Maxima::new((BLOCK / sample_time).round() as u32),
            worst: None,
            sights: Vec::new(),
            begun: f64::NEG_INFINITY,
        }
    }

    fn limits(&self) -> Option<&ExcursionLimits> {
        self.fresh.design().excursions.as_ref()
    }

    /// Selects the reference from the other half; `false` where the row is not to be judged.
    fn refer(&mut self, t: f64) -> bool {
        let Some((division, halves)) = &self.halves else { return true };
        let Some(half) = division.judged(t) else { return false };
        let Some(reference) = &halves[half] else { return false };
        if self.half.replace(half) != Some(half) {
            self.detector.refer(reference);
        }
        true
    }

    fn take(&mut self, row: &Row) {
        if !self.refer(row.t) {
            return self.detector.interrupt();
        }
        self.detector.step(&Input {
            lengths: [row.c1, row.c2],
            velocity: row.v2,
            command: row.u,
            monitored: row.monitored,
            at: row.timestamp,
        });
        if self.detector.verdict() == tertius_core::verdict::Verdict::Unknown {
            return;
        }
        let [mean, variance] = self.detector.peaks();
        let scatter = variance.nats > mean.nats;
        let peak = if scatter { variance } else { mean };
        self.maxima.add(peak.nats);
        let sight = Sight {
            nats: peak.nats,
            t: row.t,
            at: row.timestamp,
            length: row.c1.unwrap_or(f64::NAN),
            width: peak.width,
            scatter,
        };
        if self.worst.is_none_or(|worst| sight.nats > worst.nats) {
            self.worst = Some(sight);
        }
        self.keep(sight);
    }

    /// Begins anew after a pause: neither what the detector has learnt of the bus nor a block goes
    /// on from one file to the next.
    fn begin(&mut self) {
        self.detector.clone_from(&self.fresh);
        self.half = None;
        self.maxima.pause();
    }

    /// Keeps what is worth telling; a block begins with the first of it.
    fn keep(&mut self, sight: Sight) {
        if sight.nats < WORTH_TELLING {
            return;
        }
        if sight.t - self.begun < BLOCK {
            if let Some(last) = self.sights.last_mut().filter(|last| sight.nats > last.nats) {
                *last = sight;
            }
        } else if self.sights.len() < MOST {
            self.begun = sight.t;
            self.sights.push(sight);
        }
    }
}

impl Surveyor for Watch {
    fn row(&mut self, row: &Row) {
        let Some(watched) = &mut self.watched[usize::from(row.cylinder) - 1] else { return };
        if watched.lull.ends(row.t) {
            watched.begin();
        }
        if self.cuts.as_ref().is_some_and(|cuts| cuts.hold(row.cylinder, row.t)) {
            watched.detector.pause();
        } else {
            watched.take(row);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        if let Some(watched) = &mut self.watched[usize::from(cylinder) - 1] {
            watched.detector.interrupt();
        }
    }
}
