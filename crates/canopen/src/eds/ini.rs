//! The lines of an EDS: sections with their entries, each with its line.
//!
//! The dialect is that of CiA 306: `;` begins a comment, at the start of a line or behind a blank, and
//! letter case does not matter in names. Files in use also begin lines of comment with `#`.

use std::collections::BTreeSet;

use super::finding::{Concern, Findings};
use super::parse_error::{ParseError, excerpt};
use super::{MAX_ENTRIES, MAX_LINE, MAX_SECTIONS, MAX_TEXT};

/// One `KEY=VALUE`, both without blanks around them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry<'a> {
    pub key: &'a str,
    pub value: &'a str,
    pub line: usize,
}

/// One `[NAME]` with its entries.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Section<'a> {
    pub name: &'a str,
    pub line: usize,
    pub entries: Vec<Entry<'a>>,
}

impl<'a> Section<'a> {
    /// The first entry of that key, whatever the case of its letters.
    pub fn entry(&self, key: &str) -> Option<Entry<'a>> {
        self.entries.iter().find(|entry| entry.key.eq_ignore_ascii_case(key)).copied()
    }

    /// The entry of that key unless its value is empty.
    pub fn filled(&self, key: &str) -> Option<Entry<'a>> {
        self.entry(key).filter(|entry| !entry.value.is_empty())
    }
}

/// Splits `text` into its sections, in order.
///
/// # Errors
/// A text that is too long, is no text, or has too much of something. A line that is not
/// understood is a warning.
pub(super) fn split<'a>(
    text: &'a str,
    findings: &mut Findings,
) -> Result<Vec<Section<'a>>, ParseError> {
    if text.len() > MAX_TEXT {
        return Err(ParseError::TooLong { bytes: text.len() });
    }
    let text = text.strip_prefix('\u{FEFF}').unwrap_or(text);
    if text.trim_start().starts_with("<?xml") {
        return Err(ParseError::Xml);
    }
    let mut splitter = Splitter::default();
    // A line ends with LF, CR LF, or the CR of old Macintoshes.
    let line_end = if text.contains('\n') { '\n' } else { '\r' };
    for (line, content) in (1..).zip(text.split(line_end)) {
        if content.contains('\0') {
            return Err(ParseError::NotText { line });
        }
        if content.len() > MAX_LINE {
            return Err(ParseError::LongLine { line, bytes: content.len() });
        }
        splitter.take(line, without_comment(content), findings)?;
    }
    Ok(splitter.sections)
}

#[derive(Default)]
struct Splitter<'a> {
    sections: Vec<Section<'a>>,
    /// Keys of the last section in small letters.
    keys: BTreeSet<String>,
    entries: usize,
}

impl<'a> Splitter<'a> {
    fn take(
        &mut self,
        line: usize,
        content: &'a str,
        findings: &mut Findings,
    ) -> Result<(), ParseError> {
        if content.is_empty() {
            return Ok(());
        }
        if let Some(rest) = content.strip_prefix('[')
            && let Some((name, _)) = rest.rsplit_once(']')
        {
            return self.open(line, name.trim());
        }
        let Some((key, value)) = content.split_once('=') else {
            let what = format!("found {:?}", excerpt(content));
            findings.warn(Concern::Line, line, what, LINE_FORM);
            return Ok(());
        };
        self.entries += 1;
        if self.entries > MAX_ENTRIES {
            return Err(ParseError::TooMany { line, what: "entries", limit: MAX_ENTRIES });
        }
        let entry = Entry { key: key.trim(), value: value.trim(), line };
        match self.sections.last_mut() {
            None => {
                let what = format!("{:?} stands before the first section", excerpt(entry.key));
                findings.warn(Concern::Section, line, what, "begin with [FileInfo]");
            }
            Some(section) => {
                if !self.keys.insert(entry.key.to_ascii_lowercase()) {
                    let what = format!("[{}] has {} twice", section.name, excerpt(entry.key));
                    findings.warn(Concern::Duplicate, line, what, "the first one counts");
                }
                section.entries.push(entry);
            }
        }
        Ok(())
    }

