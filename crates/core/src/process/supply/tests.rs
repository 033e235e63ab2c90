use super::*;
use crate::alarm::Deadlines;
use crate::alarm::status::MAX_CYLINDERS;

const SAMPLE_TIME: f64 = 0.02;

/// Bar/s of each bar below 240, and bar/m of the rods.
const STIFFNESS: f64 = 0.8;
const TAKEN: [f64; 2] = [-7.5, -3.5];

fn relation() -> SupplyRelation {
    let q = |pressure: f64| STIFFNESS * (240.0 - pressure);
    SupplyRelation {
        reference: 230.0,
        taught: [220.0, 238.0],
        pump: [220.0, 226.0, 232.0, 238.0].map(q).to_vec(),
        taken: TAKEN,
        deviation: 0.15,
        dependence: [[1.0; WIDTHS.len()]; 2],
    }
}

fn watch() -> SupplyWatch {
    let (relation, sample_time) = (relation(), SAMPLE_TIME);
    SupplyWatch::new(SupplyDesign {
        relation,
        least: 90.0,
        deadlines: Deadlines::default(),
        level: 26.0,
        sample_time,
        clear: 50,
    })
}

/// An accumulator with a pump that gives up to `most` bar/s towards its set point, and one rod that swings by `swing` m.
struct Plant {
    pressure: f64,
    set_point: f64,
    most: f64,
    swing: f64,
    k: u32,
}

impl Plant {
    const fn new(swing: f64) -> Self {
        Self { pressure: 239.0, set_point: 240.0, most: 1e3, swing, k: 0 }
    }

    fn sample(&mut self) -> OilSample {
        let w = core::f64::consts::PI / 4.0;
        let t = SAMPLE_TIME * f64::from(self.k);
        let speed = self.swing * w * libm::cos(w * t);
        let taken = if speed > 0.0 { TAKEN[0] * speed } else { -TAKEN[1] * speed };
        let pumped = (STIFFNESS * (self.set_point - self.pressure)).clamp(0.0, self.most);
        let mut lengths = [0.0; MAX_CYLINDERS];
        lengths[0] = self.swing * libm::sin(w * t);
        let sample = OilSample { pressure: self.pressure, lengths };
        let rise = SAMPLE_TIME * (pumped + taken) / (230.0 * 230.0);
        self.pressure = 1.0 / (1.0 / self.pressure - rise);
        self.k += 1;
        sample
    }
}

/// Cycles until an alarm is raised, of at most so many.
fn raised(watch: &mut SupplyWatch, plant: &mut Plant, most: u32) -> Option<u32> {
    (0..most).find(|_| {
        let sample = plant.sample();
        watch.step(Some(&sample), true, Timestamp::default());
        watch.alarm().is_some()
    })
}

/// A watch that has seen this plant in health, for a minute.
fn warm(plant: &mut Plant) -> SupplyWatch {
    let mut watch = watch();
    assert_eq!(raised(&mut watch, plant, 3000), None);
    watch
}

#[test]
fn a_pump_that_gives_less_pressure_is_found_with_its_size_and_ends_with_it() {
    let mut plant = Plant::new(1.0);
    let mut watch = warm(&mut plant);
    plant.set_point -= 24.0;
    let delay = raised(&mut watch, &mut plant, 500).expect("it is found");
    assert!(delay < 75, "{delay} cycles");
    (0..1500).for_each(|_| watch.step(Some(&plant.sample()), true, Timestamp::default()));
    let alarm = watch.alarm().expect("it stands");
    assert_eq!(alarm.malfunction, Malfunction::Supply);
    let size = alarm.size.expect("it is known");
    assert!((size + 24.0).abs() < 1.5, "{size} bar");
    plant.set_point += 24.0;
    // Ten seconds of evidence, one in which it is over, and some in which the pressure comes back.
    let over = (0..800).find(|_| {
        watch.step(Some(&plant.sample()), true, Timestamp::default());
        watch.alarm().is_none()
    });
    assert!(over.is_some());
    // The windows that are longer still have it, and say so no more.
    assert_eq!(raised(&mut watch, &mut plant, 10_000), None);
}

/// In a rough sea the pressure falls below all that was taught, and the pump gives no more than it can.
#[test]
fn what_the_rods_take_is_no_fault_and_a_pump_that_gives_more_is_none() {
    let mut plant = Plant::new(4.0);
    plant.most = 16.0;
    let mut watch = watch();
    let mut lowest = f64::INFINITY;
    for _ in 0..10_000 {
        let sample = plant.sample();
        lowest = lowest.min(sample.pressure);
        watch.step(Some(&sample), true, Timestamp::default());
        assert_eq!(watch.alarm(), None, "{} bar", plant.pressure);
    }
    assert!(lowest < 217.0, "{lowest} bar");
    let mut plant = Plant::new(1.0);
    let mut watch = warm(&mut plant);
    plant.set_point += 24.0;
    assert_eq!(raised(&mut watch, &mut plant, 3000), None);
}

#[test]
fn nothing_is_judged_before_its_time_and_over_a_gap() {
    let mut plant = Plant::new(1.0);
    let mut watch = watch();
    let judged = |watch: &mut SupplyWatch, plant: &mut Plant, monitored, cycles: u32| {
        let count = (0..cycles).filter(|_| {
            watch.step(Some(&plant.sample()), monitored, Timestamp::default());
            watch.is_judging()
        });
        count.count()
    };
    assert_eq!(judged(&mut watch, &mut plant, false, 1000), 0);
    assert_eq!(judged(&mut watch, &mut plant, true, 508), 0);
    assert_eq!(judged(&mut watch, &mut plant, true, 100), 100);
    watch.lose();
    assert_eq!(judged(&mut watch, &mut plant, true, 9), 0);
    assert_eq!(judged(&mut watch, &mut plant, true, 1), 1);
    watch.interrupt();
    assert_eq!(judged(&mut watch, &mut plant, true, 508), 0);
}

#[test]
fn a_pump_gives_no_less_below_what_was_taught_and_goes_on_above() {
    let relation = relation();
    for (pressure, expected) in
        [(238.0, 1.6), (229.0, 8.8), (220.0, 16.0), (200.0, 16.0), (241.0, -0.8)]
    {
        let pumped = relation.pumped(pressure);
        assert!((pumped - expected).abs() < 1e-9, "{pressure} bar: {pumped} bar/s");
    }
}

/// P V is constant: as much oil makes as much of 1/P, whatever the pressure.
#[test]
fn as_much_oil_counts_as_much_at_any_pressure() {
    let (gas, oil) = (240.0 * 0.6, 2e-3);
    for pressure in [240.0, 200.0, 150.0] {
        let after = gas / (gas / pressure + oil);
        let block = OilBlock { pressures: [pressure, after], ways: [0.0; 2], follows: true };
        let expected = -230.0 * 230.0 * oil / gas;
        assert!((block.rise(230.0) - expected).abs() < 1e-9, "{pressure} bar");
    }
}

#[test]
fn what_came_before_a_gap_is_no_evidence_after_it() {
    let mut plant = Plant::new(1.0);
    let mut watch = warm(&mut plant);
    plant.set_point -= 24.0;
    for _ in 0..20 {
        watch.lose();
        // Three blocks, one less than the shortest window has.
        assert_eq!(raised(&mut watch, &mut plant, 40), None);
    }
    assert!(raised(&mut watch, &mut plant, 100).is_some());
}
