//! What the supply's pressure does by what all rods take.

use super::kept::{Consecutive, Pieces};
use super::pieces::ends;
use super::refusal::{LEAST_TIME, ProcessRefusal};
use super::scatter::{self, Left};
use crate::survey::{Lull, Ranking, Row, Surveyor};
use nalgebra::{DMatrix, DVector};
use tertius_config::settings::{Settings, SupplyTable};
use tertius_core::process::flow::{block_cycles, level};
use tertius_core::process::supply::{Oil, OilBlock, Shortfall, place};
use tertius_core::process::{OilSample, ProcessParameters, SupplyRelation};
use tertius_core::sequential::windows::WIDTHS;
use tertius_core::time;

/// Pieces of q.
const PIECES: usize = 8;

/// What keeps neighbouring pieces of q of the same slope, as a part of what a block of every knot teaches.
const SMOOTH: f64 = 1e-3;

/// Blocks that are kept: three hours, as of the rows of cylinders; and those of a piece, a minute.
const MOST: usize = 54_000;
const PIECE: usize = 300;

/// A block of the recording.
#[derive(Clone, Copy, Debug)]
struct SupplyBlock {
    /// Seconds since the recording's first frame.
    t: f64,
    block: OilBlock,
}

impl Consecutive for SupplyBlock {
    fn part(&mut self) {
        self.block.follows = false;
    }
}

/// The supply of a machine in a recording, in blocks of cycles.
#[derive(Clone, Debug)]
pub struct SupplyRows {
    sample_time: f64,
    opening: u32,
    cylinders: u8,
    oil: Oil,
    /// The cycle that is being read, and which cylinders it has.
    cycle: Option<u64>,
    sample: OilSample,
    read: u8,
    /// Cycles of the present stay in a monitored state.
    open: u32,
    lull: Lull,
    blocks: Pieces<SupplyBlock>,
}

impl SupplyRows {
    /// The supply of the machine of `settings`.
    pub fn new(settings: &Settings) -> Self {
        let sample_time = settings.machine.sample_time;
        Self {
            sample_time,
            opening: time::cycles(ProcessParameters::DEFAULT.opening, sample_time),
            cylinders: settings.machine.cylinders,
            oil: Oil::new(sample_time),
            cycle: None,
            sample: OilSample::default(),
            read: 0,
            open: 0,
            lull: Lull::default(),
            blocks: Pieces::new(MOST, PIECE),
        }
    }

    /// What the blocks teach, taken in the order of the recording's `ranking`, for a detector with a level of so many
    /// nats.
    ///
    /// # Errors
    /// They are too few, or do not determine it, or contradict it.
    pub fn learn(mut self, ranking: &Ranking, nats: f64) -> Result<SupplyTable, ProcessRefusal> {
        self.blocks.rank(ranking, |told| told.t);
        let blocks = self.blocks.rows();
        let seconds = f64::from(block_cycles(self.sample_time)) * self.sample_time;
        let known = blocks.len() as f64 * seconds;
        if known < LEAST_TIME {
            return Err(ProcessRefusal::Short { seconds: known, least: LEAST_TIME });
        }
        let sample_time = self.sample_time;
        let mut relation = fit(blocks, seconds).ok_or(ProcessRefusal::Undetermined)?;
        let left = blocks.iter().map(|told| Left {
            t: told.t,
            residual: relation.residual(&told.block, seconds),
            way: 0.0,
            follows: told.block.follows,
        });
        let left: Vec<Left> = left.collect();
        let parts = [scatter::parts(&left)[0], 0.0];
        let believed = parts[0].max(ProcessParameters::DEFAULT.supply_deviation);
        relation.dependence = scatter::dependence(&left, [believed, 0.0]);
        relation.deviation = believed;
        verify(&left, &relation, seconds, level(nats, sample_time))?;
        let SupplyRelation { reference, taught, pump, taken, dependence, .. } = relation;
        let ([mean_dependence, _], [deviation, _]) = (dependence, parts);
        Ok(SupplyTable { sample_time, reference, taught, pump, taken, deviation, mean_dependence })
    }

    /// Whether the cycle that is being read has all rods.
    const fn is_whole(&self) -> bool {
        self.read.count_ones() == self.cylinders as u32
    }

