//! The folder of `replay --parquet`: a table in each folder of it, partitioned by machine and day.
//!
//! Files are written beside their places while the recording is read, and put there together at its end, the summary
//! last: where there is a summary, the rest is there, too. They are named after the recording's first frame, so that a
//! recording that is replayed again replaces its own.

use super::Failure;
use super::files::{Inputs, Mark, Overwriting, Settled};
use crate::alarm::Warning;
use crate::config::MachineNames;
use crate::incident::Incident;
use crate::monitor::{Notice, Record};
use crate::report::Summary;
use crate::report::columns::{
    self, CylinderRow, DwellRow, IncidentRow, MinuteRow, Minutes, NoticeRow, StopTrendRow,
    SummaryFacts, SummaryRow, TABLES, TableRow, WarningRow,
};
use crate::sequential::Dwell;
use crate::time::Timestamp;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Most rows that are kept in memory for a table; they become a file of their own then.
const MOST_ROWS: usize = 1 << 16;

/// The tables of one replay.
#[derive(Debug)]
pub struct ColumnFolder {
    files: ColumnFiles,
    /// Time stamp of the first frame of all, from which seconds count.
    begin: Timestamp,
    /// How cylinders and transducers are called.
    names: MachineNames,
    warnings: DayRows<WarningRow>,
    incidents: DayRows<IncidentRow>,
    notices: DayRows<NoticeRow>,
    dwells: DayRows<DwellRow>,
    minutes: DayRows<MinuteRow>,
    gathering: Minutes,
}

/// The files that a replay writes.
#[derive(Debug)]
struct ColumnFiles {
    folder: PathBuf,
    machine: String,
    inputs: Inputs,
    overwriting: Overwriting,
    /// Time stamp of the recording's first frame, after which the files are named; `None` before it.
    first: Option<Timestamp>,
    /// The files that are not in their places yet, each with its place.
    written: Vec<(PathBuf, Settled)>,
}

/// Rows of a table, of one day.
#[derive(Debug)]
struct DayRows<R> {
    day: String,
    rows: Vec<R>,
    /// Number of files that each day has so far.
    parts: BTreeMap<String, u32>,
}

impl<R> Default for DayRows<R> {
    fn default() -> Self {
        Self { day: String::new(), rows: Vec::new(), parts: BTreeMap::new() }
    }
}

impl ColumnFolder {
    /// The tables of `machine` below `folder`, which is made where it is missing. None of the `inputs` is written over.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn create(
        folder: &Path,
        (machine, names): (&str, MachineNames),
        inputs: Inputs,
        overwriting: Overwriting,
    ) -> Result<Self, Failure> {
        make(folder)?;
        let files = ColumnFiles {
            folder: folder.to_owned(),
            machine: machine.to_owned(),
            inputs,
            overwriting,
            first: None,
            written: Vec::new(),
        };
        Ok(Self {
            files,
            begin: Timestamp::default(),
            names,
            warnings: DayRows::default(),
            incidents: DayRows::default(),
            notices: DayRows::default(),
            dwells: DayRows::default(),
            minutes: DayRows::default(),
            gathering: Minutes::default(),
        })
    }

    /// Begins with the recording's `first` frame; seconds count from `begin`.
    pub const fn begin(&mut self, first: Timestamp, begin: Timestamp) {
        self.files.first = Some(first);
        self.begin = begin;
    }

    /// Takes a cylinder's cycle.
    ///
    /// # Errors
    /// A file cannot be written, as all that follow.
    pub fn record(&mut self, record: &Record) -> Result<(), Failure> {
        let over = self.gathering.take(record);
        let over = over.map(|minute| minute.named(&self.names));
        over.map_or(Ok(()), |minute| self.minutes.take(minute, &mut self.files))
    }

    /// Takes a warning.
    ///
    /// # Errors
    /// See [`Self::record`].
    pub fn warning(&mut self, warning: &Warning) -> Result<(), Failure> {
        let row = WarningRow::new(self.begin, warning, &self.names);
        self.warnings.take(row, &mut self.files)
    }

    /// Takes a report of an incident.
    ///
    /// # Errors
    /// See [`Self::record`].
    pub fn incident(&mut self, incident: &Incident) -> Result<(), Failure> {
        let row = IncidentRow::new(self.begin, incident, &self.names);
        self.incidents.take(row, &mut self.files)
    }

    /// Takes a notice.
    ///
    /// # Errors
    /// See [`Self::record`].
    pub fn notice(&mut self, notice: &Notice) -> Result<(), Failure> {
        let row = NoticeRow::new(self.begin, notice, &self.names);
        self.notices.take(row, &mut self.files)
    }

    /// Takes the dwell of a rod on its stop.
    ///
    /// # Errors
    /// See [`Self::record`].
    pub fn dwell(&mut self, cylinder: u8, dwell: &Dwell) -> Result<(), Failure> {
        let row = DwellRow::new(self.begin, cylinder, dwell, &self.names);
        self.dwells.take(row, &mut self.files)
    }

    /// Writes what is left with the `summary` of the `recordings`, and puts all files in their places. What an earlier
    /// replay of the same recording has left on other days is deleted. Of a recording without a frame there is nothing.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(
        self,
        summary: &Summary<'_>,
        recordings: &str,
        false_alarms_per_year: f64,
    ) -> Result<(), Failure> {
        let Self {
            mut files,
            names,
            warnings,
            incidents,
            notices,
            dwells,
            mut minutes,
            gathering,
            ..
        } = self;
        let Some(begin) = files.first else { return Ok(()) };
        for minute in gathering.rest() {
            minutes.take(minute.named(&names), &mut files)?;
        }
        warnings.finish(&mut files)?;
        incidents.finish(&mut files)?;
        notices.finish(&mut files)?;
        dwells.finish(&mut files)?;
        minutes.finish(&mut files)?;
        let trends = summary.stops.lines().into_iter().map(|line| StopTrendRow { begin, line });
        DayRows::of(trends, &mut files)?;
        DayRows::of(CylinderRow::all(summary, begin), &mut files)?;
        let facts = SummaryFacts { begin, recordings, false_alarms_per_year };
        DayRows::of([SummaryRow::new(summary, facts)], &mut files)?;
        files.place()
    }
}

