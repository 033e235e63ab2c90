//! The database: its tables, version by version, and opening it.

use super::columns::text;
use super::trouble::Trouble;
use rusqlite::{Connection, OpenFlags, Transaction, TransactionBehavior};
use std::path::Path;
use std::time::Duration;

/// Marks a database as an event store: "TERT".
const APPLICATION: i32 = 0x5445_5254;

/// Part of the size that is left for the log, bytes.
pub(super) const RESERVE: u64 = 3 << 19;

/// Longest wait for another process that has locked the database. Notes gather meanwhile.
const PATIENCE: Duration = Duration::from_millis(250);

/// Settings of the writer's connection, which bound its memory (1 MB of pages) and its log (1 MB between two
/// checkpoints). Each commit is on the disk: they are few.
const SETTINGS: &str = "PRAGMA cache_size = -1024; PRAGMA synchronous = FULL; \
    PRAGMA wal_autocheckpoint = 250; PRAGMA journal_size_limit = 1048576; \
    PRAGMA temp_store = MEMORY;";

/// SQL that turns each version into the next; version 0 is an empty file. What has been released is never
/// changed: another version follows.
pub const MIGRATIONS: [&str; 5] = [V1, V2, V3, V4, V5];

/// Times are nanoseconds since 1970, of frames where a frame is behind it, otherwise of the system. Lengths are
/// metres. An incident has the number of its event.
const V1: &str = "
CREATE TABLE runs (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    begin_ns INTEGER NOT NULL, seen_ns INTEGER NOT NULL, end_ns INTEGER,
    cause TEXT NOT NULL, version TEXT NOT NULL, machine TEXT NOT NULL, configuration TEXT NOT NULL
) STRICT;
CREATE TABLE events (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    at_ns INTEGER NOT NULL, run INTEGER NOT NULL, kind TEXT NOT NULL,
    cylinder INTEGER, level INTEGER, suspect TEXT, incident INTEGER, text TEXT NOT NULL
) STRICT;
CREATE INDEX events_at ON events (at_ns, id);
CREATE INDEX events_of_incident ON events (incident) WHERE incident IS NOT NULL;
CREATE VIRTUAL TABLE words USING fts5 (
    text, facets, content = '', contentless_delete = 1, detail = column
);
CREATE TABLE incidents (
    id INTEGER PRIMARY KEY, run INTEGER NOT NULL, number INTEGER NOT NULL,
    cylinder INTEGER NOT NULL, begin_ns INTEGER NOT NULL, onset_ns INTEGER NOT NULL,
    end_ns INTEGER, ending TEXT,
    condition TEXT NOT NULL, acknowledged INTEGER NOT NULL, shelved_until_ns INTEGER,
    active INTEGER NOT NULL, listed INTEGER NOT NULL,
    level INTEGER NOT NULL, suspect TEXT NOT NULL, fault TEXT NOT NULL,
    gain REAL, size_m REAL, quantity TEXT, peak_m REAL, peak_ns INTEGER, limit_m REAL,
    detectors TEXT NOT NULL, evidence TEXT NOT NULL, advice TEXT NOT NULL, course TEXT NOT NULL,
    acknowledged_by TEXT, acknowledged_ns INTEGER, acknowledged_note TEXT,
    shelved_by TEXT, shelved_reason TEXT
) STRICT;
CREATE UNIQUE INDEX incidents_of_run ON incidents (run, number);
CREATE INDEX incidents_listed ON incidents (active, level, id) WHERE listed = 1;
CREATE INDEX incidents_shelved ON incidents (shelved_until_ns) WHERE shelved_until_ns IS NOT NULL;
CREATE TABLE tallies (
    condition TEXT NOT NULL, acknowledged INTEGER NOT NULL, count INTEGER NOT NULL,
    PRIMARY KEY (condition, acknowledged)
) STRICT, WITHOUT ROWID;
CREATE TRIGGER tally_new AFTER INSERT ON incidents BEGIN
    INSERT INTO tallies VALUES (new.condition, new.acknowledged, 1)
        ON CONFLICT DO UPDATE SET count = count + 1;
