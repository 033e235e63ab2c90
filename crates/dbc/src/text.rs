//! Turns the bytes of a DBC file into text.

use std::borrow::Cow;

const BOM: char = '\u{FEFF}';

/// Characters of Windows-1252 at 0x80..=0x9F; its five holes keep their Latin-1 control characters.
const CP1252: [char; 32] = [
    '€', '\u{81}', '‚', 'ƒ', '„', '…', '†', '‡', 'ˆ', '‰', 'Š', '‹', 'Œ', '\u{8D}', 'Ž', '\u{8F}',
    '\u{90}', '‘', '’', '“', '”', '•', '–', '—', '˜', '™', 'š', '›', 'œ', '\u{9D}', 'ž', 'Ÿ',
];

/// The text of `bytes`: UTF-8 if valid, else Windows-1252 (which contains Latin-1), as DBC editors
/// write it. A byte order mark is dropped. This never fails, since every byte has a character.
pub fn from_bytes(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(without_bom(text)),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| cp1252(byte)).collect()),
    }
}

/// `text` without a leading byte order mark.
pub(super) fn without_bom(text: &str) -> &str {
    text.strip_prefix(BOM).unwrap_or(text)
}

fn cp1252(byte: u8) -> char {
    match byte {
        0x80..=0x9F => CP1252[usize::from(byte - 0x80)],
        _ => char::from(byte),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf8_stays_and_loses_its_mark() {
        assert_eq!(from_bytes("\u{FEFF}°C".as_bytes()), "°C");
        assert!(matches!(from_bytes(b"BO_"), Cow::Borrowed("BO_")));
    }

    #[test]
    fn other_bytes_are_windows_1252() {
        assert_eq!(from_bytes(b"\xB0C \x80 \x9F \xFF"), "°C € Ÿ ÿ");
    }
}
