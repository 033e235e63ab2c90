//! The statements of a DBC's text, each with its line.
//!
//! The `can-dbc` parser accepts all or nothing, does not know every keyword, and requires each
//! statement on one line and `1.0` for `1.`. It therefore gets one cleaned statement at a time, and
//! only of the kinds that matter. Its errors then have a line, and unknown statements do no harm.

use super::finding::{Concern, Finding, Findings, Severity};
use super::parse_error::{ParseError, excerpt};

/// Keyword of a statement that is understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keyword {
    /// `BO_` with all its `SG_` lines.
    Message,
    /// `VAL_`
    Values,
    /// `SIG_VALTYPE_`
    ValueType,
    /// `SG_MUL_VAL_`
    Multiplex,
    /// `CM_`
    Comment,
    /// `BA_ "System…LongSymbol"`: a name longer than the format allows.
    LongName,
}

/// A cleaned statement: no comments, and no line breaks outside strings except before `SG_`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Statement {
    pub keyword: Keyword,
    pub text: String,
    /// Line of the statement, followed for a message by the line of each signal.
    pub lines: Vec<usize>,
}

impl Statement {
    /// Line where the statement begins.
    pub fn line(&self) -> usize {
        self.lines[0]
    }

    /// Word number `index` of the statement, separated by blanks; the keyword is 0.
    pub fn word(&self, index: usize) -> Option<&str> {
        self.text.split_ascii_whitespace().nth(index)
    }
}

/// Keywords of the format that do not affect decoding.
const IGNORED: [&str; 24] = [
    "VERSION",
    "NS_",
    "BS_",
    "BU_",
    "VAL_TABLE_",
    "EV_",
    "ENVVAR_DATA_",
    "EV_DATA_",
    "BO_TX_BU_",
    "BA_DEF_",
    "BA_DEF_DEF_",
    "BA_",
    "BA_DEF_REL_",
    "BA_DEF_DEF_REL_",
    "BA_REL_",
    "BA_DEF_SGTYPE_",
    "BA_SGTYPE_",
    "SIG_GROUP_",
    "NS_DESC_",
    "CAT_DEF_",
    "CAT_",
    "FILTER",
    "BU_SG_REL_",
    "BU_EV_REL_",
];

/// Attributes in which Vector's tools keep names longer than the format's 32 characters. Nodes and
/// environment variables have such attributes, too, but they are not needed here.
const LONG_NAMES: [&str; 2] = ["\"SystemMessageLongSymbol\"", "\"SystemSignalLongSymbol\""];

/// Splits `text` into the statements that matter, in order. Unknown keywords become warnings.
///
/// # Errors
/// A string without an end, text outside of any statement, a signal outside of any message.
pub(super) fn split(text: &str, findings: &mut Findings) -> Result<Vec<Statement>, ParseError> {
    let mut splitter = Splitter { statements: Vec::new(), current: Current::None, findings };
    for piece in pieces(text)? {
        splitter.take(&piece)?;
    }
    Ok(splitter.statements)
}

/// The statement that a piece without a keyword continues.
#[derive(Clone, Copy, PartialEq)]
enum Current {
    None,
    /// The last of the statements kept so far.
    Kept,
    Skipped,
    /// `NS_` or `BU_`: names may follow on lines of their own, keywords among them.
    Names,
}

struct Splitter<'a> {
    statements: Vec<Statement>,
    current: Current,
    findings: &'a mut Findings,
}

impl Splitter<'_> {
    fn take(&mut self, piece: &Piece) -> Result<(), ParseError> {
        let text = piece.text.trim();
        let end = text.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(text.len());
        let word = &text[..end];
        if self.current == Current::Names && piece.indented && is_names(text) {
            return Ok(());
        }
        match word {
            "BO_" => self.open(Keyword::Message, piece),
            "VAL_" => self.open(Keyword::Values, piece),
            "SIG_VALTYPE_" => self.open(Keyword::ValueType, piece),
            "SG_MUL_VAL_" => self.open(Keyword::Multiplex, piece),
            "CM_" => self.open(Keyword::Comment, piece),
            "BA_" if LONG_NAMES.iter().any(|name| text[end..].trim_start().starts_with(name)) => {
                self.open(Keyword::LongName, piece);
            }
            "SG_" => self.add_signal(piece)?,
            "NS_" | "BU_" => self.current = Current::Names,
            _ if IGNORED.contains(&word) => self.current = Current::Skipped,
            _ if is_keyword(word) => self.skip_unknown(word, piece.line),
            _ => self.continue_with(text, piece.line)?,
        }
        if piece.complete {
            self.current = Current::None;
        }
        Ok(())
    }

    fn open(&mut self, keyword: Keyword, piece: &Piece) {
        let text = piece.text.trim().to_owned();
        self.statements.push(Statement { keyword, text, lines: vec![piece.line] });
        self.current = Current::Kept;
    }

    fn add_signal(&mut self, piece: &Piece) -> Result<(), ParseError> {
        match self.statements.last_mut() {
            Some(last) if self.current == Current::Kept && last.keyword == Keyword::Message => {
                last.text.push_str("\n ");
                // A unit may be broken over lines; the parser counts a signal a line.
                last.text.push_str(&piece.text.trim().replace('\n', " "));
                last.lines.push(piece.line);
                Ok(())
            }
            _ => Err(ParseError::OrphanSignal { line: piece.line }),
        }
    }

    fn skip_unknown(&mut self, word: &str, line: usize) {
        self.current = Current::Skipped;
        self.findings.push(Finding {
            severity: Severity::Warning,
            concern: Concern::Statement,
            line,
            message: None,
            signal: None,
            what: format!("unknown keyword {}", excerpt(word)),
            remedy: "the statement is ignored; remove it if it is a mistake",
        });
    }

    fn continue_with(&mut self, text: &str, line: usize) -> Result<(), ParseError> {
        match (self.current, self.statements.last_mut()) {
            (Current::Kept, Some(last)) => {
                last.text.push(' ');
                last.text.push_str(&text.replace('\n', " "));
            }
            (Current::Skipped | Current::Names, _) => {}
            _ if text == ";" => {}
            _ => return Err(ParseError::Stray { line, found: excerpt(text) }),
        }
        Ok(())
    }
}

