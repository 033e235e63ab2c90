//! Incidents of the machine: one supply, one bus; and how soon the machine trips.

use crate::process::TAUGHT;
use tertius::alarm::{Detector, Level, State, Warning};
use tertius::frame::Frame;
use tertius::incident::{Incident, Progress, Scope};
use tertius::monitor::{Monitor, Sink};
use tertius::verdict::{Fault, Suspect};

/// What is told of a machine.
#[derive(Default)]
struct Told {
    warnings: Vec<Warning>,
    incidents: Vec<Incident>,
}

impl Sink for Told {
    fn wants_records(&self) -> bool {
        false
    }

    fn warning(&mut self, warning: &Warning) {
        self.warnings.push(*warning);
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.push(*incident);
    }
}

impl Told {
    /// Of `seconds` of the machine that has taught everything, with these faults.
    fn of(faults: &[&str], seconds: f64) -> Self {
        let (mut monitor, mut told) = (Monitor::new(TAUGHT.design.clone()), Self::default());
        let frames: Vec<Frame> = TAUGHT.frames(29, faults, seconds);
        frames.iter().for_each(|frame| monitor.take(frame, &mut told));
        monitor.finish(&mut told);
        told
    }

    fn opened(&self) -> Vec<&Incident> {
        self.incidents.iter().filter(|it| it.progress == Progress::Opened).collect()
    }
}

fn is_of_all(incident: &Incident) -> bool {
    matches!(incident.scope, Scope::Machine(cylinders) if cylinders.count() == 6)
}

/// The accumulator lasts for less than a minute.
#[test]
fn a_pump_that_stands_is_one_incident_whose_level_tells_how_long_the_accumulator_lasts() {
    let told = Told::of(&["supply_loss,cylinder=1,at=25,part=1"], 70.0);
    let [opened] = told.opened()[..] else { panic!("{:?}", told.opened()) };
    assert!(is_of_all(opened), "{opened:?}");
    assert_eq!((opened.fault, opened.suspect), (Fault::Supply, Suspect::Process));
    assert_eq!(opened.level, Level::Yellow);
    let newest = told.incidents.last().expect("it stands");
    assert!(newest.level >= Level::Orange, "{newest:?}");
    // Every cylinder's warning says so.
    for n in 1..=6 {
        let own = |it: &&Warning| it.cylinder == n && it.finding.fault == Fault::Supply;
        let level = told.warnings.iter().filter(own).map(|it| it.finding.level).max();
        assert!(level >= Some(Level::Orange), "{n}: {level:?}");
    }
}

/// A pump that only gives less pressure carries the load.
#[test]
fn a_supply_that_is_a_tenth_lower_stays_yellow() {
    let told = Told::of(&["supply_loss,cylinder=1,at=25,part=0.1"], 90.0);
    assert_eq!(told.opened().len(), 1);
    assert!(told.incidents.iter().all(|it| it.level == Level::Yellow && is_of_all(it)));
}

#[test]
fn readings_that_all_stay_away_are_one_incident_and_no_transducer_s() {
    let lost = (1..=6).flat_map(|n| {
        ["c1", "c2"]
            .map(|sensor| format!("loss,cylinder={n},sensor={sensor},at=15,until=16,probability=1"))
    });
    let lost: Vec<String> = lost.collect();
    let told = Told::of(&lost.iter().map(String::as_str).collect::<Vec<_>>(), 30.0);
    let [opened] = told.opened()[..] else { panic!("{:?}", told.opened()) };
    assert!(is_of_all(opened), "{opened:?}");
    assert_eq!(
        (opened.fault, opened.suspect, opened.level),
        (Fault::Stale, Suspect::Process, Level::Black)
    );
    let over = told.incidents.last().expect("it is over");
    assert_eq!((over.progress, over.number), (Progress::Closed, 1));
}

/// 2 mm/s: the machine trips after 25 s.
#[test]
fn a_drift_is_of_the_level_that_the_time_to_the_trip_asks_for() {
    let told = Told::of(&["drift,cylinder=3,sensor=c1,at=20,rate=0.002"], 55.0);
    let fde3 = told.warnings.iter().filter(|it| it.cylinder == 3 && it.detector == Detector::Fde3);
    let levels = fde3.filter(|it| it.state != State::Cleared).map(|it| it.finding.level);
    let mut levels: Vec<Level> = levels.collect();
    levels.dedup();
    assert_eq!(levels, [Level::Yellow, Level::Orange, Level::Red, Level::Black]);
}
