//! The state of the monitor that a replay takes up, and leaves for the next one.

use super::Failure;
use super::files::Claimed;
use crate::config::MACHINE_FILE;
use crate::monitor::{DesignChecksum, MAX_STATE, Monitor, MonitorDesign, SavedState, StateRefusal};
use crate::time::{Span, Timestamp};
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// First line of a state, by which its file is recognised.
pub const MARK: &str = "tertius state\n";

/// How long before the end of what the state has seen a recording may begin: frames may be out of order.
const OUT_OF_ORDER: Span = Span::from_nanos(1_000_000_000);

/// The file of a state.
#[derive(Debug)]
pub struct StateFile {
    path: PathBuf,
    claimed: Claimed,
    design: DesignChecksum,
    /// Time stamp of the first frame of all.
    begin: Option<Timestamp>,
    /// Whether a recording has begun since.
    is_older: bool,
}

impl StateFile {
    /// The file `path`, which is `claimed`, for a monitor of `design`; and the monitor that goes on from it, and counts
    /// anew, if it exists.
    ///
    /// # Errors
    /// See [`take_up`].
    pub fn open(
        path: &Path,
        claimed: Claimed,
        design: &MonitorDesign,
    ) -> Result<(Self, Option<Monitor>), Failure> {
        let (begin, mut monitor) = take_up(path, design)?.unzip();
        if let Some(monitor) = &mut monitor {
            monitor.count_anew();
        }
        let (path, design) = (path.to_owned(), design.checksum());
        Ok((Self { path, claimed, design, begin, is_older: false }, monitor))
    }

    /// Time stamp of the first frame of all, from which the seconds of outputs count, where a recording begins at
    /// `first`; `newest` is the monitor's newest.
    ///
    /// # Errors
    /// The state has seen later frames.
    pub fn begin(
        &mut self,
        first: Timestamp,
        newest: Option<Timestamp>,
    ) -> Result<Timestamp, Failure> {
        match newest.filter(|newest| newest.since(first) > OUT_OF_ORDER) {
            Some(newest) => Err(Failure::Wrong(format!(
                "the recording begins at {first}, but the state in {} has seen frames up to {newest}; replay \
                 recordings in the order of time, each of them once, or name another file to begin anew",
                self.path.display()
            ))),
            None => {
                self.is_older = true;
                Ok(*self.begin.get_or_insert(first))
            }
        }
    }

    /// Leaves the state of `monitor` in the file, if there was a frame.
    ///
    /// # Errors
    /// The file cannot be written; the previous one then remains.
    pub fn write(self, monitor: &Monitor) -> Result<(), Failure> {
        let Some(begin) = self.begin.filter(|_| self.is_older) else { return Ok(()) };
        let mut writer = self.claimed.open()?;
        writer.put(&SavedState::of(monitor, self.design, begin).to_bytes())?;
        writer.close()
    }
}

/// The monitor of `design` that goes on from the state in `path`, after the time stamp of the first frame of all; `None`
/// if there is no such file.
///
/// # Errors
/// The file cannot be read, or is not the state of such a monitor.
pub fn take_up(
    path: &Path,
    design: &MonitorDesign,
) -> Result<Option<(Timestamp, Monitor)>, Failure> {
    const ANEW: &str = "name another file, or move this one away to begin anew";
    const SAME: &str = "replay with the same ones, or name another file to begin anew";
    let refuse = |why: String, advice: &str| {
        let path = path.display();
        Failure::Wrong(format!("{path}: {why}. Nothing was changed; {advice}"))
    };
    let bytes = read(path).map_err(|it| refuse(format!("it cannot be read: {it}"), ANEW))?;
    let resumed = bytes.map(|bytes| {
        let saved = SavedState::from_bytes(&bytes)?;
        Ok((saved.begin(), saved.resume(design.clone())?))
    });
    resumed.transpose().map_err(|refusal: StateRefusal| {
        let advice = if refusal == StateRefusal::Design { SAME } else { ANEW };
        refuse(refusal.to_string(), advice)
    })
}

/// A monitor of `design` that goes on from the state which was recorded in the file `path`, and counts anew.
///
/// # Errors
/// The file cannot be read, or is not the state of such a monitor.
pub fn recorded(path: &Path, design: MonitorDesign) -> Result<Monitor, Failure> {
    let refuse = |why: String| {
        let path = path.display();
        Failure::Wrong(format!(
            "{path}: {why}. To replay the recording without what the monitor knew at its begin, give its \
             configuration: --config FOLDER/{MACHINE_FILE}"
        ))
    };
    let bytes = read(path).map_err(|it| refuse(format!("it cannot be read: {it}")))?;
    let saved = SavedState::from_bytes(&bytes.unwrap_or_default());
    let resumed = saved.and_then(|saved| saved.resume(design));
    let mut monitor = resumed.map_err(|refusal| refuse(refusal.to_string()))?;
    monitor.count_anew();
    Ok(monitor)
}

/// The bytes of a file, at most one more than a state has; `None` if there is no such file.
fn read(path: &Path) -> io::Result<Option<Vec<u8>>> {
    let file = match File::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        file => file?,
    };
    let mut bytes = Vec::new();
    file.take(MAX_STATE as u64 + 1).read_to_end(&mut bytes)?;
    Ok(Some(bytes))
}
