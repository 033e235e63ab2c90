//! The cylinders in a recording: pairs of readings that agree and move, and the commands that lead them.

use super::catalogue::Catalogue;
use super::likeness::{Agreement, Following, agreement, derivative, ends, following, smooth};
use super::tally::BusTally;
use super::track::Tracks;
use super::words::{Hint, Measure, measure, says};
use std::collections::BTreeMap;

/// Largest spread of two readings of one length, as a part of their motion's standard deviation.
const AGREE: f64 = 0.01;

/// The same for readings that are no lengths by their unit.
const AGREE_OPEN: f64 = 0.005;

/// Least share of the samples that agree.
const MOSTLY: f64 = 0.6;

/// Least travel of a reading in steps of its own resolution.
const LEAST_STEPS: f64 = 250.0;

/// Least motion between cycles, as a part of the travel, for a signal that jumps instead of moving.
const JUMPS: f64 = 0.08;

/// Correlation from which a command is one by its motion alone, where name or unit say so as well, and where those of
/// the readings do, too: slow signals that have nothing to do with each other may correlate.
const ALONE: f64 = 0.95;
pub(super) const SURE: f64 = 0.9;
const POSSIBLE: f64 = 0.7;

/// Correlation of the rod's speed and a reading of it, and the most cycles by which such a reading leads.
const SAME_SPEED: f64 = 0.93;
const NO_LEAD: f64 = 0.2;

/// A spool follows its command so closely that the motion follows either: by how much more of it one may leave
/// unexplained than the other, and how many cycles their leads may differ, for name and unit to tell them apart.
const ALIKE: (f64, f64) = (0.02, 1.0);

/// The signals of one period, ready to be compared.
pub(super) struct Field<'a> {
    pub catalogue: &'a Catalogue<'a>,
    tracks: &'a Tracks,
    /// Values without wild ones, by the signal's number.
    pub clean: BTreeMap<usize, Vec<f64>>,
    smooth: BTreeMap<usize, Vec<f64>>,
}

/// Two readings of one length.
#[derive(Clone, Debug)]
pub(super) struct Twins {
    pub signals: [usize; 2],
    pub agreement: Agreement,
    /// The command that leads their motion.
    pub command: Option<(usize, Following)>,
    /// The reading of the speed of each.
    pub velocities: [Option<(usize, Following)>; 2],
}

/// A pair's number, a signal that its motion follows, and how.
type Offer = (usize, usize, Following);

impl<'a> Field<'a> {
    /// The signals of `tracks` that move.
    pub fn new(catalogue: &'a Catalogue<'a>, tally: &BusTally, tracks: &'a Tracks) -> Self {
        let moving = tracks.signals().filter(|signal| tally.signals[*signal].moves());
        let clean: BTreeMap<_, _> = moving.map(|signal| (signal, tracks.clean(signal))).collect();
        let smooth = clean.iter().map(|(signal, values)| (*signal, smooth(values))).collect();
        Self { catalogue, tracks, clean, smooth }
    }

