//! One kind of fault of one size, on one grade of transducers in one sea.

use super::claim::Claim;
use super::plan::Cell;
use serde::Serialize;
use tertius_core::verdict::Fault;
use tertius_machine::inject::{Shape, Wanted};

/// Unit of noise amplitudes (5-17), a standard deviation of four counts, m.
pub const SIGMA: f64 = 4.34e-4;

/// Groups of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Study {
    /// Type I (5-15), (5-16).
    Step,
    /// Type II (5-17).
    Noise,
    /// Type III (5-18), (5-19).
    Incipient,
    Drift,
    Scale,
    /// Faults of the data, which are checked before any model.
    Data,
    /// No fault: whatever is found is found by chance.
    Chance,
    /// Faults of C1, each beside the loop and in it.
    Loop,
    /// Comparison of the detectors.
    Contest,
    /// The virtual sensor, which has its own cases instead of rows.
    Estimate,
    /// Comparison of the observers' weights.
    Weights,
    /// Faults of the cylinders themselves, which have their own cases.
    Process,
    /// A machine whose controller hears who is blamed, which has its own cases.
    Handover,
    /// Whose drift it is inside the loop, with its own cases.
    Side,
    /// Whose drift it is by the attitude of the deck, with its own cases.
    Hexapod,
    /// Faults of a cylinder's last transducer once the other one is out.
    Last,
    /// The same on cylinders that have no C2.
    Single,
    /// The estimate by a transducer less its step once the other one is lost, with its own cases.
    Accommodate,
}

impl Study {
    pub const ALL: [Self; 18] = [
        Self::Step,
        Self::Noise,
        Self::Incipient,
        Self::Drift,
        Self::Scale,
        Self::Data,
        Self::Chance,
        Self::Loop,
        Self::Contest,
        Self::Estimate,
        Self::Weights,
        Self::Process,
        Self::Handover,
        Self::Side,
        Self::Hexapod,
        Self::Last,
        Self::Single,
        Self::Accommodate,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Noise => "noise",
            Self::Incipient => "incipient",
            Self::Drift => "drift",
            Self::Scale => "scale",
            Self::Data => "data",
            Self::Chance => "chance",
            Self::Loop => "loop",
            Self::Contest => "contest",
            Self::Estimate => "estimate",
            Self::Weights => "weights",
            Self::Process => "process",
            Self::Handover => "handover",
            Self::Side => "side",
            Self::Hexapod => "hexapod",
            Self::Last => "last",
            Self::Single => "single",
            Self::Accommodate => "accommodate",
        }
    }
}

/// A row of the evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub study: Study,
    pub cell: Cell,
    /// The controller reads the fault, which is of C1, and each machine has one fault.
    pub in_loop: bool,
    /// The fault, its size positive; `None`: no fault.
    pub wanted: Option<Wanted>,
    /// How long the fault is watched, s.
    pub watch: f64,
    pub claim: Option<Claim>,
    /// Stream of random numbers: rows with the same stream try their faults on the same machines at
    /// the same times.
    pub stream: u64,
}

/// How long a fault is watched unless it needs longer, s.
const WATCH: f64 = 10.0;

/// Steps (5-15), (5-16), m.
const STEPS: [f64; 10] = [1e-3, 1.25e-3, 1.5e-3, 1.75e-3, 2e-3, 2.5e-3, 5e-3, 0.01, 0.025, 0.05];

/// Steps below those of the thesis, m.
const SMALL_STEPS: [f64; 3] = [2.5e-4, 5e-4, 7.5e-4];

/// Incipient faults of section 5-4-4, φ in m and b: the thesis's first, then slower ones that end
/// at the same size.
const INCIPIENT: [(f64, f64); 4] = [(0.07, 1.0), (0.07, 0.3), (0.07, 0.1), (0.035, 1.0)];

/// Drifts, m/s, with the time that each is watched, s.
const DRIFTS: [(f64, f64); 5] =
    [(5e-5, 60.0), (1e-4, 30.0), (5e-4, 10.0), (1e-3, 10.0), (5e-3, 10.0)];

/// Gain errors, as parts of the reading.
const GAINS: [f64; 4] = [1e-3, 2e-3, 5e-3, 1e-2];

