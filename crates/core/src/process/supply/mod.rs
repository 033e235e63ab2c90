//! What the supply's pressure does by what the rods take.
//!
//! The gas in the accumulator keeps P V, so that its volume, and with it 1/P_S, grows by the oil that the rods take and
//! shrinks by what the pump gives, which is a function of the pressure:
//!
//! P² (1/P_S − 1/P_S′) = T q(P̄_S) + c₁ w₁ + c₂ w₂
//!
//! over T from the middle of one block of cycles to that of the next, from P_S to P_S′: q is what the pump adds, bar/s, w₁
//! and w₂ the ways of all rods out and in, m, P a pressure of the lesson, and q, c₁ and c₂ are learnt. A pump that gives
//! less, or to a lower pressure, leaves the supply short of it. The rods tell what is taken, whatever the valves do; what one
//! transducer is off counts little among all rods.

mod oil;

use super::alarm::{Malfunction, ProcessAlarm};
use super::evidence::{EvidenceWindows, Weighing};
use super::flow;
use super::parameters::ProcessParameters;
use crate::alarm::{Approach, Deadlines, Urgency};
use crate::sequential::statistic::Peak;
use crate::sequential::windows::WIDTHS;
use crate::state::{state, whole};
use crate::time::{self, Span, Timestamp};
use alloc::vec::Vec;
pub use oil::{Oil, OilBlock, OilSample};

/// What is known of a supply.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplyRelation {
    /// P, bar.
    pub reference: f64,
    /// Least and largest pressure that were taught, bar, at which the outermost knots of `pump` stand; the others stand
    /// evenly between them.
    pub taught: [f64; 2],
    /// q at its knots, bar/s, at least two.
    pub pump: Vec<f64>,
    /// c₁ and c₂, bar/m.
    pub taken: [f64; 2],
    /// Standard deviation of what a block leaves, bar.
    pub deviation: f64,
    /// Numbers of dependent samples of mean and spread, see [`Weighing`].
    pub dependence: [[f64; WIDTHS.len()]; 2],
}

/// What the watch of a supply is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct SupplyDesign {
    pub relation: SupplyRelation,
    /// Pressure below which it no longer carries the load, bar, above 0.
    pub least: f64,
    pub deadlines: Deadlines,
    /// h of a relation with a sample in each cycle, nats.
    pub level: f64,
    /// s.
    pub sample_time: f64,
    /// Cycles without evidence that end an alarm.
    pub clear: u32,
}

/// The piece of `count` between the pressures `taught` in which `pressure` lies, and the part of it before that: 0 to 1, and
/// beyond the largest more.
pub fn place(taught: [f64; 2], count: usize, pressure: f64) -> (usize, f64) {
    let [lowest, highest] = taught;
    let along = (count as f64 * (pressure - lowest) / (highest - lowest)).max(0.0);
    let piece = (along as usize).min(count - 1);
    (piece, along - piece as f64)
}

impl OilBlock {
    /// P² (1/P_S − 1/P_S′), bar, with P = `reference`.
    pub fn rise(&self, reference: f64) -> f64 {
        let [from, to] = self.pressures;
        reference * reference * (1.0 / from - 1.0 / to)
    }

    /// P̄_S, bar.
    pub fn pressure(&self) -> f64 {
        let [from, to] = self.pressures;
        0.5 * (from + to)
    }
}

impl SupplyRelation {
    /// q, bar/s. Below the pressures that were taught a pump gives no less than at the least of them; above them it goes on
    /// as before.
    pub fn pumped(&self, pressure: f64) -> f64 {
        let (piece, part) = place(self.taught, self.pump.len() - 1, pressure);
        let [low, high] = [self.pump[piece], self.pump[piece + 1]];
        low + part * (high - low)
    }

    /// What a block leaves, bar: below 0 the pressure falls short.
    pub fn residual(&self, block: &OilBlock, seconds: f64) -> f64 {
        block.rise(self.reference) - seconds * self.pumped(block.pressure()) - self.taken(block)
    }

    /// c₁ w₁ + c₂ w₂, bar.
    fn taken(&self, block: &OilBlock) -> f64 {
        self.taken.iter().zip(block.ways).map(|(of, way)| of * way).sum()
    }

