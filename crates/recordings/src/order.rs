//! Checks whether recordings are named in the order of time.

use std::path::PathBuf;

use tertius_core::frame::{BusNumber, Frame};
use tertius_core::time::{Span, Timestamp};

use super::format::{End, Item, TimeStamps, Unread, blank_frame};
use super::formats;
use super::input::{Input, InputPlace};
use super::selection::Interfaces;
use super::source::SourceError;

/// Number of bytes of a recording that are looked at at a time.
const PEEK: usize = 64 * 1024;

/// Number of bytes of a recording in which its first frame is sought, unless it is read as a whole: some containers of a
/// BLF, none of whose objects is there before the container's end.
const LOOK: usize = 4 * PEEK;

/// Number of bytes of a recording in which the buses are sought that it has: in text two seconds of a full bus of
/// 1 Mbit/s, or half a minute of a machine.
const LOOK_FOR_BUSES: usize = 16 * PEEK;

/// Most frames of a recording that is read as a whole, among which its first one of an interface is sought.
const FRAMES: usize = 4096;

/// Most recordings whose right order is listed in full.
const LISTED: usize = 16;

/// Refuses recordings one of which begins before one that is named ahead of it, by more than frames of several buses may
/// be out of order. Only files are examined, and time stamps with an origin of their own are ignored.
///
/// # Errors
/// The two recordings, and the right order.
pub fn check(places: &[&InputPlace], interfaces: &Interfaces) -> Result<(), SourceError> {
    if places.len() < 2 {
        return Ok(());
    }
    let begins = |place: &&InputPlace| Some((place.name(), beginning(place, interfaces)?));
    let mut known: Vec<(String, Timestamp)> = places.iter().filter_map(begins).collect();
    // A recording of several buses may be cut within what is out of order.
    let disorder = match interfaces {
        Interfaces::Several(several) => several.disorder,
        _ => Span::ZERO,
    };
    let is_wrong = |pair: &[(String, Timestamp)]| pair[0].1.since(pair[1].1) > disorder;
    let Some(wrong) = known.windows(2).position(is_wrong) else {
        return Ok(());
    };
    let [ahead, later] = [wrong, wrong + 1].map(|place| known[place].clone());
    known.sort_by_key(|(_, begin)| *begin);
    let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
    let advice = if names.len() <= LISTED {
        format!("name them in the order of time: {}", names.join(" "))
    } else {
        "name them in the order of time".to_owned()
    };
    Err(SourceError::Order { ahead: ahead.0, at: ahead.1, later: later.0, before: later.1, advice })
}

/// Where each of `paths` begins that is named after another one: its name and its first frame's time stamp, if that has
/// no origin of its own.
pub fn later(paths: &[PathBuf], interfaces: &Interfaces) -> Vec<(String, Timestamp)> {
    let places = paths.iter().skip(1).map(|path| InputPlace::of(path));
    let begins = |place: InputPlace| Some((place.name(), beginning(&place, interfaces)?));
    places.filter_map(begins).collect()
}

/// `paths` in the order in which they begin, by their time stamps; unchanged where one of them has
/// none. Files that cannot be opened are reported when they are read.
pub fn sorted(paths: &[PathBuf], interfaces: &Interfaces) -> Vec<PathBuf> {
    let begins =
        |path: &PathBuf| Some((beginning(&InputPlace::of(path), interfaces)?, path.clone()));
    match paths.iter().map(begins).collect::<Option<Vec<_>>>() {
        Some(mut known) => {
            known.sort_by_key(|(begin, _)| *begin);
            known.into_iter().map(|(_, path)| path).collect()
        }
        None => paths.to_vec(),
    }
}

/// Time stamp of the first frame of a file, of the interface that is meant if it comes soon.
fn beginning(place: &InputPlace, interfaces: &Interfaces) -> Option<Timestamp> {
    let mut first = None;
    let found = first_frames(place, LOOK, |frame, interface, absolute| {
        first = first.or(absolute.then_some(frame.timestamp));
        (absolute && interfaces.mean(interface)).then_some(frame.timestamp)
    });
    // Of another interface, which is read where the one that is meant is nowhere.
    found.or(first.filter(|_| matches!(interfaces, Interfaces::One(_))))
}

/// The buses that the beginning of a file has frames of, at most `several`; none where it is not a file. All of the
/// beginning is looked at, up to [`LOOK_FOR_BUSES`], unless it has all of them.
pub fn first_buses(place: &InputPlace, interfaces: &Interfaces, several: usize) -> Vec<BusNumber> {
    let mut buses = Vec::new();
    first_frames(place, LOOK_FOR_BUSES, |_, interface, _| {
        let bus = interfaces.bus(interface).filter(|bus| !buses.contains(bus));
        buses.extend(bus);
        (buses.len() >= several).then_some(())
    });
    buses
}

/// Passes the first frames of a file, those in `look` of its bytes, to `find`, with their interface and whether their
/// time stamp is absolute, until it finds something.
fn first_frames<T>(
    place: &InputPlace,
    look: usize,
    mut find: impl FnMut(&Frame, &[u8], bool) -> Option<T>,
) -> Option<T> {
    let InputPlace::File(path) = place else { return None };
    // Opening and closing a pipe would end its writer.
    let is_file = path.metadata().ok()?.is_file();
    let mut input = is_file.then(|| InputPlace::File(path.to_owned()).open().ok())??;
    let (mut bytes, mut end) = (Vec::new(), End::Open);
    fill(&mut input, &mut bytes, &mut end);
    let format = formats::recognise(&bytes, true)?;
    let mut reader = (format.reader)(TimeStamps::Absolute);
    let (mut frame, mut used, mut frames) = (blank_frame(), 0, 0);
    let mut looked = bytes.len();
    while frames < FRAMES || !format.is_whole {
        let rest = &bytes[used..];
        used += match reader.read(Unread { bytes: rest, end }, &mut frame) {
            Item::Frame { taken, interface, absolute } => {
                let found = find(&frame, interface, absolute);
                if found.is_some() {
                    return found;
                }
                frames += 1;
                taken
            }
            Item::Nothing { taken } | Item::Bad { taken, .. } => taken,
            Item::BadAt { .. } => 0,
            Item::LongLine => memchr::memchr(b'\n', rest).map_or(rest.len(), |line| line + 1),
            Item::More if end == End::Open && used > 0 && (format.is_whole || looked < look) => {
                bytes.drain(..used);
                let left = bytes.len();
                used = 0;
                fill(&mut input, &mut bytes, &mut end);
                looked += bytes.len() - left;
                0
            }
            Item::More => return None,
        };
    }
    None
}

/// Reads on until [`PEEK`] bytes are there, or the end.
fn fill(input: &mut Input, bytes: &mut Vec<u8>, end: &mut End) {
    let mut length = bytes.len();
    bytes.resize(PEEK.max(length), 0);
    while length < PEEK {
        match input.read(&mut bytes[length..]) {
            Ok(0) => {
                *end = End::Whole;
                break;
            }
            Ok(more) => length += more,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            // What is damaged behind it is told when it is read.
            Err(_) => {
                *end = End::Lost;
                break;
            }
        }
    }
    bytes.truncate(length);
}
