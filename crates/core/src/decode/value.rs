//! Results of decoding and encoding a signal.

/// A signal's number as it stands in the frame, before factor and offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw {
    Unsigned(u64),
    Signed(i64),
    /// Number of a float signal (SIG_VALTYPE_); a 32-bit float is widened.
    Float(f64),
}

impl Raw {
    /// The count of an integer signal; `None` for a float.
    pub const fn as_i128(self) -> Option<i128> {
        match self {
            Self::Unsigned(raw) => Some(raw as i128),
            Self::Signed(raw) => Some(raw as i128),
            Self::Float(_) => None,
        }
    }

    /// The count if an i64 can hold it; `None` for a float and beyond i64::MAX.
    pub fn as_i64(self) -> Option<i64> {
        match self {
            Self::Unsigned(raw) => i64::try_from(raw).ok(),
            Self::Signed(raw) => Some(raw),
            Self::Float(_) => None,
        }
    }

    /// The nearest double.
    pub const fn as_f64(self) -> f64 {
        match self {
            Self::Unsigned(raw) => raw as f64,
            Self::Signed(raw) => raw as f64,
            Self::Float(raw) => raw,
        }
    }

    /// The bits of an integer; of a float, which has none, those of its integer part; `None` if it is not finite.
    pub fn bits(self) -> Option<u64> {
        let float = || Some(self.as_f64()).filter(|raw| raw.is_finite()).map(|raw| raw as u64);
        self.as_i128().map(|raw| raw as u64).or_else(float)
    }

    /// The number of an integer that fits; of a float its integer part; `None` if it is not finite.
    pub fn number(self) -> Option<i64> {
        let float = || Some(self.as_f64()).filter(|raw| raw.is_finite()).map(|raw| raw as i64);
        self.as_i64().or_else(float)
    }
}

/// A signal's value in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    pub raw: Raw,
    /// Value raw · factor + offset, in the signal's unit. Not finite where a float signal is not.
    pub physical: f64,
}

/// Content of a frame for a signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Decoded {
    Value(Value),
    /// The frame does not carry the signal: a multiplexor selects another one, or it is a remote or
    /// error frame.
    Absent,
    /// The payload ends before the signal, or before the multiplexor that would select it: bad
    /// data, not zero.
    Short,
}

impl Decoded {
    /// The value, if there is one.
    pub const fn value(self) -> Option<Value> {
        match self {
            Self::Value(value) => Some(value),
            Self::Absent | Self::Short => None,
        }
    }
}

/// Result of putting a number into a payload.
#[derive(Clone, Copy, Debug, PartialEq)]
#[must_use = "a number that did not fit was changed or left out"]
pub enum Inserted {
    /// The number was written (an integer signal takes the nearest integer, a 32-bit float signal
    /// the nearest 32-bit float).
    Whole,
    /// The number exceeds what the bits can hold; the nearest possible number, given here, was
    /// written.
    Clamped(Raw),
    /// The number is NaN and the signal an integer: nothing was written.
    NotANumber,
}
