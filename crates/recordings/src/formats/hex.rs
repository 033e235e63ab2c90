//! Digits, one by one and eight at a time in a machine word.

const ONES: u64 = u64::MAX / 0xFF;
const HIGH: u64 = ONES * 0x80;

/// Bit that is set in a value where one of its characters is no digit.
const STRANGE: u16 = 1 << 15;
/// Values by character.
static VALUES: [u16; 256] = values();
/// Values of two digits by both characters, the first in the low byte. Of its 128 KiB the digits of
/// a recording touch two kilobytes.
static PAIRS: [u16; 1 << 16] = pairs();

const fn values() -> [u16; 256] {
    let mut table = [STRANGE; 256];
    let digits = b"0123456789abcdef";
    let mut value = 0;
    while value < digits.len() {
        table[digits[value] as usize] = value as u16;
        table[digits[value].to_ascii_uppercase() as usize] = value as u16;
        value += 1;
    }
    table
}

const fn pairs() -> [u16; 1 << 16] {
    let values = values();
    let mut table = [STRANGE; 1 << 16];
    let mut pair = 0;
    while pair < table.len() {
        let (first, second) = (values[pair & 0xFF], values[pair >> 8]);
        if (first | second) & STRANGE == 0 {
            table[pair] = first << 4 | second;
        }
        pair += 1;
    }
    table
}

/// The byte of two hexadecimal digits of either case; `None` if one of them is not a digit. One
/// look-up takes fewer instructions than one for each digit, or than eight digits at a time in a
/// word, since most payloads do not fill one.
#[inline(always)]
pub fn byte(digits: [u8; 2]) -> Option<u8> {
    let value = PAIRS[usize::from(u16::from_le_bytes(digits))];
    (value & STRANGE == 0).then_some(value as u8)
}

/// The number of three hexadecimal digits.
#[inline(always)]
pub fn three(digits: [u8; 3]) -> Option<u16> {
    let [first, second, third] = digits;
    let pair = u16::from_le_bytes([second, third]);
    let (high, low) = (VALUES[usize::from(first)], PAIRS[usize::from(pair)]);
    ((high | low) & STRANGE == 0).then_some(high << 8 | low)
}

/// The value of one hexadecimal digit of either case.
pub fn digit(byte: u8) -> Option<u8> {
    char::from(byte).to_digit(16).map(|value| value as u8)
}

/// The value of up to eight hexadecimal digits; as an error, the first byte that is not a digit.
pub fn number(text: &[u8]) -> Result<u32, u8> {
    debug_assert!(text.len() <= 8);
    let add = |value: u32, &byte| digit(byte).map(|d| value << 4 | u32::from(d)).ok_or(byte);
    text.iter().try_fold(0, add)
}

/// Number of hexadecimal digits among eight characters (the first in the lowest byte) before the
/// first other character.
#[inline(always)]
pub fn leading_digits(word: u64) -> u32 {
    // Adding 0x80 − c sets a byte's high bit exactly when its low seven bits are at least c.
    let at_least = |word: u64, c: u8| word + ONES * u64::from(0x80 - c);
    let low = word & !HIGH;
    let lower = low | (ONES * 0x20);
    let decimal = at_least(low, b'0') & !at_least(low, b'9' + 1);
    let letter = at_least(lower, b'a') & !at_least(lower, b'f' + 1);
    let no_digit = !(decimal | letter) | word;
    (no_digit & HIGH).trailing_zeros() / 8
}

/// Eight hexadecimal digits (the first in the lowest byte) as four bytes, the first lowest. A pair
/// with a character that is no digit, and every pair after it, is undefined.
#[inline(always)]
pub fn bytes(word: u64) -> u32 {
    // 'A' and 'a' have 1 in their low four bits: nine short of their value.
    let nibbles = (word & (ONES * 0x0F)).wrapping_add(((word >> 6) & ONES) * 9);
    let pairs = ((nibbles << 4) | (nibbles >> 8)) & 0x00FF_00FF_00FF_00FF;
    let quads = (pairs | (pairs >> 8)) & 0x0000_FFFF_0000_FFFF;
    (quads | (quads >> 16)) as u32
}

