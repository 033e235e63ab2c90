//! The virtual sensor of one cylinder: selects trusted transducers and estimates the length.

use super::accommodation::{Accommodation, AccommodationDesign, Offset};
use super::carrier::{Carrier, Reserve};
use super::dynamics::{Dynamics, Feed};
use super::filter::{Counted, Filter};
use super::growth::Growth;
use super::mean::Mean;
use super::parameters::{EstimateCycles, EstimateParameters};
use super::scale::LengthScale;
use super::{Estimate, Source};
use crate::sequential::parameters::ResidualParameters;
use crate::sequential::velocity::Velocity;
use crate::state::state;

/// Parameters of a virtual sensor.
#[derive(Clone, Debug)]
pub struct SensorDesign {
    pub dynamics: Dynamics,
    pub scale: LengthScale,
    /// Sample time, s.
    pub sample_time: f64,
    /// Number of readings until a transducer can serve as a reference.
    pub settle: u32,
    /// Most cycles without a reading over which a filter continues.
    pub max_gap: u32,
    /// Largest difference of healthy transducers, m.
    pub difference: f64,
    /// Largest σ of a valid estimate, m.
    pub bound: f64,
    /// Range of valid lengths, inclusive, m.
    pub lengths: (f64, f64),
    /// When the step of a transducer is subtracted; `None`: never.
    pub accommodation: Option<AccommodationDesign>,
    pub parameters: &'static EstimateParameters,
}

/// Inputs of a cylinder in one cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct SensorInput {
    /// Number of the cycle.
    pub cycle: u64,
    /// Readings that passed the plausibility checks, m, each on its own scale.
    pub lengths: [Option<f64>; 2],
    /// Velocity by C2 where it is measured, m/s.
    pub velocity: Option<f64>,
    /// Command u(k), m/s, as sent.
    pub command: Option<f64>,
    /// Whether the rod follows the command: the platform is in a monitored state, and the command
    /// is not stale.
    pub follows: bool,
    /// Transducers that no finding blames.
    pub trusted: [bool; 2],
    /// Whether one of the two is blamed, but it is not known which.
    pub undecided: bool,
    /// Whether a detector names a transducer for what it reads.
    pub resolved: bool,
    /// Whether the rod does not follow the command.
    pub process: bool,
    /// What both readings may be off by alike, m.
    pub departs: f64,
    /// The largest step, m, of the only transducer that is left that its supervision would not find.
    pub unseen: f64,
    /// Transducers that are blamed for a step, and for nothing else.
    pub displaced: [bool; 2],
    /// Transducers whose residual is beyond its threshold in this cycle.
    pub beyond: [bool; 2],
    /// Whether no transducer is trusted, and a reading of the last one may have been wrong before it was blamed.
    pub doubted: bool,
}

impl SensorInput {
    const fn is_calm(&self) -> bool {
        self.trusted[0] && self.trusted[1] && !self.undecided && !self.process
    }
}

/// The virtual sensor of one cylinder.
#[derive(Clone, Debug)]
pub struct VirtualSensor {
    design: SensorDesign,
    cycles: EstimateCycles,
    velocity: Velocity,
    feed: Feed,
    filters: [Filter; 2],
    growth: Growth,
    /// Mean squared difference of healthy transducers, m².
    differences: Mean,
    /// Newest difference, m.
    difference: f64,
    /// Largest difference of about the last second, m.
    largest: f64,
    /// Largest innovation of the transducers that are used, of about the last second, m.
    startled: f64,
    carrier: Option<Carrier>,
    reserve: Reserve,
    /// Cycles for which one of the two was wrong and nobody knew which.
    disputed: u32,
    /// The steps of C1 and C2.
    accommodations: Option<[Accommodation; 2]>,
    /// Cycles since a trusted transducer was read.
    without: u32,
    /// Transducers that were trusted and had a reading in the previous cycle.
    relied_on: [bool; 2],
    cycle: u64,
}

state! {
    VirtualSensor {
        velocity, feed, filters, growth, differences, difference, largest, startled, carrier, reserve, disputed,
        without, relied_on, cycle,
    }
    parts { accommodations }
    but { design, cycles }
}

impl VirtualSensor {
    pub fn new(design: SensorDesign) -> Self {
        Self {
            cycles: design.parameters.cycles(design.sample_time),
            velocity: Velocity::new(&ResidualParameters::DEFAULT, design.sample_time),
            feed: Feed::new(design.sample_time),
            filters: [Filter::default(), Filter::default()],
            growth: Growth::default(),
            differences: Mean::default(),
            difference: 0.0,
            largest: 0.0,
            startled: 0.0,
            without: 0,
            carrier: None,
            reserve: Reserve::default(),
            disputed: 0,
            accommodations: design.accommodation.map(|it| [0, 1].map(|_| Accommodation::new(it))),
            relied_on: [false; 2],
            cycle: 0,
            design,
        }
    }