    /// The pressure to which a sound pump brings `pressure`, bar, over a block; `None` if there is none.
    fn next(&self, pressure: f64, block: &OilBlock, seconds: f64) -> Option<f64> {
        // As if with the slope of q at its end, so that no pump is too stiff for the blocks.
        let damped = 1.0 + seconds * self.stiffness().max(0.0);
        let rise = (seconds * self.pumped(pressure) + self.taken(block)) / damped;
        let next = 1.0 / (1.0 / pressure - rise / (self.reference * self.reference));
        (next > 0.0 && next.is_finite()).then_some(next)
    }

    /// How much more the pump gives a bar lower, 1/s: its mean over what was taught.
    fn stiffness(&self) -> f64 {
        let [lowest, highest] = self.taught;
        let [most, least] =
            [self.pump.first(), self.pump.last()].map(|it| it.map_or(0.0, |it| *it));
        (most - least) / (highest - lowest)
    }
}

/// Evidence that the pressure falls short.
#[derive(Clone, Debug)]
pub struct Shortfall {
    windows: EvidenceWindows,
    weighing: Weighing,
    variance: f64,
}

state! {
    Shortfall { windows }
    but { weighing, variance }
}

impl Shortfall {
    /// Of blocks of so many `seconds`.
    pub fn new(relation: &SupplyRelation, seconds: f64) -> Self {
        let band = ProcessParameters::DEFAULT.supply_band * seconds;
        let weighing = Weighing::new(band, relation.dependence, seconds);
        let variance = relation.deviation * relation.deviation;
        Self { windows: EvidenceWindows::default(), weighing, variance }
    }

    pub const fn clear(&mut self) {
        self.windows.clear();
    }

    /// Takes what a block leaves, bar.
    pub fn push(&mut self, residual: f64) {
        self.windows.push(residual, self.variance);
    }

    /// The most evidence that the newest blocks fell short: a pump that gives more is no fault.
    pub fn peak(&self) -> Peak {
        self.short(self.windows.peaks(&self.weighing))
    }

    /// The same of at most so many `blocks`.
    fn peak_within(&self, blocks: usize) -> Peak {
        self.short(self.windows.peaks_within(&self.weighing, blocks))
    }

    fn short(&self, [mean, _]: [Peak; 2]) -> Peak {
        let is_short = self.windows.mean(mean.width.max(1)).is_some_and(|mean| mean < 0.0);
        if is_short { mean } else { Peak::default() }
    }
}

/// By how much the pressure is beside what it should be, in the mean over so many blocks, and over those before.
#[derive(Clone, Copy, Debug, Default)]
struct Size {
    sum: f64,
    count: u32,
    before: Option<f64>,
}

whole! { Size { sum, count, before } }

impl Size {
    /// Takes what a block was beside, bar, of so many `blocks` at a time. Returns the size once it no longer grows.
    fn take(&mut self, beside: f64, blocks: u32) -> Option<f64> {
        (self.sum, self.count) = (self.sum + beside, self.count.saturating_add(1));
        if self.count < blocks {
            return None;
        }
        let mean = self.sum / f64::from(self.count);
        let before =
            core::mem::replace(self, Self { before: Some(mean), ..Self::default() }).before;
        let has_arrived =
            |before: f64| mean.abs() <= ProcessParameters::DEFAULT.supply_arrived * before.abs();
        before.is_some_and(has_arrived).then_some(mean)
    }
}

/// The supply of a machine, watched.
#[derive(Clone, Debug)]
pub struct SupplyWatch {
    design: SupplyDesign,
    /// Seconds of a block.
    seconds: f64,
    level: f64,
    /// Cycles that are not judged after the platform came into a monitored state.
    opening: u32,
    /// Blocks of the longest window that keeps an alarm.
    longest: usize,
    /// Blocks over which a size is measured.
    blocks: u32,
    oil: Oil,
    shortfall: Shortfall,
    open: u32,
    /// P_S as a sound pump would have it, bar, since the evidence began.
    expected: Option<f64>,
    size: Size,
    /// How soon the pressure is too low, by 1/P_S, which grows evenly as the rods take oil that no pump replaces.
    reserve: Approach,
    alarm: Option<ProcessAlarm>,
    /// What [`Self::news`] gave last.
    reported: [bool; 2],
}

state! {
    SupplyWatch { oil, shortfall, open, expected, size, reserve, alarm, reported }
    but { design, seconds, level, opening, longest, blocks }
}

