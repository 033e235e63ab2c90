//! Numbers of an EDS: decimal, hexadecimal, octal, and those that add the node-ID.

/// More digits than any number of 64 bits has in any base.
const MAX_DIGITS: usize = 40;

/// A whole number as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Written {
    pub number: i128,
    /// It is hexadecimal or octal, so that it may stand for the bits of a negative number.
    pub is_bits: bool,
    /// The node-ID is to be added.
    pub plus_node_id: bool,
}

/// `text` as a whole number: `26`, `-3`, `0x1A`, `032` (octal). What follows a `#` is a comment.
pub(super) fn whole(text: &str) -> Option<i128> {
    read(text).map(|written| written.number)
}

/// `text` as a number of `T`'s range.
pub(super) fn within<T: TryFrom<i128>>(text: &str) -> Option<T> {
    whole(text).and_then(|number| T::try_from(number).ok())
}

/// `text` as a whole number or a sum of one and `$NODEID`, in either order.
pub(super) fn expression(text: &str) -> Option<Written> {
    let mut sum: Option<Written> = None;
    let mut plus_node_id = false;
    for term in without_comment(text).split('+') {
        let term = term.trim();
        if term.eq_ignore_ascii_case("$NODEID") && !plus_node_id {
            plus_node_id = true;
        } else if sum.is_none() {
            sum = Some(read(term)?);
        } else {
            return None;
        }
    }
    let zero = Written { number: 0, is_bits: false, plus_node_id };
    (sum.is_some() || plus_node_id).then_some(Written { plus_node_id, ..sum.unwrap_or(zero) })
}

/// `text` without a comment that begins with `#`, as CiA's own templates have them behind numbers.
pub(super) fn without_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or_default().trim()
}

fn read(text: &str) -> Option<Written> {
    let text = without_comment(text);
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (radix, digits) = match digits.as_bytes() {
        [b'0', b'x' | b'X', ..] => (16, &digits[2..]),
        // Python's reader and others refuse octal numbers, so that they are rare; 00 is one of them.
        [b'0', _, ..] => (8, &digits[1..]),
        _ => (10, digits),
    };
    let plain = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    if !plain || digits.is_empty() || digits.len() > MAX_DIGITS {
        return None;
    }
    let number = i128::from_str_radix(digits, radix).ok()?;
    let number = if negative { -number } else { number };
    Some(Written { number, is_bits: radix != 10 && !negative, plus_node_id: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_in_every_base() {
        for (text, number) in [
            ("26", 26),
            ("-3", -3),
            ("0x1A", 26),
            ("0X1a", 26),
            ("032", 26),
            ("00", 0),
            ("0", 0),
            ("-0x10", -16),
            ("0x07 # VAR", 7),
            ("0xFFFFFFFFFFFFFFFF", i128::from(u64::MAX)),
        ] {
            assert_eq!(whole(text), Some(number), "{text}");
        }
        let long = "1".repeat(MAX_DIGITS + 1);
        for text in ["", "x", "0x", "08", "1A", "0x1G", "--1", "+-1", "1 2", "0x-1", "# 7", &long] {
            assert_eq!(whole(text), None, "{text}");
        }
        assert_eq!(within::<u8>("255"), Some(255));
        assert_eq!(within::<u8>("256"), None);
        assert_eq!(within::<u8>("-1"), None);
    }

    #[test]
    fn the_node_id_is_added_in_either_order() {
        let sum = |text| expression(text).map(|it| (it.number, it.plus_node_id));
        for text in ["$NODEID+0x180", "0x180+$NODEID", " $nodeid + 384 ", "384 + $NodeId # COB-ID"]
        {
            assert_eq!(sum(text), Some((0x180, true)), "{text}");
        }
        assert_eq!(sum("$NODEID"), Some((0, true)));
        assert_eq!(sum("0x180"), Some((0x180, false)));
        for text in ["", "$NODEID+$NODEID", "1+2", "$NODEID+", "$NODE+1", "$NODEID-1", "+"] {
            assert_eq!(sum(text), None, "{text}");
        }
    }
}
