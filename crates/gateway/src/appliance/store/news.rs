//! The news of the store: every event, and everything that became of an incident, in the order of writing.

use super::columns::{level, some_text, text};
use super::entries::digits;
use super::reader::StoreReader;
use super::trouble::Trouble;
use rusqlite::{Row, params};
use serde::Serialize;
use tertius_core::time::Timestamp;

/// Something that happened, once.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NewsEntry {
    /// Identity of the store; another one after the database was replaced.
    pub store: String,
    /// Number of the news in the store, by which doubles and gaps are told: each is one more than the one before.
    pub number: i64,
    /// Number of the event; all news of an incident have the same.
    pub id: i64,
    /// Exact time, s since 1970.
    #[serde(serialize_with = "digits")]
    pub at_s: Timestamp,
    /// Name of its [`EventKind`](super::EventKind).
    pub kind: String,
    /// What became of an incident: `opened`, `revised`, `standing`, `closed` or `interrupted`.
    pub progress: Option<String>,
    /// Cylinder number, counted from 1.
    pub cylinder: Option<u8>,
    pub level: Option<&'static str>,
    pub suspect: Option<String>,
    pub fault: Option<String>,
    /// Incident that an act is about.
    pub about: Option<i64>,
    pub text: String,
}

impl StoreReader {
    /// The oldest news, at most so many, behind the number that `after` gives for the identity of the store.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn news(
        &self,
        after: impl Fn(&str) -> i64,
        most: usize,
    ) -> Result<Vec<NewsEntry>, Trouble> {
        let store = self.store()?;
        // What gave way meanwhile is left out, which shows in the numbers.
        let sql = "SELECT n.id, e.id, coalesce(r.at_ns, e.at_ns), e.kind, r.progress, e.cylinder,
                 coalesce(r.level, e.level), coalesce(r.suspect, e.suspect), r.fault, e.incident,
                 coalesce(r.text, e.text)
             FROM news n JOIN events e ON e.id = n.event LEFT JOIN revisions r ON r.id = n.revision
             WHERE n.id > ? ORDER BY n.id LIMIT ?";
        let most = i64::try_from(most).unwrap_or(i64::MAX);
        let mut query = self.connection().prepare(sql)?;
        let rows = query.query_map(params![after(&store), most], |row| news(row, &store))?;
        Ok(rows.collect::<rusqlite::Result<Vec<NewsEntry>>>()?)
    }

    /// Number of news behind the number that `after` gives for the identity of the store.
    ///
    /// # Errors
    /// The store cannot be read.
    pub fn news_behind(&self, after: impl Fn(&str) -> i64) -> Result<u64, Trouble> {
        // Numbers have no gaps, and to count them would take longer after a long outage.
        let ends = "SELECT coalesce(min(id), 1), coalesce(max(id), 0) FROM news";
        let [oldest, newest]: [i64; 2] =
            self.connection().query_row(ends, [], |row| Ok([row.get(0)?, row.get(1)?]))?;
        let after = after(&self.store()?).max(oldest - 1);
        Ok(u64::try_from(newest - after).unwrap_or(0))
    }

    /// Identity of the store.
    fn store(&self) -> Result<String, Trouble> {
        let store = "SELECT store FROM identity LIMIT 1";
        Ok(self.connection().query_row(store, [], |row| row.get(0))?)
    }
}

fn news(row: &Row<'_>, store: &str) -> rusqlite::Result<NewsEntry> {
    Ok(NewsEntry {
        store: store.to_owned(),
        number: row.get(0)?,
        id: row.get(1)?,
        at_s: Timestamp::from_nanos(row.get(2)?),
        kind: text(row, 3)?,
        progress: some_text(row, 4)?,
        cylinder: row.get(5)?,
        level: row.get::<_, Option<u8>>(6)?.map(|number| level(number).name()),
        suspect: some_text(row, 7)?,
        fault: some_text(row, 8)?,
        about: row.get(9)?,
        text: text(row, 10)?,
    })
}
