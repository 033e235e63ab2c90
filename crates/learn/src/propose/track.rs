//! The second pass over a recording: the values of signals of one period, cycle by cycle.

use super::catalogue::Catalogue;
use tertius_core::frame::Frame;

/// Most cycles that are kept: ten minutes at 100 Hz.
pub(super) const MOST_CYCLES: usize = 60_000;

/// Part of a period after the end of a cycle at which a lost opening is given up.
const PATIENCE: f64 = 1.4;

/// Distance from the median, in half of that from the twentieth part to the last twentieth part of all values, beyond
/// which a value is no reading.
const WILD: f64 = 12.0;

/// The values of chosen signals, one for each cycle.
#[derive(Clone, Debug)]
pub struct Tracks {
    /// Time between cycles, s.
    pub(super) period: f64,
    /// Message whose frames open a cycle.
    opener: usize,
    /// Time of the first opening.
    begun: Option<f64>,
    /// Time of the last opening and its cycle.
    opened: Option<(f64, usize)>,
    /// Place of each signal in `values`.
    places: Vec<Option<usize>>,
    /// Values by signal and cycle; NaN where there is none.
    values: Vec<Vec<f32>>,
    /// Sum of the times from the opening to the frames of each message, cycles, and their number.
    delays: Vec<(f64, u32)>,
}

impl Tracks {
    /// Empty tracks of `signals`.
    pub(super) fn new(
        catalogue: &Catalogue<'_>,
        period: f64,
        opener: usize,
        signals: &[usize],
    ) -> Self {
        let mut places = vec![None; catalogue.signals()];
        for (place, signal) in signals.iter().enumerate() {
            places[*signal] = Some(place);
        }
        Self {
            period,
            opener,
            begun: None,
            opened: None,
            places,
            values: vec![Vec::new(); signals.len()],
            delays: vec![(0.0, 0); catalogue.messages()],
        }
    }

    /// Takes the next frame, `t` seconds after the first one.
    pub fn take(&mut self, catalogue: &Catalogue<'_>, t: f64, frame: &Frame) {
        let Some(message) = catalogue.message_of(frame) else { return };
        if message == self.opener {
            let cycle = self.opened.map_or(0, |(last, cycle)| {
                cycle + ((t - last) / self.period).round().clamp(1.0, MOST_CYCLES as f64) as usize
            });
            self.begun.get_or_insert(t);
            self.opened = Some((t, cycle));
        }
        let Some((last, opened)) = self.opened else { return };
        let late = (t - last) / self.period;
        let lost = if late > PATIENCE { late.min(MOST_CYCLES as f64) as usize } else { 0 };
        let cycle = opened + lost;
        if cycle >= MOST_CYCLES {
            return;
        }
        let (sum, count) = &mut self.delays[message];
        (*sum, *count) = (*sum + late - lost as f64, *count + 1);
        for (signal, value) in catalogue.values(message, frame) {
            let Some(place) = self.places[signal] else { continue };
            let track = &mut self.values[place];
            if track.len() <= cycle {
                track.resize(cycle + 1, f32::NAN);
            }
            track[cycle] = value.physical as f32;
        }
    }

    /// The time between cycles on average, s.
    pub(super) fn mean_period(&self) -> f64 {
        match (self.begun, self.opened) {
            (Some(first), Some((last, cycles))) if cycles > 0 => (last - first) / cycles as f64,
            _ => self.period,
        }
    }

    /// The usual time from the opening of a cycle to a signal's frame, cycles.
    pub(super) fn delay(&self, catalogue: &Catalogue<'_>, signal: usize) -> f64 {
        let (sum, count) = self.delays[catalogue.signals[signal].message];
        if count > 0 { sum / f64::from(count) } else { 0.0 }
    }

    /// The message that opens the cycles.
    pub(super) const fn opener(&self) -> usize {
        self.opener
    }

    /// The signals, by their numbers.
    pub(super) fn signals(&self) -> impl Iterator<Item = usize> {
        self.places.iter().enumerate().filter_map(|(signal, place)| place.map(|_| signal))
    }

    fn raw(&self, signal: usize) -> &[f32] {
        self.places[signal].map_or(&[], |place| &self.values[place])
    }

    /// Number of cycles.
    pub(super) fn cycles(&self) -> usize {
        self.values.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// A signal's values without those that cannot be readings, as of a broken wire; NaN where there is none.
    pub(super) fn clean(&self, signal: usize) -> Vec<f64> {
        let raw = self.raw(signal);
        let mut sorted: Vec<f32> = raw.iter().copied().filter(|it| it.is_finite()).collect();
        sorted.sort_by(f32::total_cmp);
        let at = |part: f64| {
            let place = (part * sorted.len() as f64) as usize;
            sorted.get(place).map_or(0.0, |it| f64::from(*it))
        };
        let (middle, reach) = (at(0.5), WILD * (at(0.95) - at(0.05)) / 2.0);
        let sound = |value: f64| (value - middle).abs() <= reach;
        let mut clean: Vec<f64> = raw.iter().map(|it| f64::from(*it)).collect();
        clean.iter_mut().filter(|it| !sound(**it)).for_each(|it| *it = f64::NAN);
        clean.resize(self.cycles(), f64::NAN);
        clean
    }

    /// A signal's values, held until the next one.
    pub(super) fn held(&self, signal: usize) -> Vec<f64> {
        let mut newest = f64::NAN;
        let raw = self.raw(signal);
        let value = |cycle: usize| raw.get(cycle).copied().filter(|it| it.is_finite());
        (0..self.cycles())
            .map(|cycle| {
                newest = value(cycle).map_or(newest, f64::from);
                newest
            })
            .collect()
    }
}
