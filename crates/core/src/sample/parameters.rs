//! What frames and readings are judged by before anything is calculated from them: every number of the family, with its
//! unit, source and range.
//!
//! A place takes one frame in a cycle, and a Sync opens one. Habits of a sender are therefore counted in frames or cycles at
//! every rate: it takes as many of them to distinguish a habit from an accident, however fast they come.

/// Numbers by which a frame is assigned to a cycle, and by which it is doubted.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrivalParameters {
    /// Most cycles by which a frame can be late; 3 to 10. An alive counter that is further off is another count.
    pub latest: i64,
    /// Longest silence, in cycles, after which all its frames may come at once, as from a computer that stalled; 16 to 64. In
    /// cycles, as the counter shows it.
    pub backlog: u64,
    /// Frames in a row that fit each other after which a counter is trusted again; 8 to 32. A counter of four bits has then
    /// come round.
    pub fitting: u32,
    /// Cycles in a row with frames, none in time, after which the counter or deadline that refuses them is no longer trusted;
    /// 3 to 10.
    pub starved: u32,
    /// Least number of frames for a usual time; 5 to 64, see [`PHASES`].
    pub timed: usize,
    /// Difference below which the times of two frames within their cycles are the same, s; 5e-4 to 2e-3. Two frames that come
    /// first keep the bus busy for as long at 250 kbit/s.
    pub same_time: f64,
    /// The same in median deviations of these times; 3 to 6. Three standard deviations of normal ones are 4.4 of them.
    pub same_time_deviations: f64,
    /// Cycles for which frames are in doubt after the last reason for it; 20 to 200. A twin that comes now and then is there all
    /// the time. In cycles, since reasons come with the frames.
    pub doubted: u64,
    /// Frames whose counters fit nothing beside frames that fit, within [`Self::doubted`] of each other, that are no
    /// accident; 3 to 10. A sender that starts anew sends one or two.
    pub strange: u32,
    /// Frames in a row whose counter is not believed that show one which does not count; more than [`Self::fitting`], after
    /// which that of a sender that has started anew is believed again.
    pub uncounted: u32,
    /// Frames that are no more cycles apart than this are in a row; 1 to 5.
    pub in_a_row: u64,
}

/// Frames of a place whose times within their cycles are remembered.
pub const PHASES: usize = 64;

const _: () = assert!(ArrivalParameters::DEFAULT.timed <= PHASES);
const _: () = assert!(ArrivalParameters::DEFAULT.fitting < ArrivalParameters::DEFAULT.uncounted);

impl ArrivalParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self {
        latest: 5,
        backlog: 32,
        fitting: 16,
        starved: 5,
        timed: 8,
        same_time: 1e-3,
        same_time_deviations: 4.4,
        doubted: 50,
        strange: 3,
        uncounted: 50,
        in_a_row: 3,
    };
}

/// Numbers by which Sync is followed, and by which it is doubted.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncParameters {
    /// Divisor of an opening's deviation by which the grid of cycles moves, once it has followed as many openings; 8 to 32.
    /// With 16 the Sync may run one per cent faster or slower than this clock and still deviate by less than a quarter of a
    /// sample time.
    pub slowness: i64,
    /// Cycles in a row that open without their Sync, after which readings open them as if none were configured; 2 to 10.
    /// Whoever stands in for a Sync is taken at its time only, which a machine that is one per cent fast does not keep.
    pub absent: u32,
    /// Sample times of commands without a cycle after which cycles are missing, since nothing opens the first one; 2 to 10.
    pub awaited: u32,
    /// Syncs of a cycle that may directly follow another Sync; 1 or 2. A bus that is recorded on two interfaces has one. A
    /// computer that has stalled receives many Syncs at once, but with the other frames of their cycles in between.
    pub following: u32,
    /// Further ones, within [`Self::remembered`] of each other, that make a flood; 2 to 5. A single one is an accident.
    pub flood: u32,
    /// Cycles for which Sync is ignored after the last one too many; 20 to 200. In cycles, as the Syncs that flood it come in
    /// them.
    pub remembered: u64,
    /// Time over which the cycles that had a Sync are counted, s; 0.5 to 5.
    pub window: f64,
}

impl SyncParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self {
        slowness: 16,
        absent: 4,
        awaited: 4,
        following: 1,
        flood: 2,
        remembered: 50,
        window: 1.0,
    };
}

/// Numbers by which a reading is taken for plausible, beside [`super::plausibility::PlausibilityLimits`], which come from the
/// configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct PlausibilityParameters {
    /// Factor on the time in which a reading is frozen, where no other transducer is a witness; 3 to 10. Friction holds the
    /// rod where a slow stroke turns.
    pub unwitnessed: u32,
    /// Factor on the way of the command without a witness, where it went one way only, to where the reading has been; 1 to 3.
    pub one_way: f64,
    /// Part of the same way from which on a reading that stands is not known to be right; 0.1 to 0.5. The whole is at least
    /// twenty bounds of R3, and friction holds no rod for a quarter of it.
    pub left_standing: f64,
    /// Part of the way that the other transducer has to move for a frozen one from which on a reading stands alone; 0.2 to 0.8.
    pub alone: f64,
    /// Factor on that way: a change of the other reading in one cycle by more is a jump where it was not in motion; 3 to 10.
    pub jump: f64,
    /// Most cycles in a row in which a frame came for another cycle and that do not age a reading; more than
    /// [`ArrivalParameters::starved`], within which places find their cycle anew after a clock was set, or a bus stood still.
    pub spared: u32,
    /// Largest ratio of a step to the two before it together that is none of a leap, since a rod has a mass; 1.5 to 4.
    pub steepest: f64,
}

const _: () = assert!(PlausibilityParameters::DEFAULT.spared > ArrivalParameters::DEFAULT.starved);

impl PlausibilityParameters {
    /// The same for every machine.
    pub const DEFAULT: Self = Self {
        unwitnessed: 5,
        one_way: 2.0,
        left_standing: 0.25,
        alone: 0.5,
        jump: 5.0,
        spared: 10,
        steepest: 2.0,
    };
}
