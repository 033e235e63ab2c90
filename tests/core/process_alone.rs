//! Friction of cylinders that have C1 alone.

use crate::process::{Taught, of_process};
use std::sync::LazyLock;
use tertius::alarm::Warning;
use tertius::simulator::EPOCH;
use tertius::verdict::{Fault as Kind, Suspect};

static ALONE: LazyLock<Taught> = LazyLock::new(Taught::alone);

#[test]
fn more_friction_of_a_cylinder_without_c2_is_its_own() {
    for (seed, cylinder) in [(21, 3), (22, 1), (23, 6)] {
        let fault = format!("friction,cylinder={cylinder},at=25,factor=4");
        let warnings = ALONE.warnings(seed, &[&fault], 55.0);
        let found = of_process(&warnings);
        let first = found.first().unwrap_or_else(|| panic!("{seed}: nothing was found"));
        let delay = first.timestamp.since(EPOCH).as_seconds() - 25.0;
        assert!((0.0..20.0).contains(&delay), "{seed}: after {delay} s");
        for warning in found {
            let finding = (warning.cylinder, warning.finding.fault, warning.finding.suspect);
            assert_eq!(finding, (cylinder, Kind::Friction, Suspect::Process), "{seed}");
        }
        let blamed = |it: &&Warning| it.finding.suspect == Suspect::C1;
        assert_eq!(warnings.iter().find(blamed), None, "{seed}");
    }
}

/// An hour of the machine.
#[test]
fn a_healthy_machine_without_c2_has_no_more_friction_than_it_had() {
    for seed in 31..=34 {
        let warnings = ALONE.warnings(seed, &[], 900.0);
        assert_eq!(of_process(&warnings), Vec::<&Warning>::new(), "{seed}");
    }
}
