//! The attitude sensor on the transfer deck.

use crate::hexapod::{Hexapod, LEGS, Pose};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use std::collections::VecDeque;

/// The errors of the sensor; all of them 0 without a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TopTable {
    /// What it reads while the deck is level: roll and pitch, rad.
    #[serde(default)]
    pub offset: [f64; 2],
    /// Standard deviation of an error that differs from reading to reading, rad.
    pub noise: f64,
    /// Standard deviation, rad, and time constant, s, of an error that comes and goes.
    #[serde(default)]
    pub wander: f64,
    #[serde(default)]
    pub wander_time: f64,
    /// Time between two readings, s; what is sent in between is the newest one. At 0 it reads in every cycle.
    #[serde(default)]
    pub period: f64,
    /// How old a reading is, s.
    #[serde(default)]
    pub latency: f64,
}

/// The sensor at work.
#[derive(Clone, Debug)]
pub struct TopSensor {
    table: TopTable,
    rng: ChaCha8Rng,
    sample_time: f64,
    deck: Pose,
    /// Roll and pitch of the deck in this cycle and as many before as the latency takes.
    trail: VecDeque<[f64; 2]>,
    wander: [f64; 2],
    cycle: u64,
    reading: [f64; 2],
}

impl TopSensor {
    pub fn new(table: TopTable, hexapod: &Hexapod, sample_time: f64, mut rng: ChaCha8Rng) -> Self {
        let wander = [0, 1].map(|_| table.wander * normal(&mut rng));
        Self {
            table,
            rng,
            sample_time,
            deck: hexapod.neutral(),
            trail: VecDeque::new(),
            wander,
            cycle: 0,
            reading: [0.0; 2],
        }
    }

    /// Roll and pitch, rad, with the base at `base` and these true strokes, m; called once a cycle. Strokes that no pose
    /// has leave the deck where it was.
    pub fn read(&mut self, hexapod: &Hexapod, base: &Pose, strokes: &[f64; LEGS]) -> [f64; 2] {
        let TopTable { offset, noise, wander, wander_time, period, latency } = self.table;
        if let Ok(solution) = hexapod.forward(strokes, &self.deck) {
            self.deck = solution.pose;
        }
        let turned = base.rotation() * self.deck.rotation();
        let roll = turned[(2, 1)].atan2(turned[(2, 2)]);
        self.trail.push_front([roll, -turned[(2, 0)].asin()]);
        let cycles = |seconds: f64| (seconds / self.sample_time).round() as usize;
        self.trail.truncate(cycles(latency) + 1);
        if wander > 0.0 {
            let left = (-self.sample_time / wander_time).exp();
            let new = wander * (1.0 - left * left).sqrt();
            self.wander = self.wander.map(|it| left * it + new * normal(&mut self.rng));
        }
        if self.cycle.is_multiple_of(cycles(period).max(1) as u64) {
            let old = *self.trail.back().expect("the newest is in it");
            self.reading = std::array::from_fn(|axis| {
                old[axis] + offset[axis] + self.wander[axis] + noise * normal(&mut self.rng)
            });
        }
        self.cycle += 1;
        self.reading
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hexapod::Geometry;
    use rand::SeedableRng;

    const GEOMETRY: Geometry = Geometry {
        base_radius: 2.9,
        base_half_angle: 0.12,
        top_radius: 2.3,
        top_half_angle: 0.14,
        neutral_height: 4.2,
        reach: [-1.5, 1.5],
    };

    fn sensor(table: TopTable) -> (Hexapod, TopSensor) {
        let hexapod = Hexapod::new(&GEOMETRY);
        let sensor = TopSensor::new(table, &hexapod, 0.02, ChaCha8Rng::seed_from_u64(1));
        (hexapod, sensor)
    }

    #[test]
    fn it_reads_how_the_deck_stands_and_not_how_the_vessel_does() {
        let (hexapod, mut sensor) = sensor(TopTable::default());
        let base = Pose::new([0.1, 0.2, 0.3], [0.03, -0.02, 0.05]);
        let deck = Pose::new([0.0, 0.0, 4.2], [0.004, -0.006, 0.0]);
        let strokes = hexapod.inverse(&base, &deck).expect("it is within reach");
        let [roll, pitch] = sensor.read(&hexapod, &base, &strokes);
        assert!((roll - 0.004).abs() < 1e-9 && (pitch + 0.006).abs() < 1e-9, "{roll}, {pitch}");
    }

    #[test]
    fn its_readings_are_late_rare_and_off() {
        let table =
            TopTable { latency: 0.04, period: 0.1, offset: [1e-3, 0.0], ..TopTable::default() };
        let (hexapod, mut sensor) = sensor(table);
        let level = |sensor: &mut TopSensor, roll: f64| {
            let deck = Pose::new([0.0, 0.0, 4.2], [roll, 0.0, 0.0]);
            let strokes = hexapod.inverse(&Pose::default(), &deck).expect("it is within reach");
            sensor.read(&hexapod, &Pose::default(), &strokes)[0]
        };
        let read: Vec<f64> = (0..11).map(|k| level(&mut sensor, 1e-3 * f64::from(k))).collect();
        let near = |k: usize, roll: f64| (read[k] - roll).abs() < 1e-9;
        // The first reading, then those of cycles 5 and 10, each two cycles old.
        assert!((0..5).all(|k| near(k, 1e-3)), "{read:?}");
        assert!((5..10).all(|k| near(k, 4e-3)) && near(10, 9e-3), "{read:?}");
    }
}