/// The value of six decimal digits followed by `") "`, the first in the lowest byte, in thousands;
/// `None` for other characters.
#[inline(always)]
pub fn six_decimals(word: u64) -> Option<u32> {
    let digits = word ^ u64::from_le_bytes(*b"000000) ");
    // In each of the six bytes the high bit says that it is beyond nine.
    let beyond_nine = digits.wrapping_add(0x0000_7676_7676_7676) | digits;
    if beyond_nine & 0xFFFF_8080_8080_8080 != 0 {
        return None;
    }
    // Pairs in the bytes 0, 2 and 4; the first and the last are scaled in one multiplication.
    let pairs = digits * 10 + (digits >> 8);
    let outer = (pairs & 0x0000_00FF_0000_00FF).wrapping_mul(1_000 + (10_000_000 << 32)) >> 32;
    let middle = u32::from((pairs >> 16) as u8) * 100_000;
    Some(outer as u32 + middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_at_every_place_is_a_digit_or_not_as_the_standard_library_says() {
        for place in 0..8 {
            for byte in 0..=u8::MAX {
                let mut text = *b"09afAF7b";
                text[place] = byte;
                let expected = if byte.is_ascii_hexdigit() { 8 } else { place as u32 };
                assert_eq!(leading_digits(u64::from_le_bytes(text)), expected, "{text:?}");
            }
        }
        assert_eq!(leading_digits(u64::from_le_bytes([0xFF; 8])), 0);
    }

    #[test]
    fn pairs_become_bytes_whatever_follows() {
        for value in [0u32, 0x0123_4567, 0x89AB_CDEF, u32::MAX, 0xFEDC_BA98] {
            for text in [format!("{value:08X}"), format!("{value:08x}")] {
                let word = u64::from_le_bytes(text.as_bytes().try_into().unwrap());
                assert_eq!(bytes(word), value.swap_bytes());
            }
        }
        for byte in 0..=u8::MAX {
            let text = [b'F', b'e', b'9', b'A', byte, byte, byte, byte];
            assert_eq!(bytes(u64::from_le_bytes(text)) & 0xFFFF, 0x9AFE);
        }
    }

    #[test]
    fn every_two_and_three_characters_are_read_as_the_standard_library_does() {
        for (first, second) in (0..=u16::MAX).map(|both| both.to_be_bytes().into()) {
            let text: [u8; 2] = [first, second];
            let is_number = text.iter().all(u8::is_ascii_hexdigit);
            let text = std::str::from_utf8(&text).ok().filter(|_| is_number);
            let expected = text.and_then(|text| u8::from_str_radix(text, 16).ok());
            assert_eq!(byte([first, second]), expected, "{first} {second}");
            let padded = expected.map(|value| 0x900 | u16::from(value));
            assert_eq!(three([b'9', first, second]), padded);
            let shifted = expected.map(|value| u16::from(value) << 4 | 0xB);
            assert_eq!(three([first, second, b'b']), shifted);
        }
    }

    #[test]
    fn six_decimals_are_read_and_nothing_else() {
        let read = |text: &[u8; 8]| six_decimals(u64::from_le_bytes(*text));
        for value in (0..1_000_000).step_by(997).chain([999_999]) {
            let text = format!("{value:06}) ");
            assert_eq!(read(text.as_bytes().try_into().unwrap()), Some(1000 * value));
        }
        for place in 0..8 {
            for byte in 0..=u8::MAX {
                let mut text = *b"123456) ";
                let allowed = text[place] == byte || (place < 6 && byte.is_ascii_digit());
                text[place] = byte;
                assert_eq!(read(&text).is_some(), allowed, "{text:?}");
            }
        }
    }
}
