//! The faults that are tried.

use crate::evaluate::fault::SIGMA;
use tertius_core::verdict::Fault;
use tertius_machine::inject::{Shape, Wanted};
use tertius_machine::plant::Ailment;
use tertius_machine::simulator::Tables;

/// A fault and what it should be called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProcessCase {
    pub label: &'static str,
    /// Sensor with the fault; `machine` for the machine itself.
    pub sensor: &'static str,
    pub wanted: Wanted,
    /// What the process detector should call it; `None`: nothing at all.
    pub expected: Option<Fault>,
    /// Size as a warning should give it, where it gives one; negative sizes are tried as often.
    pub size: Option<f64>,
    /// How long it is watched, s.
    pub watch: f64,
}

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;

/// How long a fault is watched, s.
const WATCH: f64 = 25.0;
const LONG_WATCH: f64 = 75.0;

const fn of_the_machine(
    label: &'static str,
    ailment: Ailment,
    expected: Fault,
    size: Option<f64>,
) -> ProcessCase {
    let wanted = Wanted::Machine(ailment);
    ProcessCase { label, sensor: "machine", wanted, expected: Some(expected), size, watch: WATCH }
}

/// A fault that shows in the flow or in the friction alone, or of which the size does: it takes longer.
const fn by_flow(
    label: &'static str,
    ailment: Ailment,
    expected: Fault,
    size: Option<f64>,
) -> ProcessCase {
    ProcessCase { watch: LONG_WATCH, ..of_the_machine(label, ailment, expected, size) }
}

/// α of (3-8) that the leakages of [`CASES`] are for, bar/m: that of the default plant.
const PRESSURE_RISE: f64 = 7000.0;

/// A spool's signal at full stroke that the sizes of [`CASES`] are for: they are in %.
const SPOOL_FULL: f64 = 100.0;

/// Oil that passes the piston at `speed`, m/s at 24 bar: β / α of (3-8) times the load.
const fn leakage(speed: f64) -> Ailment {
    Ailment::Leakage { rate: speed * PRESSURE_RISE / 24.0 }
}

impl ProcessCase {
    /// Whether a machine has one of it, and not each cylinder.
    pub(super) const fn is_of_all(&self) -> bool {
        matches!(self.wanted, Wanted::Machine(Ailment::SupplyLoss { .. }))
    }

    /// The case on the machine of `tables`: with the same oil past the piston, and its size in the unit of the
    /// machine's spool.
    pub(super) fn on(&self, tables: &Tables) -> Self {
        let wanted = match self.wanted {
            Wanted::Machine(Ailment::Leakage { rate }) => {
                let rate = rate * (tables.cylinder.pressure_rise / PRESSURE_RISE);
                Wanted::Machine(Ailment::Leakage { rate })
            }
            other => other,
        };
        let unit = match self.expected {
            Some(Fault::ValveSticking | Fault::ValveOffset | Fault::ValveDeadBand) => {
                tables.sensors.spool_full / SPOOL_FULL
            }
            Some(Fault::Supply) => tables.supply.pressure,
            _ => 1.0,
        };
        Self { wanted, size: self.size.map(|size| size * unit), ..*self }
    }
}

/// The pump's set point lower by a part of it: its size is of a pressure of 1 bar, see [`ProcessCase::on`].
const fn of_supply(label: &'static str, part: f64) -> ProcessCase {
    by_flow(label, Ailment::SupplyLoss { part }, Fault::Supply, Some(-part))
}

const fn of_pressure(label: &'static str, shape: Shape, size: Option<f64>) -> ProcessCase {
    ProcessCase {
        label,
        sensor: "pressure_bottom",
        wanted: Wanted::Shape(shape),
        expected: Some(Fault::PressureSensor),
        size,
        watch: WATCH,
    }
}

const fn of_c1(label: &'static str, shape: Shape) -> ProcessCase {
    let wanted = Wanted::Shape(shape);
    ProcessCase { label, sensor: "c1", wanted, expected: None, size: None, watch: WATCH }
}

