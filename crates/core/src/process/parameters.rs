//! What the process detectors judge by: every number of the family, with its unit and source.

use crate::time;

/// Number of directions.
pub const DIRECTIONS: usize = 6;

/// All of them. Those without a source were chosen on simulated machines (docs/PROCESS.md).
#[derive(Clone, Debug, PartialEq)]
pub struct ProcessParameters {
    /// Time for which a relation is not judged after the platform came into a monitored state, s: valve and oil
    /// are not yet where they were taught.
    pub opening: f64,
    /// Time after which a spool that starts anywhere stands where its command says, s: five time constants of
    /// the slowest, 60 ms.
    pub settling: f64,
    /// Shortest and longest window, s.
    pub windows: [f64; 2],
    /// No sample is evidence beyond so many standard deviations: a spike is no fault.
    pub farthest: f64,
    /// What the second derivative of a spool's expected position may leave of it, s²: a recording of a smooth sea does not
    /// show how a valve follows a command that swings with several hertz, as the one of a rod whose seals stick.
    pub spool_bend: f64,
    /// Displacement of the spool that is no fault, as a part of the largest position that was taught.
    pub spool_band: f64,
    /// Cycles with both readings that weigh as much as one without: where more than one in 17 is without, that adds up.
    pub loss: u32,
    /// From so many in a row on they are many, …
    pub losses: u32,
    /// … and that many for so long after them at the most, s.
    pub lost_for: f64,
    /// A transducer without any reading for this long is gone for good, s; beyond `lost_for`. One of which a reading in a
    /// hundred comes is not.
    pub gone: f64,
    /// Displacement of the chambers' sum that is no fault, bar.
    pub chambers_band: f64,
    /// What it may be off for each bar that P_S is beyond what was taught, bar/bar: a supply that fails is no fault of
    /// the sensors in chambers.
    pub chambers_untaught: f64,
    /// Least standard deviations that a calibration is believed, of the spool as a part of its largest position, and
    /// of the chambers' sum, bar: below it is not noise that sets the limit, but the relation's own form.
    pub least_deviations: [f64; 2],
    /// Evidence in the recording that teaches, as a part of the level, from which a relation is refused.
    pub doubtful: f64,
    /// Factor of the variance that is no fault.
    pub spread_band: f64,
    /// Time over which a fault is looked at before its kind is decided, s, and until it is decided anew, s.
    pub looks: [f64; 2],
    /// Part of the energy that an offset, a delay or a gain has to leave at the most, to be the kind.
    pub left: f64,
    /// Movements of the spool in each direction that tell sticking from an offset, and from when one counts,
    /// as a part of the largest position.
    pub movements: usize,
    pub moving: f64,
    /// Deviations of a late command that are as many times healthy ones are still taken for healthy; 2 to 5.
    pub late_rest: f64,
    /// Part of the largest position beyond which a spool that follows nothing else does not stick: it is commanded by
    /// something else; 0.05 to 0.3.
    pub most_sticking: f64,
    /// Part of the deviations below the one that is taken for the band of a sticking spool, 0.9 to 1, …
    pub in_band: f64,
    /// … and what as many deviations of noise alone are below, in its standard deviations: it goes with `in_band`.
    pub in_band_of_noise: f64,
    /// Time by which other cylinders may find the same, s, before a pressure sensor is named.
    pub company: f64,
    /// Least number of cylinders whose sums of chambers are off when it is the supply's sensor, as a part of all.
    pub many: f64,
    /// The same as a number, 2 or more: one cylinder has nothing in common with others.
    pub least_many: usize,
    /// Least number of samples with which the spool's positions between two knots of f are taught.
    pub flow_samples: u64,
    /// Part of P_S by which it may be beyond what was taught where f is believed of a gain.
    pub flow_untaught: f64,
    /// Time of a block of rod and oil, s.
    pub flow_block: f64,
    /// Time of an alarm by the flow after which its kind is sought, each time anew, s, and until it is sought, s.
    pub flow_looks: [f64; 2],
    /// Part of its size that a fault has to have in the newest blocks of the first of these times, to be called another
    /// one than before, 0 to 1.
    pub flow_lasting: f64,
    /// What may have changed without a fault: leakage at 24 bar, null, gain, dead band, worn edges (m/s but for the
    /// gain), and compressibility, m/bar. Warm oil leaks more, its density changes, and a dead band of 1 % of the stroke
    /// wanders by 0.4 %, which is 6 mm/s.
    pub flow_tolerances: [f64; DIRECTIONS],
    /// What of each of them is no fault.
    pub flow_bands: [f64; DIRECTIONS],
    /// Distance of the spool from its middle within which worn edges leak, as a speed by the mean slope of f, m/s.
    pub edges: f64,
    /// Blocks near the middle from which worn edges are judged.
    pub edges_least: f64,
    /// Time over which loads move on, s: of pressures and movements only what is faster tells of friction; and the
    /// time until that is told apart, s: three of them.
    pub friction_slow: f64,
    pub friction_settling: f64,
    /// v₀: speed at which Coulomb's friction has its full size, m/s.
    pub friction_speed: f64,
    /// The most friction that a block is evidence of, bar, and in deviations that were learnt (the root of Ω's first place),
    /// whichever is more: a load that changes suddenly, as where people walk over the gangway, leaves ten bar
    /// for some seconds.
    pub friction_farthest: [f64; 2],
    /// Coulomb friction beyond that learnt that is no fault, bar, …
    pub friction_band: f64,
    /// … and the part of the viscous one that the oil's temperature may change.
    pub friction_viscosity: f64,
    /// What the supply's pressure may fall short of without a fault, bar/s.
    pub supply_band: f64,
    /// Least standard deviation that is believed of what a block leaves of it, bar.
    pub supply_deviation: f64,
    /// Time over which it is measured by how much the pressure is too low, s: most of a wave, …
    pub supply_look: f64,
    /// … and the most that it is of that before where it has arrived.
    pub supply_arrived: f64,
    /// Pressure below which the supply no longer carries the load, as a part of that of the lesson, 0 to 1, where the
    /// configuration does not say: rods of the simulated plant follow a sea of 2.5 m above it.
    pub supply_least: f64,
    /// Part of the level below which evidence has to fall for an alarm to end.
    pub over: f64,
    pub side: SideParameters,
}

