//! How readings are judged: `[plausibility]`, `[model]`, `[observer]`, `[fde]`, `[comparator]` and `[alarm]`.

use super::levels::{LEVELS, LevelsTable};
use crate::kinds::{DURATION, FINITE, THRESHOLD, counts, number, numbers, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use tertius_core::alarm::Levels;

table! {
    /// Limits beyond which a reading is rejected before any model is asked.
    pub struct Plausibility = PLAUSIBILITY {
        stale: f64 = 0.1 => number(Limits::above(0.0, DURATION).most(3600.0)),
            "0.1", "without a new reading for this long a signal is stale, s";
        /// See [`Settings::broken_wire_codes`](super::Settings::broken_wire_codes).
        broken_wire_codes: Option<Vec<i64>> = None => counts(0, 64),
            "[32767]",
            "raw counts that mean a broken wire; absent: 32767 of a signal of 16 bits, unless it is valid";
        status_mask: u64 = u64::MAX => whole(0, u64::MAX as i128, "bits of an unsigned signal"),
            "3", "the bits of a status signal that mean a broken wire";
        valid_raw: Option<[i64; 2]> = None => counts(2, 2),
            "[1, 27648]", "the lowest and the highest raw count of a healthy reading";
        frozen: f64 = 0.1 => number(Limits::above(0.0, DURATION).most(3600.0)),
            "0.1", "a reading exactly constant for this long while the command moves is frozen, s";
        frozen_speed: f64 = 0.02 => number(Limits::least(0.0, "the size of a speed in metres per second")),
            "0.02", "the command moves when it is beyond this, m/s";
        state_stale: f64 = 1.0 => number(Limits::above(0.0, DURATION).most(3600.0)),
            "1.0", "without a new platform state for this long the state is not known, s";
    }
}

table! {
    /// The discrete model (4-1); the defaults are Table 4-1.
    pub struct Model = MODEL {
        theta: [f64; 5] = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023] =>
            numbers(5, Limits::finite(FINITE)),
            "[-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023]", "theta of (4-1)";
        gamma: [f64; 2] = [0.0926, 6.5427] => numbers(2, Limits::finite(FINITE)),
            "[0.0926, 6.5427]", "gamma of (4-1)";
        command_offset: f64 = 0.0 => number(Limits::finite(FINITE)),
            "0.0", "the command at which a cylinder rests, m/s; (4-1) takes u less this";
        /// See [`Settings::model_time_of`](super::Settings::model_time_of).
        sample_time: Option<f64> = None => number(Limits::above(0.0, DURATION)),
            "0.02", "the sample time of theta and gamma, s; absent: not known, except for Table 4-1";
    }
}

table! {
    /// Weights of the Riccati equation, the diagonals of Q (position, velocity, load pressure) and R
    /// (position, velocity).
    pub struct Observer = OBSERVER {
        q: [f64; 3] = [5e-9, 2e-4, 1e4] => numbers(3, Limits::least(0.0, "a variance of the process")),
            "[5e-9, 2e-4, 1e4]", "the diagonal of Q: position, velocity, load pressure";
        r: [f64; 2] = [1e-8, 5.0] =>
            numbers(2, Limits::above(0.0, "the variance of a measurement; without noise there is no gain")),
            "[1e-8, 5.0]", "the diagonal of R: position, velocity";
        settle: f64 = 1.0 => number(Limits::least(0.0, DURATION).most(600.0)),
            "1.0", "an observer judges after it has followed its readings for this long, s";
        sample_time: Option<f64> = None => number(Limits::above(0.0, DURATION)),
            "0.02", "the sample time that q and r were tuned at, s; absent: not known";
    }
}

table! {
    /// Thresholds of R1 and R2 (section 5-4-1), m.
    pub struct Fde = FDE {
        enabled: bool = true => Kind::One(Scalar::Switch),
            "true", "whether FDE1 and FDE2 judge by high; false: they warn by joint alone, and a transducer is healthy only where the sequential detector judges it (commission writes this where high would be too large to find a fault)";
        low: f64 = 7.5e-4 => number(Limits::above(0.0, THRESHOLD)),
            "7.5e-4", "below this R1 and R2 count towards clearing, m";
        high: f64 = 1.0e-3 => number(Limits::above(0.0, THRESHOLD)),
            "1.0e-3", "above this R1 and R2 raise a warning, m";
        joint: Option<f64> = None => number(Limits::above(0.0, THRESHOLD)),
            "1.0e-3", "above this R1 raises a warning of C1 where R2 shows less than a quarter of it and C1 - C2 has moved by at least three quarters of it, and R2 of C2 likewise, m; needs tables of the sequential detector; absent: no such warnings";
        command: Option<f64> = None => number(Limits::above(0.0, "the size of a speed in metres per second")),
            "0.5", "largest command that the thresholds were learnt with, either way, m/s; after a larger one, for observer.settle, R1 or R2 raises a warning only where the other one shows less than half of it; absent: any";
        command_change: Option<f64> = None => number(Limits::above(0.0, "the size of a speed in metres per second")),
            "0.015", "the same of the change of the command from one cycle to the next, m/s; absent: any";
    }
}

impl Fde {
    /// Whether the thresholds were learnt from a recording of this machine: `tune` writes the command of that beside them.
    pub const fn is_learnt(&self) -> bool {
        self.command.is_some()
    }
}

table! {
    /// Thresholds of R3 (section 5-5), m.
    pub struct Comparator = COMPARATOR {
        enabled: bool = true => Kind::One(Scalar::Switch),
            "true", "whether FDE3 judges by bound; false: only critical holds for C1 - C2 (commission writes this where bound would be too large to find a fault)";
        bound: f64 = 1.5e-3 => number(Limits::above(0.0, THRESHOLD)),
            "1.5e-3", "above this R3 raises a warning, m";
        low: Option<f64> = None => number(Limits::above(0.0, THRESHOLD)),
            "1.125e-3", "below this R3 counts towards clearing, m; absent: three quarters of bound";
        critical: f64 = 0.05 => number(Limits::above(0.0, THRESHOLD)),
            "0.05", "the machine's own limit of the measured difference, m";
    }
}

table! {
    /// How warnings are raised and cleared.
    pub struct Alarm = ALARM {
        clear: f64 = 1.0 => number(Limits::least(0.0, DURATION).most(3600.0)),
            "1.0", "a warning clears after its residual stayed below the lower threshold this long, s";
        coincidence: f64 = 0.2 => number(Limits::least(0.0, DURATION).most(3600.0)),
            "0.2", "FDEs that raise within this time of each other saw the same event, s";
        soon: f64 = 60.0 => number(Limits::least(0.0, DURATION).most(3600.0)),
            "60.0", "C1 - C2 that reaches comparator.critical within this time at its present rate, or a supply that no longer carries the load, has the level alarm.levels.soon, s";
        at_once: f64 = 5.0 => number(Limits::least(0.0, DURATION).most(3600.0)),
            "5.0", "the same with the level alarm.levels.at_once, s";
        levels: Levels as LevelsTable = Levels::default() => Kind::Table(&LEVELS),
            "", "which finding has which level of Table 2-1";
    }
}
