//! The faults that a trial puts into a recording, and where.

use super::holding::Blocks;
use std::fmt;
use tertius_core::time::Span;
use tertius_core::verdict::Suspect;
use tertius_machine::inject::{Fault, Shape, Wanted, Window};

/// Kind of fault that a trial puts on each transducer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// Type I (5-15), m.
    Step(f64),
    /// Type II (5-17), m.
    Noise(f64),
    /// Drift, m/s.
    Drift(f64),
}

/// Faults that are tried. Noise is 2σ of section 5-4-3, eight counts.
pub const KINDS: [FaultKind; 5] = [
    FaultKind::Step(5e-4),
    FaultKind::Step(1e-3),
    FaultKind::Noise(8.68e-4),
    FaultKind::Drift(1e-4),
    FaultKind::Drift(1e-5),
];

/// Faults of each kind for each transducer.
const EACH: usize = 2;

/// Golden section: offsets by multiples of it are spread evenly, however many are taken.
const GOLDEN: f64 = 0.618_033_988_749_895;

impl FaultKind {
    /// How long the monitor is watched after the fault, s.
    pub const fn watch(self) -> f64 {
        match self {
            Self::Step(_) | Self::Noise(_) => 4.0,
            Self::Drift(rate) if rate < 5e-5 => 30.0,
            Self::Drift(_) => 8.0,
        }
    }

    fn shape(self, sign: f64) -> Shape {
        match self {
            Self::Step(size) => Shape::Step { size: sign * size },
            Self::Noise(size) => Shape::Noise { size },
            Self::Drift(rate) => Shape::Drift { rate: sign * rate },
        }
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step(size) => write!(f, "step of {} mm", size * 1e3),
            Self::Noise(size) => write!(f, "noise of ±{} mm", size * 1e3),
            Self::Drift(rate) => write!(f, "drift of {} mm/s", rate * 1e3),
        }
    }
}

/// A fault that is to be tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planned {
    /// Number of the fault, from 0, whenever it begins.
    pub number: usize,
    pub kind: FaultKind,
    /// Cylinder number, counted from 1.
    pub cylinder: u8,
    pub transducer: Suspect,
    pub sign: f64,
    /// Earliest and latest time at which the fault may begin, s.
    pub begin: [f64; 2],
    /// How long the monitor is watched after the fault, s.
    pub watch: f64,
}

impl Planned {
    /// The fault from the first frame on that the injector sees.
    pub fn fault(&self) -> Fault {
        let sensor = if self.transducer == Suspect::C2 { "c2" } else { "c1" };
        let window = Window { from: Span::from_nanos(0), until: None };
        let wanted = Wanted::Shape(self.kind.shape(self.sign));
        Fault { cylinder: self.cylinder, sensor, wanted, window }
    }
}

/// All faults of `cylinders`, spread over the `blocks`, in the order in which they begin; `has_c2` tells whether a
/// cylinder has a C2.
pub fn plan(blocks: &Blocks, cylinders: &[u8], has_c2: impl Fn(u8) -> bool) -> Vec<Planned> {
    let spans = blocks.spans();
    let both = [Suspect::C1, Suspect::C2];
    let mut planned = Vec::new();
    for number in 0..EACH {
        for kind in KINDS {
            for cylinder in cylinders {
                for transducer in if has_c2(*cylinder) { &both[..] } else { &both[..1] } {
                    let place = planned.len();
                    let along = (place as f64 * GOLDEN).fract() * spans.len() as f64;
                    let Some([from, to]) = spans.get(along as usize) else { continue };
                    let watch = kind.watch().min(to - from);
                    let latest = to - watch;
                    let begin = [from + along.fract() * (latest - from), latest];
                    // Both transducers up and down.
                    let up = (number + usize::from(*cylinder)).is_multiple_of(2);
                    let sign = if up { 1.0 } else { -1.0 };
                    let (cylinder, transducer) = (*cylinder, *transducer);
                    planned.push(Planned {
                        number: place,
                        kind,
                        cylinder,
                        transducer,
                        sign,
                        begin,
                        watch,
                    });
                }
            }
        }
    }
    planned.sort_by(|one, other| one.begin[0].total_cmp(&other.begin[0]));
    planned
}

#[cfg(test)]
mod tests {
    use super::*;
    use tertius_learn::survey;

    #[test]
    fn faults_begin_and_end_in_what_is_held_back() {
        let window = survey::Window { from: 0.0, to: 900.0 };
        let blocks = Blocks::of(window, survey::Ranking::default());
        let planned = plan(&blocks, &[1, 2, 4], |_| true);
        assert_eq!(planned.len(), 2 * KINDS.len() * 3 * EACH);
        for one in &planned {
            assert!(blocks.hold(one.begin[0]) && blocks.hold(one.begin[1] + one.watch - 1e-6));
            assert!(one.begin[0] <= one.begin[1], "{one:?}");
        }
        let blocks_used = blocks.spans();
        for [from, to] in blocks_used {
            let within = planned.iter().filter(|it| (from..to).contains(&it.begin[0])).count();
            assert!(within >= 8, "{within} in {from}");
        }
        assert_eq!(plan(&blocks, &[1], |_| false).len(), KINDS.len() * EACH);
    }
}