impl SupplyWatch {
    pub fn new(design: SupplyDesign) -> Self {
        let oil = Oil::new(design.sample_time);
        let seconds = f64::from(oil.block()) * design.sample_time;
        let by = &ProcessParameters::DEFAULT;
        Self {
            seconds,
            level: flow::level(design.level, design.sample_time),
            opening: time::cycles(by.opening, design.sample_time),
            longest: time::cycles(by.windows[1], seconds) as usize,
            blocks: time::cycles(by.supply_look, seconds),
            shortfall: Shortfall::new(&design.relation, seconds),
            oil,
            open: 0,
            expected: None,
            size: Size::default(),
            reserve: Approach::new(design.deadlines, seconds),
            alarm: None,
            reported: [false; 2],
            design,
        }
    }

    /// Forgets the evidence, after a time in which nobody knows what happened; an alarm stands.
    pub fn interrupt(&mut self) {
        self.lose();
        self.open = 0;
    }

    /// Takes a cycle that did not come.
    pub fn lose(&mut self) {
        self.oil.reset();
        self.shortfall.clear();
        self.reserve.interrupt();
        (self.expected, self.size) = (None, Size::default());
    }

    pub const fn alarm(&self) -> Option<&ProcessAlarm> {
        self.alarm.as_ref()
    }

    /// The alarm and [`Self::is_judging`], if there is or was an alarm, or the latter has changed, since they were last
    /// asked for.
    #[inline]
    pub fn news(&mut self) -> Option<(Option<ProcessAlarm>, bool)> {
        let news = [self.alarm.is_some(), self.is_judging()];
        let before = core::mem::replace(&mut self.reported, news);
        (news[0] || news != before).then_some((self.alarm, news[1]))
    }

    /// Whether the newest cycle belongs to a block that is judged.
    pub const fn is_judging(&self) -> bool {
        self.oil.is_begun()
    }

    /// Takes a cycle, `None` without the supply's pressure and every rod's length, in a monitored state or not.
    #[inline]
    pub fn step(&mut self, sample: Option<&OilSample>, monitored: bool, at: Timestamp) {
        self.open = if monitored { self.open.saturating_add(1) } else { 0 };
        let sample = sample.filter(|_| self.open >= self.opening);
        if sample.is_none() {
            self.lose();
            return;
        }
        if let Some(block) = self.oil.step(sample) {
            self.judge(&block, at);
        }
    }

    #[inline(never)]
    fn judge(&mut self, block: &OilBlock, at: Timestamp) {
        self.shortfall.push(self.design.relation.residual(block, self.seconds));
        // What is long over ends no alarm later than a fault of anything else.
        let peak = match self.alarm {
            None => self.shortfall.peak(),
            Some(_) => self.shortfall.peak_within(self.longest),
        };
        let cycles = self.oil.block();
        let expected = self.follow(block);
        let [_, pressure] = block.pressures;
        self.reserve.push(1.0 / pressure, 1.0 / self.design.least);
        match &mut self.alarm {
            None if peak.nats < self.level => return,
            None => self.alarm = Some(self.raised(peak, at)),
            Some(alarm) => {
                let least = ProcessParameters::DEFAULT.over * self.level;
                if alarm.follow(peak.nats, least, cycles, self.design.clear) {
                    self.alarm = None;
                    // What longer windows still have of it would raise it again.
                    self.shortfall.clear();
                    (self.expected, self.size) = (None, Size::default());
                    return;
                }
            }
        }
        let urgency = self.reserve.urgency();
        self.alarm.iter_mut().for_each(|alarm| alarm.urgency = urgency);
        self.measure(pressure - expected);
    }

    /// Tells the size of an alarm of which nobody knows it: by how much the pressure is `beside` what it should be, bar, in
    /// the mean over some seconds, once it is hardly more than in those before: an accumulator takes its time.
    fn measure(&mut self, beside: f64) {
        let Some(alarm) = self.alarm.as_mut().filter(|alarm| alarm.size.is_none()) else {
            self.size = Size::default();
            return;
        };
        alarm.size = self.size.take(beside, self.blocks);
    }

    /// The pressure that a sound pump would have brought about since the evidence began, bar.
    fn follow(&mut self, block: &OilBlock) -> f64 {
        let [from, _] = block.pressures;
        let next = self.expected.and_then(|it| self.design.relation.next(it, block, self.seconds));
        *self.expected.insert(next.unwrap_or(from))
    }

    fn raised(&self, peak: Peak, at: Timestamp) -> ProcessAlarm {
        let back = self.seconds * peak.width as f64;
        ProcessAlarm {
            malfunction: Malfunction::Supply,
            size: None,
            nats: peak.nats,
            urgency: Urgency::None,
            onset: at.after(Span::from_seconds(-back)),
            age: 0,
            quiet: 0,
        }
    }
}

#[cfg(test)]
mod tests;
