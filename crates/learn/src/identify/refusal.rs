//! Why a cylinder is not identified, in words for the person who has to correct it.

use thiserror::Error;

/// What is wrong with the data of one cylinder.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum IdentificationRefusal {
    #[error(
        "no frame of it is in the recording; check the cylinder's number and {{n}} in \
         [signals.cylinder], and that its transducers were on the bus"
    )]
    Absent,
    #[error(
        "none of its {rows} cycles is in a monitored state; name the state that was recorded in \
         machine.monitored_states, or record in it"
    )]
    NeverMonitored { rows: u64 },
    #[error("{signal} is missing in {missing} of {rows} monitored cycles{detail}")]
    Missing { signal: &'static str, missing: u64, rows: u64, detail: String },
    #[error(
        "{signal} is constant at {value} {unit} in all {rows} monitored cycles; the cylinder's \
         response to it cannot be learnt: is it connected, was the machine moving?"
    )]
    Constant { signal: &'static str, value: f64, unit: &'static str, rows: u64 },
    #[error(
        "it moves over only {range_mm:.2} mm, and at least {least_mm} mm are needed to tell a \
         model from the steps of the readings; record it in motion"
    )]
    HardlyMoves { range_mm: f64, least_mm: f64 },
    #[error(
        "{rows} consecutive cycles can be used, and at least {least} are needed; the recording is \
         too short, or has too many gaps"
    )]
    TooFewRows { rows: u64, least: u64 },
    #[error(
        "{signal} is {factor:.4} times what {reference} says it is{guess}; check its unit, factor \
         and offset in the DBC"
    )]
    Unit { signal: &'static str, reference: &'static str, factor: f64, guess: String },
    #[error(
        "the load pressure reaches {largest:.0} bar, beyond any hydraulics; is it in Pa, kPa or \
         mbar? check its factor in the DBC"
    )]
    PressureUnit { largest: f64 },
    #[error(
        "C1 and C2 look swapped: C1 is {as_given_mm:.3} mm (RMS) from a C2 + b as configured, but \
         C2 is {swapped_mm:.3} mm from a C1 + b; exchange them in [signals.cylinder] or at the \
         machine, or calibrate again"
    )]
    SwappedTransducers { as_given_mm: f64, swapped_mm: f64 },
    #[error(
        "its motion follows the command of cylinder {other} (correlation {with_other:.3}), not its \
         own ({with_own:.3}): the cylinders look swapped; check the identifiers of their \
         transducers and valves"
    )]
    SwappedCylinders { other: u8, with_other: f64, with_own: f64 },
    #[error(
        "in the {equation}, {among} cannot be told apart (condition number {condition:.3e}, {most:e} \
         at most): they move together in this recording; record with a motion that differs in \
         them, for example other speeds or loads"
    )]
    Collinear { equation: &'static str, among: String, condition: f64, most: f64 },
    #[error(
        "it would rest at a command of {offset:.4} m/s, but was only commanded {low:.4} to \
         {high:.4} m/s, so no such rest was recorded; check the command's factor and offset in the \
        DBC and whether it is the requested speed, record motion in both directions, or leave the \
        offset out (--offset never)"
    )]
    RestNeverCommanded { offset: f64, low: f64, high: f64 },
    #[error("the fitted model holds a number that is not finite")]
    NotFinite,
}