/// The rows of all studies, in each of `cells`; the loop is studied in the first of them. Smaller steps are tried where sequential
/// detectors were `taught`.
pub fn rows(cells: &[Cell], taught: bool) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (index, cell) in (0_u64..).zip(cells) {
        let open = Row::open(Study::Step, *cell, None);
        let first = rows.len();
        rows.extend(thesis(open));
        rows.extend(others(open));
        rows.extend(SMALL_STEPS.into_iter().filter(|_| taught).map(|size| {
            let wanted = Some(Wanted::Shape(Shape::Step { size }));
            Row { study: Study::Step, wanted, ..open }
        }));
        for (number, row) in (0_u64..).zip(&mut rows[first..]) {
            row.stream = (index << 16) + number;
        }
    }
    if let Some(cell) = cells.first() {
        rows.extend(loops(*cell));
    }
    rows
}

/// Types I, II and III with the thesis's claim about each.
fn thesis(open: Row) -> impl Iterator<Item = Row> {
    let steps = STEPS.map(|size| {
        let claim = if size < 1.25e-3 { Claim::NotAlways } else { Claim::AtOnce };
        let wanted = Some(Wanted::Shape(Shape::Step { size }));
        Row { study: Study::Step, wanted, claim: Some(claim), ..open }
    });
    let noises = [1_u8, 2, 3, 4, 5, 6].map(|n| {
        let claim = if n == 1 { Claim::Never } else { Claim::Found };
        let wanted = Some(Wanted::Shape(Shape::Noise { size: f64::from(n) * SIGMA }));
        Row { study: Study::Noise, wanted, claim: Some(claim), ..open }
    });
    let incipient = INCIPIENT.map(|(size, b)| {
        let claim = ((size, b) == (0.07, 1.0)).then_some(Claim::Within(0.08));
        let wanted = Some(Wanted::Shape(Shape::Incipient { size, b }));
        Row { study: Study::Incipient, wanted, claim, ..open }
    });
    steps.into_iter().chain(noises).chain(incipient)
}

fn others(open: Row) -> impl Iterator<Item = Row> {
    let of = move |study, shape| Row { study, wanted: Some(Wanted::Shape(shape)), ..open };
    let drifts =
        DRIFTS.map(|(rate, watch)| Row { watch, ..of(Study::Drift, Shape::Drift { rate }) });
    let scales = GAINS.map(|gain| of(Study::Scale, Shape::Scale { gain }));
    let data = [
        of(Study::Data, Shape::Freeze),
        of(Study::Data, Shape::Stale),
        of(Study::Data, Shape::Loss { probability: 1.0 }),
        of(Study::Data, Shape::Loss { probability: 0.1 }),
        of(Study::Data, Shape::Spike { size: 5e-3, probability: 0.02 }),
        Row { study: Study::Data, wanted: Some(Wanted::BrokenWire(None)), ..open },
        Row { study: Study::Data, wanted: Some(Wanted::OutOfRange(None)), ..open },
    ];
    let chance = Row { study: Study::Chance, ..open };
    drifts.into_iter().chain(scales).chain(data).chain([chance])
}

/// Each fault beside the loop and in it, on the same machines.
fn loops(cell: Cell) -> Vec<Row> {
    let studied = [
        (Shape::Step { size: 2.5e-3 }, WATCH),
        (Shape::Step { size: 0.01 }, WATCH),
        (Shape::Step { size: 0.05 }, WATCH),
        (Shape::Noise { size: 4.0 * SIGMA }, WATCH),
        (Shape::Incipient { size: 0.07, b: 1.0 }, WATCH),
        (Shape::Drift { rate: 1e-4 }, 30.0),
        (Shape::Drift { rate: 1e-3 }, 20.0),
        (Shape::Drift { rate: 5e-3 }, 20.0),
        (Shape::Scale { gain: 1e-2 }, WATCH),
        (Shape::Freeze, WATCH),
        (Shape::Loss { probability: 0.1 }, WATCH),
    ];
    // Above every stream of a cell.
    let streams = 1_u64 << 32..;
    let pair = |((shape, watch), stream): ((Shape, f64), u64)| {
        [false, true].map(|in_loop| Row {
            study: Study::Loop,
            cell,
            in_loop,
            wanted: Some(Wanted::Shape(shape)),
            watch,
            claim: None,
            stream,
        })
    };
    studied.into_iter().zip(streams).flat_map(pair).collect()
}

impl Row {
    /// A row without a claim whose fault the controller does not read.
    pub const fn open(study: Study, cell: Cell, wanted: Option<Wanted>) -> Self {
        Self { study, cell, in_loop: false, wanted, watch: WATCH, claim: None, stream: 0 }
    }

