//! Census of each cylinder's data in a recording, and whether the signals can be what they are
//! configured as.

use super::moments::{Pair, Spread};
use super::refusal::IdentificationRefusal;
use super::shaper::Sources;
use crate::survey::{Row, Surveyor};
use tertius_core::sample::Quality;

/// Least motion for an identification, mm: some fifty counts of a 16-bit transducer.
const LEAST_MOTION: f64 = 5.0;

/// Factor of the noise beyond which two signals that should be equal differ.
const SAME: f64 = 3.0;

/// Largest gain of a command, which may be a speed, a voltage or a percentage.
const PLAUSIBLE_GAIN: f64 = 300.0;

/// Highest plausible pressure, bar; hydraulics end at some hundred.
const HIGHEST_PRESSURE: f64 = 2000.0;

/// Fewest cycles of a correlation that is used.
const ENOUGH: u64 = 250;

/// What the configuration says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expectations {
    /// Sample time Ts, s.
    pub sample_time: f64,
    pub area_ratio: f64,
    /// Whether a velocity of C1 is configured.
    pub velocity: bool,
    /// Whether a load pressure is configured.
    pub pressure: bool,
    /// Whether each cylinder has a C2.
    pub seconds: Vec<bool>,
    /// a and b of (5-20) for each cylinder, where it is calibrated.
    pub calibrations: Vec<Option<(f64, f64)>>,
}

/// Counts of one cylinder, over its monitored cycles, except `rows`, which counts all.
#[derive(Clone, Debug, Default)]
pub struct Counted {
    pub rows: u64,
    pub monitored: u64,
    /// Positions of C1 that came but were not plausible, by [`Quality`].
    pub implausible: [u64; Quality::COUNT],
    pub position: Spread,
    pub velocity: Spread,
    pub command: Spread,
    pub pressure: Spread,
    /// C1 as received, plausible or not.
    pub raw: Spread,
    /// Recorded velocity over the position's slope.
    velocity_of_slope: Pair,
    /// Slope of the position over the command.
    slope_of_command: Pair,
    /// C1 − (a C2 + b), and C2 − (a C1 + b).
    as_given: Spread,
    swapped: Spread,
    /// Row of the previous cycle.
    last: Option<Row>,
    /// Position before the previous cycle.
    before: Option<f64>,
}

/// The first pass, over every cylinder.
#[derive(Clone, Debug)]
pub struct Census {
    expected: Expectations,
    cylinders: Vec<Counted>,
    /// Cycle, command and slope of each cylinder, correlated when the next cycle comes.
    newest: Vec<Option<(u64, f64, f64)>>,
    cycle: u64,
    /// Command of one cylinder with the slope of another, row by row.
    crossed: Vec<Pair>,
}

impl Census {
    /// A census of `count` cylinders.
    pub fn new(count: usize, expected: Expectations) -> Self {
        Self {
            expected,
            cylinders: vec![Counted::default(); count],
            newest: vec![None; count],
            cycle: 0,
            crossed: vec![Pair::default(); count * count],
        }
    }

    pub fn cylinders(&self) -> &[Counted] {
        &self.cylinders
    }

    /// Sources of velocity and load pressure of the cylinder of `index` (from 0): the recorded
    /// signals if at least half of the cycles with a position have them.
    pub fn sources(&self, index: usize) -> Sources {
        let counted = &self.cylinders[index];
        let half = counted.position.count / 2;
        Sources {
            velocity: self.expected.velocity && counted.velocity.count > half,
            pressure: self.expected.pressure && counted.pressure.count > half,
        }
    }

    /// Checks whether the cylinder of `index` can be identified.
    ///
    /// # Errors
    /// What is wrong with its data.
    pub fn judge(&self, index: usize) -> Result<(), IdentificationRefusal> {
        let counted = &self.cylinders[index];
        let sources = self.sources(index);
        counted.presence()?;
        counted.excitation(sources)?;
        counted.units(sources)?;
        let range_mm = counted.position.range() * 1e3;
        if range_mm < LEAST_MOTION {
            return Err(IdentificationRefusal::HardlyMoves { range_mm, least_mm: LEAST_MOTION });
        }
        counted.transducers()?;
        self.neighbours(index)
    }

    /// Remarks on a cylinder that can be identified.
    pub fn remarks(&self, index: usize) -> Vec<String> {
        let (counted, sources) = (&self.cylinders[index], self.sources(index));
        let mut remarks = Vec::new();
        if !sources.velocity {
            let why = if self.expected.velocity {
                "its velocity is configured, but hardly ever came"
            } else {
                "no velocity is recorded"
            };
            remarks.push(format!(
                "{why}: it is the slope of the position over five cycles (Savitzky-Golay, no shift \
                 in phase)"
            ));
        }
        if !sources.pressure {
            let why = if self.expected.pressure {
                "its pressures are configured, but hardly ever came"
            } else {
                "no load pressure is recorded"
            };
            remarks.push(format!(
                "{why}: the model is reduced to position and velocity (theta 3, 4 and gamma 2 are 0, \
                 theta 5 is -1)"
            ));
        }
        let implausible: u64 = counted.implausible[3..].iter().sum();
        if implausible > 0 {
            remarks.push(format!("{implausible} readings of C1 were not plausible and left out"));
        }
        let is_alone = self.expected.seconds.get(index) == Some(&false);
        if !is_alone && self.expected.calibrations.get(index).copied().flatten().is_none() {
            remarks.push(
                "whether C1 and C2 are swapped cannot be told without a calibration (c2_gain, \
                 c2_offset)"
                    .to_owned(),
            );
        }
        remarks
    }

