//! What the pressures of both chambers add up to.

use super::pieces::ends;
use super::refusal::{LEAST_TIME, ProcessRefusal, enough};
use super::rows::ProcessRow;
use super::scatter::{self, Left, Scatter};
use nalgebra::{SMatrix, SVector};
use tertius_config::settings::ChambersTable;
use tertius_core::process::chambers::{TERMS, terms};
use tertius_core::process::{ChambersDesign, ProcessParameters};
use tertius_core::sequential::windows::WIDTHS;

/// Learns the relation from the rows of one cylinder; where the machine reads spools, from those with its position.
pub(super) fn learn(
    rows: &[ProcessRow],
    has_spool: bool,
    sample_time: f64,
    level: f64,
) -> Result<ChambersTable, ProcessRefusal> {
    let is_known =
        |row: &&ProcessRow| row.pressures.is_some() && (row.spool.is_some() || !has_spool);
    let known: Vec<&ProcessRow> = rows.iter().filter(is_known).collect();
    enough(known.len(), sample_time, LEAST_TIME)?;
    let coefficients = fit(&known).ok_or(ProcessRefusal::Undetermined)?;
    let (deviation, growth, dependence) = (1.0, 0.0, [[1.0; WIDTHS.len()]; 2]);
    let supplies = known.iter().filter_map(|row| row.pressures.map(|[.., supply]| supply.into()));
    let supplies = ends(supplies.collect()).ok_or(ProcessRefusal::Undetermined)?;
    let design = ChambersDesign { coefficients, supplies, deviation, growth, dependence };
    let left = |row: &&ProcessRow| {
        let ([bottom, rod, supply], spool) = values(row)?;
        let residual = design.residual([bottom, rod], supply, spool)?;
        let way = spool.map_or(0.0, |spool| spool * spool);
        Some(Left { t: row.t, residual, way, follows: row.follows })
    };
    let left: Vec<Left> = known.iter().filter_map(left).collect();
    let by = &ProcessParameters::DEFAULT;
    let (least, band) = (by.least_deviations[1], by.chambers_band);
    let Scatter { parts: [deviation, growth], dependence: [mean_dependence, square_dependence] } =
        scatter::measure(&left, least, band, sample_time, level)?;
    let supplies = Some(supplies);
    Ok(ChambersTable {
        coefficients,
        supplies,
        deviation,
        growth,
        mean_dependence,
        square_dependence,
    })
}

/// P_bot, P_rod and P_S, bar, and the spool's position.
fn values(row: &ProcessRow) -> Option<([f64; 3], Option<f64>)> {
    Some((row.pressures?.map(f64::from), row.spool.map(f64::from)))
}

/// What keeps a coefficient of a signal that never moves at 0, as a part of the mean diagonal.
const RIDGE: f64 = 1e-9;

/// Least squares of P_bot + P_rod.
fn fit(rows: &[&ProcessRow]) -> Option<[f64; TERMS]> {
    let (mut normal, mut right) =
        (SMatrix::<f64, TERMS, TERMS>::zeros(), SVector::<f64, TERMS>::zeros());
    for row in rows {
        let Some(([bottom, rod, supply], spool)) = values(row) else { continue };
        // Without a spool its coefficient gets nothing but the ridge, and is 0.
        let terms = SVector::from(terms([bottom, rod], supply, spool.unwrap_or(0.0)));
        normal += terms * terms.transpose();
        right += terms * (bottom + rod);
    }
    let ridge = RIDGE * normal.trace() / TERMS as f64;
    normal += SMatrix::from_diagonal_element(ridge);
    let solved = normal.cholesky()?.solve(&right);
    solved.iter().all(|it| it.is_finite()).then(|| solved.into())
}
