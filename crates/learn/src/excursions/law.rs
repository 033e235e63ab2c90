//! The law of a healthy transducer's excursions.

/// Excursions of one size and length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atom {
    /// Size, m, above 0.
    pub size: f64,
    /// Length, samples, at least 1.
    pub length: u32,
    /// Share of all excursions.
    pub weight: f64,
}

/// What excursions the transducers of a cylinder make: two renewal processes, one for each
/// transducer, alike, both directions equally likely.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// Chance that an excursion of one direction begins with a sample, on one transducer that is in
    /// none.
    pub chance: f64,
    /// Weights add up to 1. Empty, with chance 0, where there are no excursions.
    pub atoms: Vec<Atom>,
}