    /// Restarts the estimate after a time jump or lost frames. What is known of transducers and
    /// model stays.
    pub fn interrupt(&mut self) {
        self.velocity.reset();
        self.feed.clear();
        self.filters.iter_mut().for_each(Filter::stop);
        self.growth.recall();
        (self.difference, self.largest, self.startled) = (0.0, 0.0, 0.0);
        self.carrier = None;
        self.reserve.clear();
        self.relied_on = [false; 2];
    }

    /// Takes one cycle; returns `None` while nothing is known of the length.
    pub fn step(&mut self, input: &SensorInput) -> Option<Estimate> {
        if input.cycle != self.cycle.wrapping_add(1) {
            self.interrupt();
        }
        self.cycle = input.cycle;
        if input.is_calm() || input.resolved {
            self.disputed = 0;
        } else if input.undecided {
            self.disputed = self.disputed.saturating_add(1);
        }
        let SensorDesign { dynamics, scale, max_gap, parameters, .. } = &self.design;
        let counted = Counted { wild: parameters.wild, memory: self.cycles.memory };
        let counted = input.is_calm().then_some(counted);
        let lengths = scale.apply(&mut self.velocity, input.lengths, input.velocity);
        for (filter, length) in self.filters.iter_mut().zip(lengths) {
            filter.correct(dynamics, length, *max_gap, counted);
        }
        let source = self.choose(input);
        self.without = if source.is_some() { 0 } else { self.without.saturating_add(1) };
        self.accommodate(input);
        let estimate = match (source, self.corrected(input)) {
            (Some(source), _) => self.estimate(input, source),
            (None, Some((i, offset))) => Some(self.estimate_corrected(input, i, offset)),
            (None, None) => self.carry(input),
        };
        self.relied_on = [0, 1].map(|i| input.trusted[i] && self.filters[i].is_fresh());
        self.predict(input);
        estimate
    }

    /// The transducers that are trusted and have been read for long enough, if one was read now.
    fn choose(&mut self, input: &SensorInput) -> Option<Source> {
        let settled = |i: usize| self.filters[i].evidence()[0] >= self.design.settle;
        let used = [0, 1].map(|i| input.trusted[i] && self.filters[i].is_running() && settled(i));
        let fresh = |i: usize| used[i] && self.filters[i].is_fresh();
        if !fresh(0) && !fresh(1) {
            return None;
        }
        let source = match used {
            [true, true] => Source::Both,
            [true, false] => Source::C1,
            _ => Source::C2,
        };
        if source == Source::Both {
            let [one, other] = self.filters.each_ref().map(|filter| filter.state()[0]);
            self.difference = (one - other).abs();
            if fresh(0) && fresh(1) && input.is_calm() {
                let counted = self.difference.min(self.design.difference);
                self.differences.add(counted * counted, self.cycles.memory);
            }
        }
        self.largest = self.difference.max(self.cycles.difference_left * self.largest);
        Some(source)
    }

    /// The estimate from the transducers of `source`.
    fn estimate(&mut self, input: &SensorInput, source: Source) -> Option<Estimate> {
        let [one, other] = &self.filters;
        let usual = self.differences.value();
        let now = if input.undecided { self.largest } else { self.difference };
        let (x, variance) = match source {
            // They err together where the model does, so two are not taken for better than one; and
            // whichever of them is right, their mean is off by half of their difference.
            Source::Both => {
                let [v1, v2] = [one.variance(), other.variance()];
                let part = if v1 + v2 > 0.0 { v2 / (v1 + v2) } else { 0.5 };
                let x = one.state() * part + other.state() * (1.0 - part);
                (x, part * v1 + (1.0 - part) * v2 + 0.25 * usual.max(now * now))
            }
            Source::C1 => (*one.state(), one.variance() + usual + self.unseen(input)),
            _ => (*other.state(), other.variance() + usual + self.unseen(input)),
        };
        let used = [source != Source::C2, source != Source::C1];
        let startling = self.filters.iter().zip(used).filter(|(_, used)| *used);
        let startling = startling.map(|(filter, _)| filter.innovation().abs());
        self.startled =
            startling.fold(self.cycles.difference_left * self.startled, |all, it| all.max(it));
        // The filters were measured where the rod follows the command; where it does not they lag behind it.
        let astray = self.startled.max(input.departs);
        let variance = variance + if input.process { astray * astray } else { 0.0 };
        let follows = |i: usize| self.filters[i].evidence()[1] >= self.design.settle;
        let able = (0..2).all(|i| !used[i] || follows(i));
        let carrier = Carrier { x, variance, coasted: 0, able };
        if able && input.is_calm() {
            self.growth.compare(&x, self.cycles.memory);
            self.reserve.offer(carrier, self.cycles.reserve);
        } else {
            self.growth.recall();
        }
        self.carrier = Some(carrier);
        // One transducer alone is vouched for by the model only, and not while that is in doubt, or it may itself be the one
        // by which the two had differed before the other one was lost.
        let disputed = self.disputed > self.cycles.disputed;
        let alone = able && !input.undecided && !input.process && !disputed;
        Some(self.judged(x[0], variance, source, source == Source::Both || alone))
    }