impl ProcessParameters {
    pub const DEFAULT: Self = Self {
        opening: 10.0,
        settling: 0.5,
        windows: [0.08, 10.24],
        farthest: 6.0,
        spool_bend: 2e-4,
        spool_band: 3e-3,
        loss: 16,
        losses: 6,
        lost_for: 2.0,
        gone: 10.0,
        chambers_band: 1.0,
        chambers_untaught: 0.05,
        least_deviations: [1.2e-3, 0.15],
        doubtful: 0.6,
        spread_band: 2.0,
        looks: [0.5, 10.0],
        left: 0.35,
        movements: 20,
        moving: 4e-3,
        late_rest: 3.0,
        most_sticking: 0.15,
        in_band: 0.97,
        in_band_of_noise: 2.17,
        company: 0.1,
        many: 0.6,
        least_many: 2,
        flow_samples: 400,
        flow_untaught: 0.15,
        flow_block: 0.2,
        flow_looks: [10.0, 50.0],
        flow_lasting: 0.5,
        flow_tolerances: [0.3e-3, 0.25e-3, 0.012, 3e-3, 0.4e-3, 3e-4],
        flow_bands: [0.8e-3, 0.7e-3, 0.03, 7e-3, 1.5e-3, 0.0],
        edges: 0.022,
        edges_least: 2.0,
        friction_slow: 3.0,
        friction_settling: 9.0,
        friction_speed: 0.01,
        friction_farthest: [2.7, 3.0],
        friction_band: 0.45,
        friction_viscosity: 0.25,
        supply_band: 1.5,
        supply_deviation: 0.05,
        supply_look: 5.0,
        supply_arrived: 1.1,
        supply_least: 0.4,
        over: 0.5,
        side: SideParameters::DEFAULT,
    };

    /// Widths of the windows, samples, shortest and longest.
    pub fn widths(&self, sample_time: f64) -> [usize; 2] {
        self.windows.map(|seconds| time::samples(seconds, sample_time) as usize)
    }
}

/// The numbers by which the oil tells whose reading has moved ([`crate::process::flow::FlowSide`]). They come from trials
/// on simulated hydraulic plants (`evaluate --rows side`, docs/PROCESS.md), and hold for machines whose rods move by up
/// to 1 m/s; those of [`ProcessParameters`] from which they are taken say where they come from.
#[derive(Clone, Debug, PartialEq)]
pub struct SideParameters {
    /// What a lesson leaves of each direction, in the units of [`ProcessParameters::flow_tolerances`], and of a constant
    /// speed, m/s, at least 0: standard deviations. A dead band that wanders is followed.
    pub usual: [f64; DIRECTIONS + 1],
    /// How far they walk in a second, in the same units, at least 0, a random walk: oil warms up, the load moves on. A
    /// hundredth of what they are usually in a second lets them follow within minutes.
    pub walks: [f64; DIRECTIONS + 1],
    /// Standard deviation of the mean speed over so many seconds beside the oil's, m/s, above 0, before any was measured:
    /// that of the simulated plants, …
    pub scatter: f64,
    pub scatter_time: f64,
    /// … and the blocks of a stretch of which it is measured, the stretches that this counts for, and the most that are
    /// remembered.
    pub stretch: u32,
    pub stretches: [u32; 2],
    /// No block teaches more than one that is off by so many standard deviations, 3 to 6: fewer would clip what is usual.
    pub odd: f64,
    /// What one reading may be off, m: a count of a coarse transducer.
    pub reading: f64,
    /// Blocks of a suspicion before anything is said, at least 1: a second of them; …
    pub blocks: u32,
    /// … and those after which evidence of more than so many nats is: a fast drift leaves no second.
    pub least_blocks: u32,
    pub certain: f64,
    /// Blocks of a suspicion that are remembered until somebody asks: what has been suspected for longer without an
    /// alarm is no part of it.
    pub unasked: u32,
    /// Nothing is said where both explanations are off by more than so many standard deviations, 3 to 6.
    pub beside: f64,
}

impl SideParameters {
    pub const DEFAULT: Self = Self {
        usual: [0.3e-3, 0.25e-3, 0.012, 0.45e-3, 0.4e-3, 3e-4, 0.2e-3],
        walks: [3e-6, 3e-6, 3e-5, 3e-6, 3e-6, 3e-7, 1e-5],
        scatter: 0.2e-3,
        scatter_time: 10.0,
        stretch: 25,
        stretches: [10, 60],
        odd: 4.0,
        reading: 1e-4,
        blocks: 5,
        least_blocks: 2,
        certain: 40.0,
        unasked: 10,
        beside: 4.0,
    };
}
