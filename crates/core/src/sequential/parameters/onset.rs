//! When C1 − C2 left its healthy level, and whose reading moved then.

/// The numbers of [`crate::sequential::excursions::Onset`] and of the comparison at it
/// ([`crate::sequential::pair::Pair::compare_at`]). Deviations are those of C1 − C2 outside of excursions. All but the times are
/// counts of samples at every rate, since it takes samples to distinguish a step from noise.
#[derive(Clone, Debug, PartialEq)]
pub struct OnsetParameters {
    /// Samples that the size is the median of: half of the alarm's window, within these bounds, …
    pub sized: [usize; 2],
    /// … up to this many samples after the alarm.
    pub after: usize,
    /// Samples before the alarm's window in which the onset may lie.
    pub before: usize,
    /// Smallest displacement for which a transducer is named, m; 2e-4 to 4e-4. It takes a second to outlast excursions, and of those of 0.25 mm that
    /// were named one in thirteen was wrong.
    pub least: f64,
    /// Least size of a displacement whose rise can be seen, deviations; a smaller one is taken for a step.
    pub large: f64,
    /// Two successive samples within this many deviations are before the departure of a ramp, …
    pub departed: f64,
    /// … which then never falls by more than this many deviations, …
    pub fallen: f64,
    /// … and whose first three samples have a median below this part of the displacement.
    pub begun: f64,
    /// Two successive samples beyond this many deviations before the onset are another excursion, whose end looks like a step of the
    /// other transducer.
    pub another: f64,
    /// Three samples after the onset of a step are farther than three before it by more than this part of its size; 0.5 to 0.8. Without
    /// an edge a drift of 1 mm/s was named wrong in 7 of 100 cases.
    pub edge: f64,
    /// Samples by which the onset may be earlier or later.
    pub around: usize,
    /// Samples from the onset that tell: then the filter has followed.
    pub telling: usize,
    /// Degrees of freedom of the residuals that the onset is sought by; 3 to 10. One in some hundreds is wild.
    pub sought_freedom: f64,
    /// Samples before the onset that show how much the command's prediction errs now: bursts of the model widen it.
    pub errors: usize,
    /// Degrees of freedom of its errors; 4 to 15.
    pub freedom: f64,
    /// Evidence by the measured course that a step takes beside its own, nats.
    pub agreeing: f64,
    /// Evidence that names, nats; 4 to 8. At e⁵ to one fewer than one in a hundred is wrong.
    pub decided: f64,
    /// The same of a ramp, which moves the mean of both readings by hundredths of a millimetre a sample; more than `decided`. At 5 nats
    /// two of 120 drifts of 5 mm/s were named wrong.
    pub decided_of_a_ramp: f64,
    /// Samples from the onset until which the comparison is repeated, and at least for `after` samples from the alarm: sooner there are
    /// too few to compare.
    pub compared: usize,
}

impl OnsetParameters {
    pub const DEFAULT: Self = Self {
        sized: [4, 24],
        after: 4,
        before: 12,
        least: 3e-4,
        large: 8.0,
        departed: 2.5,
        fallen: 3.0,
        begun: 0.55,
        another: 4.0,
        edge: 0.6,
        around: 3,
        telling: 16,
        sought_freedom: 4.0,
        errors: 48,
        freedom: 8.0,
        agreeing: 1.5,
        decided: 5.0,
        decided_of_a_ramp: 8.0,
        compared: 10,
    };
}
