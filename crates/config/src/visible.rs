//! Texts that are not ours, for a terminal or a log.

use std::borrow::Cow;

/// `text` on one line, where nothing acts on a terminal: control characters, also the C1 ones, separators of lines and
/// what turns the direction of writing stand as escapes. They are those of JSON, so that JSON keeps its meaning.
pub fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, |_, _| false)
}

/// As [`visible`], for a text of several lines: line breaks and tabulators stay.
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c, rest| match c {
        '\n' | '\t' => true,
        '\r' => rest.starts_with('\n'),
        _ => false,
    })
}

/// `text` with escapes for what acts and does not `stay`, which is asked with what follows it.
fn escaped(text: &str, stays: impl Fn(char, &str) -> bool) -> Cow<'_, str> {
    let is_escaped = |at: usize, c: char| acts(c) && !stays(c, &text[at + c.len_utf8()..]);
    let Some(first) = text.char_indices().find(|&(at, c)| is_escaped(at, c)) else {
        return Cow::Borrowed(text);
    };
    let mut out = String::with_capacity(text.len() + 16);
    out.push_str(&text[..first.0]);
    for (at, c) in text[first.0..].char_indices() {
        match c {
            c if !is_escaped(first.0 + at, c) => out.push(c),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c => out.push_str(&format!("\\u{:04x}", u32::from(c))),
        }
    }
    Cow::Owned(out)
}

/// Whether a character does something to a terminal instead of being shown.
fn acts(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || turns || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_acts_and_all_else_stays() {
        let evil = "a\u{1b}[2J\u{9b}1m\u{202e}b\u{2066}\0\u{7f}\r\n\tö—…";
        assert_eq!(visible(evil), "a\\u001b[2J\\u009b1m\\u202eb\\u2066\\u0000\\u007f\\r\\n\\tö—…");
        assert_eq!(visible_lines("one\r\n\ttwo\rthree\u{1b}"), "one\r\n\ttwo\\rthree\\u001b");
        assert!(matches!(visible("Größe — 1 mm"), Cow::Borrowed(_)));
        let json = format!("\"{}\"", visible("\u{9b}\u{202e}"));
        assert_eq!(json, "\"\\u009b\\u202e\"", "a reader of JSON gets back what there was");
    }
}
