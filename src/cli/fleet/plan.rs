//! The jobs of a fleet.

use super::recordings::{TimedRecording, files, timed};
use super::roster::{Roster, RosterEntry, is_url};
use crate::cli::history;
use crate::cli::machine::Machine;
use crate::config::Overrides;
use crate::failure::Failure;
use crate::time::Span;
use std::path::PathBuf;

/// By how much a recording may begin before the end of the one before, as `replay --state` allows: frames may be out
/// of order.
const OUT_OF_ORDER: Span = Span::from_nanos(1_000_000_000);

/// A fleet, in the order of its file.
#[derive(Debug)]
pub struct FleetPlan {
    pub machines: Vec<MachinePlan>,
}

/// A machine and its recordings in order.
#[derive(Debug)]
pub struct MachinePlan {
    pub name: String,
    pub config: PathBuf,
    /// Identity of the configuration.
    pub configuration: String,
    pub interface: Option<String>,
    pub history: Option<PathBuf>,
    pub inputs: Vec<PlannedInput>,
}

/// A recording of a machine.
#[derive(Debug)]
pub enum PlannedInput {
    File(TimedRecording),
    /// Somewhere else; whoever runs the plan gets it.
    Url(String),
}

impl FleetPlan {
    /// The plan of a fleet. To the end of each recording is looked unless it has to be `quick`.
    ///
    /// # Errors
    /// A configuration is missing or wrong; recordings are missing, without frames, or overlap.
    pub fn new(roster: &Roster, quick: bool) -> Result<Self, Failure> {
        let plan = |entry| MachinePlan::new(entry, quick);
        Ok(Self { machines: roster.machines.iter().map(plan).collect::<Result<_, _>>()? })
    }
}

impl MachinePlan {
    fn new(entry: &RosterEntry, quick: bool) -> Result<Self, Failure> {
        let wrong = |why: String| Failure::Wrong(format!("machine {:?}: {why}", entry.name));
        if !entry.config.is_file() {
            return Err(wrong(format!(
                "its configuration is missing: there is no file {}",
                entry.config.display()
            )));
        }
        let machine = Machine::load(&entry.config, &Overrides::default())?;
        if let Some(lack) = history::lack(&machine).filter(|_| entry.history.is_some()) {
            return Err(wrong(format!("`history` cannot be used here: {lack}")));
        }
        let interfaces =
            machine.interfaces(entry.interface.as_deref()).map_err(|failure| match failure {
                Failure::Wrong(why) => wrong(why),
                other => other,
            })?;
        let urls = entry.recordings.iter().filter(|it| is_url(it)).count();
        let inputs = match urls {
            _ if entry.recordings.is_empty() => {
                return Err(wrong("it has no recordings".to_owned()));
            }
            0 => {
                let paths = files(&entry.recordings).map_err(wrong)?;
                let known = paths.into_iter().map(|path| timed(path, &interfaces, quick));
                let mut known = known.collect::<Result<Vec<_>, _>>()?;
                known.sort_by(|a, b| (a.begin, &a.path).cmp(&(b.begin, &b.path)));
                let is_several = machine.loaded.settings.bus.is_several();
                refuse_overlaps(&known, is_several).map_err(wrong)?;
                known.into_iter().map(PlannedInput::File).collect()
            }
            all if all == entry.recordings.len() => {
                entry.recordings.iter().cloned().map(PlannedInput::Url).collect()
            }
            _ => {
                return Err(wrong(
                    "some of its recordings are URLs, whose order is that in which they are named, and some are \
                     files, which are sorted by time; name either the ones or the others"
                        .to_owned(),
                ));
            }
        };
        Ok(Self {
            name: entry.name.clone(),
            config: entry.config.clone(),
            configuration: machine.loaded.fingerprints().configuration.to_string(),
            interface: entry.interface.clone(),
            history: entry.history.clone(),
            inputs,
        })
    }
}

/// Refuses recordings, in the order of time, one of which begins before the one before has ended; of a machine with
/// several buses, they may be those of one bus each.
fn refuse_overlaps(known: &[TimedRecording], is_several: bool) -> Result<(), String> {
    let remedy = if is_several {
        "; a recording has to have all buses of the machine: record them to one file, or leave one of them out"
    } else {
        ": leave one of them out"
    };
    for pair in known.windows(2) {
        let [earlier, later] = [&pair[0], &pair[1]];
        let end = earlier.end.unwrap_or(earlier.begin);
        // Of a recording of which only the begin is known, a second one that begins alike is refused.
        let is_same = earlier.begin == later.begin;
        if is_same || end.since(later.begin) > OUT_OF_ORDER {
            return Err(format!(
                "its recordings overlap: {} begins at {}, and {}, which begins at {}, ends at {end}; each frame of \
                 the machine has to be there once{remedy}",
                later.path.display(),
                later.begin,
                earlier.path.display(),
                earlier.begin,
            ));
        }
    }
    Ok(())
}
