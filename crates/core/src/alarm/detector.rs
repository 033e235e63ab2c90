//! The detectors and the places for their warnings: one table, from which frames, texts, JSON, metrics and
//! capacities follow.

use super::status::MAX_CYLINDERS;

/// Declares [`Detector`] and [`WarningPlace`]. A row is a detector, its number in Fd_Warning.Detector, its name in
/// files and reports, its name for people, what it judges, and the places for its warnings of a cylinder:
/// one for each warning that can stand beside the others.
macro_rules! detectors {
    ($(
        $(#[doc = $doc:literal])*
        $detector:ident = $number:literal, $name:literal, $label:literal, $basis:expr,
            [$($(#[doc = $place_doc:literal])* $place:ident),*];
    )*) => {
        /// Detector that warns. The numbers are those of Fd_Warning.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Detector {
            $($(#[doc = $doc])* $detector = $number,)*
        }

        impl Detector {
            /// All detectors, in the order of their numbers, which begin with 1.
            pub const ALL: [Self; [$($number),*].len()] = [$(Self::$detector),*];

            /// Name in files and reports.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$detector => $name,)* }
            }

            /// Name for people.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$detector => $label,)* }
            }

            /// What it judges.
            pub const fn basis(self) -> Basis {
                match self { $(Self::$detector => $basis,)* }
            }
        }

        /// Place of a warning among those of its cylinder.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum WarningPlace {
            $($($(#[doc = $place_doc])* $place,)*)*
        }

        /// Number of places for the warnings of a cylinder.
        pub const PLACES: usize = [$($(WarningPlace::$place,)*)*].len();

        /// Detector of each place.
        pub const DETECTORS: [Detector; PLACES] =
            [$($({ let _ = WarningPlace::$place; Detector::$detector },)*)*];
    };
}

detectors! {
    /// The observer on C1.
    Fde1 = 1, "fde1", "FDE1", Basis::Residual(0), [Fde1];
    /// The observer on C2.
    Fde2 = 2, "fde2", "FDE2", Basis::Residual(1), [Fde2];
    /// The comparator of C1 and the corrected C2.
    Fde3 = 3, "fde3", "FDE3", Basis::Residual(2), [Fde3];
    /// The plausibility checks, which come before any model.
    Plausibility = 4, "plausibility", "plausibility", Basis::Readings,
        [PlausibilityOfC1, PlausibilityOfC2, PlausibilityOfCommand];
    /// The evidence of many samples together: of C1 − C2, and on a cylinder without C2 of the mechanical stop or of the
    /// deck's attitude.
    Sequential = 5, "sequential", "sequential", Basis::Samples, [Sequential];
    /// Valve, pressures and supply, by what spool and pressures say of each other.
    Process = 6, "process", "process", Basis::Samples, [Process];
}

/// What a detector judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// R1, R2 or R3, of index 0 to 2, by a threshold.
    Residual(usize),
    /// Single readings as they came, which are facts: no healthy machine sends them by chance.
    Readings,
    /// Many samples of a cylinder together, by their evidence.
    Samples,
}

impl Detector {
    /// The detectors that have places and may warn by chance, so that their false alarms are counted.
    pub const BY_CHANCE: [Self; Self::count_by_chance()] = Self::by_chance();

    const fn is_by_chance(self) -> bool {
        matches!(self.basis(), Basis::Residual(_) | Basis::Samples)
    }

    const fn count_by_chance() -> usize {
        let (mut count, mut i) = (0, 0);
        while i < Self::ALL.len() {
            count += Self::ALL[i].is_by_chance() as usize;
            i += 1;
        }
        count
    }

    const fn by_chance() -> [Self; Self::count_by_chance()] {
        let mut found = [Self::Fde1; Self::count_by_chance()];
        let (mut count, mut i) = (0, 0);
        while i < Self::ALL.len() {
            if Self::ALL[i].is_by_chance() {
                found[count] = Self::ALL[i];
                count += 1;
            }
            i += 1;
        }
        found
    }
}

/// Most warnings that can stand at once on the largest machine.
pub const MOST_STANDING: usize = PLACES * MAX_CYLINDERS;

// Fd_Warning has three bits for the detector and for the cylinder, and Fd_Status six for the number of
// standing warnings.
const _: () = assert!(Detector::ALL.len() < 1 << 3);
const _: () = assert!(MAX_CYLINDERS < 1 << 3);
const _: () = assert!(MOST_STANDING < 1 << 6);