/// Sizes of spools are in % of their stroke.
pub const CASES: [ProcessCase; 35] = [
    of_the_machine(
        "sticking 0.5 %",
        Ailment::Sticking { band: 0.005 },
        Fault::ValveSticking,
        Some(0.5),
    ),
    of_the_machine(
        "sticking 1 %",
        Ailment::Sticking { band: 0.01 },
        Fault::ValveSticking,
        Some(1.0),
    ),
    of_the_machine(
        "sticking 2 %",
        Ailment::Sticking { band: 0.02 },
        Fault::ValveSticking,
        Some(2.0),
    ),
    of_the_machine(
        "sticking 5 %",
        Ailment::Sticking { band: 0.05 },
        Fault::ValveSticking,
        Some(5.0),
    ),
    of_the_machine(
        "spool offset 0.5 %",
        Ailment::SpoolOffset { size: 0.005 },
        Fault::ValveOffset,
        Some(0.5),
    ),
    of_the_machine(
        "spool offset 1 %",
        Ailment::SpoolOffset { size: 0.01 },
        Fault::ValveOffset,
        Some(1.0),
    ),
    of_the_machine(
        "spool offset 2 %",
        Ailment::SpoolOffset { size: 0.02 },
        Fault::ValveOffset,
        Some(2.0),
    ),
    of_the_machine(
        "command 1 cycle late",
        Ailment::LateCommand { cycles: 1 },
        Fault::Command,
        Some(1.0),
    ),
    of_the_machine(
        "command 3 cycles late",
        Ailment::LateCommand { cycles: 3 },
        Fault::Command,
        Some(3.0),
    ),
    of_the_machine(
        "command 10 % too large",
        Ailment::WrongCommand { gain: 0.1 },
        Fault::Command,
        None,
    ),
    by_flow("leakage 2.5 mm/s", leakage(2.5e-3), Fault::Leakage, Some(2.5e-3)),
    by_flow("leakage 5 mm/s", leakage(5e-3), Fault::Leakage, Some(5e-3)),
    by_flow("leakage 12.5 mm/s", leakage(12.5e-3), Fault::Leakage, Some(12.5e-3)),
    by_flow("null 0.25 %", Ailment::NullShift { size: 0.0025 }, Fault::ValveOffset, Some(0.25)),
    by_flow("null 0.5 %", Ailment::NullShift { size: 0.005 }, Fault::ValveOffset, Some(0.5)),
    by_flow("null 1 %", Ailment::NullShift { size: 0.01 }, Fault::ValveOffset, Some(1.0)),
    by_flow("dead band 0.5 %", Ailment::DeadBand { size: 0.005 }, Fault::ValveDeadBand, Some(0.5)),
    by_flow("dead band 1 %", Ailment::DeadBand { size: 0.01 }, Fault::ValveDeadBand, Some(1.0)),
    by_flow("worn edges 12.5 mm/s", Ailment::ValveLeakage { speed: 0.0125 }, Fault::Leakage, None),
    by_flow("friction × 1.5", Ailment::Friction { factor: 1.5 }, Fault::Friction, None),
    by_flow("friction × 2", Ailment::Friction { factor: 2.0 }, Fault::Friction, None),
    by_flow("friction × 3", Ailment::Friction { factor: 3.0 }, Fault::Friction, None),
    of_supply("supply −10 %", 0.1),
    of_supply("supply −20 %", 0.2),
    of_pressure("pressure 3 bar off", Shape::Step { size: 3.0 }, Some(3.0)),
    of_pressure("pressure 10 bar off", Shape::Step { size: 10.0 }, Some(10.0)),
    of_pressure("pressure drifts 0.2 bar/s", Shape::Drift { rate: 0.2 }, None),
    of_pressure("pressure frozen", Shape::Freeze, None),
    of_c1("C1 step 5 mm", Shape::Step { size: 5e-3 }),
    of_c1("C1 step 60 mm", Shape::Step { size: 0.06 }),
    of_c1("C1 drift 1 mm/s", Shape::Drift { rate: 1e-3 }),
    of_c1("C1 drift 20 mm/s", Shape::Drift { rate: 0.02 }),
    of_c1("C1 noise 4 σ", Shape::Noise { size: 4.0 * SIGMA }),
    of_c1("C1 scale 1 %", Shape::Scale { gain: 0.01 }),
    of_c1("C1 frozen", Shape::Freeze),
];
