//! Values of variables: defaults, limits, and what a DCF sets.

use std::fmt;

use super::data_type::DataType;
use super::number;

/// A value as an EDS gives it.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number, to which the node-ID may have to be added.
    Whole {
        number: i128,
        plus_node_id: bool,
    },
    Real(f64),
    Text(String),
    Bytes(Vec<u8>),
}

impl Value {
    /// The whole number on the node of that node-ID; `None` for another kind of value, and for a sum
    /// with the node-ID where none is given.
    pub fn whole(&self, node_id: Option<u8>) -> Option<i128> {
        match *self {
            Self::Whole { number, plus_node_id: false } => Some(number),
            Self::Whole { number, plus_node_id: true } => Some(number + i128::from(node_id?)),
            Self::Real(_) | Self::Text(_) | Self::Bytes(_) => None,
        }
    }

    /// `text` as a value of that type. A number that has more digits than its type's sign allows stands
    /// for the type's bits, so that 0xFF is −1 as an INTEGER8.
    ///
    /// # Errors
    /// What was expected instead.
    pub(super) fn read(text: &str, data_type: DataType) -> Result<Self, &'static str> {
        match data_type {
            DataType::VisibleString | DataType::UnicodeString => Ok(Self::Text(text.to_owned())),
            DataType::OctetString | DataType::Domain => {
                bytes(text).map(Self::Bytes).ok_or("expected bytes of two hexadecimal digits each")
            }
            DataType::Real32 | DataType::Real64 => {
                let number = number::without_comment(text).parse().ok();
                let finite = number.filter(|number: &f64| number.is_finite());
                finite.map(Self::Real).ok_or("expected a number such as 1.5")
            }
            DataType::Boolean => whole(text, 0, 1, 0),
            DataType::Integer(bits) => {
                let half = 1_i128 << (bits - 1);
                whole(text, -half, half - 1, 2 * half)
            }
            DataType::Unsigned(bits) => whole(text, 0, (1 << bits) - 1, 0),
            DataType::TimeOfDay | DataType::TimeDifference => whole(text, 0, (1 << 48) - 1, 0),
            DataType::Other(_) => Err("values of this data type are not read"),
        }
    }
}

/// `text` as a whole number from `low` to `high`. Written as bits it may be beyond `high` by what it
/// takes of `turn` to come within.
fn whole(text: &str, low: i128, high: i128, turn: i128) -> Result<Value, &'static str> {
    let written = number::expression(text)
        .ok_or("expected a number such as 26, 0x1A, 032 or $NODEID+0x180")?;
    let folded = written.is_bits && written.number > high && written.number < turn;
    let number = if folded { written.number - turn } else { written.number };
    if !(low..=high).contains(&number) {
        return Err("the number does not fit the data type");
    }
    Ok(Value::Whole { number, plus_node_id: written.plus_node_id })
}

/// `text` as pairs of hexadecimal digits, with blanks between them or not.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let digits: Vec<u32> = text
        .chars()
        .filter(|character| !character.is_whitespace())
        .map(|character| character.to_digit(16))
        .collect::<Option<_>>()?;
    let pairs = digits.chunks_exact(2);
    pairs.remainder().is_empty().then_some(())?;
    pairs.map(|pair| u8::try_from(pair[0] * 16 + pair[1]).ok()).collect()
}

impl fmt::Display for Value {
    /// `26`, `$NODEID+384`, `1.5`, the text itself, or bytes in hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole { number, plus_node_id: false } => write!(f, "{number}"),
            Self::Whole { number, plus_node_id: true } => write!(f, "$NODEID+{number}"),
            Self::Real(number) => write!(f, "{number:?}"),
            Self::Text(text) => f.write_str(text),
            Self::Bytes(bytes) => bytes.iter().try_for_each(|byte| write!(f, "{byte:02x}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_range_of_their_type() {
        let whole = |text, data_type| {
            Value::read(text, data_type).ok().map(|value| value.whole(Some(5)).unwrap())
        };
        for (text, data_type, expected) in [
            ("0xFF", DataType::Integer(8), Some(-1)),
            ("0x7F", DataType::Integer(8), Some(127)),
            ("0x80", DataType::Integer(8), Some(-128)),
            ("-128", DataType::Integer(8), Some(-128)),
            ("128", DataType::Integer(8), None),
            ("0x100", DataType::Integer(8), None),
            ("0xFFFFFFFFFFFFFFFF", DataType::Integer(64), Some(-1)),
            ("0xFFFFFFFFFFFFFFFF", DataType::Unsigned(64), Some(i128::from(u64::MAX))),
            ("255", DataType::Unsigned(8), Some(255)),
            ("256", DataType::Unsigned(8), None),
            ("-1", DataType::Unsigned(8), None),
            ("$NODEID+0x180", DataType::Unsigned(32), Some(0x185)),
            ("1", DataType::Boolean, Some(1)),
            ("2", DataType::Boolean, None),
        ] {
            assert_eq!(whole(text, data_type), expected, "{text} as {data_type}");
        }
    }

    #[test]
    fn a_sum_with_the_node_id_needs_one() {
        let value = Value::read("$NODEID+0x180", DataType::Unsigned(32)).unwrap();
        assert_eq!(value.whole(None), None);
        assert_eq!(value.to_string(), "$NODEID+384");
    }

    #[test]
    fn what_is_no_number_is_read_by_its_type() {
        let read = |text, data_type| Value::read(text, data_type).map(|it| it.to_string());
        assert_eq!(read("0 1; x", DataType::VisibleString).as_deref(), Ok("0 1; x"));
        assert_eq!(read("0a FF", DataType::OctetString).as_deref(), Ok("0aff"));
        assert_eq!(read("1e3", DataType::Real32).as_deref(), Ok("1000.0"));
        for (text, data_type) in [
            ("0af", DataType::Domain),
            ("0aé", DataType::Domain),
            ("inf", DataType::Real64),
            ("x", DataType::Real32),
            ("1", DataType::Other(0x40)),
        ] {
            assert!(read(text, data_type).is_err(), "{text} as {data_type}");
        }
    }
}
