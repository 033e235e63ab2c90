//! Reads recordings twice for a proposal.

use crate::bus::{Interfaces, Options, Recording, Source, Statistics};
use crate::cli::progress::Bar;
use crate::dbc::Database;
use crate::failure::Failure;
use crate::frame::{Frame, Kind};
use crate::propose::{self, BusTally, Catalogue, Finder, Proposal};
use crate::time::Timestamp;
use std::path::{Path, PathBuf};

/// Number of frames between two updates of the progress bar.
const STRIDE: u64 = 1 << 16;

/// What was read, and what is proposed.
#[derive(Debug)]
pub struct Read {
    pub proposal: Proposal,
    /// Interface of the recordings.
    pub interface: Option<String>,
    /// Recordings and how much of them was read, in words; empty without any.
    pub told: String,
}

/// The proposal from the first `seconds` of the recordings, or from names alone where there are none.
///
/// # Errors
/// A recording that cannot be read, or without a frame of the DBC.
pub fn read(
    database: &Database,
    logs: &[PathBuf],
    options: &Options,
    seconds: f64,
) -> Result<Read, Failure> {
    let catalogue = Catalogue::new(database);
    let mut tally = BusTally::new(&catalogue);
    if logs.is_empty() {
        let proposal = propose::find(&catalogue, &tally, None);
        return Ok(Read { proposal, interface: None, told: String::new() });
    }
    if logs.iter().any(|log| log.as_os_str() == "-") {
        return Err(Failure::Wrong(
            "-: the recording is read twice, which is impossible with standard input; name a file"
                .to_owned(),
        ));
    }
    let mut frames = 0;
    let (interface, statistics) = pass(logs, options, seconds, |t, frame| {
        frames += 1;
        tally.take(&catalogue, t, frame);
    })?;
    if frames == 0 {
        return Err(nothing(&statistics, options));
    }
    if !tally.is_known() {
        return Err(Failure::Failed(format!(
            "none of the {frames} frames read is of a message in the DBC; is it the DBC of this bus?"
        )));
    }
    let mut finder = Finder::new(&catalogue, &tally);
    pass(logs, options, seconds, |t, frame| finder.take(&catalogue, t, frame))?;
    let names: Vec<String> = logs.iter().map(|log| log.display().to_string()).collect();
    let length = tally.length();
    let part = if length + 1.0 >= seconds { ", the first of them" } else { "" };
    let told = format!("{length:.0} s of {}{part}", names.join(", "));
    Ok(Read { proposal: propose::find(&catalogue, &tally, Some(&finder)), interface, told })
}

/// Why recordings have no data frame.
fn nothing(statistics: &Statistics, options: &Options) -> Failure {
    let Statistics { frames, damage, barren, other_interface_frames, .. } = statistics;
    let mut reasons = Vec::new();
    if *frames > 0 && other_interface_frames == frames {
        let found = statistics.interfaces_found();
        reasons.push(format!("no frame is from {}; the recording has {found}", options.interfaces));
    } else if *frames > 0 {
        reasons.push(match frames {
            1 => "its only frame is not a data frame".to_owned(),
            _ => format!("none of its {frames} frames is a data frame"),
        });
    }
    reasons.extend(damage.iter().map(ToString::to_string));
    reasons.extend(barren.iter().map(ToString::to_string));
    Failure::Failed(format!(
        "nothing was read: {}; expected a recording of the machine in motion",
        reasons.join("; ")
    ))
}

/// Passes the data frames of the first `seconds` to `take`, with their time since the first one, s. Returns the
/// interface that was read, if it is one that a configuration may have, and the statistics of what was read.
fn pass<P: AsRef<Path>>(
    logs: &[P],
    options: &Options,
    seconds: f64,
    mut take: impl FnMut(f64, &Frame),
) -> Result<(Option<String>, Statistics), Failure> {
    let mut recording = Recording::open(logs, options.clone())?;
    let bar = Bar::new(recording.progress());
    let mut first: Option<Timestamp> = None;
    let mut frames = 0_u64;
    while let Some(frame) = recording.next_frame()? {
        let t = frame.timestamp.since(*first.get_or_insert(frame.timestamp)).as_seconds();
        if t > seconds {
            break;
        }
        if t >= 0.0 && matches!(frame.kind, Kind::Data | Kind::Fd { .. }) {
            take(t, frame);
        }
        frames += 1;
        if frames.is_multiple_of(STRIDE) {
            bar.show(recording.progress());
        }
    }
    bar.finish();
    let statistics = recording.statistics().clone();
    let interface = match (&options.interfaces, statistics.interfaces.as_slice()) {
        // By its name in full, which a number is not.
        (asked @ Interfaces::Only(_), all) => all.iter().find(|it| asked.mean(it.name.as_bytes())),
        (_, [only]) => Some(only),
        _ => None,
    };
    let interface = interface.map(|it| it.name.clone()).filter(|name| !name.is_empty());
    Ok((interface, statistics))
}
