//! The servo-valve: from spool position to flow.

use super::parameters::ValveTable;

/// f_NL of (3-7) for one valve: a progressive spool (Figure 3-5) with overlap, which leaks (Figure
/// 3-4c). Flows are given as the speed of the piston that they would move without a loss of
/// pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valve {
    overlap: f64,
    leakage: f64,
    /// Flow at the edge of the overlap; an opening `beyond` it adds (linear + progressive · beyond)
    /// · beyond.
    edge: f64,
    linear: f64,
    progressive: f64,
    /// Speeds at full opening and nominal supply pressure, out and in, m/s.
    speeds: [f64; 2],
}

impl Valve {
    /// A valve of `table` whose flows out and in are `factors` times the table's; the speeds hold
    /// where √(P_S ∓ P_L) is √`nominal`, bar.
    pub fn new(table: &ValveTable, factors: [f64; 2], nominal: f64) -> Self {
        let (beyond, travel) = (1.0 - table.leakage, 1.0 - table.overlap);
        Self {
            overlap: table.overlap,
            leakage: table.leakage / table.overlap,
            edge: table.leakage,
            linear: beyond * (1.0 - table.progression) / travel,
            progressive: beyond * table.progression / (travel * travel),
            speeds: [
                factors[0] * table.extend_speed / nominal.sqrt(),
                factors[1] * table.retract_speed / nominal.sqrt(),
            ],
        }
    }

    /// Spool position at which the ports begin to open, part of the full stroke.
    pub(super) fn overlap(&self) -> f64 {
        self.overlap
    }

    /// The part of the full flow that passes at `spool`, −1 to 1, in its direction: 0 to 1.
    pub fn opening(&self, spool: f64) -> f64 {
        let size = spool.abs();
        let beyond = size - self.overlap;
        if beyond <= 0.0 {
            return self.leakage * size;
        }
        self.edge + (self.linear + self.progressive * beyond) * beyond
    }

    /// The flow (3-7), as a speed in m/s, at load pressure `load` and supply pressure `supply`,
    /// bar. There is no flow against a pressure difference.
    pub fn flow(&self, spool: f64, load: f64, supply: f64) -> f64 {
        let (speed, drop) = if spool >= 0.0 {
            (self.speeds[0], supply - load)
        } else {
            (-self.speeds[1], supply + load)
        };
        speed * self.opening(spool) * drop.max(0.0).sqrt()
    }
}
