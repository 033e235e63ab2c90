//! Where the main spool should stand by the command, and where it stands.
//!
//! x̂(k+1) = a x̂(k) + g(u(k)) + g₂(u(k−1)): a lag behind the controller's look-up table. The command of the cycle before
//! acts until the new one has reached the valve. The prediction runs free and never sees the position, since a
//! spool that sticks would else take it along.

use super::curve::Curve;
use super::parameters::ProcessParameters;
use crate::sequential::windows::WIDTHS;
use crate::state::{state, whole};
use crate::time;
use alloc::vec::Vec;

/// What is known of a spool. Positions are in the unit of its signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SpoolDesign {
    /// a: what of the position is left after a cycle.
    pub retained: f64,
    /// Command of the outermost knots of both curves, m/s.
    pub limit: f64,
    /// g, by the command of the cycle.
    pub curve: Curve,
    /// g₂, by that of the cycle before.
    pub before: Curve,
    /// How far the curves may be off in each piece of g: zero where enough commands were learnt; their whole rise where
    /// commands were rare but those on both sides were learnt, as at rest. `None`: not learnt.
    pub doubts: Vec<Option<f64>>,
    /// Standard deviation of x − x̂ at rest, as it was measured.
    pub noise: f64,
    /// What is taken for it, and what it grows by with a movement within a cycle.
    pub deviation: f64,
    pub timing: f64,
    /// Largest position that was taught.
    pub largest: f64,
    /// Numbers of dependent samples of mean and spread, see [`super::Weighing`].
    pub dependence: [[f64; WIDTHS.len()]; 2],
}

/// A spool beside where it should stand, in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stand {
    pub position: f64,
    pub expected: f64,
    /// Variance of their difference.
    pub variance: f64,
    /// How far the prediction may be off because its recent commands were rare when it was learnt.
    pub doubt: f64,
    /// Whether the prediction has forgotten where it began, on commands that were taught.
    pub is_settled: bool,
}

impl Stand {
    /// The part of x − x̂ that exceeds what the prediction may be off.
    pub fn residual(&self) -> f64 {
        let residual = self.position - self.expected;
        residual - residual.clamp(-self.doubt, self.doubt)
    }
}

/// The prediction of a spool's position.
#[derive(Clone, Debug)]
pub struct Spool {
    design: SpoolDesign,
    /// Cycles until a prediction that began anywhere is right.
    settling: u32,
    /// [`ProcessParameters::spool_bend`], cycles².
    bend: f64,
    run: Run,
}

state! {
    Spool { run }
    but { design, settling, bend }
}

/// What changes from cycle to cycle.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    /// x̂ of this cycle, once there is one, and of the two before.
    expected: Option<[f64; 3]>,
    /// g₂ of the command of the cycle before.
    before: Option<f64>,
    /// Cycles that are left until it is right.
    unsettled: u32,
    /// How far it may be off.
    doubt: f64,
}

whole! { Run { expected, before, unsettled, doubt } }

impl Spool {
    pub fn new(design: SpoolDesign, sample_time: f64) -> Self {
        let by = &ProcessParameters::DEFAULT;
        let settling = time::cycles(by.settling, sample_time).max(2);
        let bend = by.spool_bend / (sample_time * sample_time);
        Self { design, settling, bend, run: Run::default() }
    }

    pub const fn design(&self) -> &SpoolDesign {
        &self.design
    }

    pub fn reset(&mut self) {
        self.run = Run::default();
    }