impl<R: TableRow> DayRows<R> {
    /// Writes `rows`, which are all of their table.
    fn of(rows: impl IntoIterator<Item = R>, files: &mut ColumnFiles) -> Result<(), Failure> {
        let mut table = Self::default();
        for row in rows {
            table.take(row, files)?;
        }
        table.finish(files)
    }

    fn take(&mut self, row: R, files: &mut ColumnFiles) -> Result<(), Failure> {
        let day = columns::day(row.at());
        if day != self.day || self.rows.len() == MOST_ROWS {
            self.write(files)?;
            self.day = day;
        }
        self.rows.push(row);
        Ok(())
    }

    /// Writes the rows that are kept, if there are any.
    fn write(&mut self, files: &mut ColumnFiles) -> Result<(), Failure> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let part = self.parts.entry(self.day.clone()).or_default();
        *part += 1;
        files.write(&self.day, *part, &self.rows)?;
        self.rows.clear();
        Ok(())
    }

    /// Writes the rows that are kept; or a file without rows, if there were none: a table without any file cannot
    /// be read, and that nothing was found is a result.
    fn finish(mut self, files: &mut ColumnFiles) -> Result<(), Failure> {
        if self.rows.is_empty() && self.parts.is_empty() {
            let day = columns::day(files.first.unwrap_or_default());
            return files.write::<R>(&day, 1, &[]);
        }
        self.write(files)
    }
}

impl ColumnFiles {
    /// The name of a file of this recording, of those of a day the `part`-th.
    fn name(&self, part: u32) -> String {
        let name = columns::file_name(self.first.unwrap_or_default());
        if part == 1 { format!("{name}.parquet") } else { format!("{name}-{part}.parquet") }
    }

    /// Writes `rows` beside their place.
    fn write<R: TableRow>(&mut self, day: &str, part: u32, rows: &[R]) -> Result<(), Failure> {
        let folder = self.folder.join(columns::partition(R::TABLE, &self.machine, day));
        make(&folder)?;
        let path = folder.join(self.name(part));
        let fail = |error: io::Error| Failure::writing_file(&path.display().to_string(), &error);
        let bytes =
            columns::encode(rows, &self.machine).map_err(|error| fail(io::Error::other(error)))?;
        let [claimed] = self.inputs.claim([(Some(&path), Mark::Columns)], self.overwriting)?;
        if let Some(claimed) = claimed {
            let mut writer = claimed.open()?;
            writer.put(&bytes)?;
            let settled = writer.settle().map_err(fail)?;
            self.written.push((path, settled));
        }
        Ok(())
    }

    /// Puts all files in their places, in the order in which they were written.
    fn place(mut self) -> Result<(), Failure> {
        let mut places = Vec::new();
        for (path, settled) in std::mem::take(&mut self.written) {
            settled
                .place()
                .map_err(|error| Failure::writing_file(&path.display().to_string(), &error))?;
            places.push(path);
        }
        for table in TABLES {
            self.tidy(&self.folder.join(columns::machine_folder(table, &self.machine)), &places);
        }
        Ok(())
    }

    /// Deletes what an earlier replay of the recording has left below `folder` beside the `places` of now: it found
    /// something on another day, or more of it.
    fn tidy(&self, folder: &Path, places: &[PathBuf]) {
        let Ok(days) = fs::read_dir(folder) else { return };
        for day in days.flatten() {
            for part in 1.. {
                let path = day.path().join(self.name(part));
                if places.contains(&path) {
                    continue;
                }
                if !Mark::Columns.is_on(&path).unwrap_or_default() {
                    break;
                }
                // What stays is a row too many for the next reader, and no reason to fail now.
                if fs::remove_file(&path).is_err() {
                    tell!("{} is of an earlier replay, and cannot be deleted", path.display());
                }
            }
        }
    }
}

fn make(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder).map_err(|error| Failure::creating(folder, &error))
}