    /// Whether each machine has one fault of C1 instead of one on every cylinder.
    pub fn is_alone(&self) -> bool {
        self.study == Study::Loop
    }

    /// The name of the row's fault, as in `inject`.
    pub const fn fault(&self) -> &'static str {
        match self.wanted {
            None => "none",
            Some(Wanted::OutOfRange(_)) => "out_of_range",
            Some(Wanted::BrokenWire(_)) => "broken_wire",
            Some(Wanted::Shape(shape)) => name(shape),
            Some(Wanted::Machine(ailment)) => ailment.name(),
        }
    }

    /// Size of the fault: m, m/s (a drift) or a part of the reading (a scale).
    pub const fn size(&self) -> Option<f64> {
        let Some(Wanted::Shape(shape)) = self.wanted else { return None };
        match shape {
            Shape::Step { size }
            | Shape::Noise { size }
            | Shape::Incipient { size, .. }
            | Shape::Spike { size, .. } => Some(size),
            Shape::Drift { rate } => Some(rate),
            Shape::Scale { gain } => Some(gain),
            Shape::Freeze | Shape::Constant(_) | Shape::Stale | Shape::Loss { .. } => None,
        }
    }

    /// b of (5-18), or the probability of a spike or a loss.
    pub const fn parameter(&self) -> Option<f64> {
        let Some(Wanted::Shape(shape)) = self.wanted else { return None };
        match shape {
            Shape::Incipient { b, .. } => Some(b),
            Shape::Spike { probability, .. } | Shape::Loss { probability } => Some(probability),
            _ => None,
        }
    }

    /// The name that warnings should give the fault; `None` where Table 5-1 has none.
    pub const fn kind(&self) -> Option<Fault> {
        match self.wanted {
            None | Some(Wanted::Machine(_)) => None,
            Some(Wanted::OutOfRange(_)) => Some(Fault::OutOfRange),
            Some(Wanted::BrokenWire(_)) => Some(Fault::BrokenWire),
            Some(Wanted::Shape(shape)) => match shape {
                Shape::Step { .. } => Some(Fault::Abrupt),
                Shape::Noise { .. } => Some(Fault::Noise),
                Shape::Incipient { .. } | Shape::Drift { .. } => Some(Fault::Incipient),
                Shape::Freeze => Some(Fault::Frozen),
                Shape::Stale => Some(Fault::Stale),
                Shape::Loss { probability } if probability >= 1.0 => Some(Fault::Stale),
                Shape::Loss { .. }
                | Shape::Scale { .. }
                | Shape::Spike { .. }
                | Shape::Constant(_) => None,
            },
        }
    }

    /// The fault in words.
    pub fn label(&self) -> String {
        match self.wanted {
            Some(Wanted::Shape(shape)) => label(shape),
            _ => self.fault().replace('_', " "),
        }
    }
}

/// The name of a fault of that shape, as in `inject`.
const fn name(shape: Shape) -> &'static str {
    match shape {
        Shape::Step { .. } => "step",
        Shape::Noise { .. } => "noise",
        Shape::Incipient { .. } => "incipient",
        Shape::Drift { .. } => "drift",
        Shape::Scale { .. } => "scale",
        Shape::Freeze => "freeze",
        Shape::Spike { .. } => "spike",
        Shape::Constant(_) => "constant",
        Shape::Stale => "stale",
        Shape::Loss { .. } => "loss",
    }
}

/// A fault of that shape in words.
pub fn label(shape: Shape) -> String {
    let name = name(shape);
    match shape {
        Shape::Step { size } => format!("{name} {} mm", tidy(size * 1e3)),
        Shape::Noise { size } => format!("{name} {} σ", tidy(size / SIGMA)),
        Shape::Incipient { size, b } => format!("{name} {} mm, b {b}", tidy(size * 1e3)),
        Shape::Drift { rate } => format!("{name} {} mm/s", tidy(rate * 1e3)),
        Shape::Scale { gain } => format!("{name} {} %", tidy(gain * 1e2)),
        Shape::Spike { size, probability } => {
            format!("{name} {} mm in {} %", tidy(size * 1e3), tidy(probability * 1e2))
        }
        Shape::Loss { probability } => format!("{name} of {} %", tidy(probability * 1e2)),
        Shape::Freeze | Shape::Stale | Shape::Constant(_) => name.to_owned(),
    }
}

/// `value` without the rounding residue of binary fractions.
fn tidy(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
