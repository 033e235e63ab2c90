//! What the fault detection estimators classify by, beside the thresholds, which are configured.

use crate::time;

/// Residuals R1 or R2 that are kept: those of [`VerdictParameters::window`] up to 100 Hz.
pub const LONGEST_WINDOW: usize = 32;

/// Residuals R3 that are kept: those of [`VerdictParameters::differences`] up to 100 Hz.
pub const LONGEST_DIFFERENCES: usize = 128;

/// Samples beyond a threshold that are kept: those of [`VerdictParameters::often`].
pub const KEPT_EXCEEDED: usize = 7;

/// Newest wild readings whose times show how frequent they are.
pub const KEPT_WILD: usize = 8;

/// Most samples that a residual has to stay beyond its threshold to be a fault.
pub const LONGEST_WAIT: usize = 5;

const _: () = {
    let VerdictParameters { often, again, lasting, frequent, .. } = VerdictParameters::DEFAULT;
    assert!(again <= often && often <= KEPT_EXCEEDED);
    assert!(lasting as usize + frequent.len() <= LONGEST_WAIT);
};

/// The numbers of the classification (Table 5-1). Times are in seconds; a kind is told from samples, so
/// that below 50 Hz each of them is as many as at 50 Hz ([`time::samples`]).
#[derive(Clone, Debug, PartialEq)]
pub struct VerdictParameters {
    /// Newest residuals R1 or R2 that are compared with the signatures of a step and a ramp, s; 0.2 to
    /// 0.32. In 16 samples at 50 Hz the observers of Table 4-1 have followed a step, and random signs
    /// are no signature yet.
    pub window: f64,
    /// When after a raise the kind is looked at, s; each within `window`. At once, on the first sample
    /// that tells a ramp from a step, and when the window is full.
    pub looks: [f64; 3],
    /// Newest residuals R3 that are compared with a step and a ramp, s; up to 1.28. A ramp of 1.2 mm/s
    /// comes to the bound of 1.5 mm in it.
    pub differences: f64,
    /// A residual R3 of which the mean before the newest `window` has had more than this part crept up to
    /// its bound; 0 to 1. Half: nearer to what it is now than to nothing.
    pub crept: f64,
    /// On a cylinder without a calibration a first R3 of more than this part of its bound is a difference that stands
    /// since the start; 0 to 1. Half: nearer to the bound than to nothing, as `crept`.
    pub stood: f64,
    /// What the gains of two transducers differ by that nobody calibrated, m per m; 0.002 to 0.01. By what a calibration
    /// finds, 0.3 % is much; the difference may grow by so much of the length and be none but that.
    pub gain: f64,
    /// The part of the residuals' energy that a signature must explain, or it is noise; 0 to 1. White
    /// noise stays far below it.
    pub explained: f64,
    /// How much more a ramp must explain than a step, as a ratio; 1 or more. One sample alone fits both.
    pub ramp_advantage: f64,
    /// Joint evidence takes the other observer to see less than this part of the residual; 0.1 to 0.5. A quarter: two
    /// fluctuations of four counts, opposite to each other, need an error of the model beyond 0.55 mm beside them.
    pub joint_quiet: f64,
    /// And C1 − C2, and its change, to be at least this part of it; 0.5 to 0.9.
    pub joint_moved: f64,
    /// Samples for which a residual has to stay beyond its threshold to be a fault, 1 to 5. Where one sample in a hundred is
    /// wild, three follow each other hardly once an hour on a machine, and two every minute.
    pub lasting: u32,
    /// Those after the first need at least this part of it, in its direction; 0.3 to 0.7. An observer of Table 4-1 has
    /// followed a third of a step by then.
    pub stays: f64,
    /// Samples beyond the threshold within [`Self::window`] that are noise; 7 of 16 samples, and no more than
    /// [`KEPT_EXCEEDED`]. Noise of 2 σ has six of 16, of 4 σ ten. Where 2 % of the samples of C1 and of C2 are wild, seven of 16
    /// differences are beyond about once an hour on a machine.
    pub often: usize,
    /// Samples beyond the threshold within the same window that keep a raised residual raised; 2 to [`Self::often`]. A single
    /// wild one does not: where 2 % of the samples were wild, FDE1 was raised by three in a row once, and stood for an hour.
    pub again: usize,
    /// For each of these times that the newest [`KEPT_WILD`] wild readings fit into, s, a residual has to stay for a further
    /// sample. At 50 Hz they are one reading in 120, and one in 40. Where 2 % are wild, three follow each other forty times an
    /// hour on a machine, and five hardly ever.
    pub frequent: [f64; 2],
    /// Part of a residual from which the other observer sees it, too, and the model errs; 0.3 to 0.7.
    pub shared: f64,
}

impl VerdictParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self {
        window: 0.32,
        looks: [0.0, 0.08, 0.3],
        differences: 1.28,
        crept: 0.5,
        stood: 0.5,
        gain: 0.005,
        explained: 0.5,
        ramp_advantage: 1.02,
        joint_quiet: 0.25,
        joint_moved: 0.75,
        lasting: 3,
        stays: 0.5,
        often: 7,
        again: 3,
        frequent: [20.0, 6.0],
        shared: 0.5,
    };

    /// [`Self::lasting`] of a machine whose thresholds, or whose sequential detector, were learnt; the thesis's thresholds
    /// count at once.
    pub const fn lasting_of(&self, is_learnt: bool) -> u32 {
        if is_learnt { self.lasting } else { 1 }
    }

    /// The counts for a machine with this `sample_time`, s. Above 100 Hz the rings are too short, and the
    /// windows as long as these.
    pub fn cycles(&self, sample_time: f64) -> VerdictCycles {
        let samples = |seconds: f64| time::samples(seconds, sample_time);
        let window = (samples(self.window) as usize).min(LONGEST_WINDOW);
        VerdictCycles {
            window,
            differences: (samples(self.differences) as usize).min(LONGEST_DIFFERENCES),
            looks: self.looks.map(|look| samples(look).min(window as u32 - 1)),
        }
    }
}

impl Default for VerdictParameters {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The times of [`VerdictParameters`] in samples of one machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerdictCycles {
    pub window: usize,
    pub differences: usize,
    pub looks: [u32; 3],
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stay_and_below_50_hz_samples_do() {
        let of = |rate: f64| VerdictParameters::DEFAULT.cycles(1.0 / rate);
        let at_50 = VerdictCycles { window: 16, differences: 64, looks: [0, 4, 15] };
        assert_eq!([of(10.0), of(20.0), of(50.0)], [at_50; 3]);
        assert_eq!(of(100.0), VerdictCycles { window: 32, differences: 128, looks: [0, 8, 30] });
        assert_eq!(of(1000.0), VerdictCycles { window: 32, differences: 128, looks: [0, 31, 31] });
    }
}
