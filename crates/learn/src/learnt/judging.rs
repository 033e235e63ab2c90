//! Judges whether a new recording is healthy by the tables from earlier recordings.

use crate::calibrate::watch::{Sight, Watch};
use crate::calibrate::{Cuts, are_few, places};
use crate::survey::{PAUSE, Row, Surveyor, Window};
use tertius_config::settings::Settings;
use tertius_core::monitor::MonitorDesign;
use tertius_core::sequential::Reference;
use tertius_core::sequential::parameters::ResidualParameters;
use tertius_core::sequential::velocity::Velocity;
use tertius_core::text::Millimetres;

/// Time over which readings are averaged, s.
const BLOCK: f64 = 10.0;

/// Largest healthy difference of C1 − C2 from what earlier recordings have taught, m: beyond it a
/// transducer was replaced or adjusted, or has drifted, as on the stops.
const MOST_OFF: f64 = 5e-4;

/// Largest change of C1 − C2 across a fault that is over, m, apart from the temperature.
const STAYS: f64 = 2e-4;

/// Time before and after a place that is compared, s.
const BESIDE: f64 = 120.0;

/// Fewest readings of a mean that is used.
const LEAST_ROWS: u32 = 400;

/// Limit of one reading's contribution to a mean, m.
const CLIP: f64 = 5e-3;

/// Judgement of a new recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// Parts that are left out.
    pub cuts: Cuts,
    /// Reasons for the cuts, one line for each place.
    pub left_out: Vec<String>,
    /// Reasons why nothing is learnt from the recording, one line each; empty where it is healthy
    /// apart from the cuts.
    pub refused: Vec<String>,
}

/// Judges a recording with the sequential detectors, the bounds of R3 and the profiles of a
/// configuration.
#[derive(Clone, Debug)]
pub struct Judging {
    watch: Watch,
    /// Level h of each cylinder, nats.
    levels: Vec<f64>,
    cylinders: Vec<Compared>,
}

#[derive(Clone, Debug)]
struct Compared {
    /// a and b of (5-20).
    line: (f64, f64),
    /// Bound of R3, m.
    bound: f64,
    reference: Option<Reference>,
    velocity: Velocity,
    /// Times at which |R3| exceeded its bound, s, once in a block, and the largest |R3| then, m.
    beyond: Vec<(f64, f64)>,
    /// C1 − C2 less what is healthy there, by blocks from their start, s.
    blocks: Vec<Block>,
}

#[derive(Clone, Copy, Debug)]
struct Block {
    from: f64,
    sum: f64,
    rows: u32,
}

/// A time that does not look healthy, s.
struct Seen {
    t: f64,
    what: String,
    /// Ratio to what is healthy, to name the worst.
    times: f64,
}

impl Judging {
    /// A judge by the tables of `settings`, from which `design` was made.
    pub fn new(settings: &Settings, design: &MonitorDesign) -> Self {
        let sample_time = settings.machine.sample_time;
        let designs = || design.cylinders.iter().map(|cylinder| cylinder.sequential.as_ref());
        let compared =
            |(index, design): (usize, Option<&tertius_core::sequential::Design>)| Compared {
                line: settings.comparator_of(index as u8 + 1),
                bound: settings.comparator.bound,
                reference: design.map(|design| design.reference.clone()),
                velocity: Velocity::new(&ResidualParameters::DEFAULT, sample_time),
                beyond: Vec::new(),
                blocks: Vec::new(),
            };
        Self {
            watch: Watch::new(designs(), sample_time),
            levels: (1..=settings.machine.cylinders)
                .map(|n| settings.sequential_level_of(n))
                .collect(),
            cylinders: designs().enumerate().map(compared).collect(),
        }
    }

    /// The judgement of a recording with this `window`.
    pub fn judgement(&self, window: Window) -> Judgement {
        let mut judgement =
            Judgement { cuts: Cuts::none(self.cylinders.len()), ..Judgement::default() };
        // How often false alarms may come changes levels, and no sight.
        let sights = self.watch.levels(1.0);
        for (index, cylinder) in self.cylinders.iter().enumerate() {
            let sights = sights.get(index).and_then(Option::as_ref).map(|own| &own.sights[..]);
            let seen = cylinder.seen(sights.unwrap_or_default(), self.levels[index]);
            cylinder.judge(index, &seen, window, &mut judgement);
        }
        judgement
    }
}

impl Surveyor for Judging {
    fn row(&mut self, row: &Row) {
        self.watch.row(row);
        self.cylinders[usize::from(row.cylinder) - 1].take(row);
    }

    fn gap(&mut self, cylinder: u8) {
        self.watch.gap(cylinder);
        self.cylinders[usize::from(cylinder) - 1].velocity.reset();
    }
}

impl Compared {
    fn take(&mut self, row: &Row) {
        let velocity = self.velocity.step(row.c2, row.v2);
        let Some((c1, c2)) = row.c1.zip(row.c2) else { return };
        let r3 = (c1 - (self.line.0 * c2 + self.line.1)).abs();
        if r3 > self.bound {
            match self.beyond.last_mut() {
                Some((t, largest)) if row.t - *t < BLOCK => *largest = largest.max(r3),
                _ => self.beyond.push((row.t, r3)),
            }
        }
        let Some((reference, velocity)) = self.reference.as_ref().zip(velocity) else { return };
        let residual = reference.residual(c1, c2, velocity).filter(|_| row.monitored);
        let Some((residual, _)) = residual else { return };
        if self.blocks.last().is_none_or(|block| row.t - block.from >= BLOCK) {
            self.blocks.push(Block { from: row.t, sum: 0.0, rows: 0 });
        }
        if let Some(block) = self.blocks.last_mut() {
            block.sum += residual.clamp(-CLIP, CLIP);
            block.rows += 1;
        }
    }

