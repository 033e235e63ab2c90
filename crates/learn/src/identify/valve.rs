//! The flow curve of each valve in the form that a plant and the process detector take: the relation
//! ΔC = Ts Σ f(x̄) √((P_S ∓ P_L)/210 bar) + c₁ Ts Σ P_L + c₂ ΔP_L.
//!
//! (3-17) takes all oil that passes the valve for the rod's way, so that leakage and compression are in its curve
//! ([`super::flow`]). Fed back into (3-15), which has them besides, they would count twice; and inwards its flow is that of
//! the rod side, a_p l̇, while (3-15) adds speeds of the piston. Here f is that speed, without leakage and compression.

use super::flow::{NoFlow, Reach};
use super::validate::SignalScore;
use crate::relate::{ProcessRefusal, ProcessRows, flow};
use crate::survey::{Row, Surveyor};
use std::collections::VecDeque;
use tertius_config::settings::{ValveCurve, ValveFlow};
use thiserror::Error;

/// Shortest time from which a curve is identified, s.
pub const LEAST_TIME: f64 = 120.0;

/// Least speed, at a pressure drop of 210 bar, up to which a curve has to be known each way, m/s.
pub const LEAST_SPEED: f64 = 0.05;

/// Least share of the rod's motion that a curve has to explain on the data of the trial, % of the variance.
pub const LEAST_SHARE: f64 = 90.0;

/// Cycles over which the velocity of a trial is taken: 0.2 s at 50 Hz.
const SPEED_CYCLES: usize = 10;

/// A curve, and how it does on data that it was not identified on.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentifiedValve {
    pub curve: ValveCurve,
    /// Outermost positions of the spool for which f is known, in and out.
    pub reach: [f64; 2],
    pub score: ValveScore,
}

/// Accuracy of a rod that is moved by the curve alone, from the recorded spool and pressures, open loop.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ValveScore {
    /// Accuracy of the position, m.
    pub position: SignalScore,
    /// Accuracy of the velocity over 0.2 s, m/s.
    pub velocity: SignalScore,
}

/// Why there is no curve.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoValve {
    #[error(
        "no spool position is configured: a curve by the command is not the valve's; name \
         signals.cylinder.spool, and record it"
    )]
    NoSpool,
    #[error(transparent)]
    Missing(#[from] NoFlow),
    #[error("{0}")]
    Refused(ProcessRefusal),
    #[error(
        "the spool was not excited: {way} the curve is known up to {speed_mm_s:.0} mm/s only, and it \
         takes {:.0}; record the platform engaged in a sea", 1e3 * LEAST_SPEED
    )]
    NotExcited { way: &'static str, speed_mm_s: f64 },
    #[error(
        "compression is {compression:e} m per bar, expected -1 to -1e-5: load pressure and motion do \
         not belong together; is machine.area_ratio right?"
    )]
    Compression { compression: f64 },
    #[error(
        "spool and pressures explain {share:.1} % of the rod's velocity in the trial, and it takes \
         {LEAST_SHARE:.0} %: do the signals belong to this cylinder, and is the machine healthy?"
    )]
    Unexplained { share: f64 },
}

/// The curve of cylinder `n`, which reached as far as `reach` says.
///
/// # Errors
/// What is missing, or too little motion.
pub fn curve(
    rows: &ProcessRows,
    n: u8,
    reach: &Reach,
    has_spool: bool,
    sample_time: f64,
) -> Result<(ValveCurve, ValveFlow), NoValve> {
    if !has_spool {
        return Err(NoValve::NoSpool);
    }
    // The velocity is in the curve of (3-17) alone.
    let [_, missing @ ..] = reach.missing;
    Reach { missing: [0, missing[0], missing[1], missing[2]], ..*reach }.judge()?;
    let curve = flow::curve(rows.of(n), 1.0, sample_time, LEAST_TIME).map_err(NoValve::Refused)?;
    let known = curve.flow();
    let reach = known.as_ref().map_or([0.0; 2], ValveFlow::reach);
    let ways = ["inwards", "outwards"].into_iter().zip(reach).zip([-1.0, 1.0]);
    for ((way, x), sign) in ways {
        let speed = known.as_ref().map_or(0.0, |known| sign * known.at(x));
        if speed < LEAST_SPEED {
            return Err(NoValve::NotExcited { way, speed_mm_s: 1e3 * speed });
        }
    }
    let compression = curve.compression;
    if !(-1.0..=-1e-5).contains(&compression) {
        return Err(NoValve::Compression { compression });
    }
    known.map(|known| (curve, known)).ok_or(NoValve::NotExcited { way: "at all", speed_mm_s: 0.0 })
}