END;
CREATE TRIGGER tally_changed AFTER UPDATE OF condition, acknowledged ON incidents BEGIN
    UPDATE tallies SET count = count - 1
        WHERE condition = old.condition AND acknowledged = old.acknowledged;
    INSERT INTO tallies VALUES (new.condition, new.acknowledged, 1)
        ON CONFLICT DO UPDATE SET count = count + 1;
END;
CREATE TRIGGER tally_gone AFTER DELETE ON incidents BEGIN
    UPDATE tallies SET count = count - 1
        WHERE condition = old.condition AND acknowledged = old.acknowledged;
END;
CREATE INDEX incidents_active ON incidents (cylinder) WHERE active = 1;
CREATE TABLE revisions (
    id INTEGER PRIMARY KEY, incident INTEGER NOT NULL, at_ns INTEGER NOT NULL, progress TEXT NOT NULL,
    level INTEGER NOT NULL, suspect TEXT NOT NULL, fault TEXT NOT NULL, text TEXT NOT NULL
) STRICT;
CREATE INDEX revisions_of_incident ON revisions (incident);
CREATE TABLE warnings (
    id INTEGER PRIMARY KEY, run INTEGER NOT NULL, at_ns INTEGER NOT NULL, cylinder INTEGER NOT NULL,
    detector TEXT NOT NULL, state TEXT NOT NULL, fault TEXT NOT NULL, suspect TEXT NOT NULL,
    level INTEGER NOT NULL, residual_m REAL, threshold_m REAL, evidence_nats REAL, device TEXT
) STRICT;
CREATE INDEX warnings_at ON warnings (at_ns, cylinder);
CREATE TABLE acts (
    event INTEGER PRIMARY KEY, incident INTEGER NOT NULL, at_ns INTEGER NOT NULL, kind TEXT NOT NULL,
    who TEXT NOT NULL, note TEXT NOT NULL, until_ns INTEGER
) STRICT;
CREATE INDEX acts_of_incident ON acts (incident);
CREATE TABLE stops (
    id INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, cylinder INTEGER NOT NULL,
    c1_m REAL NOT NULL, c2_m REAL NOT NULL
) STRICT;
CREATE INDEX stops_of_cylinder ON stops (cylinder, id);
CREATE TABLE hours (
    hour_s INTEGER NOT NULL, cylinder INTEGER NOT NULL, quantity TEXT NOT NULL,
    count INTEGER NOT NULL, judged_s REAL NOT NULL,
    mean_m REAL NOT NULL, squares_m2 REAL NOT NULL, least_m REAL NOT NULL, most_m REAL NOT NULL,
    PRIMARY KEY (hour_s, cylinder, quantity)
) STRICT, WITHOUT ROWID;
";

/// The order in which things were written, across tables, for those who follow the store from elsewhere; and the identity
/// of the store, by which they know that it is another one.
const V2: &str = "
CREATE TABLE identity (store TEXT NOT NULL) STRICT;
INSERT INTO identity VALUES (lower(hex(randomblob(8))));
CREATE TABLE news (
    id INTEGER PRIMARY KEY AUTOINCREMENT, event INTEGER NOT NULL, revision INTEGER
) STRICT;
CREATE INDEX news_of_event ON news (event);
CREATE TRIGGER news_event AFTER INSERT ON events WHEN new.kind <> 'incident' BEGIN
    INSERT INTO news (event) VALUES (new.id);
END;
CREATE TRIGGER news_revision AFTER INSERT ON revisions BEGIN
    INSERT INTO news (event, revision) VALUES (new.incident, new.id);
END;
CREATE TRIGGER news_gone AFTER DELETE ON events BEGIN
    DELETE FROM news WHERE event = old.id;
END;
";

/// When the suspect of an incident was named, and whether by the end of the fault.
const V3: &str = "
ALTER TABLE incidents ADD COLUMN named_ns INTEGER;
ALTER TABLE incidents ADD COLUMN named_by_its_end INTEGER;
";