    fn open(&mut self, line: usize, name: &'a str) -> Result<(), ParseError> {
        if self.sections.len() == MAX_SECTIONS {
            return Err(ParseError::TooMany { line, what: "sections", limit: MAX_SECTIONS });
        }
        self.sections.push(Section { name, line, entries: Vec::new() });
        self.keys.clear();
        Ok(())
    }
}

const LINE_FORM: &str =
    "a line is [SECTION], KEY=VALUE, or a comment that begins with ;, so this one was left out";

/// `line` without a comment and without blanks around it.
fn without_comment(line: &str) -> &str {
    let line = line.trim();
    if line.starts_with([';', '#']) {
        return "";
    }
    let mut behind_blank = false;
    for (at, character) in line.char_indices() {
        if character == ';' && behind_blank {
            return line[..at].trim_end();
        }
        behind_blank = character.is_whitespace();
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sections with their lines, entries with theirs, and findings.
    type Read<'a> = (Vec<(&'a str, usize)>, Vec<(&'a str, &'a str, usize)>, Vec<String>);

    fn read(text: &str) -> Read<'_> {
        let mut findings = Findings::default();
        let sections = split(text, &mut findings).unwrap();
        (
            sections.iter().map(|section| (section.name, section.line)).collect(),
            sections
                .iter()
                .flat_map(|it| &it.entries)
                .map(|it| (it.key, it.value, it.line))
                .collect(),
            findings.list().iter().map(ToString::to_string).collect(),
        )
    }

    #[test]
    fn comments_blanks_and_line_ends_do_not_matter() {
        let lines = [
            "\u{FEFF}; a comment",
            "# another",
            "",
            "  [ 1000 ] ; the type",
            "ParameterName = a;b # 1 ; c",
            "[1001] # repeat",
        ];
        for end in ["\n", "\r\n", "\r"] {
            let text = lines.join(end);
            let (sections, entries, findings) = read(&text);
            assert_eq!(sections, [("1000", 4), ("1001", 6)]);
            assert_eq!(entries, [("ParameterName", "a;b # 1", 5)]);
            assert_eq!(findings, [] as [String; 0]);
        }
    }

    #[test]
    fn what_is_no_entry_is_told_with_its_line() {
        let (_, entries, findings) = read("a=1\n[x]\nb\nc=1\nC=2");
        assert_eq!(entries, [("c", "1", 4), ("C", "2", 5)]);
        assert_eq!(findings.len(), 3);
        assert!(findings[0].starts_with("line 1: \"a\" stands before the first section"));
        assert!(findings[1].starts_with("line 3: found \"b\"; a line is [SECTION]"));
        assert!(findings[2].starts_with("line 5: [x] has C twice"));
    }

    #[test]
    fn what_is_no_text_is_refused() {
        let refused = |text: &str| split(text, &mut Findings::default()).unwrap_err();
        assert_eq!(refused("[a]\nb\0=1"), ParseError::NotText { line: 2 });
        assert_eq!(refused("<?xml version=\"1.0\"?>"), ParseError::Xml);
        let long = format!("[a]\n\nb={}", "1".repeat(MAX_LINE));
        assert_eq!(refused(&long), ParseError::LongLine { line: 3, bytes: MAX_LINE + 2 });
        let bytes = MAX_TEXT + 1;
        assert_eq!(refused(&"\n".repeat(bytes)), ParseError::TooLong { bytes });
        let many = "[a]\n".repeat(MAX_SECTIONS + 1);
        assert_eq!(refused(&many).line(), Some(MAX_SECTIONS + 1));
        let many = format!("[a]\n{}", "b=1\n".repeat(MAX_ENTRIES + 1));
        assert_eq!(refused(&many).line(), Some(MAX_ENTRIES + 2));
    }
}
