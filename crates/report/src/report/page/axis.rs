//! Axes: their ranges, ticks and labels.

use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Linear,
    /// Logarithmic.
    Log,
    /// Seconds, written as hours, minutes and seconds.
    Clock,
}

/// One axis of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    pub label: String,
    low: f64,
    high: f64,
    kind: Kind,
    /// Most ticks.
    most: usize,
}

/// Steps of a clock, s.
const CLOCK_STEPS: [f64; 22] = [
    0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0,
    900.0, 1800.0, 3600.0, 7200.0, 14_400.0, 21_600.0,
];

/// Least number of ticks by which a scale can be read.
const FEWEST: f64 = 3.0;

const DAY: f64 = 86_400.0;

impl Axis {
    /// A linear axis from `low` to `high`, widened where they are equal or not numbers.
    pub fn linear(label: &str, low: f64, high: f64) -> Self {
        Self::new(label, low, high, Kind::Linear)
    }

    /// An axis of time, s.
    pub fn clock(label: &str, low: f64, high: f64) -> Self {
        Self::new(label, low, high, Kind::Clock)
    }

    /// A logarithmic axis from `low` to `high`, both above 0; at least one decade.
    pub fn log(label: &str, low: f64, high: f64) -> Self {
        let sound = low > 0.0 && high >= low && high < 1e300;
        let (low, high) = if sound { (low, high.max(10.0 * low)) } else { (0.1, 10.0) };
        Self::new(label, low, high, Kind::Log)
    }

    /// A linear axis over all of `values` with a margin; values that are not finite are ignored.
    pub fn over(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let mut ends: Option<(f64, f64)> = None;
        for value in values.into_iter().filter(|value| value.is_finite()) {
            ends = Some(ends.map_or((value, value), |(a, b)| (a.min(value), b.max(value))));
        }
        let (low, high) = ends.unwrap_or((-1.0, 1.0));
        let room = 0.06 * (high - low);
        Self::linear(label, low - room, high + room)
    }

    fn new(label: &str, low: f64, high: f64, kind: Kind) -> Self {
        let sound = low.is_finite() && high.is_finite() && low <= high;
        let (mut low, mut high) = if sound { (low, high) } else { (0.0, 1.0) };
        if high - low <= 1e-12 * high.abs().max(low.abs()) {
            let room = (0.5 * high.abs()).max(1e-3);
            (low, high) = (low - room, high + room);
        }
        Self { label: label.to_owned(), low, high, kind, most: 8 }
    }

    /// This axis with at most `most` ticks.
    #[must_use]
    pub fn with_ticks(mut self, most: usize) -> Self {
        self.most = most.max(2);
        self
    }

    pub const fn low(&self) -> f64 {
        self.low
    }

    pub const fn high(&self) -> f64 {
        self.high
    }

    /// Whether `value` is within the axis, and not drawn at its border.
    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Relative position of `value`: 0 is the lower end, 1 the upper one.
    fn part(&self, value: f64) -> f64 {
        match self.kind {
            Kind::Log if value <= 0.0 => 0.0,
            Kind::Log => (value / self.low).log10() / (self.high / self.low).log10(),
            _ => (value - self.low) / (self.high - self.low),
        }
    }

    /// Values of the ticks.
    pub fn ticks(&self) -> Vec<f64> {
        if self.kind == Kind::Log {
            let place = |value: f64, room: f64| (value.log10() + room).floor() as i32;
            // The first that is not below the end, the last that is not above.
            let (low, high) = (-place(1.0 / self.low, 1e-9), place(self.high, 1e-9));
            let step = high.saturating_sub(low).unsigned_abs() as usize / self.most + 1;
            return (low..=high).step_by(step).map(|decade| 10_f64.powi(decade)).collect();
        }
        let step = self.step();
        let (first, last) = ((self.low / step).ceil(), (self.high / step).floor());
        let count = (last - first).clamp(0.0, 2.0 * self.most as f64) as usize;
        (0..=count).map(|k| (first + k as f64) * step).filter(|tick| self.holds(*tick)).collect()
    }

    /// Distance between ticks: small enough that the axis can be read, within the limit of their
    /// number.
    fn step(&self) -> f64 {
        let least = (self.high - self.low) / self.most as f64;
        let step = self.round(least);
        let count = (self.high / step).floor() - (self.low / step).ceil() + 1.0;
        if count < FEWEST { self.round(step / 2.6) } else { step }
    }

    /// The next round step that is at least `least`.
    fn round(&self, least: f64) -> f64 {
        if self.kind == Kind::Clock && least > CLOCK_STEPS[0] {
            let known = CLOCK_STEPS.iter().copied().find(|step| *step >= least);
            return known.unwrap_or_else(|| nice(least / DAY) * DAY);
        }
        nice(least)
    }

    /// Label of the tick `value`.
    pub fn text(&self, value: f64) -> String {
        match self.kind {
            Kind::Linear => decimal(value, self.step()),
            Kind::Clock => clock(value, self.step()),
            Kind::Log => {
                let decade = value.log10().round() as i32;
                match decade {
                    0..=3 => format!("{}", 10_i32.pow(decade.unsigned_abs())),
                    -3..0 => format!("{:.*}", decade.unsigned_abs() as usize, value),
                    _ => format!("10{}", raised(decade)),
                }
            }
        }
    }
}