    /// Pairs of readings with their commands; pairs without one last.
    pub fn twins(&self) -> Vec<Twins> {
        let pairs = self.pairs();
        let speed = |signal: usize| derivative(&self.clean[&signal]);
        let speeds: Vec<[Vec<f64>; 2]> =
            pairs.iter().map(|twins| twins.signals.map(speed)).collect();
        let paired: Vec<usize> = pairs.iter().flat_map(|twins| twins.signals).collect();
        let mut offers: Vec<Offer> = Vec::new();
        for (place, [first, second]) in speeds.iter().enumerate() {
            let [one, other] = pairs[place].signals;
            for &signal in self.smooth.keys() {
                // One of the two may have had a fault.
                let both = [(first, one), (second, other)]
                    .map(|(speed, reading)| self.following(speed, reading, signal));
                let size = |it: &Following| it.correlation.abs();
                let best = both.into_iter().flatten().max_by(|a, b| size(a).total_cmp(&size(b)));
                if let Some(found) = best {
                    offers.push((place, signal, found));
                }
            }
        }
        // Readings of a speed agree with each other, too; their command would be of a wrong kind.
        let is_speed = |twins: &Twins| {
            offers.iter().any(|(place, signal, found)| {
                twins.signals.contains(signal)
                    && !pairs[*place].signals.contains(signal)
                    && is_reading_of_speed(found)
            })
        };
        let lengths: Vec<bool> = pairs.iter().map(|twins| !is_speed(twins)).collect();
        // What is best explained as the speed of one rod is not the command of another that moves alike.
        let is_some_speed = |signal: usize| {
            let of_signal = offers.iter().filter(|offer| offer.1 == signal);
            let best =
                of_signal.max_by(|a, b| a.2.correlation.abs().total_cmp(&b.2.correlation.abs()));
            best.is_some_and(|(_, _, found)| is_reading_of_speed(found))
        };
        let drives = |offer: &Offer| {
            let (place, signal, found) = offer;
            let least = match (self.is_called_a_command(*signal), self.is_length(&pairs[*place])) {
                (true, true) => POSSIBLE,
                (true, false) => SURE,
                (false, _) => ALONE,
            };
            lengths[*place]
                && !paired.contains(signal)
                && !is_some_speed(*signal)
                && found.lead > NO_LEAD
                && found.correlation.abs() >= least
                && self.may_command(*signal, &pairs[*place])
        };
        let commands: Vec<_> = offers.iter().copied().filter(drives).collect();
        let mut found = self.assign(&pairs, commands);
        found.retain(|twins| twins.command.is_some() || self.is_length(twins));
        for twins in &mut found {
            self.measure_speeds(twins);
        }
        found.sort_by_key(|twins| (twins.command.is_none(), twins.signals));
        found
    }

    /// How the motion with the derivative `speed` of `reading` follows another signal, from the time at which the one is
    /// sampled to that of the other.
    fn following(&self, speed: &[f64], reading: usize, signal: usize) -> Option<Following> {
        let found = following(speed, &self.smooth[&signal], self.tracks.period)?;
        let delay = |signal| self.tracks.delay(self.catalogue, signal);
        Some(Following { lead: found.lead + delay(reading) - delay(signal), ..found })
    }

    /// Whether its unit or its name says that a signal may be a command.
    fn is_called_a_command(&self, signal: usize) -> bool {
        measure(self.catalogue.unit(signal)) == Measure::Speed
            || says(self.catalogue.name(signal), Hint::Command)
    }

    /// Gives each pair a command of its own, so that together the motions follow them best.
    fn assign(&self, pairs: &[Twins], offers: Vec<Offer>) -> Vec<Twins> {
        let mut pairs = pairs.to_vec();
        for offer in assignment(pairs.len(), &offers) {
            pairs[offer.0].command = Some((offer.1, offer.2));
        }
        for place in 0..pairs.len() {
            let Some((chosen, found)) = pairs[place].command else { continue };
            let free = |signal: usize| {
                signal == chosen
                    || pairs.iter().all(|twins| twins.command.is_none_or(|it| it.0 != signal))
            };
            let rest = |found: &Following| 1.0 - found.correlation.powi(2);
            let alike = |offer: &&Offer| {
                let near = (offer.2.lead - found.lead).abs() <= ALIKE.1;
                offer.0 == place
                    && near
                    && free(offer.1)
                    && rest(&offer.2) <= rest(&found) + ALIKE.0
            };
            let preferred =
                offers.iter().filter(alike).max_by(|a, b| self.merit(a).total_cmp(&self.merit(b)));
            pairs[place].command = preferred.map(|offer| (offer.1, offer.2));
        }
        pairs
    }

