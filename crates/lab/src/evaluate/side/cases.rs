//! The drifts that are tried.

use tertius_core::verdict::Suspect;

/// A drift of one transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SideCase {
    /// C1 or C2.
    pub transducer: Suspect,
    /// m/s; either sign is tried.
    pub rate: f64,
}

/// What is tried.
pub const CASES: [SideCase; 10] = SideCase::each([0.3e-3, 0.5e-3, 1e-3, 2e-3, 5e-3]);

impl SideCase {
    /// Those of C1 with each of the `rates`, m/s, and then those of C2: `CASES` are twice as many.
    pub(in crate::evaluate) const fn each<const RATES: usize, const CASES: usize>(
        rates: [f64; RATES],
    ) -> [Self; CASES] {
        let mut cases = [Self { transducer: Suspect::C1, rate: 0.0 }; CASES];
        let mut i = 0;
        while i < RATES {
            cases[i].rate = rates[i];
            cases[i + RATES] = Self { transducer: Suspect::C2, rate: rates[i] };
            i += 1;
        }
        cases
    }
}

/// A drift has to be named before this, m.
pub const IN_TIME: f64 = 0.02;

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 1800.0;