    fn correlate(&mut self) {
        let count = self.cylinders.len();
        for i in 0..count {
            let Some((_, command, _)) = self.newest[i].filter(|(cycle, ..)| *cycle == self.cycle)
            else {
                continue;
            };
            for j in 0..count {
                if let Some((cycle, _, slope)) = self.newest[j]
                    && cycle == self.cycle
                {
                    self.crossed[i * count + j].add(command, slope);
                }
            }
        }
    }

    /// Correlation of the command of one cylinder with the motion of another.
    fn correlation(&self, command: usize, motion: usize) -> f64 {
        let pair = &self.crossed[command * self.cylinders.len() + motion];
        pair.correlation().filter(|_| pair.count() >= ENOUGH).unwrap_or(0.0)
    }

    /// The cylinder whose command the motion of the cylinder of `index` follows much more closely
    /// than its own.
    fn stranger(&self, index: usize) -> Option<usize> {
        let with = |command: usize| self.correlation(command, index);
        let best = (0..self.cylinders.len()).max_by(|i, j| with(*i).total_cmp(&with(*j)))?;
        let by_far = 1.0 - with(best) < 0.5 * (1.0 - with(index));
        (best != index && with(best) > 0.5 && by_far).then_some(best)
    }

    /// Checks that the cylinder of `index` follows its own command.
    fn neighbours(&self, index: usize) -> Result<(), IdentificationRefusal> {
        let Some(other) = self.stranger(index) else { return Ok(()) };
        // Neighbours move alike, one behind the other, and a motion is behind its command: so it may
        // be nearest to the command of the cylinder behind. Where commands are swapped the other one,
        // too, follows a stranger, and so on round to this one.
        let mut way = std::iter::successors(Some(other), |at| self.stranger(*at));
        if way.by_ref().take(self.cylinders.len()).all(|at| at != index) {
            return Ok(());
        }
        Err(IdentificationRefusal::SwappedCylinders {
            other: other as u8 + 1,
            with_other: self.correlation(other, index),
            with_own: self.correlation(index, index),
        })
    }
}

impl Surveyor for Census {
    fn row(&mut self, row: &Row) {
        let index = usize::from(row.cylinder) - 1;
        if row.cycle != self.cycle {
            self.correlate();
            self.cycle = row.cycle;
        }
        let slope = self.cylinders[index].take(row, &self.expected);
        // The slope is that of the cycle before; in the next one both are a cycle late together.
        self.newest[index] = slope.map(|(command, slope)| (row.cycle, command, slope));
    }

    fn gap(&mut self, cylinder: u8) {
        let counted = &mut self.cylinders[usize::from(cylinder) - 1];
        (counted.last, counted.before) = (None, None);
    }
}

impl Counted {
    /// Counts a row; returns command and slope of the cycle before it, where they are known.
    fn take(&mut self, row: &Row, expected: &Expectations) -> Option<(f64, f64)> {
        self.rows += 1;
        if !row.monitored {
            (self.last, self.before) = (None, None);
            return None;
        }
        self.monitored += 1;
        let add = |spread: &mut Spread, value: Option<f64>| {
            if let Some(value) = value.filter(|value| value.is_finite()) {
                spread.add(value);
            }
        };
        add(&mut self.position, row.c1);
        add(&mut self.velocity, row.v1);
        add(&mut self.command, row.u);
        add(&mut self.pressure, row.load_pressure(expected.area_ratio));
        add(&mut self.raw, row.raw[0]);
        self.implausible[row.qualities[0] as usize] += 1;
        let calibration = expected.calibrations.get(usize::from(row.cylinder) - 1);
        if let (Some((c1, c2)), Some(Some((a, b)))) = (row.c1.zip(row.c2), calibration) {
            self.as_given.add(c1 - (a * c2 + b));
            self.swapped.add(c2 - (a * c1 + b));
        }
        let middle = self.last.replace(*row);
        let before = std::mem::replace(&mut self.before, middle.and_then(|middle| middle.c1));
        let slope = (row.c1? - before?) / (2.0 * expected.sample_time);
        let middle = middle?;
        if let Some(velocity) = middle.v1.filter(|velocity| velocity.is_finite()) {
            self.velocity_of_slope.add(slope, velocity);
        }
        self.slope_of_command.add(middle.u?, slope);
        Some((middle.u?, slope))
    }