    /// How much a signal looks like a command, among those that the motion follows equally well.
    fn merit(&self, (_, signal, found): &Offer) -> f64 {
        let name = self.catalogue.name(*signal);
        let of = |holds: bool, points: f64| if holds { points } else { 0.0 };
        of(measure(self.catalogue.unit(*signal)) == Measure::Speed, 40.0)
            + of(says(name, Hint::Command) && !says(name, Hint::Spool), 20.0)
            - of(says(name, Hint::Spool) || says(name, Hint::Unmeasured), 40.0)
            + 100.0 * found.correlation.abs()
    }

    /// Whether unit and name do not say that a signal is something else: a length, a pressure, or the speed of what
    /// its own message has the length of.
    fn may_command(&self, signal: usize, twins: &Twins) -> bool {
        let own = &self.catalogue.signals[signal].signal.name;
        let is_speed = says(own, Hint::Velocity) && !says(own, Hint::Command);
        let beside = |length: &usize| self.catalogue.beside(*length).contains(&signal);
        let unit = measure(self.catalogue.unit(signal));
        !(matches!(unit, Measure::Length | Measure::Pressure)
            || is_speed && twins.signals.iter().any(beside))
    }

    pub fn is_length(&self, twins: &Twins) -> bool {
        let length = |signal: &usize| measure(self.catalogue.unit(*signal)) == Measure::Length;
        twins.signals.iter().all(length)
    }

    /// Pairs of readings that agree, the closest ones first; each signal is in one pair.
    fn pairs(&self) -> Vec<Twins> {
        let readings: Vec<usize> =
            self.clean.keys().copied().filter(|signal| self.is_reading(*signal)).collect();
        let mut pairs: Vec<Twins> = Vec::new();
        for (place, &first) in readings.iter().enumerate() {
            for &second in &readings[place + 1..] {
                if self.catalogue.unit(first) == self.catalogue.unit(second)
                    && self.are_alike(first, second)
                    && let Some(twins) = self.compare(first, second)
                {
                    pairs.push(twins);
                }
            }
        }
        let closeness = |twins: &Twins| twins.agreement.spread / twins.agreement.motion;
        pairs.sort_by(|a, b| closeness(a).total_cmp(&closeness(b)));
        let mut taken: Vec<usize> = Vec::new();
        pairs.retain(|twins| {
            let free = twins.signals.iter().all(|signal| !taken.contains(signal));
            taken.extend(twins.signals.iter().filter(|_| free));
            free
        });
        pairs
    }

    fn compare(&self, first: usize, second: usize) -> Option<Twins> {
        let resolution = self.catalogue.signals[first].signal.plan.factor().abs();
        let agreement = agreement(&self.clean[&first], &self.clean[&second], resolution)?;
        let twins =
            Twins { signals: [first, second], agreement, command: None, velocities: [None, None] };
        let least = if self.is_length(&twins) { AGREE } else { AGREE_OPEN };
        let agrees = agreement.spread <= least * agreement.motion
            && agreement.share >= MOSTLY
            && agreement.gain.abs() > 0.2
            && agreement.gain.abs() < 5.0
            && agreement.travel >= LEAST_STEPS * resolution;
        agrees.then_some(twins)
    }

    /// Whether a signal may be a length: it moves instead of jumping, and its unit does not say otherwise.
    fn is_reading(&self, signal: usize) -> bool {
        let unit = measure(self.catalogue.unit(signal));
        let values = &self.clean[&signal];
        let (low, high) = ends(values);
        let steps = values.windows(2).map(|two| (two[1] - two[0]).abs());
        let (sum, count) = steps
            .filter(|step| step.is_finite())
            .fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
        matches!(unit, Measure::Length | Measure::Open)
            && high > low
            && count >= 50.0
            && sum / count < JUMPS * (high - low)
    }

