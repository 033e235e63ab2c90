//! From statements to drafts of messages: the contents of a DBC, gathered by message but not yet
//! judged.

use std::collections::HashMap;

use can_dbc::{Comment, Dbc, MessageId, ValueDescription};

use super::draft::{Draft, DraftSignal, Multiplex};
use super::finding::{Concern, Finding, Findings, Severity};
use super::parse_error::{ParseError, excerpt};
use super::statement::{Keyword, Statement};
use super::syntax::{id_of, parse, syntax};
use super::{MAX_MESSAGES, MAX_MULTIPLEX_RANGES, MAX_NAME, MAX_SIGNALS, MAX_SIGNALS_PER_MESSAGE};

/// The pseudo-message that holds signals without a message.
const INDEPENDENT: &str = "VECTOR__INDEPENDENT_SIG_MSG";
const INDEPENDENT_ID: u64 = 0xC000_0000;

/// Gathers `statements`.
///
/// # Errors
/// A syntax error in a statement that affects decoding, or a limit that is exceeded. A
/// broken value table or comment is only a warning.
pub(super) fn collect(
    statements: Vec<Statement>,
    findings: &mut Findings,
) -> Result<Vec<Draft>, ParseError> {
    let (messages, others): (Vec<_>, Vec<_>) =
        statements.into_iter().partition(|statement| statement.keyword == Keyword::Message);
    let mut drafts = Vec::new();
    let mut signals = 0;
    for statement in messages {
        let Some(draft) = message(&statement, findings)? else { continue };
        signals += draft.signals.len();
        let line = draft.line;
        drafts.push(draft);
        for (what, count, limit) in
            [("messages", drafts.len(), MAX_MESSAGES), ("signals in all", signals, MAX_SIGNALS)]
        {
            if count > limit {
                return Err(ParseError::TooMany { line, what, limit });
            }
        }
    }
    let mut gathered = Gathered::new(drafts, findings);
    for statement in others {
        gathered.attach(&statement)?;
    }
    Ok(gathered.drafts)
}

fn message(statement: &Statement, findings: &mut Findings) -> Result<Option<Draft>, ParseError> {
    let line = statement.line();
    let id = id_of(statement, 1);
    let name = statement.word(2).and_then(|word| word.split(':').next()).unwrap_or_default();
    if id == Some(INDEPENDENT_ID) || name == INDEPENDENT {
        return Ok(None);
    }
    if statement.lines.len() > MAX_SIGNALS_PER_MESSAGE + 1 {
        return Err(ParseError::TooMany {
            line,
            what: "signals in a message",
            limit: MAX_SIGNALS_PER_MESSAGE,
        });
    }
    // An identifier that the parser cannot take would refuse the whole file: checked before.
    if let Some(id) = id
        && u32::try_from(id).is_err()
    {
        let mut draft = empty_draft(statement, id, checked_name(name, line)?);
        let finding = draft.finding(
            Severity::Error,
            Concern::IdOutOfRange,
            None,
            format!(
                "the identifier {} is beyond 32 bits",
                excerpt(statement.word(1).unwrap_or(""))
            ),
            "give the identifier that the message has on the bus",
        );
        draft.judge(finding, findings);
        return Ok(Some(draft));
    }
    let mut parsed = parse(statement)?.messages;
    let (Some(message), true, Some(id)) = (parsed.pop(), parsed.is_empty(), id) else {
        return Err(syntax(statement, line, "not one message".to_owned()));
    };
    let consistent = u32::try_from(id).ok().and_then(|id| MessageId::try_from(id).ok());
    if consistent != Some(message.id) || message.signals.len() + 1 != statement.lines.len() {
        return Err(syntax(statement, line, "the parser read something else".to_owned()));
    }
    let mut draft = empty_draft(statement, id, checked_name(&message.name, line)?);
    draft.length = message.size;
    for ((parsed, &line), text) in
        message.signals.into_iter().zip(&statement.lines[1..]).zip(statement.text.lines().skip(1))
    {
        checked_name(&parsed.name, line)?;
        draft.signals.push(DraftSignal {
            line,
            parsed,
            long: None,
            bare_indicator: text
                .split(':')
                .next()
                .is_some_and(|head| head.split_ascii_whitespace().nth(2) == Some("m")),
            value_type: None,
            multiplex: None,
            values: Vec::new(),
            comment: None,
        });
    }
    Ok(Some(draft))
}