/// Tries the curves of all cylinders.
#[derive(Clone, Debug)]
pub struct ValveTrial {
    sample_time: f64,
    area_ratio: f64,
    supply: Option<f64>,
    cylinders: Vec<Result<Tried, NoValve>>,
}

#[derive(Clone, Debug)]
struct Tried {
    curve: ValveCurve,
    flow: ValveFlow,
    /// The newest cycle, and the position that the curve gives for it.
    last: Option<(Moment, f64)>,
    /// Recorded and modelled positions of the newest cycles, the oldest first.
    positions: VecDeque<[f64; 2]>,
    score: ValveScore,
}

/// One cycle of one cylinder.
#[derive(Clone, Copy, Debug)]
struct Moment {
    cycle: u64,
    length: f64,
    spool: f64,
    load: f64,
    supply: f64,
}

impl ValveTrial {
    /// A trial of the curves of all cylinders from 1, on a machine with this sample time, s, area ratio (3-5) and supply
    /// pressure, bar, if that is not recorded.
    pub fn new(
        curves: impl Iterator<Item = Result<(ValveCurve, ValveFlow), NoValve>>,
        sample_time: f64,
        area_ratio: f64,
        supply: Option<f64>,
    ) -> Self {
        let tried = |(curve, flow)| Tried {
            curve,
            flow,
            last: None,
            positions: VecDeque::with_capacity(SPEED_CYCLES + 1),
            score: ValveScore::default(),
        };
        let cylinders = curves.map(|curve| curve.map(tried)).collect();
        Self { sample_time, area_ratio, supply, cylinders }
    }

    /// The curve of each cylinder with its score, or why there is none.
    pub fn finish(self) -> Vec<Result<IdentifiedValve, NoValve>> {
        let judged = |tried: Tried| {
            let Tried { curve, flow, score, .. } = tried;
            let share = score.velocity.vaf();
            // What ran beyond the finite numbers has no share at all.
            if share >= LEAST_SHARE {
                Ok(IdentifiedValve { curve, reach: flow.reach(), score })
            } else {
                Err(NoValve::Unexplained { share })
            }
        };
        self.cylinders.into_iter().map(|tried| tried.and_then(judged)).collect()
    }
}

impl Surveyor for ValveTrial {
    fn row(&mut self, row: &Row) {
        let place = usize::from(row.cylinder).wrapping_sub(1);
        let Some(Ok(tried)) = self.cylinders.get_mut(place) else { return };
        let moment = || {
            Some(Moment {
                cycle: row.cycle,
                length: row.c1?,
                spool: row.spool?,
                load: row.load_pressure(self.area_ratio)?,
                supply: self.supply.or(row.supply)?,
            })
        };
        match moment().filter(|_| row.monitored) {
            Some(moment) => tried.step(moment, self.sample_time),
            None => tried.last = None,
        }
    }

    fn gap(&mut self, cylinder: u8) {
        let place = usize::from(cylinder).wrapping_sub(1);
        if let Some(Ok(tried)) = self.cylinders.get_mut(place) {
            tried.last = None;
        }
    }
}

impl Tried {
    fn step(&mut self, moment: Moment, sample_time: f64) {
        let before = self.last.filter(|(last, _)| last.cycle + 1 == moment.cycle);
        let Some((last, position)) = before else {
            self.positions.clear();
            self.last = Some((moment, moment.length));
            return;
        };
        let position = position + self.way(&last, &moment, sample_time);
        self.last = Some((moment, position));
        self.score.position.add(moment.length, position);
        self.positions.push_back([moment.length, position]);
        if self.positions.len() > SPEED_CYCLES
            && let Some(oldest) = self.positions.pop_front()
        {
            let time = SPEED_CYCLES as f64 * sample_time;
            let [measured, modelled] = [0, 1].map(|i| {
                let newest = if i == 0 { moment.length } else { position };
                (newest - oldest[i]) / time
            });
            self.score.velocity.add(measured, modelled);
        }
    }

    /// How far the rod goes from one cycle to the next, m.
    fn way(&self, last: &Moment, moment: &Moment, sample_time: f64) -> f64 {
        let ValveCurve { between, leakage, compression, .. } = self.curve;
        let spool = last.spool + between * (moment.spool - last.spool);
        let [load, supply] =
            [last.load + moment.load, last.supply + moment.supply].map(|it| 0.5 * it);
        let speed = self.flow.speed(spool, load, supply) + leakage * load;
        sample_time * speed + compression * (moment.load - last.load)
    }
}