    /// Begins a cycle; one that does not follow a whole one begins anew.
    fn begin(&mut self, row: &Row) {
        let follows = self.cycle.is_some_and(|cycle| cycle + 1 == row.cycle) && self.is_whole();
        let is_after_pause = self.lull.ends(row.t);
        if is_after_pause {
            self.blocks.pause();
        }
        if is_after_pause || !row.monitored {
            self.open = 0;
        }
        if !follows || self.open == 0 {
            self.oil.reset();
        }
        self.open = self.open.saturating_add(row.monitored.into());
        (self.cycle, self.read) = (Some(row.cycle), 0);
    }
}

impl Surveyor for SupplyRows {
    fn row(&mut self, row: &Row) {
        if self.cycle != Some(row.cycle) {
            self.begin(row);
        }
        let index = usize::from(row.cylinder) - 1;
        if let (Some(length), Some(pressure)) = (row.c1, row.supply) {
            (self.sample.lengths[index], self.sample.pressure) = (length, pressure);
            self.read |= 1 << index;
        }
        if !self.is_whole() || self.open < self.opening {
            return;
        }
        if let Some(block) = self.oil.step(Some(&self.sample)) {
            self.blocks.push(SupplyBlock { t: row.t, block });
        }
    }

    fn gap(&mut self, _: u8) {
        self.read = 0;
    }
}

/// Least squares of the pressure's rise; `None` where the recording does not determine it, or has no pump that gives more
/// to a lower pressure.
fn fit(blocks: &[SupplyBlock], seconds: f64) -> Option<SupplyRelation> {
    const TERMS: usize = PIECES + 3;
    let [lowest, highest] = ends(blocks.iter().map(|told| told.block.pressure()).collect())?;
    let taught = [lowest, highest];
    if highest - lowest <= ProcessParameters::DEFAULT.supply_band {
        return None;
    }
    let sum: f64 = blocks.iter().map(|told| told.block.pressure()).sum();
    let reference = sum / blocks.len() as f64;
    let (mut normal, mut right) = (DMatrix::zeros(TERMS, TERMS), DVector::zeros(TERMS));
    for SupplyBlock { block, .. } in blocks {
        let (piece, part) = place(taught, PIECES, block.pressure());
        let [out, back] = block.ways;
        let terms = [
            (piece, seconds * (1.0 - part)),
            (piece + 1, seconds * part),
            (PIECES + 1, out),
            (PIECES + 2, back),
        ];
        for (i, by) in terms {
            terms.iter().for_each(|(j, other)| normal[(i, *j)] += by * other);
            right[i] += by * block.rise(reference);
        }
    }
    let weight = SMOOTH * blocks.len() as f64 * seconds * seconds;
    for middle in 1..PIECES {
        let bend = [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)];
        for (i, by) in bend {
            bend.iter().for_each(|(j, other)| normal[(i, *j)] += weight * by * other);
        }
    }
    let solved = normal.cholesky()?.solve(&right);
    let relation = SupplyRelation {
        reference,
        taught,
        pump: solved.iter().take(PIECES + 1).copied().collect(),
        taken: [solved[PIECES + 1], solved[PIECES + 2]],
        deviation: 1.0,
        dependence: [[1.0; WIDTHS.len()]; 2],
    };
    let is_a_pump =
        relation.pump.first() > relation.pump.last() && relation.taken.iter().all(|it| *it < 0.0);
    (is_a_pump && solved.iter().all(|it| it.is_finite())).then_some(relation)
}

/// Tries the detector on its own lesson, at its `level`, nats.
fn verify(
    left: &[Left],
    relation: &SupplyRelation,
    seconds: f64,
    level: f64,
) -> Result<(), ProcessRefusal> {
    let mut shortfall = Shortfall::new(relation, seconds);
    let (mut nats, mut at) = (0.0, 0.0);
    for one in left {
        if !one.follows {
            shortfall.clear();
        }
        shortfall.push(one.residual);
        let peak = shortfall.peak().nats;
        if peak > nats {
            (nats, at) = (peak, one.t);
        }
    }
    if nats < ProcessParameters::DEFAULT.doubtful * level {
        Ok(())
    } else {
        Err(ProcessRefusal::Contradicted { at, nats })
    }
}
