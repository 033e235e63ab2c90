//! The witnesses that are compared, and the drifts that are tried.

use crate::evaluate::side::cases::SideCase;
use tertius_core::monitor::MonitorDesign;

/// What the deck's attitude is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeckWitness {
    /// The vessel's motion sensor alone: a deck that stands level.
    VesselAlone,
    /// A sensor on the deck whose noise, and whose error that comes and goes, have this standard deviation each, rad.
    Sensor(f64),
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// What is compared.
pub const WITNESSES: [DeckWitness; 4] = [
    DeckWitness::VesselAlone,
    DeckWitness::Sensor(0.005 * DEGREE),
    DeckWitness::Sensor(0.01 * DEGREE),
    DeckWitness::Sensor(0.05 * DEGREE),
];

impl DeckWitness {
    /// The monitor that knows how good the witness is; a deck that is presumed to be level is as good as configured.
    pub(super) fn known_to(self, mut design: MonitorDesign) -> MonitorDesign {
        if let (Self::Sensor(accuracy), Some(tilt)) = (self, &mut design.tilt) {
            tilt.accuracy = accuracy;
        }
        design
    }

    /// In words.
    pub fn label(self) -> String {
        match self {
            Self::VesselAlone => "the vessel's sensor alone".to_owned(),
            Self::Sensor(accuracy) => format!("a sensor of {:.3}° on the deck", accuracy / DEGREE),
        }
    }
}

/// What is tried.
pub const CASES: [SideCase; 6] = SideCase::each([0.2e-3, 0.5e-3, 2e-3]);

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;