    fn presence(&self) -> Result<(), IdentificationRefusal> {
        let rows = self.monitored;
        if self.rows == 0 {
            return Err(IdentificationRefusal::Absent);
        }
        if rows == 0 {
            return Err(IdentificationRefusal::NeverMonitored { rows: self.rows });
        }
        let signals = [("the position C1", &self.position), ("the command", &self.command)];
        for (signal, spread) in signals {
            let missing = rows - spread.count;
            if missing > rows / 2 {
                let detail = if signal == "the command" { String::new() } else { self.detail() };
                return Err(IdentificationRefusal::Missing { signal, missing, rows, detail });
            }
        }
        Ok(())
    }

    /// What became of the readings of C1, in words.
    fn detail(&self) -> String {
        let of = |quality: Quality| self.implausible[quality as usize];
        let (low, high) = (self.raw.low, self.raw.high);
        let mut parts: Vec<String> = Vec::new();
        if of(Quality::OutOfRange) > 0 {
            let mut part =
                format!("{} out of range, from {low:.3} to {high:.3} m", of(Quality::OutOfRange));
            if self.raw.largest > 20.0 {
                part += "; are they in millimetres, a factor of 1000?";
            }
            parts.push(part);
        }
        for (quality, name) in [
            (Quality::BrokenWire, "with a broken wire"),
            (Quality::Frozen, "frozen"),
            (Quality::Stale, "stale"),
            (Quality::Failed, "of a device that says it is faulty"),
            (Quality::NotOperational, "missing from a device that is not operational"),
        ] {
            if of(quality) > 0 {
                parts.push(format!("{} {name}", of(quality)));
            }
        }
        if parts.is_empty() { String::new() } else { format!(": {}", parts.join(", ")) }
    }

    fn excitation(&self, sources: Sources) -> Result<(), IdentificationRefusal> {
        let signals = [
            (true, "the command", &self.command, "m/s"),
            (true, "the position C1", &self.position, "m"),
            (sources.velocity, "the velocity of C1", &self.velocity, "m/s"),
            (sources.pressure, "the load pressure", &self.pressure, "bar"),
        ];
        for (used, signal, spread, unit) in signals {
            if used && spread.range() <= 0.0 {
                let (value, rows) = (spread.mean, spread.count);
                return Err(IdentificationRefusal::Constant { signal, value, unit, rows });
            }
        }
        Ok(())
    }

    fn units(&self, sources: Sources) -> Result<(), IdentificationRefusal> {
        let enough = |pair: &Pair| pair.count() >= ENOUGH;
        let together = |pair: &Pair| pair.correlation().unwrap_or(0.0);
        let pair = &self.velocity_of_slope;
        if sources.velocity
            && enough(pair)
            && let Some(ratio) = pair.ratio()
        {
            let factor = ratio * together(pair).signum();
            let same = (1.0 / SAME..SAME).contains(&factor);
            if together(pair).abs() > 0.3 && !same {
                let (signal, reference) = ("the velocity of C1", "the position's slope");
                return Err(IdentificationRefusal::Unit {
                    signal,
                    reference,
                    factor,
                    guess: guess(factor),
                });
            }
        }
        let pair = &self.slope_of_command;
        if enough(pair)
            && together(pair).abs() > 0.3
            && let Some(gain) = pair.ratio()
            && !(1.0 / PLAUSIBLE_GAIN..PLAUSIBLE_GAIN).contains(&gain)
        {
            let factor = 1.0 / gain;
            let (signal, reference) = ("the command", "the motion that follows it");
            return Err(IdentificationRefusal::Unit {
                signal,
                reference,
                factor,
                guess: guess(factor),
            });
        }
        if sources.pressure && self.pressure.largest > HIGHEST_PRESSURE {
            return Err(IdentificationRefusal::PressureUnit { largest: self.pressure.largest });
        }
        Ok(())
    }

    fn transducers(&self) -> Result<(), IdentificationRefusal> {
        let (as_given_mm, swapped_mm) = (self.as_given.rms() * 1e3, self.swapped.rms() * 1e3);
        let enough = self.as_given.count >= ENOUGH;
        if enough && swapped_mm < 0.5 * as_given_mm && as_given_mm - swapped_mm > 0.5 {
            return Err(IdentificationRefusal::SwappedTransducers { as_given_mm, swapped_mm });
        }
        Ok(())
    }
}

/// A possible origin of a factor between two units.
fn guess(factor: f64) -> String {
    if factor < 0.0 {
        return ": its sign is the other way round".to_owned();
    }
    let power = factor.log10();
    let near = power.round();
    if near == 0.0 || (power - near).abs() > 0.18 {
        return String::new();
    }
    let times = 10_f64.powf(near.abs());
    format!(", about a factor of {}{times}", if near < 0.0 { "1/" } else { "" })
}