fn empty_draft(statement: &Statement, id: u64, name: String) -> Draft {
    Draft {
        line: statement.line(),
        id,
        name,
        short: None,
        length: 0,
        comment: None,
        signals: Vec::new(),
        refused: None,
    }
}

fn checked_name(name: &str, line: usize) -> Result<String, ParseError> {
    if name.len() > MAX_NAME {
        return Err(ParseError::LongName { line, bytes: name.len() });
    }
    Ok(name.to_owned())
}

/// Drafts with the data that other statements give about them.
struct Gathered<'a> {
    drafts: Vec<Draft>,
    /// Drafts by identifier; the first of twins, which are all refused later.
    by_id: HashMap<u64, usize>,
    /// Signals by draft and name; the first of twins.
    by_name: HashMap<(usize, String), usize>,
    findings: &'a mut Findings,
}

impl<'a> Gathered<'a> {
    fn new(drafts: Vec<Draft>, findings: &'a mut Findings) -> Self {
        let mut by_id = HashMap::new();
        let mut by_name = HashMap::new();
        for (index, draft) in drafts.iter().enumerate() {
            by_id.entry(draft.id).or_insert(index);
            for (at, signal) in draft.signals.iter().enumerate() {
                by_name.entry((index, signal.parsed.name.clone())).or_insert(at);
            }
        }
        Self { drafts, by_id, by_name, findings }
    }

    fn attach(&mut self, statement: &Statement) -> Result<(), ParseError> {
        if statement.keyword == Keyword::LongName {
            self.attach_long_name(statement);
            return Ok(());
        }
        let optional = matches!(statement.keyword, Keyword::Values | Keyword::Comment);
        let about = match statement.keyword {
            // CM_ BO_ id …, CM_ SG_ id …; others are about nodes, variables or the whole.
            Keyword::Comment if !matches!(statement.word(1), Some("BO_" | "SG_")) => return Ok(()),
            Keyword::Comment => id_of(statement, 2),
            _ => id_of(statement, 1),
        };
        let id = match about {
            // VAL_ of an environment variable has no identifier.
            None if optional => return Ok(()),
            None => {
                return Err(syntax(statement, statement.line(), "no identifier".to_owned()));
            }
            Some(INDEPENDENT_ID) => return Ok(()),
            Some(id) => id,
        };
        let Some(&index) = self.by_id.get(&id) else {
            self.warn(statement, None, None, format!("there is no message with identifier {id}"));
            return Ok(());
        };
        // Such a message is refused already, and the parser would refuse the file.
        if u32::try_from(id).is_err() {
            return Ok(());
        }
        match parse(statement) {
            Ok(dbc) => self.attach_parsed(index, &dbc, statement),
            Err(error) if optional => {
                self.findings.push(Finding {
                    severity: Severity::Warning,
                    concern: Concern::Statement,
                    line: statement.line(),
                    message: Some(self.drafts[index].name.clone()),
                    signal: None,
                    what: error.to_string(),
                    remedy: "the statement is ignored; correct it",
                });
                Ok(())
            }
            Err(error) => Err(error),
        }
    }

    /// Attaches a long name to the short one. A statement without a name or an object is left out:
    /// the short name still works.
    fn attach_long_name(&mut self, statement: &Statement) {
        let Some(LongName { id, signal, name }) = LongName::read(&statement.text) else {
            self.warn(statement, None, None, "not understood as a long name".to_owned());
            return;
        };
        let Some(&index) = self.by_id.get(&id) else {
            self.warn(statement, None, None, format!("there is no message with identifier {id}"));
            return;
        };
        if name.is_empty() || name.len() > MAX_NAME {
            let message = self.drafts[index].name.clone();
            let what = format!("a long name of {} bytes, expected 1 to {MAX_NAME}", name.len());
            self.warn(statement, Some(message), signal.map(str::to_owned), what);
            return;
        }
        let draft = &mut self.drafts[index];
        let Some(signal) = signal else {
            if draft.name != name {
                let short = std::mem::replace(&mut draft.name, name.to_owned());
                draft.short.get_or_insert(short);
            }
            return;
        };
        match self.by_name.get(&(index, signal.to_owned())) {
            Some(&at) => draft.signals[at].long = Some(name.to_owned()),
            None => {
                let message = draft.name.clone();
                let what = "no such signal".to_owned();
                self.warn(statement, Some(message), Some(signal.to_owned()), what);
            }
        }
    }

