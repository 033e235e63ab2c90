//! The event store: what happened on the machine, in a database on disk.
//!
//! ```text
//! data path ─ Clerk ─ notes ─→ Writer ─ rows ─→ SQLite ─→ StoreReader ─→ page, `tertius events`
//!              StoreHandle ─ acts ─↗
//! ```
//!
//! The data path hands small notes over ([`Clerk`]) and never waits; a thread of its own writes them twice a
//! second at most. People's acts on alarms ([`crate::alarm_list`]) come through a [`StoreHandle`] and are events
//! themselves. Anyone reads with a [`StoreReader`], which has its own connection. Whatever befalls the disk, detection
//! does not notice: what cannot be written waits in bounded memory, and what is lost is counted and told.

mod act;
mod backlog;
mod clerk;
mod columns;
mod entries;
mod event_rows;
mod export;
mod hours;
mod incident_rows;
mod news;
mod note;
mod plan;
mod query;
mod reader;
mod retention;
mod rows;
#[cfg(test)]
mod samples;
mod schema;
mod shared;
#[cfg(test)]
mod tests;
mod trouble;
mod vault;
mod writer;

pub use act::{ActError, AlarmAct, LONGEST_NAME, LONGEST_NOTE};
pub use clerk::Clerk;
pub use export::{EXPORT_COLUMNS, ExportFormat, export};
pub use news::NewsEntry;
pub use note::{Event, EventKind};
pub use plan::{Cause, StorePlan};
pub use query::{Filter, MOST_FOUND};
pub use reader::{
    ActEntry, AlarmEntry, AlarmOverview, Counts, EventEntry, EventPage, HourEntry, IncidentFields,
    IncidentPage, Revision, RunEntry, StopEntry, StoreReader, WarningEntry,
};
pub use schema::READ_CACHE;
pub use shared::{StoreHandle, StoreState};
pub use trouble::Trouble;
