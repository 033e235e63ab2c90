//! Outputs of a replay.

use super::Failure;
use super::behind::{Behind, Table};
use super::columns::ColumnFolder;
use super::files::{Claimed, Writer};
use crate::alarm::{OwnFrame, Warning};
use crate::bus::LogWriter;
use crate::config::{MachineNames, Settings};
use crate::estimate::Estimate;
use crate::incident::Incident;
use crate::monitor::{Explained, Notice, Record, Sink};
use crate::report::human::Notices;
use crate::report::page::PageRecorder;
use crate::report::stamps::Wraps;
use crate::report::{
    Episodes, EstimateRow, EstimateTable, Incidents, ResidualRow, ResidualTable, jsonl,
};
use crate::sequential::Dwell;
use crate::time::{Span, Timestamp};
use std::io::{self, BufWriter, Stdout, Write};

const RESIDUALS: &str = "the table of residuals";
const ESTIMATES: &str = "the table of estimates";
const FRAMES: &str = "the log of warnings";

/// Name of the destination of JSON lines.
const LINES: &str = "standard output";

/// The outputs of a replay. The first error of any of them ends the writing, and [`Output::close`]
/// returns it.
pub struct Output {
    /// The time stamp of the recording's first frame.
    pub first: Timestamp,
    /// The time stamp from which the seconds of lines and tables count: of the first frame of all, where a state
    /// was taken up.
    pub begin: Timestamp,
    /// Sum of the jumps of the time stamps, s.
    pub jumped: f64,
    /// Those of them that a counter of time stamps made that began again.
    pub wraps: Wraps,
    pub episodes: Episodes,
    pub incidents: Incidents,
    pub notices: Notices,
    /// Recorder for the page's figures, if a page is requested.
    pub recorder: Option<PageRecorder>,
    /// The tables as Parquet files, if they are requested.
    pub columns: Option<ColumnFolder>,
    /// The time at which the findings are to be explained, if any.
    pub explaining: Option<Explaining>,
    /// How cylinders and transducers are called.
    names: MachineNames,
    lines: Option<BufWriter<Stdout>>,
    residuals: Option<Behind<ResidualTable<Writer>>>,
    estimates: Option<Behind<EstimateTable<Writer>>>,
    frames: Option<LogWriter<Writer>>,
    failure: Option<Failure>,
}

/// A time at which the findings are to be explained.
#[derive(Debug)]
pub struct Explaining {
    /// Since the first frame.
    pub at: Span,
    /// The findings then; `None` before that time.
    pub explained: Option<Explained>,
}

impl Output {
    /// The requested outputs: lines of JSON on standard output, tables of residuals and of
    /// estimates, a log of the frames sent (on the bus of `settings`). With more than one of `threads` the tables are written
    /// behind, each by a thread of its own.
    ///
    /// # Errors
    /// A pipe or a device that cannot be opened; a file that cannot be written.
    pub fn create(
        lines: bool,
        [residuals, estimates, frames]: [Option<Claimed>; 3],
        settings: &Settings,
        threads: usize,
    ) -> Result<Self, Failure> {
        let names = settings.names();
        let of_residuals = |file| ResidualTable::new(file, &names);
        let residuals = table(RESIDUALS, residuals, threads, of_residuals)?;
        let of_estimates = |file| EstimateTable::new(file, &names);
        let estimates = table(ESTIMATES, estimates, threads, of_estimates)?;
        let frames = frames
            .map(Claimed::open)
            .transpose()?
            .map(|file| LogWriter::new(file, &settings.bus.interface));
        Ok(Self {
            first: Timestamp::default(),
            begin: Timestamp::default(),
            jumped: 0.0,
            wraps: Wraps::default(),
            episodes: Episodes::default(),
            incidents: Incidents::default(),
            notices: Notices::default(),
            recorder: None,
            columns: None,
            explaining: None,
            names,
            lines: lines.then(|| BufWriter::new(io::stdout())),
            residuals,
            estimates,
            frames,
            failure: None,
        })
    }

    /// Whether writing failed, so that continuing is useless.
    pub const fn failed(&self) -> bool {
        self.failure.is_some()
    }

    /// The lines of JSON, to which a summary is added at the end.
    pub fn lines(&mut self) -> Option<&mut impl Write> {
        self.lines.as_mut()
    }

    /// Waits until the tables have all rows so far.
    pub fn catch_up(&mut self) {
        let written = self.residuals.as_mut().map_or(Ok(()), Behind::catch_up);
        self.note(RESIDUALS, written);
        let written = self.estimates.as_mut().map_or(Ok(()), Behind::catch_up);
        self.note(ESTIMATES, written);
    }

