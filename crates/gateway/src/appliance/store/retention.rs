//! What gives way, so that the database keeps to its size and its age.

use super::schema::{self, RESERVE};
use super::trouble::Trouble;
use rusqlite::{Connection, TransactionBehavior, params};
use tertius_core::time::{Span, Timestamp};

/// Share of the size, less [`RESERVE`], from which rows give way, percent.
const SHARE: u64 = 90;

/// Events that give way in one transaction.
const ROWS: u32 = 256;

/// Most such pieces in a step.
const PIECES: usize = 8;

/// Most events other than incidents and acts: those of a bus that comes and goes for months.
const EVENTS: u32 = 50_000;

/// Pages that are given back to the disk in a step.
const PAGES: u32 = 512;

/// Interval at which the age is looked at.
const EACH: Span = Span::from_nanos(3_600_000_000_000);

/// Limits of the database.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    /// Bytes.
    pub size: u64,
    pub days: u32,
}

impl Limits {
    /// Size from which rows give way, bytes.
    const fn most(self) -> u64 {
        self.size.saturating_sub(RESERVE) / 100 * SHARE
    }
}

/// The clock by which rows age.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Aging(Option<Timestamp>);

/// Whether rows have to give way now.
///
/// # Errors
/// The database cannot be read.
pub(super) fn is_due(database: &Connection, limits: Limits) -> Result<bool, Trouble> {
    Ok(used(database)? > limits.most())
}

/// What a step has left to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Left {
    Nothing,
    More,
}

impl Aging {
    /// The time by which rows are old, at `now` by the system; `None` while it is too early. A clock that leaps ahead
    /// ages nothing at once: the time grows by [`EACH`] at most between two looks.
    fn look(&mut self, now: Timestamp) -> Option<Timestamp> {
        let last = *self.0.get_or_insert(now);
        if now < last {
            // It was set back.
            self.0 = Some(now);
            return None;
        }
        if now.since(last) < EACH {
            return None;
        }
        let next = last.after(EACH);
        self.0 = Some(next);
        Some(next)
    }
}

/// Takes a step towards the limits.
///
/// # Errors
/// The database cannot be written.
pub(super) fn step(
    database: &mut Connection,
    limits: Limits,
    aging: &mut Aging,
    now: Timestamp,
) -> Result<Left, Trouble> {
    if let Some(now) = aging.look(now) {
        let day = Span::from_seconds(86_400.0).as_nanos();
        let age = day.saturating_mul(i64::from(limits.days));
        let before = now.after(Span::from_nanos(-age));
        for _ in 0..PIECES {
            if delete(database, Some(before))? < ROWS {
                break;
            }
        }
        crowd_out(database)?;
    }
    let mut left = Left::Nothing;
    let most = limits.most();
    for _ in 0..PIECES {
        if used(database)? <= most || delete(database, None)? == 0 && delete_hours(database)? == 0 {
            break;
        }
        left = Left::More;
    }
    // What is free is used again; more of it than that goes back to the disk.
    let free: i64 = pragma(database, "freelist_count")?;
    if size(database)? > most && free > 0 || free > 16 * i64::from(PAGES) {
        give_back(database)?;
        left = Left::More;
    }
    Ok(left)
}

/// Makes room now, because nothing can be written any more, if that is for the size of the database; where the disk
/// is full for something else, nothing is given up. Returns whether there is room now.
///
/// # Errors
/// The database cannot be written.
pub(super) fn make_room(database: &mut Connection, limits: Limits) -> Result<bool, Trouble> {
    if !is_due(database, limits)? {
        return Ok(false);
    }
    // The index notes what is deleted, for which it needs pages before any are free: for so long it may grow.
    schema::limit(database, limits.size, limits.size)?;
    let made = clear_out(database);
    schema::limit(database, limits.size, 0)?;
    made
}

/// Deletes the oldest, and gives the pages back. Returns whether anything was deleted.
fn clear_out(database: &mut Connection) -> Result<bool, Trouble> {
    let mut made = false;
    for _ in 0..PIECES {
        if delete(database, None)? == 0 && delete_hours(database)? == 0 {
            break;
        }
        made = true;
    }
    give_back(database)?;
    Ok(made)
}

/// Size of the database, bytes.
pub(super) fn size(database: &Connection) -> Result<u64, Trouble> {
    let pages: i64 = pragma(database, "page_count")?;
    Ok(pages.cast_unsigned() * page_size(database)?)
}

