//! One kind of fault of one size, on one grade of transducers in one sea.

use super::claim::Claim;
use crate::evaluate::extent::StudyName;
use crate::evaluate::fault::SIGMA;
use crate::evaluate::grade::Cell;
use tertius_machine::inject::{Shape, Wanted};

/// Groups of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowGroup {
    Step,
    Noise,
    Incipient,
    Drift,
    Scale,
    /// Faults of the data, which are checked before any model.
    Data,
    /// No fault: whatever is found is found by chance.
    Chance,
    /// Faults of C1, each beside the loop and in it.
    Loop,
}

impl RowGroup {
    /// All groups, in the order in which `--rows` lists them.
    pub const ALL: [Self; 8] = [
        Self::Step,
        Self::Noise,
        Self::Incipient,
        Self::Drift,
        Self::Scale,
        Self::Data,
        Self::Chance,
        Self::Loop,
    ];

    /// The name by which the group is asked for.
    pub const fn name(self) -> &'static str {
        self.study().name
    }

    /// The studies of [`Self::ALL`].
    pub const STUDIES: [StudyName; Self::ALL.len()] = {
        let mut studies = [Self::Step.study(); Self::ALL.len()];
        let mut at = 0;
        while at < studies.len() {
            studies[at] = Self::ALL[at].study();
            at += 1;
        }
        studies
    };

    /// The study of this group alone.
    pub const fn study(self) -> StudyName {
        match self {
            Self::Step => StudyName::quick("step", "Type I (5-15), (5-16)"),
            Self::Noise => StudyName::quick("noise", "Type II (5-17)"),
            Self::Incipient => StudyName::quick("incipient", "Type III (5-18)"),
            Self::Drift => StudyName::quick("drift", "A constant rate"),
            Self::Scale => StudyName::quick("scale", "A gain error"),
            Self::Data => {
                StudyName::quick("data", "Frozen, stale, lost, out of range, broken wire, spikes")
            }
            Self::Chance => StudyName::quick("chance", "No fault: what is found by chance"),
            Self::Loop => StudyName::quick(
                "loop",
                "Faults of C1 that the controller reads, beside those that it does not",
            ),
        }
    }
}

/// A row of the evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub group: RowGroup,
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
        let open = Row::open(RowGroup::Step, *cell, None);
        let first = rows.len();
        rows.extend(thesis(open));
        rows.extend(others(open));
        rows.extend(SMALL_STEPS.into_iter().filter(|_| taught).map(|size| {
            let wanted = Some(Wanted::Shape(Shape::Step { size }));
            Row { group: RowGroup::Step, wanted, ..open }
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
        Row { group: RowGroup::Step, wanted, claim: Some(claim), ..open }
    });
    let noises = [1_u8, 2, 3, 4, 5, 6].map(|n| {
        let claim = if n == 1 { Claim::Never } else { Claim::Found };
        let wanted = Some(Wanted::Shape(Shape::Noise { size: f64::from(n) * SIGMA }));
        Row { group: RowGroup::Noise, wanted, claim: Some(claim), ..open }
    });
    let incipient = INCIPIENT.map(|(size, b)| {
        let claim = ((size, b) == (0.07, 1.0)).then_some(Claim::Within(0.08));
        let wanted = Some(Wanted::Shape(Shape::Incipient { size, b }));
        Row { group: RowGroup::Incipient, wanted, claim, ..open }
    });
    steps.into_iter().chain(noises).chain(incipient)
}

fn others(open: Row) -> impl Iterator<Item = Row> {
    let of = move |group, shape| Row { group, wanted: Some(Wanted::Shape(shape)), ..open };
    let drifts =
        DRIFTS.map(|(rate, watch)| Row { watch, ..of(RowGroup::Drift, Shape::Drift { rate }) });
    let scales = GAINS.map(|gain| of(RowGroup::Scale, Shape::Scale { gain }));
    let data = [
        of(RowGroup::Data, Shape::Freeze),
        of(RowGroup::Data, Shape::Stale),
        of(RowGroup::Data, Shape::Loss { probability: 1.0 }),
        of(RowGroup::Data, Shape::Loss { probability: 0.1 }),
        of(RowGroup::Data, Shape::Spike { size: 5e-3, probability: 0.02 }),
        Row { group: RowGroup::Data, wanted: Some(Wanted::BrokenWire(None)), ..open },
        Row { group: RowGroup::Data, wanted: Some(Wanted::OutOfRange(None)), ..open },
    ];
    let chance = Row { group: RowGroup::Chance, ..open };
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
            group: RowGroup::Loop,
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
    const fn open(group: RowGroup, cell: Cell, wanted: Option<Wanted>) -> Self {
        Self { group, cell, in_loop: false, wanted, watch: WATCH, claim: None, stream: 0 }
    }

    /// Whether each machine has one fault of C1 instead of one on every cylinder.
    pub fn is_alone(&self) -> bool {
        self.group == RowGroup::Loop
    }
}
