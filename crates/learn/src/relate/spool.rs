//! Where the spool stands by the command.

use super::pieces;
use super::refusal::{LEAST_TIME, ProcessRefusal, enough};
use super::rows::ProcessRow;
use super::scatter::{self, Left, Scatter};
use nalgebra::{DMatrix, DVector};
use tertius_config::settings::SpoolTable;
use tertius_core::process::{Curve, ProcessParameters, Spool, SpoolDesign, curve};
use tertius_core::sequential::windows::WIDTHS;

/// Pieces of g and of g₂: short enough that a bend of the controller's look-up table between two knots is below the dead
/// band.
const PIECES: usize = 64;
const PIECES_BEFORE: usize = 32;
/// Unknowns: a, and the values of both curves at their knots.
const UNKNOWNS: usize = 1 + (PIECES + 1) + (PIECES_BEFORE + 1);

/// What keeps values at knots near which no command came from running away, as a part of the mean diagonal.
const RIDGE: f64 = 1e-9;

/// Commands that are smaller everywhere move no valve, m/s.
const LEAST_LIMIT: f64 = 1e-3;

/// Learns the relation from the rows of one cylinder.
pub(super) fn learn(
    rows: &[ProcessRow],
    sample_time: f64,
    level: f64,
) -> Result<SpoolTable, ProcessRefusal> {
    let count = rows.iter().filter(|row| row.spool.is_some()).count();
    enough(count, sample_time, LEAST_TIME)?;
    let commands = rows.iter().map(|row| row.command.abs()).collect();
    let limit = pieces::limit(commands).filter(|limit| *limit > LEAST_LIMIT);
    let limit = limit.ok_or(ProcessRefusal::Undetermined)?;
    let design = fit(rows, limit).ok_or(ProcessRefusal::Undetermined)?;
    let left = run(rows, &design, sample_time);
    let by = &ProcessParameters::DEFAULT;
    let [least, dead_band] =
        [by.least_deviations[0], by.spool_band].map(|part| part * design.largest);
    let Scatter { parts: [deviation, timing], dependence: [mean_dependence, square_dependence] } =
        scatter::measure(&left, least, dead_band, sample_time, level)?;
    let known = rows.iter().filter(|row| row.spool.is_some()).map(|row| f64::from(row.command));
    Ok(SpoolTable {
        retained: design.retained,
        limit,
        curve: design.curve.values().to_vec(),
        before: design.before.values().to_vec(),
        samples: pieces::samples(known, limit, PIECES),
        deviation,
        timing,
        largest: design.largest,
        mean_dependence,
        square_dependence,
    })
}

/// Least squares of x(k+1) by x(k), u(k) and u(k−1).
fn fit(rows: &[ProcessRow], limit: f64) -> Option<SpoolDesign> {
    let mut normal = DMatrix::<f64>::zeros(UNKNOWNS, UNKNOWNS);
    let mut right = DVector::<f64>::zeros(UNKNOWNS);
    let mut largest = 0.0_f64;
    for three in rows.windows(3).filter(|three| three[1].follows && three[2].follows) {
        let (Some(now), Some(next)) = (three[1].spool, three[2].spool) else { continue };
        let [now, next] = [now, next].map(f64::from);
        let [last, command] = [three[0].command, three[1].command].map(f64::from);
        if command.abs() > limit || last.abs() > limit {
            continue;
        }
        largest = largest.max(next.abs());
        let (at, part) = curve::place(limit, PIECES, command);
        let (before, part_before) = curve::place(limit, PIECES_BEFORE, last);
        let (of, of_before) = (1 + at, 2 + PIECES + before);
        let row = [
            (0, now),
            (of, 1.0 - part),
            (of + 1, part),
            (of_before, 1.0 - part_before),
            (of_before + 1, part_before),
        ];
        for (i, one) in row {
            right[i] += one * next;
            for (j, other) in row {
                normal[(i, j)] += one * other;
            }
        }
    }
    // Both curves may be shifted against each other: the ridge decides.
    let ridge = RIDGE * normal.trace() / UNKNOWNS as f64;
    (1..UNKNOWNS).for_each(|i| normal[(i, i)] += ridge);
    let solved = normal.cholesky()?.solve(&right);
    let values = |from: usize, count: usize| solved.as_slice()[from..from + count].to_vec();
    let retained = solved[0];
    let is_sound = (0.0..0.9999).contains(&retained) && solved.iter().all(|it| it.is_finite());
    (is_sound && largest > 0.0).then(|| SpoolDesign {
        retained,
        limit,
        curve: Curve::new(limit, values(1, PIECES + 1)),
        before: Curve::new(limit, values(2 + PIECES, PIECES_BEFORE + 1)),
        doubts: vec![Some(0.0); PIECES],
        noise: 1.0,
        deviation: 1.0,
        timing: 0.0,
        largest,
        dependence: [[1.0; WIDTHS.len()]; 2],
    })
}

/// What the prediction, which runs freely, leaves.
fn run(rows: &[ProcessRow], design: &SpoolDesign, sample_time: f64) -> Vec<Left> {
    let mut spool = Spool::new(design.clone(), sample_time);
    let (mut left, mut former, mut is_joined) = (Vec::with_capacity(rows.len()), None, false);
    for row in rows {
        if !row.follows {
            spool.reset();
            (former, is_joined) = (None, false);
        }
        let stand = spool.step(Some(row.command.into()), row.spool.map(f64::from));
        let before = former;
        former = stand.as_ref().map(|stand| stand.expected);
        let Some(stand) = stand.filter(|stand| stand.is_settled) else { continue };
        let way = before.map_or(0.0, |before| stand.expected - before);
        left.push(Left { t: row.t, residual: stand.residual(), way, follows: is_joined });
        is_joined = true;
    }
    left
}
