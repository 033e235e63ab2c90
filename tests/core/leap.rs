//! The detector of leaps, from frames to warnings.

use tertius::alarm::{Detector, State, Warning};
use tertius::config::{self, design};
use tertius::dbc::Database;
use tertius::frame::{Frame, Id, Kind};
use tertius::monitor::Monitor;
use tertius::time::{Span, Timestamp};

const DBC: &str = r#"VERSION ""
BU_: Machine
BO_ 385 C1: 2 Machine
 SG_ Position : 0|16@1+ (0.0001,-1.5) [-1.5|1.5] "m" Machine
BO_ 401 C2: 2 Machine
 SG_ Position : 0|16@1+ (0.0001,-1.5) [-1.5|1.5] "m" Machine
BO_ 417 Valve: 2 Machine
 SG_ ControlSpeed : 0|16@1- (0.0001,0) [0|0] "m/s" Machine
"#;

const MACHINE: &str = r#"
machine = { name = "One cylinder", cylinders = 1, sample_time = 0.02, stroke = [-1.5, 1.5] }
bus = { interface = "virtual", dbc = "machine.dbc" }
signals.cylinder = { c1 = "C1.Position", c2 = "C2.Position", control_speed = "Valve.ControlSpeed" }
"#;

/// Warnings of leaps where C1 reads this many counts of 0.1 mm more from the hundredth cycle on.
fn leaps(counts: u16) -> Vec<(State, Option<f64>)> {
    let (settings, _) = config::parse("machine.toml", MACHINE).expect("it is sound");
    let database = Database::parse(DBC).expect("it is sound");
    let mut monitor = Monitor::new(design::judging(&settings, &database).expect("they fit"));
    let mut warnings: Vec<Warning> = Vec::new();
    for cycle in 0..200 {
        let at = Timestamp::default().after(Span::from_seconds(0.02 * f64::from(cycle)));
        let c1 = if cycle < 100 { 15_000 } else { 15_000 + counts };
        for (id, count) in [(385, c1), (401, 15_000), (417, 0)] {
            let id = Id::standard(id).expect("11 bits");
            monitor.take(&Frame::new(at, id, Kind::Data, &count.to_le_bytes()), &mut warnings);
        }
    }
    let own = warnings.iter().filter(|warning| warning.detector == Detector::Leap);
    own.map(|warning| (warning.state, warning.finding.residual)).collect()
}

#[test]
fn a_leap_beyond_the_machines_own_limit_is_one_warning() {
    let [raised, cleared] = leaps(600).try_into().expect("it is raised and cleared");
    assert_eq!((raised.0, cleared.0), (State::Raised, State::Cleared));
    assert!((raised.1.expect("a leap") - 0.06).abs() < 1e-9);
    assert_eq!(leaps(400), []);
}