/// A cylinder with one transducer has no reading of C2 on its stop.
const V4: &str = "
CREATE TABLE stops_of_any (
    id INTEGER PRIMARY KEY, at_ns INTEGER NOT NULL, cylinder INTEGER NOT NULL,
    c1_m REAL NOT NULL, c2_m REAL
) STRICT;
INSERT INTO stops_of_any SELECT id, at_ns, cylinder, c1_m, c2_m FROM stops;
DROP TABLE stops;
ALTER TABLE stops_of_any RENAME TO stops;
CREATE INDEX stops_of_cylinder ON stops (cylinder, id);
";

/// The rule that named the suspect of a warning.
const V5: &str = "
ALTER TABLE warnings ADD COLUMN rule TEXT;
";

/// Opens the database at `path` to write, makes it where there is none, and brings an older one up to date. It
/// never grows beyond `size` bytes.
///
/// # Errors
/// Why it cannot be used.
pub(super) fn open(path: &Path, size: u64) -> Result<Connection, Trouble> {
    let mut database = Connection::open(path)?;
    database.busy_timeout(PATIENCE)?;
    let found = version(&database, &MIGRATIONS)?;
    if found == 0 {
        // Before there is any table, or else it has no effect.
        database.execute_batch("PRAGMA auto_vacuum = INCREMENTAL;")?;
    }
    database.query_row("PRAGMA journal_mode = WAL", [], |_| Ok(()))?;
    database.execute_batch(SETTINGS)?;
    look_over(&database)?;
    migrate(&mut database, &MIGRATIONS)?;
    limit(&database, size, 0)?;
    Ok(database)
}

/// Looks at every page of the database, which takes about a second for 256 MB; damage that nobody looks for is opened
/// in silence, and found when the page is needed.
///
/// # Errors
/// It is damaged.
fn look_over(database: &Connection) -> Result<(), Trouble> {
    let found: String = database.query_row("PRAGMA quick_check(1)", [], |row| text(row, 0))?;
    if found == "ok" { Ok(()) } else { Err(Trouble::Corrupt(found.replace('\n', " "))) }
}

/// Makes the database refuse to grow beyond `size` bytes, less the [`RESERVE`], but for `more` bytes.
///
/// # Errors
/// It cannot be read.
pub(super) fn limit(database: &Connection, size: u64, more: u64) -> Result<(), Trouble> {
    let size = size.saturating_sub(RESERVE).saturating_add(more);
    let page: i64 = database.query_row("PRAGMA page_size", [], |row| row.get(0))?;
    let pages = size.cast_signed() / page.max(512);
    Ok(database.query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))?)
}

/// Most bytes of the database that one who reads keeps in memory.
pub const READ_CACHE: usize = 2 << 20;

/// Opens the database at `path` to read.
///
/// # Errors
/// Why it cannot be used.
pub(super) fn open_to_read(path: &Path) -> Result<Connection, Trouble> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = Connection::open_with_flags(path, flags)?;
    database.busy_timeout(PATIENCE)?;
    let cache = READ_CACHE / 1024;
    database.execute_batch(&format!("PRAGMA cache_size = -{cache}; PRAGMA query_only = ON;"))?;
    match version(&database, &MIGRATIONS)? {
        found if found == MIGRATIONS.len() => Ok(database),
        0 => Err(Trouble::Empty),
        found => Err(Trouble::Older(found)),
    }
}

/// Version of the database.
///
/// # Errors
/// It is not an event store, or one of a newer program.
fn version(database: &Connection, migrations: &[&str]) -> Result<usize, Trouble> {
    let number = |pragma: &str| -> rusqlite::Result<i32> {
        database.query_row(&format!("PRAGMA {pragma}"), [], |row| row.get(0))
    };
    let (application, found) = (number("application_id")?, number("user_version")?);
    let objects: i64 =
        database.query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))?;
    if application != APPLICATION && (application != 0 || found != 0 || objects != 0) {
        return Err(Trouble::Foreign);
    }
    match usize::try_from(found) {
        Ok(found) if found <= migrations.len() => Ok(found),
        _ => Err(Trouble::Newer { found, known: migrations.len() }),
    }
}

