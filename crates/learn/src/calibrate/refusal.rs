//! Why a cylinder's C2 is not calibrated, in words for the person who has to correct it.

use thiserror::Error;

#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationRefusal {
    #[error(
        "C1 - C2 changes by {size_mm:.2} mm between {:.0} and {to:.0} s, and stays so: is there a fault in the recording? \
         Leave what is before or after it out (--from, --to), or record again",
        from.max(0.0)
    )]
    Steps { from: f64, to: f64, size_mm: f64 },
    #[error(
        "no frame of it is in this part of the recording; check the cylinder's number and {{n}} in \
         [signals.cylinder], and that its transducers were on the bus"
    )]
    Absent,
    /// The configuration says that there is none, which is no fault of the recording.
    #[error("it has no C2 to be calibrated")]
    NoSecond,
    #[error("{signal} is missing in {missing} of {rows} cycles{detail}")]
    Missing { signal: &'static str, missing: u64, rows: u64, detail: String },
    #[error("{signal} is constant at {value} m in all {rows} cycles; is it connected?")]
    Constant { signal: &'static str, value: f64, rows: u64 },
    #[error(
        "it moves over only {range_mm:.2} mm, and at least {least_mm:.0} mm, a tenth of the \
         stroke, are needed to tell a gain from an offset over the whole stroke; record it in \
        motion"
    )]
    HardlyMoves { range_mm: f64, least_mm: f64 },
    #[error(
        "{rows} cycles have both readings, and at least {least} are needed; the recording is \
        too short"
    )]
    TooFewRows { rows: u64, least: u64 },
    #[error(
        "C1 and C2 do not move together (correlation {correlation:.3}); are they transducers of the \
         same cylinder?"
    )]
    Unrelated { correlation: f64 },
    #[error(
        "C1 moves with C2 of cylinder {other} (correlation {with_other:.6}), not with its own \
         ({with_own:.6}): the cylinders look swapped; check the identifiers of their transducers"
    )]
    SwappedCylinders { other: u8, with_other: f64, with_own: f64 },
    #[error(
        "C1 is {gain:.5} times C2{guess}, but for two transducers of one stroke the ratio is \
         between 0.5 and 2; check unit, factor and offset of both in the DBC"
    )]
    Unit { gain: f64, guess: String },
    #[error(
        "C1 and C2 look swapped: as configured C1 is {as_given_mm:.3} mm (RMS) from a C2 + b, but \
         C2 is {swapped_mm:.3} mm from a C1 + b; exchange them in [signals.cylinder] or at the \
         machine, or take c2_gain and c2_offset out of the configuration to calibrate again"
    )]
    SwappedTransducers { as_given_mm: f64, swapped_mm: f64 },
    #[error(
        "{trimmed} of {rows} samples are farther than {limit_mm:.3} mm from any one line, which is \
         more than a few faulty samples; look at C1 - C2 over time (`replay --residuals`)"
    )]
    NotALine { trimmed: u64, rows: u64, limit_mm: f64 },
}

impl CalibrationRefusal {
    /// Whether a lasting step of C1 - C2 would have the same refused: its half of the recording may lie beside the line as
    /// C1 and C2 in each other's place do, or as scattered samples.
    pub(super) const fn may_be_a_step(&self) -> bool {
        matches!(self, Self::SwappedTransducers { .. } | Self::NotALine { .. })
    }
}