    fn attach_parsed(
        &mut self,
        index: usize,
        dbc: &Dbc,
        statement: &Statement,
    ) -> Result<(), ParseError> {
        let line = statement.line();
        if let Some(multiplex) = dbc.extended_multiplex.first()
            && multiplex.mappings.len() > MAX_MULTIPLEX_RANGES
        {
            let (what, limit) = ("ranges in one SG_MUL_VAL_", MAX_MULTIPLEX_RANGES);
            return Err(ParseError::TooMany { line, what, limit });
        }
        if let Some(Comment::Message { comment, .. }) = dbc.comments.first() {
            self.drafts[index].comment = Some(comment.clone());
        }
        let Some(name) = signal_name(dbc) else { return Ok(()) };
        match self.by_name.get(&(index, name.clone())) {
            Some(&at) => self.attach_to_signal(index, at, dbc, line),
            None => {
                let message = self.drafts[index].name.clone();
                self.warn(statement, Some(message), Some(name), "no such signal".to_owned());
            }
        }
        Ok(())
    }

    fn attach_to_signal(&mut self, index: usize, at: usize, dbc: &Dbc, line: usize) {
        let mut twice = None;
        let signal = &mut self.drafts[index].signals[at];
        if let Some(entry) = dbc.signal_extended_value_type_list.first() {
            let new = entry.signal_extended_value_type;
            if signal.value_type.replace(new).is_some_and(|old| old != new) {
                twice = Some("SIG_VALTYPE_ gives it two types");
            }
        }
        if let Some(entry) = dbc.extended_multiplex.first() {
            let ranges = entry.mappings.iter().map(|m| (m.min_value, m.max_value)).collect();
            let multiplexor = entry.multiplexor_signal_name.clone();
            if signal.multiplex.replace(Multiplex { line, multiplexor, ranges }).is_some() {
                twice = Some("two SG_MUL_VAL_ name it");
            }
        }
        if let Some(ValueDescription::Signal { value_descriptions, .. }) =
            dbc.value_descriptions.first()
        {
            signal.values =
                value_descriptions.iter().map(|v| (v.id, v.description.clone())).collect();
        }
        if let Some(Comment::Signal { comment, .. }) = dbc.comments.first() {
            signal.comment = Some(comment.clone());
        }
        if let Some(what) = twice {
            let draft = &mut self.drafts[index];
            let mut finding = draft.finding(
                Severity::Error,
                Concern::Reference,
                Some(&draft.signals[at]),
                what.to_owned(),
                "keep one of the statements",
            );
            finding.line = line;
            draft.judge(finding, self.findings);
        }
    }

    fn warn(
        &mut self,
        statement: &Statement,
        message: Option<String>,
        signal: Option<String>,
        what: String,
    ) {
        self.findings.push(Finding {
            severity: Severity::Warning,
            concern: Concern::Reference,
            line: statement.line(),
            message,
            signal,
            what,
            remedy: "the statement is ignored; correct or remove it",
        });
    }
}

/// `BA_ "SystemSignalLongSymbol" SG_ 385 Short "Long";`, or of a message with `BO_ 385`.
struct LongName<'a> {
    id: u64,
    signal: Option<&'a str>,
    name: &'a str,
}

impl<'a> LongName<'a> {
    fn read(text: &'a str) -> Option<Self> {
        let mut parts = text.split('"');
        let attribute = parts.nth(1)?;
        let mut about = parts.next()?.split_ascii_whitespace();
        let name = parts.next()?;
        let kind = about.next()?;
        let id = about.next()?.parse().ok()?;
        let signal = about.next();
        let fits = match attribute {
            "SystemMessageLongSymbol" => kind == "BO_" && signal.is_none(),
            _ => kind == "SG_" && signal.is_some(),
        };
        fits.then_some(Self { id, signal, name })
    }
}

/// The signal that a parsed statement is about.
fn signal_name(dbc: &Dbc) -> Option<String> {
    let value_type = dbc.signal_extended_value_type_list.first().map(|entry| &entry.signal_name);
    let multiplex = dbc.extended_multiplex.first().map(|entry| &entry.signal_name);
    let values = dbc.value_descriptions.first().and_then(|entry| match entry {
        ValueDescription::Signal { name, .. } => Some(name),
        ValueDescription::EnvironmentVariable { .. } => None,
    });
    let comment = dbc.comments.first().and_then(|entry| match entry {
        Comment::Signal { name, .. } => Some(name),
        _ => None,
    });
    value_type.or(multiplex).or(values).or(comment).cloned()
}
