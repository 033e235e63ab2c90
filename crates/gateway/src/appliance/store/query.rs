//! What is searched for.

use super::event_rows::compact;
use super::note::EventKind;
use super::trouble::Trouble;
use rusqlite::Connection;
use rusqlite::types::Value;
use tertius_core::alarm::Level;
use tertius_core::time::Timestamp;
use tertius_core::verdict::Suspect;

/// Most entries that a search returns.
pub const MOST_FOUND: usize = 500;

/// Most words of a search, and most letters of each.
const WORDS: usize = 8;
const LETTERS: usize = 32;

/// What entries have to be. Everything that is `None` holds for all.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filter {
    /// Words that the entry has, in any order; the beginning of each is enough. At most eight are looked for.
    pub text: String,
    /// Cylinder number, counted from 1.
    pub cylinder: Option<u8>,
    pub suspect: Option<Suspect>,
    /// Least level.
    pub level: Option<Level>,
    pub kind: Option<EventKind>,
    /// Earliest time.
    pub from: Option<Timestamp>,
    /// Time before which they are.
    pub to: Option<Timestamp>,
    /// EventEntry before which they are: [`EventPage::next`](super::EventPage::next) of the page before.
    pub before: Option<i64>,
    /// Most entries; 0, and more than [`MOST_FOUND`], is as many as these.
    pub limit: usize,
}

impl Filter {
    pub(super) fn limit(&self) -> usize {
        if self.limit == 0 { MOST_FOUND } else { self.limit.min(MOST_FOUND) }
    }

    /// An expression for the index; `None` if every entry fits.
    fn expression(&self) -> Option<String> {
        let level = self.level.filter(|level| *level > Level::None).map(|least| {
            let levels = (least as u8..=Level::Black as u8).map(|it| format!("\"level{it}\""));
            format!("facets : ({})", levels.collect::<Vec<_>>().join(" OR "))
        });
        let facet = |name: String| format!("facets : \"{name}\"");
        let facets = [
            self.kind.map(|kind| facet(format!("kind{}", compact(kind.name())))),
            self.cylinder.map(|number| facet(format!("cylinder{number}"))),
            self.suspect.map(|suspect| facet(format!("suspect{}", suspect.name()))),
            level,
        ];
        let words = self.text.split(|c: char| !c.is_alphanumeric()).filter(|it| !it.is_empty());
        let words = words.take(WORDS).map(|word| {
            let word: String = word.chars().take(LETTERS).collect();
            format!("text : \"{word}\" *")
        });
        let terms: Vec<String> = facets.into_iter().flatten().chain(words).collect();
        (!terms.is_empty()).then(|| terms.join(" AND "))
    }

    /// The conditions, to follow `FROM`, and their values. The numbers of a time range bound the search, since they
    /// are nearly in the order of time.
    pub(super) fn conditions(&self, database: &Connection) -> Result<Conditions, Trouble> {
        let [from, to] = [(self.from, i64::MIN), (self.to, i64::MAX)]
            .map(|(at, open)| at.map_or(open, Timestamp::as_nanos));
        let mut ids = (i64::MIN, self.before.unwrap_or(i64::MAX).saturating_sub(1));
        if self.from.is_some() || self.to.is_some() {
            let (first, last): (Option<i64>, Option<i64>) = database.query_row(
                "SELECT min(id), max(id) FROM events WHERE at_ns >= ? AND at_ns < ?",
                [from, to],
                |row| Ok((row.get(0)?, row.get(1)?)),
            )?;
            ids = (first.unwrap_or(i64::MAX), ids.1.min(last.unwrap_or(i64::MIN)));
        }
        let mut values = [from, to, ids.0, ids.1].map(Value::Integer).to_vec();
        let sql = match self.expression() {
            Some(expression) => {
                values.push(Value::Text(expression));
                "words CROSS JOIN events e ON e.id = words.rowid
                     LEFT JOIN incidents i ON i.id = e.id
                 WHERE e.at_ns >= ?1 AND e.at_ns < ?2
                     AND words.rowid BETWEEN ?3 AND ?4 AND words MATCH ?5
                 ORDER BY words.rowid DESC"
            }
            None => {
                "events e LEFT JOIN incidents i ON i.id = e.id
                 WHERE e.at_ns >= ?1 AND e.at_ns < ?2 AND e.id BETWEEN ?3 AND ?4
                 ORDER BY e.id DESC"
            }
        };
        Ok(Conditions { sql, values })
    }
}

/// SQL that follows `FROM`, with its values.
pub(super) struct Conditions {
    pub sql: &'static str,
    pub values: Vec<Value>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_people_write_never_is_syntax() {
        let filter =
            Filter { text: "\"frozen* OR (C1 -NEAR 65.8 ä".to_owned(), ..Filter::default() };
        let expected = ["frozen", "OR", "C1", "NEAR", "65", "8", "ä"];
        let expected = expected.map(|word| format!("text : \"{word}\" *")).join(" AND ");
        assert_eq!(filter.expression(), Some(expected));
        let blank = Filter { text: " *\" - ".to_owned(), ..Filter::default() };
        assert_eq!(blank.expression(), None);
        let long = Filter { text: format!("{} ", "x".repeat(99)).repeat(20), ..Filter::default() };
        assert!(long.expression().is_some_and(|it| it.len() < 500));
    }

    #[test]
    fn a_level_is_the_least_one() {
        let filter = Filter { level: Some(Level::Red), ..Filter::default() };
        assert_eq!(filter.expression().as_deref(), Some("facets : (\"level3\" OR \"level4\")"));
        let any = Filter { level: Some(Level::None), ..Filter::default() };
        assert_eq!(any.expression(), None);
    }
}