    /// Everything that does not look healthy, in the order of time.
    fn seen(&self, sights: &[Sight], level: f64) -> Vec<Seen> {
        let evidence = sights.iter().filter(|sight| sight.nats > level).map(|sight| {
            let Sight { nats, t, length, width, scatter, .. } = *sight;
            let how = if scatter { "a scatter that grew" } else { "a mean that moved" };
            let what = format!(
                "{nats:.1} nats of evidence at {t:.1} s where {level:.1} are a warning, C1 at \
                 {length:.3} m, by {how} over {width} samples"
            );
            Seen { t, what, times: nats / level }
        });
        let crossings = self.beyond.iter().map(|(t, r3)| {
            let what = format!(
                "R3 of {:.2} at {t:.1} s where {:.2} are a warning",
                Millimetres(*r3),
                Millimetres(self.bound)
            );
            Seen { t: *t, what, times: r3 / self.bound }
        });
        let mut seen: Vec<Seen> = evidence.chain(crossings).collect();
        seen.sort_by(|one, other| one.t.total_cmp(&other.t));
        seen
    }

    /// Adds what is left out of the cylinder of `index`, or why it cannot be, to the judgement.
    fn judge(&self, index: usize, seen: &[Seen], window: Window, judgement: &mut Judgement) {
        let n = index + 1;
        let places = places(seen.iter().map(|seen| seen.t));
        let worst = |[from, to]: [f64; 2]| {
            let within = seen.iter().filter(|seen| (from..=to).contains(&seen.t));
            let worst = within.max_by(|one, other| one.times.total_cmp(&other.times));
            worst.map_or("", |seen| &seen.what)
        };
        let stays = places.iter().find_map(|place| Some((*place, self.step(*place, &places)?)));
        if let Some((place, step)) = stays {
            let what = worst(place);
            judgement
                .refused
                .push(format!("cylinder {n}: {what}, and {:.2} of it stay", Millimetres(step)));
        } else if let Some(last) = seen.last().filter(|seen| seen.t > window.to - BLOCK) {
            let [from, _] = *places.last().unwrap_or(&[last.t; 2]);
            let (from, what) = (from.max(0.0), worst([from, f64::INFINITY]));
            judgement
                .refused
                .push(format!("cylinder {n}: {what}, from {from:.0} s until after the end"));
        } else if let Some((from, off)) = self.off(&places) {
            judgement.refused.push(format!(
                "cylinder {n}: C1 - C2 differs from the tables by {:.2} from {from:.0} s on: a \
                 transducer has drifted, or was replaced or adjusted",
                Millimetres(off)
            ));
        } else if !are_few(&places, window.length()) {
            let whole = [f64::NEG_INFINITY, f64::INFINITY];
            let (count, worst) = (places.len(), worst(whole));
            let more = if count == 1 { "in one long place" } else { "again and again" };
            judgement.refused.push(format!(
                "cylinder {n} does not look healthy {more}, {count} in all; the worst: {worst}"
            ));
        } else {
            for [from, to] in places {
                judgement.left_out.push(format!(
                    "cylinder {n}: {}; its readings from {:.0} to {to:.0} s are left out: look \
                     there for a fault",
                    worst([from, to]),
                    from.max(0.0)
                ));
                judgement.cuts.add(index, [from, to]);
            }
        }
    }

    /// Step of C1 − C2 from before a place to after it, m, where the temperature does not explain
    /// it.
    fn step(&self, [from, to]: [f64; 2], places: &[[f64; 2]]) -> Option<f64> {
        let before = self.mean([from - BESIDE, from], places)?;
        let after = self.mean([to, to + BESIDE], places)?;
        Some(after - before).filter(|step| step.abs() > STAYS)
    }

    /// Time from which C1 − C2 differs too much from the tables, s, and the difference, m.
    fn off(&self, places: &[[f64; 2]]) -> Option<(f64, f64)> {
        let follow = |one: &Block, next: &Block| next.from - one.from < BLOCK + PAUSE.as_seconds();
        // A minute begins anew after a pause, and ends before it.
        let minutes = self.blocks.chunk_by(follow).flat_map(|file| file.chunks(6));
        let mut means = minutes.filter_map(|minute| {
            let [from, last] = [minute.first()?.from, minute.last()?.from];
            Some((from, self.mean([from, last + BLOCK], places)?))
        });
        means.find(|(_, mean)| mean.abs() > MOST_OFF)
    }

    /// Mean of C1 − C2 beyond what is healthy, m, between two times and outside `places`.
    fn mean(&self, [from, to]: [f64; 2], places: &[[f64; 2]]) -> Option<f64> {
        let within = self.blocks.iter().filter(|block| {
            let [begin, end] = [block.from, block.from + BLOCK];
            let apart = |[from, to]: &[f64; 2]| end <= *from || *to <= begin;
            from <= begin && end <= to + 1e-6 && places.iter().all(apart)
        });
        let (sum, rows) = within.fold((0.0, 0), |(sum, rows), it| (sum + it.sum, rows + it.rows));
        (rows >= LEAST_ROWS).then(|| sum / f64::from(rows))
    }
}
