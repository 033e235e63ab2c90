//! When both transducers are sampled.

/// The numbers by which all cylinders together tell that C1 and C2 are sampled otherwise than calibrated
/// ([`crate::sequential::sampling`]).
#[derive(Clone, Debug, PartialEq)]
pub struct SamplingParameters {
    /// Nobody has sampled two devices more alike than this, s: a calibration that says so was lucky.
    pub least_timing: f64,
    /// Time constants of what one cylinder shows, s: of what has just begun, and of what is known for
    /// sure.
    pub times: [f64; 2],
    /// Beyond so many deviations, squared, a residual says no more of the noise than there.
    pub clip: f64,
    /// The mean square of a normal residual that is clipped so, in variances: it goes with `clip`.
    pub clipped: f64,
    /// Beyond so many deviations, squared, a residual is wild and says nothing at all.
    pub wild: f64,
    /// As if so many samples had said what the calibration has said, …
    pub prior_samples: f64,
    /// … at such a speed, m/s.
    pub prior_speed: f64,
    /// Fewer cylinders have no majority; 3 or more.
    pub least_cylinders: usize,
    /// A time between both samples that a calibration leaves, s: at 0.5 m/s half of the dead band.
    pub least_apart: f64,
    /// The scatter counts beyond so many of the known one, …
    pub more: f64,
    /// … and so many of what is seen are expected then.
    pub margin: f64,
    /// Standard errors that something told is beyond.
    pub sure: f64,
    /// What was told is over below this part of `least_apart`; 0 to 1, so that it does not come and go.
    pub over: f64,
    /// Cycles from one comparison of all cylinders to the next; 1 to 25. In cycles, since it bounds the work of a cycle.
    pub every: u32,
    /// It takes up to so long until all cylinders together know, s; one of them may have an alarm first.
    pub shared: f64,
}

impl SamplingParameters {
    pub const DEFAULT: Self = Self {
        least_timing: 2e-4,
        times: [0.5, 20.0],
        clip: 4.0,
        clipped: 0.920_5,
        wild: 25.0,
        prior_samples: 12.0,
        prior_speed: 0.2,
        least_cylinders: 3,
        least_apart: 1e-4,
        more: 1.25,
        margin: 1.15,
        sure: 3.0,
        over: 0.7,
        every: 5,
        shared: 5.0,
    };
}

/// The numbers by which the other cylinders say whether a noise may be that of the sampling
/// ([`crate::sequential::witness`]).
#[derive(Clone, Debug, PartialEq)]
pub struct WitnessParameters {
    /// What chance has a mean square seem larger by, standard errors, …
    pub luck: f64,
    /// … and the part of what is left of it that the others are asked for; 0 to 1.
    pub part: f64,
    /// The others contradict by so many nats.
    pub contradicted: f64,
    /// Of so many others the one that contradicts least is not heard: it may be noisy itself.
    pub many: usize,
    /// Where another one bears it out by so many nats, it is common to several.
    pub borne_out: f64,
}

impl WitnessParameters {
    pub const DEFAULT: Self =
        Self { luck: 2.0, part: 0.5, contradicted: 6.0, many: 3, borne_out: 2.0 };
}