    /// Flushes the outputs.
    ///
    /// # Errors
    /// The first error that occurred.
    pub fn close(mut self) -> Result<(), Failure> {
        self.catch_up();
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some(lines) = &mut self.lines {
            lines.flush().map_err(|error| Failure::writing(LINES, &error))?;
        }
        let residuals = self.residuals.and_then(Behind::into_inner);
        let residuals = residuals.map(|table| (RESIDUALS, table.into_inner()));
        let estimates = self.estimates.and_then(Behind::into_inner);
        let estimates = estimates.map(|table| (ESTIMATES, table.into_inner()));
        let frames = self.frames.map(|frames| (FRAMES, frames.into_inner()));
        for (what, writer) in [residuals, estimates, frames].into_iter().flatten() {
            writer.finish().map_err(|error| Failure::writing_file(what, &error))?;
        }
        Ok(())
    }

    fn note(&mut self, what: &str, result: io::Result<()>) {
        if let Err(error) = result {
            let of = if what == LINES { Failure::writing } else { Failure::writing_file };
            self.failure.get_or_insert_with(|| of(what, &error));
        }
    }

    /// Passes what is told on to the tables, if they are requested.
    fn tabulate(&mut self, take: impl FnOnce(&mut ColumnFolder) -> Result<(), Failure>) {
        if let Some(Err(failure)) = self.columns.as_mut().map(take) {
            self.failure.get_or_insert(failure);
        }
    }
}

/// Opens `file` for the table `what`, if it is requested.
fn table<T: Table>(
    what: &str,
    file: Option<Claimed>,
    threads: usize,
    begin: impl FnOnce(Writer) -> io::Result<T>,
) -> Result<Option<Behind<T>>, Failure> {
    let Some(file) = file else { return Ok(None) };
    let table = begin(file.open()?).map_err(|error| Failure::writing(what, &error))?;
    Ok(Some(Behind::new(table, threads)))
}

impl Table for ResidualTable<Writer> {
    type Row = ResidualRow;

    fn write(&mut self, row: &ResidualRow) -> io::Result<()> {
        Self::write(self, row)
    }
}

impl Table for EstimateTable<Writer> {
    type Row = EstimateRow;

    fn write(&mut self, row: &EstimateRow) -> io::Result<()> {
        Self::write(self, row)
    }
}

impl Sink for Output {
    fn wants_records(&self) -> bool {
        self.recorder.is_some() || self.residuals.is_some() || self.columns.is_some()
    }

    fn record(&mut self, record: &Record) {
        if let Some(recorder) = &mut self.recorder {
            recorder.record(self.first, record);
        }
        if let Some(table) = &mut self.residuals {
            let result = table.write(ResidualRow::new(self.begin, record));
            self.note(RESIDUALS, result);
        }
        self.tabulate(|columns| columns.record(record));
    }

    fn warning(&mut self, warning: &Warning) {
        self.episodes.take(warning);
        if let Some(recorder) = &mut self.recorder {
            recorder.warning(self.first, warning);
        }
        if let Some(lines) = &mut self.lines {
            let result = jsonl::warning(lines, self.begin, warning, &self.names);
            self.note(LINES, result);
        }
        self.tabulate(|columns| columns.warning(warning));
    }

    fn incident(&mut self, incident: &Incident) {
        self.incidents.take(incident);
        if let Some(lines) = &mut self.lines {
            let result = jsonl::incident(lines, self.begin, incident, &self.names);
            self.note(LINES, result);
        }
        self.tabulate(|columns| columns.incident(incident));
    }

    fn dwell(&mut self, cylinder: u8, dwell: &Dwell) {
        self.tabulate(|columns| columns.dwell(cylinder, dwell));
    }

    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        if let Some(table) = &mut self.estimates {
            let result = table.write(EstimateRow::new(self.begin, at, cylinder, estimate));
            self.note(ESTIMATES, result);
        }
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        if let Some(frames) = &mut self.frames {
            let result = frames.write(frame.as_frame());
            self.note(FRAMES, result);
        }
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.take(notice);
        if let Notice::TimeJump { by, .. } = notice {
            self.jumped += by.as_seconds();
            self.wraps.take(*by);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.notice(self.first, notice);
        }
        if let Some(lines) = &mut self.lines {
            let result = jsonl::notice(lines, self.begin, notice, &self.names);
            self.note(LINES, result);
        }
        self.tabulate(|columns| columns.notice(notice));
    }
}
