//! How far the oil that passes the valve moves the rod.

use super::refusal::{LEAST_TIME, ProcessRefusal, enough};
use super::rows::ProcessRow;
use super::{long_run, pieces};
use nalgebra::{DMatrix, DVector};
use tertius_config::settings::{FlowTable, ValveCurve};
use tertius_core::process::flow::directions::{HALF, upper};
use tertius_core::process::flow::{
    self, Flow, FlowBlock, FlowWeighing, FlowWindows, Passage, block_cycles,
};
use tertius_core::process::parameters::DIRECTIONS;
use tertius_core::process::{Curve, FlowDesign, FlowSample, ProcessParameters, curve};

/// Pieces of f.
const PIECES: usize = 40;
/// Unknowns: f at its knots, c₁ and c₂.
const UNKNOWNS: usize = PIECES + 3;

/// Places of the spool between two cycles that are tried: the valve may be read before the Sync or after it.
const BETWEEN: [f64; 11] = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2];

/// What keeps values at knots near which no position was from running away, as a part of the mean diagonal of f.
const RIDGE: f64 = 1e-7;

/// What Ω gets, as a part of its trace, where a direction did not occur.
const FLOOR: f64 = 1e-9;

/// A machine with its rows, in the detector's form.
struct Lesson<'a> {
    rows: &'a [ProcessRow],
    sample_time: f64,
    /// a of (5-20).
    gain: f64,
    area_ratio: f64,
}

/// Learns the relation from the rows of one cylinder whose C1 is `gain` times C2.
pub(super) fn learn(
    rows: &[ProcessRow],
    [gain, area_ratio]: [f64; 2],
    sample_time: f64,
    level: f64,
) -> Result<FlowTable, ProcessRefusal> {
    let lesson = Lesson { rows, sample_time, gain, area_ratio };
    let (mut design, samples) = lesson.best(LEAST_TIME)?;
    let limit = design.limit;
    design.taught = FlowDesign::taught(&samples);
    let supplies = (0..rows.len()).filter_map(|index| Some(lesson.sample(index)?.supply));
    design.supplies = pieces::ends(supplies.collect()).ok_or(ProcessRefusal::Undetermined)?;
    let blocks = lesson.blocks(&design);
    design.scatter = [0, 1].map(|of| scatter(&blocks, of));
    lesson.verify(&blocks, &design, level)?;
    Ok(FlowTable {
        limit,
        curve: design.curve.values().to_vec(),
        samples,
        between: design.between,
        leakage: design.leakage,
        compression: design.compression,
        supplies: Some(design.supplies),
        scatter_c1: half(&design.scatter[0]),
        scatter_c2: half(&design.scatter[1]),
    })
}

/// The curve of a cylinder's valve from its rows, of at least `least` seconds, by the mean of C1 and `gain` times C2.
///
/// # Errors
/// Too few rows, or rows that do not determine it.
pub fn curve(
    rows: &[ProcessRow],
    gain: f64,
    sample_time: f64,
    least: f64,
) -> Result<ValveCurve, ProcessRefusal> {
    let lesson = Lesson { rows, sample_time, gain, area_ratio: 1.0 };
    let (design, samples) = lesson.best(least)?;
    let FlowDesign { limit, curve, between, leakage, compression, .. } = design;
    let curve = curve.values().to_vec();
    Ok(ValveCurve { limit, curve, samples, between, leakage, compression })
}