/// The next of 1, 2, 5, 10, … that is at least `least`.
fn nice(least: f64) -> f64 {
    let unit = 10_f64.powf(least.log10().floor());
    let times = [1.0, 2.0, 5.0].into_iter().find(|times| times * unit >= least * (1.0 - 1e-9));
    times.unwrap_or(10.0) * unit
}

/// `value` with as many decimals as `step` has.
fn decimal(value: f64, step: f64) -> String {
    let places = (-(step.log10() + 1e-9).floor()).clamp(0.0, 9.0) as usize;
    let value = if value.abs() < 1e-6 * step { 0.0 } else { value };
    format!("{value:.places$}").replace('-', "−")
}

/// Hours, minutes and seconds, with as many decimals as `step` has.
fn clock(value: f64, step: f64) -> String {
    let places = (-(step.log10() + 1e-9).floor()).clamp(0.0, 3.0) as usize;
    let unit = 10_f64.powi(places as i32);
    let count = (value.abs() * unit).round();
    let sign = if value < 0.0 && count > 0.0 { "−" } else { "" };
    let seconds = count / unit;
    let (hours, minutes) = ((seconds / 3600.0).floor(), (seconds / 60.0).floor() % 60.0);
    let rest = seconds - 60.0 * (seconds / 60.0).floor();
    let width = if places == 0 { 2 } else { places + 3 };
    if hours > 0.0 {
        return format!("{sign}{hours}:{minutes:02}:{rest:0width$.places$}");
    }
    format!("{sign}{minutes}:{rest:0width$.places$}")
}

/// An integer as an exponent.
fn raised(number: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // The others follow each other.
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    number.to_string().chars().map(digit).collect()
}

impl Ranged for Axis {
    type ValueType = f64;
    type FormatOption = DefaultFormatting;

    /// Maps a value to the drawing; values beyond an end are drawn at it.
    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let part = self.part(*value).clamp(0.0, 1.0);
        from + (part * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks()
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|tick| axis.text(tick)).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(
            texts(&Axis::linear("", -1.3, 1.3).with_ticks(6)),
            ["−1.0", "−0.5", "0.0", "0.5", "1.0"]
        );
        assert_eq!(
            texts(&Axis::linear("", 0.0, 1e-3).with_ticks(3)),
            ["0.0000", "0.0005", "0.0010"]
        );
        assert_eq!(texts(&Axis::log("", 0.5, 20_000.0)), ["1", "10", "100", "1000", "10⁴"]);
        assert_eq!(texts(&Axis::log("", 1e-13, 1e-2).with_ticks(4))[0], "10⁻¹³");
        assert_eq!(
            texts(&Axis::clock("", 0.0, 480.0).with_ticks(5)),
            ["0:00", "2:00", "4:00", "6:00", "8:00"]
        );
        assert_eq!(
            texts(&Axis::clock("", 3599.0, 3601.0).with_ticks(4)),
            ["59:59.0", "59:59.5", "1:00:00.0", "1:00:00.5", "1:00:01.0"]
        );
        assert_eq!(
            texts(&Axis::clock("", -1.0, 0.0).with_ticks(2)),
            ["−0:01.0", "−0:00.5", "0:00.0"]
        );
    }

    /// Steps of 5 would leave 0 alone; those of 2 do not.
    #[test]
    fn there_are_enough_ticks_to_read_it() {
        for k in 1..500 {
            let end = 0.013 * f64::from(k);
            for axis in [Axis::linear("", -end, end), Axis::clock("", 60.0 - end, 60.0 + end)] {
                for most in [4, 5, 9] {
                    let ticks = axis.clone().with_ticks(most).ticks().len();
                    assert!((3..=2 * most).contains(&ticks), "±{end}: {ticks} of {most}");
                }
            }
        }
    }

    /// For any values there is an axis with few ticks.
    #[test]
    fn degenerate_axes_are_axes() {
        let inf = f64::INFINITY;
        for (low, high) in
            [(1.0, 1.0), (0.0, 0.0), (f64::NAN, 1.0), (-inf, inf), (2.0, 1.0), (1e300, 1e300)]
        {
            for axis in
                [Axis::linear("", low, high), Axis::clock("", low, high), Axis::log("", low, high)]
            {
                assert!(axis.low() < axis.high(), "{axis:?}");
                assert!(axis.ticks().len() <= 17, "{axis:?}");
                assert!((0..=100).contains(&axis.map(&f64::NAN, (0, 100))));
                texts(&axis);
            }
        }
        assert_eq!(Axis::over("", [f64::NAN]).low(), -1.06 - 0.06);
    }

    #[test]
    fn what_is_beyond_is_drawn_at_the_end() {
        let axis = Axis::linear("", -1.0, 1.0);
        let places = [-5.0, -1.0, 0.0, 1.0, 7.0].map(|value| axis.map(&value, (200, 0)));
        assert_eq!(places, [200, 200, 100, 0, 0]);
        let decades = Axis::log("", 1.0, 100.0);
        assert_eq!(
            [0.0, 1.0, 10.0, 100.0].map(|value| decades.map(&value, (0, 100))),
            [0, 0, 50, 100]
        );
    }
}
