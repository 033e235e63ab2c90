//! The first pass over a recording: how often each signal comes, and whether it moves, counts or rests.

use super::catalogue::Catalogue;
use crate::order_statistics::lower_median;
use tertius_core::decode::Value;
use tertius_core::frame::Frame;

/// Intervals that are kept of each signal and message.
const KEPT: usize = 256;

/// Different values up to which a signal is a state and not a quantity.
const FEW: usize = 16;

/// Samples below which nothing is said of a signal.
const LEAST: u64 = 50;

/// Share of the steps that are one count for a counter.
const COUNTING: f64 = 0.9;

/// Periods that differ by less are the same.
const SAME_PERIOD: f64 = 0.08;

/// What the first pass counts; memory grows with the DBC and not with the recording.
#[derive(Clone, Debug)]
pub struct BusTally {
    pub(super) signals: Vec<SignalTally>,
    messages: Vec<MessageTally>,
    last: Option<f64>,
    pub(super) known: u64,
    span: [f64; 2],
}

/// What is counted of one signal.
#[derive(Clone, Debug, Default)]
pub(super) struct SignalTally {
    pub count: u64,
    newest: Option<(f64, i128)>,
    intervals: Vec<f64>,
    pub low: f64,
    pub high: f64,
    steps: u64,
    counted: u64,
    /// Different raw values, up to [`FEW`] and one more.
    pub values: Vec<i128>,
}

/// What is counted of one message.
#[derive(Clone, Debug, Default)]
struct MessageTally {
    count: u64,
    newest: Option<f64>,
    /// Times without any frame before those of this message.
    before: Vec<f64>,
    intervals: Vec<f64>,
}

impl BusTally {
    /// An empty tally of the signals of `catalogue`.
    pub fn new(catalogue: &Catalogue<'_>) -> Self {
        Self {
            signals: vec![SignalTally::default(); catalogue.signals()],
            messages: vec![MessageTally::default(); catalogue.messages()],
            last: None,
            known: 0,
            span: [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Takes the next frame, `t` seconds after the first one.
    pub fn take(&mut self, catalogue: &Catalogue<'_>, t: f64, frame: &Frame) {
        self.span = [self.span[0].min(t), self.span[1].max(t)];
        let Some(message) = catalogue.message_of(frame) else { return };
        self.known += 1;
        let last = self.last.replace(t);
        self.messages[message].take(t, last);
        for (signal, value) in catalogue.values(message, frame) {
            self.signals[signal].take(t, value);
        }
    }

    /// Whether a frame of the DBC was among those taken.
    pub const fn is_known(&self) -> bool {
        self.known > 0
    }

    /// Time from the first frame to the last, s.
    pub fn length(&self) -> f64 {
        (self.span[1] - self.span[0]).max(0.0)
    }

    /// The usual time without a frame before those of a message, s.
    pub(super) fn gap(&self, message: usize) -> f64 {
        lower_median(&self.messages[message].before).unwrap_or(0.0)
    }

    /// The usual time from one frame of a message to the next, s.
    pub(super) fn period(&self, message: usize) -> Option<f64> {
        let MessageTally { count, intervals, .. } = &self.messages[message];
        lower_median(intervals).filter(|period| *count >= LEAST && *period > 0.0)
    }

    /// The message of this period that opens the cycles: the longest time without a frame is before it.
    pub(super) fn opener(&self, period: f64) -> Option<usize> {
        let of_period = |message: &usize| {
            self.period(*message).is_some_and(|other| (other / period - 1.0).abs() < SAME_PERIOD)
        };
        let messages = (0..self.messages.len()).filter(of_period);
        messages.max_by(|a, b| self.gap(*a).total_cmp(&self.gap(*b)))
    }

    /// The periods of the bus, s, each with its signals that change and do not count, most signals first.
    pub(super) fn classes(&self) -> Vec<(f64, Vec<usize>)> {
        let mut classes: Vec<(f64, Vec<usize>)> = Vec::new();
        for (place, signal) in self.signals.iter().enumerate() {
            let Some(period) = signal.period().filter(|_| signal.moves()) else { continue };
            let near =
                |class: &&mut (f64, Vec<usize>)| (class.0 / period - 1.0).abs() < SAME_PERIOD;
            match classes.iter_mut().find(near) {
                Some((_, signals)) => signals.push(place),
                None => classes.push((period, vec![place])),
            }
        }
        classes.sort_by_key(|(_, signals)| std::cmp::Reverse(signals.len()));
        classes
    }
}

impl MessageTally {
    fn take(&mut self, t: f64, last: Option<f64>) {
        self.count += 1;
        if let Some(last) = last.filter(|_| self.before.len() < KEPT) {
            self.before.push(t - last);
        }
        if let Some(newest) = self.newest.replace(t)
            && self.intervals.len() < KEPT
        {
            self.intervals.push(t - newest);
        }
    }
}

impl SignalTally {
    fn take(&mut self, t: f64, value: Value) {
        let number = value.physical;
        if !number.is_finite() {
            return;
        }
        // A float has no counts; its bits tell different values apart as well.
        let raw = value.raw.as_i128().unwrap_or(i128::from(number.to_bits()));
        if let Some((before, last)) = self.newest {
            if self.intervals.len() < KEPT {
                self.intervals.push(t - before);
            }
            self.steps += u64::from(raw != last);
            self.counted += u64::from(raw == last + 1 || raw == 0 && last > 0);
        } else {
            (self.low, self.high) = (number, number);
        }
        (self.low, self.high) = (self.low.min(number), self.high.max(number));
        if self.values.len() <= FEW && !self.values.contains(&raw) {
            self.values.push(raw);
        }
        self.newest = Some((t, raw));
        self.count += 1;
    }

    /// The usual time from one value to the next, s.
    pub fn period(&self) -> Option<f64> {
        lower_median(&self.intervals).filter(|period| self.count >= LEAST && *period > 0.0)
    }

    /// Whether it counts frames: one up with each of them.
    pub fn counts(&self) -> bool {
        let steps = self.count.saturating_sub(1);
        self.count >= LEAST && self.counted as f64 >= COUNTING * steps as f64
    }

    /// Whether it is a quantity that changes.
    pub fn moves(&self) -> bool {
        self.count >= LEAST && self.values.len() > FEW && !self.counts()
    }

    /// Whether it is always 0.
    pub fn is_zero(&self) -> bool {
        self.count > 0 && self.values == [0]
    }

    /// Whether it has a few values only.
    pub fn is_state(&self) -> bool {
        self.count > 0 && self.values.len() <= FEW
    }
}