impl Lesson<'_> {
    /// The relation without its scatter, by rows of at least `least` seconds, and the samples in each piece of f.
    fn best(&self, least: f64) -> Result<(FlowDesign, Vec<u64>), ProcessRefusal> {
        let sizes: Vec<f32> = self.positions().map(|position| position.abs() as f32).collect();
        enough(sizes.len(), self.sample_time, least)?;
        let limit = pieces::limit(sizes).filter(|limit| *limit > 0.0);
        let limit = limit.ok_or(ProcessRefusal::Undetermined)?;
        let samples = pieces::samples(self.positions(), limit, PIECES);
        let fitted = BETWEEN.into_iter().filter_map(|between| self.fit(limit, between));
        let best = fitted.min_by(|one, other| one.0.total_cmp(&other.0));
        let (_, design) = best.ok_or(ProcessRefusal::Undetermined)?;
        if design.slope() > 0.0 { Ok((design, samples)) } else { Err(ProcessRefusal::Undetermined) }
    }

    /// The row of this index, if it has everything.
    fn sample(&self, index: usize) -> Option<FlowSample> {
        let row = &self.rows[index];
        let flow = row.flow?;
        let [c1, c2] = flow.lengths.map(f64::from);
        let [load, supply] = [flow.load, flow.supply?].map(f64::from);
        let lengths = Some([c1, self.gain * c2]);
        Some(FlowSample { lengths, spool: row.spool?.into(), load, supply, apart: None })
    }

    /// Positions of the spool in the rows that have everything.
    fn positions(&self) -> impl Iterator<Item = f64> {
        (0..self.rows.len()).filter_map(|index| Some(self.sample(index)?.spool))
    }

    /// Least squares of the mean way of both transducers over blocks: what it leaves, and the relation.
    fn fit(&self, limit: f64, between: f64) -> Option<(f64, FlowDesign)> {
        let mut normal = DMatrix::<f64>::zeros(UNKNOWNS, UNKNOWNS);
        let mut right = DVector::<f64>::zeros(UNKNOWNS);
        let mut squares = 0.0;
        self.regress(limit, between, |terms, way| {
            for (i, one) in terms.iter().enumerate().filter(|(_, one)| **one != 0.0) {
                right[i] += one * way;
                terms.iter().enumerate().for_each(|(j, other)| normal[(i, j)] += one * other);
            }
            squares += way * way;
        });
        let of_curve: f64 = (0..=PIECES).map(|i| normal[(i, i)]).sum();
        let ridge = RIDGE * of_curve / (PIECES + 1) as f64;
        (0..=PIECES).for_each(|i| normal[(i, i)] += ridge);
        let solved = normal.cholesky()?.solve(&right);
        let values = solved.as_slice();
        let left = squares - solved.dot(&right);
        let design = FlowDesign {
            limit,
            curve: Curve::new(limit, values[..=PIECES].to_vec()),
            taught: vec![true; PIECES],
            between,
            leakage: values[PIECES + 1],
            compression: values[PIECES + 2],
            area_ratio: self.area_ratio,
            supplies: [0.0, f64::INFINITY],
            scatter: [[[0.0; DIRECTIONS]; DIRECTIONS]; 2],
        };
        values.iter().all(|it| it.is_finite()).then_some((left, design))
    }

    /// Gives `take` what each block's way is compared with, and the way, m.
    fn regress(&self, limit: f64, between: f64, mut take: impl FnMut(&[f64; UNKNOWNS], f64)) {
        let block = block_cycles(self.sample_time);
        let (mut terms, mut first, mut last, mut cycles) = ([0.0; UNKNOWNS], None, None, 0);
        for index in 0..self.rows.len() {
            let sample = self.sample(index);
            let former: Option<FlowSample> = last.filter(|_| self.rows[index].follows);
            last = sample;
            let (Some(sample), Some(former)) = (sample, former) else {
                (terms, first, cycles) = ([0.0; UNKNOWNS], None, 0);
                continue;
            };
            let first_of_block = *first.get_or_insert(former);
            let passage = Passage::of(&former, &sample, between);
            let (piece, part) = curve::place(limit, PIECES, passage.position);
            let flow = self.sample_time * passage.root;
            terms[piece] += (1.0 - part) * flow;
            terms[piece + 1] += part * flow;
            terms[PIECES + 1] += self.sample_time * passage.load;
            cycles += 1;
            if cycles == block {
                terms[PIECES + 2] = sample.load - first_of_block.load;
                let mean = |sample: &FlowSample| sample.lengths.map(|[c1, c2]| 0.5 * (c1 + c2));
                if let Some((from, to)) = mean(&first_of_block).zip(mean(&sample)) {
                    take(&terms, to - from);
                }
                (terms, first, cycles) = ([0.0; UNKNOWNS], None, 0);
            }
        }
    }

    /// What the detector makes of the rows: blocks, and whether each follows the one before.
    fn blocks(&self, design: &FlowDesign) -> Vec<(f64, bool, FlowBlock)> {
        let mut flow = Flow::new(design.clone(), self.sample_time);
        let (mut blocks, mut is_joined) = (Vec::new(), false);
        for (index, row) in self.rows.iter().enumerate() {
            let sample = self.sample(index);
            if !row.follows || sample.is_none() {
                flow.reset();
                is_joined = false;
            }
            if let Some(block) = flow.step(sample) {
                blocks.push((row.t, is_joined, block));
                is_joined = true;
            }
        }
        blocks
    }

    /// Tries the detector on its own lesson.
    fn verify(
        &self,
        blocks: &[(f64, bool, FlowBlock)],
        design: &FlowDesign,
        level: f64,
    ) -> Result<(), ProcessRefusal> {
        let weighing = FlowWeighing::new(design).ok_or(ProcessRefusal::Undetermined)?;
        let level = flow::level(level, self.sample_time);
        let least = ProcessParameters::DEFAULT.doubtful * level;
        let mut windows = FlowWindows::default();
        let (mut worst, mut at) = (0.0, 0.0);
        for (t, _, block) in blocks {
            windows.push(block);
            let nats = windows.peak(&weighing, least).nats;
            if nats > worst {
                (worst, at) = (nats, *t);
            }
        }
        if worst > 0.0 { Err(ProcessRefusal::Contradicted { at, nats: worst }) } else { Ok(()) }
    }
}

/// Ω: the long-run covariance of what is left of one transducer times the directions, by Bartlett's weights.
fn scatter(blocks: &[(f64, bool, FlowBlock)], of: usize) -> [[f64; DIRECTIONS]; DIRECTIONS] {
    let products: Vec<[f64; DIRECTIONS]> = blocks
        .iter()
        .map(|(_, _, block)| block.directions.map(|direction| direction * block.left[of]))
        .collect();
    // How many blocks before it are joined to each.
    let mut joined = Vec::with_capacity(blocks.len());
    for (_, is_joined, _) in blocks {
        let before = joined.last().copied().unwrap_or(0_usize);
        joined.push(if *is_joined { before + 1 } else { 0 });
    }
    let mut sums = long_run::covariance(&products, &joined);
    let count = blocks.len().max(1) as f64;
    let trace: f64 = (0..DIRECTIONS).map(|i| sums[i][i]).sum();
    for (i, j) in upper() {
        let floor = if i == j { FLOOR * trace } else { 0.0 };
        sums[i][j] = (sums[i][j] + floor) / count;
        sums[j][i] = sums[i][j];
    }
    sums
}

fn half(whole: &[[f64; DIRECTIONS]; DIRECTIONS]) -> [f64; HALF] {
    let mut half = [0.0; HALF];
    for (value, (i, j)) in half.iter_mut().zip(upper()) {
        *value = whole[i][j];
    }
    half
}