fn used(database: &Connection) -> Result<u64, Trouble> {
    let free: i64 = pragma(database, "freelist_count")?;
    Ok(size(database)?.saturating_sub(free.cast_unsigned() * page_size(database)?))
}

fn page_size(database: &Connection) -> Result<u64, Trouble> {
    pragma(database, "page_size").map(i64::cast_unsigned)
}

fn pragma(database: &Connection, name: &str) -> Result<i64, Trouble> {
    Ok(database.query_row(&format!("PRAGMA {name}"), [], |row| row.get(0))?)
}

fn give_back(database: &Connection) -> Result<(), Trouble> {
    let mut query = database.prepare(&format!("PRAGMA incremental_vacuum({PAGES})"))?;
    let mut pages = query.query([])?;
    while pages.next()?.is_some() {}
    Ok(())
}

/// Deletes the oldest events, at most [`ROWS`], but for incidents that are open: those from before `before`, or the
/// oldest of all, with everything that belongs to them. Returns the number of events.
fn delete(database: &mut Connection, before: Option<Timestamp>) -> Result<u32, Trouble> {
    let step = database.transaction_with_behavior(TransactionBehavior::Immediate)?;
    step.execute_batch(
        "CREATE TEMP TABLE IF NOT EXISTS gone (id INTEGER PRIMARY KEY); DELETE FROM gone",
    )?;
    let before = before.map_or(i64::MAX, Timestamp::as_nanos);
    step.execute(
        "INSERT INTO gone SELECT id FROM events WHERE at_ns < ?
             AND id NOT IN (SELECT id FROM incidents WHERE active = 1) ORDER BY id LIMIT ?",
        params![before, ROWS],
    )?;
    let (newest, count): (Option<i64>, u32) =
        step.query_row("SELECT max(id), count(*) FROM gone", [], |row| {
            Ok((row.get(0)?, row.get(1)?))
        })?;
    let Some(newest) = newest else { return Ok(0) };
    // Warnings and stops have no event: those go that are as old.
    step.execute_batch(&format!(
        "DELETE FROM warnings WHERE at_ns <= (SELECT at_ns FROM events WHERE id = {newest})
             AND at_ns < coalesce(
                 (SELECT min(begin_ns) FROM incidents WHERE active = 1), {max});
         INSERT OR IGNORE INTO gone SELECT id FROM events WHERE incident IN gone;
         DELETE FROM revisions WHERE incident IN gone;
         DELETE FROM acts WHERE event IN gone;
         DELETE FROM words WHERE rowid IN gone;
         DELETE FROM incidents WHERE id IN gone;
         DELETE FROM events WHERE id IN gone;
         DELETE FROM runs WHERE id < (SELECT run FROM events ORDER BY id LIMIT 1);",
        max = i64::MAX
    ))?;
    step.commit()?;
    Ok(count)
}

/// Deletes what a bus that comes and goes has left beyond [`EVENTS`].
fn crowd_out(database: &mut Connection) -> Result<(), Trouble> {
    let step = database.transaction_with_behavior(TransactionBehavior::Immediate)?;
    step.execute_batch(&format!(
        "CREATE TEMP TABLE IF NOT EXISTS gone (id INTEGER PRIMARY KEY); DELETE FROM gone;
         INSERT INTO gone SELECT id FROM events WHERE kind NOT IN ('incident', 'act')
             ORDER BY id DESC LIMIT -1 OFFSET {EVENTS};
         DELETE FROM words WHERE rowid IN gone;
         DELETE FROM events WHERE id IN gone;"
    ))?;
    Ok(step.commit()?)
}

/// Deletes the oldest hours of all cylinders, and as old stops. Returns the number of rows.
fn delete_hours(database: &Connection) -> Result<usize, Trouble> {
    let hours = database
        .execute("DELETE FROM hours WHERE hour_s <= (SELECT min(hour_s) FROM hours) + 86400", [])?;
    let oldest = "DELETE FROM stops WHERE id IN (SELECT id FROM stops ORDER BY id LIMIT ?)";
    Ok(hours + database.execute(oldest, [ROWS])?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_leaps_ages_nothing_at_once() {
        let at = |hours: i64| Timestamp::from_nanos(hours * EACH.as_nanos());
        let mut aging = Aging::default();
        let years = 24 * 365 * 20;
        let looks = [0, 1, 1, 2, years, years, 3, 4];
        let seen = looks.map(|hours| aging.look(at(hours)));
        let expected = [None, Some(1), None, Some(2), Some(3), Some(4), None, Some(4)];
        assert_eq!(seen, expected.map(|hours| hours.map(at)));
    }
}
