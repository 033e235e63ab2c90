//! What the supply's pressure does by what all rods take.

use super::scatter::{self, Left};
use super::{LEAST_TIME, ProcessRefusal};
use crate::survey::{Lull, Ranking, Row, Surveyor};
use nalgebra::{DMatrix, DVector};
use tertius_config::settings::{Settings, SupplyTable};
use tertius_core::process::flow::{block_cycles, level};
use tertius_core::process::supply::{Oil, OilBlock, Shortfall, place};
use tertius_core::process::{OilSample, ProcessParameters, SupplyDesign};
use tertius_core::time;

/// Pieces of q.
const PIECES: usize = 8;

/// What keeps neighbouring pieces of q of the same slope, as a part of what a block of every knot teaches.
const SMOOTH: f64 = 1e-3;

/// Part of the blocks beyond the outermost knots of q, on either side.
const BEYOND: f64 = 1e-3;

/// Blocks that are kept: 30 hours, 25 MB. More teach nothing new.
const MOST: usize = 540_000;

/// A block of the recording.
#[derive(Clone, Copy, Debug)]
struct Told {
    /// Seconds since the recording's first frame.
    t: f64,
    block: OilBlock,
}

/// The supply of a machine in a recording, in blocks of cycles.
#[derive(Clone, Debug)]
pub struct SupplyRows {
    sample_time: f64,
    opening: u32,
    cylinders: u8,
    oil: Oil,
    /// The cycle that is being read, and which cylinders it has.
    cycle: u64,
    sample: OilSample,
    read: u8,
    /// Cycles of the present stay in a monitored state.
    open: u32,
    lull: Lull,
    blocks: Vec<Told>,
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
            cycle: 0,
            sample: OilSample::default(),
            read: 0,
            open: 0,
            lull: Lull::default(),
            blocks: Vec::new(),
        }
    }

    /// What the blocks teach, taken in the order of the recording's `ranking`, for a detector with a level of so many
    /// nats.
    ///
    /// # Errors
    /// They are too few, or do not determine it, or contradict it.
    pub fn learn(mut self, ranking: &Ranking, nats: f64) -> Result<SupplyTable, ProcessRefusal> {
        self.blocks.sort_by_key(|told| ranking.rank(told.t));
        let seconds = f64::from(block_cycles(self.sample_time)) * self.sample_time;
        let known = self.blocks.len() as f64 * seconds;
        if known < LEAST_TIME {
            return Err(ProcessRefusal::Short { seconds: known, least: LEAST_TIME });
        }
        let mut design = fit(&self.blocks, seconds).ok_or(ProcessRefusal::Undetermined)?;
        (design.level, design.sample_time) = (nats, self.sample_time);
        let left = self.blocks.iter().map(|told| Left {
            t: told.t,
            residual: design.residual(&told.block, seconds),
            way: 0.0,
            follows: told.block.follows,
        });
        let left: Vec<Left> = left.collect();
        let parts = [scatter::parts(&left)[0], 0.0];
        let believed = parts[0].max(ProcessParameters::DEFAULT.supply_deviation);
        design.dependence = scatter::dependence(&left, [believed, 0.0]);
        design.deviation = believed;
        verify(&left, &design, seconds)?;
        let SupplyDesign { reference, taught, pump, taken, dependence, .. } = design;
        let (sample_time, deviation) = (self.sample_time, parts[0]);
        let [mean_dependence, _] = dependence;
        Ok(SupplyTable { sample_time, reference, taught, pump, taken, deviation, mean_dependence })
    }

    /// Whether the cycle that is being read has all rods.
    const fn is_whole(&self) -> bool {
        self.read.count_ones() == self.cylinders as u32
    }

    /// Ends the cycle that is being read.
    fn close(&mut self, t: f64) {
        if self.read == 0 {
            return;
        }
        let is_whole = self.is_whole();
        self.read = 0;
        let sample = Some(&self.sample).filter(|_| is_whole && self.open >= self.opening);
        if let Some(block) = self.oil.step(sample).filter(|_| self.blocks.len() < MOST) {
            self.blocks.push(Told { t, block });
        }
    }

    /// Begins a cycle.
    fn begin(&mut self, row: &Row) {
        let is_next = row.cycle == self.cycle + 1;
        if self.lull.ends(row.t) || !row.monitored {
            self.open = 0;
        }
        if !is_next || self.open == 0 {
            self.oil.reset();
        }
        self.open = if row.monitored { self.open.saturating_add(1) } else { 0 };
        self.cycle = row.cycle;
    }
}

impl Surveyor for SupplyRows {
    fn row(&mut self, row: &Row) {
        if self.read == 0 || row.cycle != self.cycle {
            self.close(row.t);
            self.begin(row);
        }
        let index = usize::from(row.cylinder) - 1;
        if let (Some(length), Some(pressure)) = (row.c1, row.supply) {
            (self.sample.lengths[index], self.sample.pressure) = (length, pressure);
            self.read |= 1 << index;
        }
        if self.is_whole() {
            self.close(row.t);
        }
    }

    fn gap(&mut self, _: u8) {
        self.read = 0;
        self.oil.reset();
    }
}

/// The pressures at the outermost knots, bar; `None` where it hardly moves.
fn ends(blocks: &[Told]) -> Option<[f64; 2]> {
    let mut pressures: Vec<f64> = blocks.iter().map(|told| told.block.pressure()).collect();
    pressures.sort_unstable_by(f64::total_cmp);
    let last = pressures.len().checked_sub(1)?;
    let beyond = (BEYOND * last as f64) as usize;
    let [lowest, highest] = [pressures[beyond], pressures[last - beyond]];
    (highest - lowest > ProcessParameters::DEFAULT.supply_band).then_some([lowest, highest])
}

/// Least squares of the pressure's rise; `None` where the recording does not determine it, or has no pump that gives more
/// to a lower pressure.
fn fit(blocks: &[Told], seconds: f64) -> Option<SupplyDesign> {
    const TERMS: usize = PIECES + 3;
    let taught = ends(blocks)?;
    let sum: f64 = blocks.iter().map(|told| told.block.pressure()).sum();
    let reference = sum / blocks.len() as f64;
    let (mut normal, mut right) = (DMatrix::zeros(TERMS, TERMS), DVector::zeros(TERMS));
    for Told { block, .. } in blocks {
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
    let design = SupplyDesign {
        reference,
        taught,
        pump: solved.iter().take(PIECES + 1).copied().collect(),
        taken: [solved[PIECES + 1], solved[PIECES + 2]],
        deviation: 1.0,
        dependence: Default::default(),
        level: 0.0,
        sample_time: 0.0,
        clear: 0,
    };
    let is_a_pump =
        design.pump.first() > design.pump.last() && design.taken.iter().all(|it| *it < 0.0);
    (is_a_pump && solved.iter().all(|it| it.is_finite())).then_some(design)
}

/// Tries the detector on its own lesson.
fn verify(left: &[Left], design: &SupplyDesign, seconds: f64) -> Result<(), ProcessRefusal> {
    let mut shortfall = Shortfall::new(design, seconds);
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
    let most = ProcessParameters::DEFAULT.doubtful * level(design.level, design.sample_time);
    if nats < most { Ok(()) } else { Err(ProcessRefusal::Contradicted { at, nats }) }
}
