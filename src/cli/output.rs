//! Where a replay writes what the monitor gives.

use super::Failure;
use crate::alarm::{OwnFrame, Warning};
use crate::bus::LogWriter;
use crate::estimate::Estimate;
use crate::monitor::{Notice, Record, Sink};
use crate::report::human::Notices;
use crate::report::page::Recorder;
use crate::report::{Episodes, EstimateTable, ResidualTable, jsonl};
use crate::time::Timestamp;
use std::fs::File;
use std::io::{self, BufWriter, Stdout, Write};
use std::path::Path;

type OutFile = BufWriter<File>;

/// The outputs of a replay. The first error of any ends the writing; [`Output::close`] tells it.
pub struct Output {
    /// The time stamp of the recording's first frame.
    pub first: Timestamp,
    pub episodes: Episodes,
    pub notices: Notices,
    /// Gathers figures, where a page of them is asked for.
    pub recorder: Option<Recorder>,
    lines: Option<BufWriter<Stdout>>,
    residuals: Option<ResidualTable<OutFile>>,
    estimates: Option<EstimateTable<OutFile>>,
    frames: Option<LogWriter<OutFile>>,
    failure: Option<Failure>,
}

impl Output {
    /// Outputs as asked for: lines of JSON on standard output, tables of residuals and of estimates, a
    /// log of the frames sent (on `interface`).
    ///
    /// # Errors
    /// If a file cannot be created.
    pub fn create(
        lines: bool,
        residuals: Option<&Path>,
        estimates: Option<&Path>,
        frames: Option<&Path>,
        interface: &str,
    ) -> Result<Self, Failure> {
        let residuals = residuals
            .map(|path| {
                let table = create(path)?;
                ResidualTable::new(table).map_err(|error| Failure::creating(path, &error))
            })
            .transpose()?;
        let estimates = estimates
            .map(|path| {
                let table = create(path)?;
                EstimateTable::new(table).map_err(|error| Failure::creating(path, &error))
            })
            .transpose()?;
        let frames = frames.map(create).transpose()?.map(|file| LogWriter::new(file, interface));
        Ok(Self {
            first: Timestamp::default(),
            episodes: Episodes::default(),
            notices: Notices::default(),
            recorder: None,
            lines: lines.then(|| BufWriter::new(io::stdout())),
            residuals,
            estimates,
            frames,
            failure: None,
        })
    }

    /// Whether writing failed, so that there is no use in going on.
    pub const fn failed(&self) -> bool {
        self.failure.is_some()
    }

    /// The lines of JSON, to end them with a summary.
    pub fn lines(&mut self) -> Option<&mut impl Write> {
        self.lines.as_mut()
    }

    /// Writes out what is buffered.
    ///
    /// # Errors
    /// The first that occurred.
    pub fn close(mut self) -> Result<(), Failure> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        if let Some(lines) = &mut self.lines {
            lines.flush().map_err(|error| Failure::writing("standard output", &error))?;
        }
        if let Some(table) = self.residuals {
            table.finish().map_err(|error| Failure::writing("the table of residuals", &error))?;
        }
        if let Some(table) = self.estimates {
            table.finish().map_err(|error| Failure::writing("the table of estimates", &error))?;
        }
        if let Some(frames) = &mut self.frames {
            frames.flush().map_err(|error| Failure::writing("the log of warnings", &error))?;
        }
        Ok(())
    }

    fn note(&mut self, what: &str, result: io::Result<()>) {
        if let Err(error) = result {
            self.failure.get_or_insert_with(|| Failure::writing(what, &error));
        }
    }
}

fn create(path: &Path) -> Result<OutFile, Failure> {
    let file = File::create(path).map_err(|error| Failure::creating(path, &error))?;
    Ok(BufWriter::with_capacity(1 << 16, file))
}

impl Sink for Output {
    fn record(&mut self, record: &Record) {
        if let Some(recorder) = &mut self.recorder {
            recorder.record(self.first, record);
        }
        if let Some(table) = &mut self.residuals {
            let result = table.write(self.first, record);
            self.note("the table of residuals", result);
        }
    }

    fn warning(&mut self, warning: &Warning) {
        self.episodes.take(warning);
        if let Some(recorder) = &mut self.recorder {
            recorder.warning(self.first, warning);
        }
        if let Some(lines) = &mut self.lines {
            let result = jsonl::warning(lines, self.first, warning);
            self.note("standard output", result);
        }
    }

    fn estimate(&mut self, at: Timestamp, cylinder: u8, estimate: Option<&Estimate>) {
        if let Some(table) = &mut self.estimates {
            let result = table.write(self.first, at, cylinder, estimate);
            self.note("the table of estimates", result);
        }
    }

    fn transmit(&mut self, frame: &OwnFrame) {
        if let Some(frames) = &mut self.frames {
            let result = frames.write(frame.as_frame());
            self.note("the log of warnings", result);
        }
    }

    fn notice(&mut self, notice: &Notice) {
        self.notices.take(notice);
        if let Some(recorder) = &mut self.recorder {
            recorder.notice(self.first, notice);
        }
        if let Some(lines) = &mut self.lines {
            let result = jsonl::notice(lines, self.first, notice);
            self.note("standard output", result);
        }
    }
}