fn is_keyword(word: &str) -> bool {
    word.len() > 2
        && word.ends_with('_')
        && word.bytes().all(|byte| byte.is_ascii_uppercase() || byte == b'_')
}

fn is_names(text: &str) -> bool {
    text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == ' ' || c == '\t')
}

/// Text between line breaks and semicolons outside of strings.
struct Piece {
    line: usize,
    text: String,
    indented: bool,
    /// A semicolon ended it.
    complete: bool,
}

/// Splits `text` into pieces, none of which is blank.
fn pieces(text: &str) -> Result<Vec<Piece>, ParseError> {
    let mut pieces = Vec::new();
    let mut piece = String::new();
    // Line on which the piece began, line now, line on which the open string began.
    let (mut start, mut line, mut opened) = (1, 1, None);
    let mut characters = text.chars().peekable();
    let mut finish = |piece: &mut String, line: usize, complete: bool| {
        let text = std::mem::take(piece);
        if !text.trim().is_empty() {
            let indented = text.starts_with([' ', '\t']);
            pieces.push(Piece { line, text, indented, complete });
        }
    };
    while let Some(character) = characters.next() {
        let character = match character {
            // CRLF and the lone CR of old editors.
            '\r' => {
                characters.next_if_eq(&'\n');
                '\n'
            }
            other => other,
        };
        match (character, opened) {
            ('\0', _) => return Err(ParseError::NotText { line }),
            ('"', _) => {
                opened = if opened.is_some() { None } else { Some(line) };
                piece.push('"');
            }
            ('\\', Some(_)) => {
                piece.push('\\');
                piece.extend(characters.next_if_eq(&'"'));
            }
            ('\n', None) => {
                finish(&mut piece, start, false);
                start = line + 1;
            }
            (';', None) => {
                piece.push(';');
                finish(&mut piece, start, true);
                start = line;
            }
            ('/', None) if characters.peek() == Some(&'/') => {
                while characters.next_if(|&c| c != '\n' && c != '\r').is_some() {}
            }
            ('.', None) => {
                let bare = piece.ends_with(|c: char| c.is_ascii_digit())
                    && !characters.peek().is_some_and(char::is_ascii_digit);
                piece.push_str(if bare { ".0" } else { "." });
            }
            (other, _) => piece.push(other),
        }
        if character == '\n' {
            line += 1;
        }
    }
    if let Some(line) = opened {
        return Err(ParseError::OpenString { line });
    }
    finish(&mut piece, start, false);
    Ok(pieces)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split_all(text: &str) -> Vec<(Keyword, String, Vec<usize>)> {
        let mut findings = Findings::default();
        let statements = split(text, &mut findings).unwrap();
        assert_eq!(findings.list(), []);
        statements.into_iter().map(|s| (s.keyword, s.text, s.lines)).collect()
    }

    #[test]
    fn signals_belong_to_their_message_over_blank_lines_and_comments() {
        let text = "NS_ :\n\tCM_\n\tBO_\n\nBU_: A\n B_\n\nBO_ 1 M: 8 A\n\n // SG_ no\r\n SG_ S : 0|8@1+ (1.,0) [0|1] \"a.\"\n  A // end\n";
        assert_eq!(
            split_all(text),
            [(
                Keyword::Message,
                "BO_ 1 M: 8 A\n SG_ S : 0|8@1+ (1.0,0) [0|1] \"a.\" A".to_owned(),
                vec![8, 11]
            )]
        );
    }

    #[test]
    fn strings_hide_everything_and_count_their_lines() {
        let text = "CM_ \"BO_ 1; // \\\" \n SG_\";VAL_ 1 S\n 0 \"x\"\n;\nVAL_ 2 S 0 \"y\";";
        assert_eq!(
            split_all(text),
            [
                (Keyword::Comment, "CM_ \"BO_ 1; // \\\" \n SG_\";".to_owned(), vec![1]),
                (Keyword::Values, "VAL_ 1 S 0 \"x\" ;".to_owned(), vec![2]),
                (Keyword::Values, "VAL_ 2 S 0 \"y\";".to_owned(), vec![5]),
            ]
        );
    }
}
