//! Runs the `can-dbc` parser on one statement at a time, and words its errors for people.

use can_dbc::{Dbc, DbcError};

use super::MAX_STATEMENT;
use super::parse_error::{ParseError, excerpt};
use super::statement::{Keyword, Statement};

/// The identifier in word `index` of the statement; the parser would cut it to 16 bits.
pub(super) fn id_of(statement: &Statement, index: usize) -> Option<u64> {
    let word = statement.word(index)?;
    let digits = !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| word.parse().unwrap_or(u64::MAX))
}

/// Parses one statement.
///
/// # Errors
/// A syntax error, with the statement's line in the DBC, what was found there, and what it
/// should look like.
pub(super) fn parse(statement: &Statement) -> Result<Dbc, ParseError> {
    // The parser takes many times a text's size in memory.
    if statement.text.len() > MAX_STATEMENT {
        let (what, limit) = ("bytes in one statement", MAX_STATEMENT);
        return Err(ParseError::TooMany { line: statement.line(), what, limit });
    }
    let dbc = Dbc::try_from(statement.text.as_str()).map_err(|error| {
        let at = statement.line();
        match error {
            DbcError::Pest(error) => {
                // pest's own position types are not exported; its message begins with them.
                let shown = error.to_string();
                let (row, column) = position(&shown).unwrap_or((1, 1));
                let line = statement.lines.get(row - 1).copied().unwrap_or(at);
                let text = statement.text.lines().nth(row - 1).unwrap_or_default();
                let rest: String = text.chars().skip(column - 1).collect();
                let reason = match rest.trim() {
                    "" => "it ends too early".to_owned(),
                    rest => format!("not understood from {:?} on", excerpt(rest)),
                };
                syntax_at(statement.keyword, line, text, reason)
            }
            DbcError::InvalidUint(number) | DbcError::InvalidInt(number) => {
                let (line, text) = find(statement, &number);
                let reason = format!("{} is not a number that can stand here", excerpt(&number));
                syntax_at(statement.keyword, line, text, reason)
            }
            DbcError::UnknownMultiplexIndicator(text) => {
                let (line, found) = find(statement, &text);
                let reason = format!("multiplex indicator m{} out of range", excerpt(&text));
                syntax_at(statement.keyword, line, found, reason)
            }
            other => match without_length(statement) {
                Some((line, text)) => {
                    syntax_at(statement.keyword, line, text, "no length in bits".to_owned())
                }
                None => syntax(statement, at, other.to_string()),
            },
        }
    })?;
    let things = dbc.messages.len()
        + dbc.value_descriptions.len()
        + dbc.signal_extended_value_type_list.len()
        + dbc.extended_multiplex.len()
        + dbc.comments.len();
    if things != 1 {
        let reason = format!("{things} statements on one line");
        return Err(syntax(statement, statement.line(), reason));
    }
    Ok(dbc)
}

/// The line that contains `part`, and its number; the first line if none does.
fn find<'a>(statement: &'a Statement, part: &str) -> (usize, &'a str) {
    let mut rows = statement.text.lines().zip(&statement.lines);
    let first = statement.text.lines().next().unwrap_or_default();
    rows.find(|(text, _)| text.contains(part))
        .map_or((statement.line(), first), |(text, &line)| (line, text))
}

/// The signal line without `|length`, which the grammar accepts and the parser then refuses.
fn without_length(statement: &Statement) -> Option<(usize, &str)> {
    let mut rows = statement.text.lines().zip(&statement.lines).skip(1);
    let place = |text: &'_ str| text.split('@').next().is_some_and(|place| !place.contains('|'));
    rows.find(|(text, _)| place(text)).map(|(text, &line)| (line, text))
}

/// Row and column, both from 1, of ` --> row:column`.
fn position(shown: &str) -> Option<(usize, usize)> {
    let (row, column) = shown.lines().next()?.trim().strip_prefix("--> ")?.split_once(':')?;
    let (row, column) = (row.parse().ok()?, column.parse().ok()?);
    (row > 0 && column > 0).then_some((row, column))
}

/// The error that `statement` cannot be read, for `reason`.
pub(super) fn syntax(statement: &Statement, line: usize, reason: String) -> ParseError {
    let text = statement.text.lines().next().unwrap_or_default();
    syntax_at(statement.keyword, line, text, reason)
}

fn syntax_at(keyword: Keyword, line: usize, text: &str, reason: String) -> ParseError {
    let form = match keyword {
        Keyword::Message if text.trim_start().starts_with("SG_") => {
            "SG_ Name : start|length@1+ (factor,offset) [min|max] \"unit\" Receiver"
        }
        Keyword::Message => "BO_ identifier Name: length Transmitter",
        Keyword::Values => "VAL_ identifier Signal 0 \"off\" 1 \"on\" ;",
        Keyword::ValueType => "SIG_VALTYPE_ identifier Signal : 1;",
        Keyword::Multiplex => "SG_MUL_VAL_ identifier Signal Multiplexor 0-3, 5-5;",
        Keyword::LongName => "BA_ \"SystemSignalLongSymbol\" SG_ identifier Signal \"LongName\";",
        Keyword::Comment => "CM_ SG_ identifier Signal \"text\";",
    };
    ParseError::Syntax { line, found: excerpt(text.trim()), reason, form }
}