    /// One cycle: `command` u(k), m/s, and the spool's position x(k), both as sent. `None` without both.
    // What it returns is taken apart at once: as a call it goes through memory, for 50 instructions.
    #[inline(always)]
    pub fn step(&mut self, command: Option<f64>, position: Option<f64>) -> Option<Stand> {
        let Self { design, settling, bend, run } = self;
        let Some(command) = command else {
            *run = Run::default();
            return None;
        };
        let at = design.curve.place(command);
        let own = design.before.at(command);
        let before = run.before.replace(own).unwrap_or(own);
        if run.expected.is_none() {
            run.unsettled = *settling;
        }
        let [expected, former, earlier] = run.expected.or(position.map(|here| [here; 3]))?;
        let stand = position.map(|position| {
            let way = design.timing * (expected - former);
            let bent = *bend * (expected - 2.0 * former + earlier);
            let variance = design.deviation * design.deviation + way * way + bent * bent;
            let (doubt, is_settled) = (run.doubt, run.unsettled == 0);
            Stand { position, expected, variance, doubt, is_settled }
        });
        let doubt = design.doubts[at.0].filter(|_| command.abs() <= design.limit);
        run.unsettled = match doubt {
            Some(_) => run.unsettled.saturating_sub(1),
            None => *settling,
        };
        run.doubt = design.retained * run.doubt + doubt.unwrap_or_default();
        let next = design.retained * expected + design.curve.at_place(at) + before;
        // Whatever is not finite gets there first.
        run.expected = next.is_finite().then_some([next, expected, former]);
        stand
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    /// Spool and command rise alike, but that the commands next to rest are rare and the curve may be 2 off there.
    fn spool() -> Spool {
        let design = SpoolDesign {
            retained: 0.5,
            limit: 1.0,
            curve: Curve::new(1.0, vec![-10.0, -2.5, 0.0, 2.5, 10.0]),
            before: Curve::new(1.0, vec![0.0; 3]),
            doubts: vec![Some(0.0), Some(2.0), Some(2.0), None],
            noise: 0.1,
            deviation: 0.1,
            timing: 0.0,
            largest: 20.0,
            dependence: [[1.0; WIDTHS.len()]; 2],
        };
        Spool::new(design, 0.02)
    }

    /// Where the spool is found after ten seconds of this command, at `position`.
    fn after(command: f64, position: f64) -> Stand {
        let mut spool = spool();
        for _ in 0..500 {
            spool.step(Some(command), Some(position));
        }
        spool.step(Some(command), Some(position)).expect("both have come")
    }

    #[test]
    fn a_command_that_stands_at_rest_is_judged_beyond_what_the_curve_may_be_off() {
        let stand = after(0.0, 30.0);
        assert!(stand.is_settled && (stand.doubt - 4.0).abs() < 1e-6, "{stand:?}");
        assert!((stand.residual() - 26.0).abs() < 1e-6, "{stand:?}");
        for within in [-3.9, 0.0, 3.9] {
            assert_eq!(after(0.0, within).residual(), 0.0, "{within}");
        }
    }

    /// From end to end in each cycle, as a rod whose seals stick and slip may be commanded to within some.
    #[test]
    fn the_faster_a_prediction_swings_the_less_it_is_known() {
        let mut spool = spool();
        let stands: Vec<Stand> = (0..600)
            .map(|k| [-1.0, -0.9][k / (if k < 300 { 300 } else { 1 }) % 2])
            .map(|command| spool.step(Some(command), Some(0.0)).expect("both have come"))
            .collect();
        let bend = ProcessParameters::DEFAULT.spool_bend / (0.02 * 0.02);
        for three in stands.windows(3) {
            let [earlier, former, now] = [three[0], three[1], three[2]];
            let bent = bend * (now.expected - 2.0 * former.expected + earlier.expected);
            assert!((now.variance - 0.01 - bent * bent).abs() < 1e-9, "{now:?}");
        }
        assert!((stands[299].variance - 0.01).abs() < 1e-9 && stands[599].variance > 0.02);
    }

    #[test]
    fn commands_that_were_taught_leave_no_doubt_and_those_beyond_all_are_not_judged() {
        let stand = after(-1.0, -21.0);
        assert!(stand.is_settled && stand.doubt < 1e-9, "{stand:?}");
        assert!((stand.residual() + 1.0).abs() < 1e-6, "{stand:?}");
        assert!(!after(0.9, 20.0).is_settled, "nobody knows");
        assert!(!after(-1.1, -20.0).is_settled, "beyond the curve");
    }
}
