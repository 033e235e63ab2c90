//! What pressure it takes to move the rod.

use super::long_run;
use super::refusal::{LEAST_TIME, ProcessRefusal, enough};
use super::rows::ProcessRow;
use nalgebra::{SMatrix, SVector};
use tertius_config::settings::FrictionTable;
use tertius_core::process::friction::{
    FORCE_TERMS, ForceBlock, FrictionBlock, FrictionWeighing, FrictionWindows, SCATTERS,
};
use tertius_core::process::{ForceSample, Forces, FrictionDesign, ProcessParameters, flow};

/// A block of the recording.
struct TimedBlock<T> {
    /// Seconds since the recording's first frame.
    t: f64,
    /// How many blocks before it are joined to it.
    joined: usize,
    block: T,
}

/// Learns the relation from the rows of one cylinder whose C1 is `gain` times C2.
pub(super) fn learn(
    rows: &[ProcessRow],
    [gain, area_ratio]: [f64; 2],
    sample_time: f64,
    level: f64,
) -> Result<FrictionTable, ProcessRefusal> {
    let known = rows.iter().filter(|row| row.flow.is_some()).count();
    enough(known, sample_time, LEAST_TIME)?;
    let blocks = blocks(rows, gain, sample_time);
    let coefficients = fit(&blocks).ok_or(ProcessRefusal::Undetermined)?;
    let mut design = FrictionDesign { coefficients, scatter: [0.0; SCATTERS], area_ratio };
    let left = |it: &TimedBlock<ForceBlock>| TimedBlock {
        t: it.t,
        joined: it.joined,
        block: design.block(&it.block),
    };
    let left: Vec<TimedBlock<FrictionBlock>> = blocks.iter().map(left).collect();
    design.scatter = scatter(&left);
    verify(&left, &design, flow::level(level, sample_time))?;
    Ok(FrictionTable { coefficients, scatter: design.scatter })
}

/// What the detector makes of the rows.
fn blocks(rows: &[ProcessRow], gain: f64, sample_time: f64) -> Vec<TimedBlock<ForceBlock>> {
    let mut forces = Forces::new(sample_time);
    let (mut blocks, mut joined) = (Vec::new(), 0);
    for row in rows {
        if !row.follows {
            forces.reset();
        }
        let sample = row.flow.map(|flow| {
            let [c1, c2] = flow.lengths.map(f64::from);
            ForceSample { length: 0.5 * (c1 + gain * c2), load: flow.load.into() }
        });
        let block = forces.step(sample);
        if !forces.is_settled() {
            joined = 0;
        }
        if let Some(block) = block {
            blocks.push(TimedBlock { t: row.t, joined, block });
            joined += 1;
        }
    }
    blocks
}

/// Least squares of P_L; `None` where nothing moves.
fn fit(blocks: &[TimedBlock<ForceBlock>]) -> Option<[f64; FORCE_TERMS]> {
    let mut normal = SMatrix::<f64, FORCE_TERMS, FORCE_TERMS>::zeros();
    let mut right = SVector::<f64, FORCE_TERMS>::zeros();
    for TimedBlock { block, .. } in blocks {
        let terms = SVector::from(block.terms);
        normal += terms * terms.transpose();
        right += terms * block.load;
    }
    let solved = normal.cholesky()?.solve(&right);
    solved.iter().all(|it| it.is_finite()).then(|| solved.into())
}

/// Ω: the long-run covariance of what is left times the directions, by Bartlett's weights.
fn scatter(blocks: &[TimedBlock<FrictionBlock>]) -> [f64; SCATTERS] {
    let product =
        |it: &TimedBlock<FrictionBlock>| it.block.directions.map(|along| along * it.block.left);
    let products: Vec<[f64; 2]> = blocks.iter().map(product).collect();
    let joined: Vec<usize> = blocks.iter().map(|it| it.joined).collect();
    let [[coulomb, mixed], [_, viscous]] = long_run::covariance(&products, &joined);
    [coulomb, mixed, viscous].map(|sum| sum / blocks.len().max(1) as f64)
}

/// Tries the detector on its own lesson, at the detector's `level`, nats.
fn verify(
    blocks: &[TimedBlock<FrictionBlock>],
    design: &FrictionDesign,
    level: f64,
) -> Result<(), ProcessRefusal> {
    let weighing = FrictionWeighing::new(design).ok_or(ProcessRefusal::Undetermined)?;
    let mut windows = FrictionWindows::default();
    let (mut worst, mut at) = (0.0, 0.0);
    for TimedBlock { t, block, .. } in blocks {
        windows.push(block, &weighing);
        let nats = windows.peak(&weighing).nats;
        if nats > worst {
            (worst, at) = (nats, *t);
        }
    }
    let is_doubtful = worst > ProcessParameters::DEFAULT.doubtful * level;
    if is_doubtful { Err(ProcessRefusal::Contradicted { at, nats: worst }) } else { Ok(()) }
}