/// Brings a database up to the last of `migrations`, each whole or not at all.
fn migrate(database: &mut Connection, migrations: &[&str]) -> Result<(), Trouble> {
    while version(database, migrations)? < migrations.len() {
        let step = database.transaction_with_behavior(TransactionBehavior::Immediate)?;
        // Another process may have been faster.
        let found = version(&step, migrations)?;
        if let Some(sql) = migrations.get(found) {
            apply(&step, sql, found + 1)?;
        }
        step.commit()?;
    }
    Ok(())
}

fn apply(step: &Transaction<'_>, sql: &str, version: usize) -> rusqlite::Result<()> {
    step.execute_batch(sql)?;
    step.execute_batch(&format!(
        "PRAGMA application_id = {APPLICATION}; PRAGMA user_version = {version};"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u64 = 4 << 20;

    #[test]
    fn a_database_goes_through_each_version_and_keeps_its_rows() {
        let steps = [V1, "ALTER TABLE stops ADD COLUMN temperature_k REAL"];
        let mut database = Connection::open_in_memory().expect("memory");
        migrate(&mut database, &steps[..1]).expect("it is new");
        database
            .execute_batch("INSERT INTO stops VALUES (7, 1, 2, 0.25, 0.5)")
            .expect("a row of version 1");
        migrate(&mut database, &steps).expect("one step more");
        assert_eq!(version(&database, &steps).expect("ours"), 2);
        let row: (f64, Option<f64>) = database
            .query_row("SELECT c1_m, temperature_k FROM stops WHERE id = 7", [], |row| {
                Ok((row.get(0)?, row.get(1)?))
            })
            .expect("it is still there");
        assert_eq!(row, (0.25, None));
        // What the older program then makes of it.
        let refused = version(&database, &steps[..1]);
        assert!(matches!(refused, Err(Trouble::Newer { found: 2, known: 1 })), "{refused:?}");
    }

    #[test]
    fn readings_on_the_stop_are_kept_where_c2_may_be_missing() {
        let mut database = Connection::open_in_memory().expect("memory");
        migrate(&mut database, &MIGRATIONS[..3]).expect("it is new");
        let insert = |database: &Connection, row: &str| {
            database.execute_batch(&format!("INSERT INTO stops VALUES ({row})"))
        };
        insert(&database, "7, 1, 2, 0.25, 0.5").expect("a pair");
        insert(&database, "8, 1, 2, 0.25, NULL").expect_err("there was always a C2");
        migrate(&mut database, &MIGRATIONS).expect("one step more");
        insert(&database, "8, 1, 2, 0.25, NULL").expect("a cylinder with one transducer");
        let mut rows = database.prepare("SELECT c2_m FROM stops ORDER BY id").expect("it is there");
        let found: Vec<Option<f64>> = rows
            .query_map([], |row| row.get(0))
            .expect("rows")
            .map(|it| it.expect("one"))
            .collect();
        assert_eq!(found, [Some(0.5), None]);
    }

    #[test]
    fn a_step_that_fails_changes_nothing() {
        let mut database = Connection::open_in_memory().expect("memory");
        migrate(&mut database, &[V1]).expect("it is new");
        let bad = [V1, "CREATE TABLE more (a) STRICT; CREATE TABLE runs (a)"];
        migrate(&mut database, &bad).expect_err("the table is there already");
        assert_eq!(version(&database, &bad).expect("ours"), 1);
        let more = database.prepare("SELECT a FROM more");
        assert!(more.is_err(), "half of the step was kept");
    }

    #[test]
    fn what_is_not_an_event_store_is_told_and_left_alone() {
        let folder = tempfile::tempdir().expect("there is room");
        let path = folder.path().join("other");
        let other = Connection::open(&path).expect("the folder is ours");
        other.execute_batch("CREATE TABLE kept (a)").expect("it is a database");
        drop(other);
        let before = std::fs::read(&path).expect("it is there");
        assert!(matches!(open(&path, SIZE), Err(Trouble::Foreign)));
        assert_eq!(std::fs::read(&path).expect("it is there"), before);
        std::fs::write(&path, "no database, however long it is, and longer").expect("ours");
        assert!(matches!(open(&path, SIZE), Err(Trouble::Corrupt(_))));
    }
}