    /// Variance of an error of the last transducer that its supervision would not find, m².
    fn unseen(&self, input: &SensorInput) -> f64 {
        let sigma = input.unseen / self.design.parameters.unseen;
        sigma * sigma
    }

    /// The estimate from the command alone.
    fn carry(&mut self, input: &SensorInput) -> Option<Estimate> {
        if !input.is_calm() {
            self.growth.recall();
        }
        if (0..2).any(|i| self.relied_on[i] && !input.trusted[i]) {
            self.carrier = self.reserve.get();
        }
        let Carrier { x, variance, coasted, able } = self.carrier?;
        let grown =
            self.growth.variance(coasted, self.design.parameters.doubt).unwrap_or(f64::INFINITY);
        Some(self.judged(
            x[0],
            variance + grown,
            Source::Model,
            able && !input.process && !input.doubted,
        ))
    }

    /// Follows the steps of C1 and C2, where they are to be subtracted.
    fn accommodate(&mut self, input: &SensorInput) {
        let Some(accommodations) = &mut self.accommodations else { return };
        for (i, step) in accommodations.iter_mut().enumerate() {
            let other = 1 - i;
            let is_alone = !input.trusted[other];
            if !input.displaced[i] || is_alone && input.beyond[i] {
                // It is another step now, or another fault.
                step.forget();
                continue;
            }
            let [own, others] = [i, other].map(|i| &self.filters[i]);
            let compares = !is_alone && !input.process && own.is_fresh() && others.is_fresh();
            step.step(compares.then(|| own.state()[0] - others.state()[0]));
        }
    }

    /// The transducer that is read less its step, where none is trusted, and that step.
    fn corrected(&self, input: &SensorInput) -> Option<(usize, Offset)> {
        let accommodations = self.accommodations.as_ref()?;
        let is_left = |i: &usize| {
            let filter = &self.filters[*i];
            !input.trusted[*i]
                && input.displaced[*i]
                && filter.is_fresh()
                && filter.evidence()[0] >= self.design.settle
        };
        let (usual, parameters) = (self.differences.value(), self.design.parameters);
        let offset = |i: usize| Some((i, accommodations[i].offset(usual, parameters)?));
        (0..2).filter(is_left).find_map(offset)
    }

    /// The estimate by transducer `i` less its step.
    fn estimate_corrected(&mut self, input: &SensorInput, i: usize, offset: Offset) -> Estimate {
        let filter = &self.filters[i];
        let mut x = *filter.state();
        x[0] -= offset.size;
        let unknown = self.differences.value() + offset.variance + self.unseen(input);
        let variance = filter.variance() + unknown;
        let able = filter.evidence()[1] >= self.design.settle;
        self.growth.recall();
        self.carrier = Some(Carrier { x, variance, coasted: 0, able });
        let source = [Source::C1Corrected, Source::C2Corrected][i];
        self.judged(x[0], variance, source, able && !input.process)
    }

    fn judged(&self, position: f64, variance: f64, source: Source, evidence: bool) -> Estimate {
        let sigma = libm::sqrt(variance);
        let (lowest, highest) = self.design.lengths;
        let inside = (lowest..=highest).contains(&position);
        // Written so that a NaN is not valid.
        let valid = evidence && inside && sigma <= self.design.bound;
        let without = f64::from(self.without) * self.design.sample_time;
        Estimate { position, sigma, source, valid, without }
    }

    fn predict(&mut self, input: &SensorInput) {
        let Self { design, feed, filters, growth, carrier, reserve, .. } = self;
        // The commands are taken where the rod does not follow them, too, to be known when it does.
        let part = feed.step(&design.dynamics, input.command).filter(|_| input.follows);
        for filter in filters {
            filter.predict(&design.dynamics, part.as_ref());
        }
        let a = &design.dynamics.a;
        match &part {
            Some(part) => {
                growth.predict(a, part);
                reserve.predict(a, part);
            }
            None => {
                growth.recall();
                reserve.clear();
            }
        }
        *carrier = carrier.zip(part).and_then(|(carrier, part)| carrier.predicted(a, &part));
    }
}

#[cfg(test)]
mod tests;