    /// A first look at whether two signals may agree.
    fn are_alike(&self, first: usize, second: usize) -> bool {
        let (first, second) = (&self.clean[&first], &self.clean[&second]);
        let stride = (first.len() / 800) | 1;
        let both = first.iter().zip(second).step_by(stride);
        let both = both.filter(|(y, x)| y.is_finite() && x.is_finite());
        let sums = both.fold([0.0; 6], |mut sums, (y, x)| {
            for (sum, term) in sums.iter_mut().zip([1.0, *y, *x, y * y, x * x, x * y]) {
                *sum += term;
            }
            sums
        });
        let [count, y, x, yy, xx, xy] = sums;
        let covariance = xy * count - x * y;
        covariance.powi(2) > 0.5 * (xx * count - x * x) * (yy * count - y * y)
    }

    /// Finds the signals that are the speed of either reading; one beside it in its message first.
    fn measure_speeds(&self, twins: &mut Twins) {
        let mut taken = None;
        for place in 0..2 {
            let signal = twins.signals[place];
            let speed = derivative(&self.clean[&signal]);
            let beside = self.catalogue.beside(signal);
            let of_twin = self.catalogue.beside(twins.signals[1 - place]);
            let others = self.smooth.iter().filter(|(other, _)| {
                !twins.signals.contains(other)
                    && twins.command.is_none_or(|(command, _)| command != **other)
                    && taken != Some(**other)
                    && (beside.contains(*other) || !of_twin.contains(*other))
                    && matches!(
                        measure(self.catalogue.unit(**other)),
                        Measure::Speed | Measure::Open
                    )
            });
            let found = others.filter_map(|(&other, _)| {
                let found = self.following(&speed, signal, other).filter(is_reading_of_speed)?;
                Some((other, found))
            });
            let near = |(other, found): &(usize, Following)| {
                f64::from(beside.contains(other)) + found.correlation.abs()
            };
            twins.velocities[place] = found.max_by(|a, b| near(a).total_cmp(&near(b)));
            taken = twins.velocities[place].map(|(other, _)| other);
        }
    }
}

fn is_reading_of_speed(found: &Following) -> bool {
    found.correlation >= SAME_SPEED && found.lead <= NO_LEAD
}

/// What an offer costs: the logarithm of what it leaves unexplained, and a little for each cycle of lead, since of
/// rods that move alike a neighbour's command may lead by much.
fn cost(offer: &Offer) -> f64 {
    const PER_CYCLE: f64 = 0.1;
    (1.0 - offer.2.correlation.powi(2)).max(1e-9).ln() + PER_CYCLE * offer.2.lead
}

/// The offers to take, each pair and each signal at most once: the cheapest ones, improved as long as another choice
/// for one pair, with what remains for the one that had it, is cheaper together.
fn assignment(pairs: usize, offers: &[Offer]) -> Vec<Offer> {
    let mut sorted = offers.to_vec();
    sorted.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let mut taken: Vec<Option<Offer>> = vec![None; pairs];
    let total = |taken: &[Option<Offer>]| taken.iter().flatten().map(cost).sum::<f64>();
    let best = |taken: &[Option<Offer>], pair: usize| {
        let free = |signal: usize| taken.iter().flatten().all(|it| it.1 != signal);
        sorted.iter().find(|offer| offer.0 == pair && free(offer.1)).copied()
    };
    for offer in &sorted {
        if taken[offer.0].is_none() && taken.iter().flatten().all(|it| it.1 != offer.1) {
            taken[offer.0] = Some(*offer);
        }
    }
    let rounds = 4 * pairs;
    for _ in 0..rounds {
        let changed = sorted.iter().find_map(|offer| {
            let mut other = taken.clone();
            let loser = other.iter().position(|it| it.is_some_and(|it| it.1 == offer.1));
            if let Some(loser) = loser {
                other[loser] = None;
            }
            other[offer.0] = Some(*offer);
            if let Some(loser) = loser.filter(|loser| *loser != offer.0) {
                other[loser] = best(&other, loser);
            }
            (total(&other) < total(&taken) - 1e-9).then_some(other)
        });
        match changed {
            Some(other) => taken = other,
            None => break,
        }
    }
    taken.into_iter().flatten().collect()
}
