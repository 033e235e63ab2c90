//! Recordings of several buses as one, in the order of the time stamps.
//!
//! Each bus may have been recorded to files of its own, or all to one, where what is written beside each other is out of
//! order by as much as the recorder was late. Frames are therefore held back until the newest one is the gateway's guard
//! ahead, as the gateway holds back what its interfaces receive: both give the monitor the same frames in the same order.
//!
//! Which files follow each other and which run beside each other is told by the buses that their first mebibyte has, after
//! decompression: files that share a bus follow each other in the order in which they are named. A recording of all buses
//! may therefore be cut anywhere. If each of its pieces begins with a mebibyte of one bus only, and not all of them with the
//! same one, they are taken for recordings of single buses, which differ where frames have equal time stamps or the clock
//! was set back.

use std::path::Path;

use tertius_core::frame::{BusNumber, Frame};
use tertius_core::time::Span;

use super::Recording;
use crate::input::InputPlace;
use crate::options::Options;
use crate::order;
use crate::progress::Progress;
use crate::selection::SeveralInterfaces;
use crate::sorter::Sorter;
use crate::source::{Source, SourceError};
use crate::statistics::Statistics;

/// Step back of the time stamps from which on it is the clock that was set: nothing is sorted across it.
const SETBACK: Span = Span::from_nanos(-1_000_000_000);

/// Recordings that run beside each other.
pub(super) struct Merge {
    lanes: Vec<Lane>,
    sorter: Sorter,
    /// Minus the time within which frames of several buses may be out of order.
    back: Span,
    /// A frame after the clock was set back, before which everything held back is given.
    set_back: Option<Frame>,
}

/// Files that follow each other.
struct Lane {
    recording: Recording,
    next: Option<Frame>,
    ended: bool,
}

impl Merge {
    /// Opens `paths`, each file in its lane. Frames are sorted that are out of order by less than that of `several`.
    ///
    /// # Errors
    /// See [`Recording::open`].
    pub fn open<P: AsRef<Path>>(
        paths: &[P],
        options: &Options,
        several: &SeveralInterfaces,
    ) -> Result<Self, SourceError> {
        let meant: Vec<BusNumber> = several.buses.iter().map(|(bus, _)| *bus).collect();
        let buses = |path: &P| {
            order::first_buses(&InputPlace::of(path.as_ref()), &options.interfaces, meant.len())
        };
        let files: Vec<Vec<BusNumber>> = paths.iter().map(buses).collect();
        let open = |files: Vec<usize>| {
            let paths: Vec<&Path> = files.iter().map(|file| paths[*file].as_ref()).collect();
            let recording = Recording::lane(&paths, options.clone())?;
            Ok(Lane { recording, next: None, ended: false })
        };
        let lanes = lanes(&files, &meant).into_iter().map(open);
        let lanes = lanes.collect::<Result<_, SourceError>>()?;
        let back = Span::from_nanos(several.disorder.as_nanos().saturating_neg());
        Ok(Self { lanes, sorter: Sorter::default(), back, set_back: None })
    }

    /// Statistics of all files together.
    pub fn statistics(&mut self) -> Statistics {
        let mut all = Statistics::default();
        self.lanes.iter_mut().for_each(|lane| all.add(lane.recording.statistics()));
        all
    }

    pub fn progress(&self) -> Progress {
        let each = self.lanes.iter().map(|lane| lane.recording.progress());
        each.fold(Progress::NONE, Progress::and)
    }

    /// The next frame of all.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, SourceError> {
        loop {
            if self.set_back.is_some() {
                match self.sorter.take_any() {
                    Some(frame) => return Ok(Some(frame)),
                    None => self.set_back.take().iter().for_each(|frame| self.sorter.put(frame)),
                }
            }
            let newest = self.sorter.newest().map(|newest| newest.after(self.back));
            if let Some(frame) = newest.and_then(|until| self.sorter.take(until)) {
                return Ok(Some(frame));
            }
            let Some(frame) = self.next_of_lanes()? else { return Ok(self.sorter.take_any()) };
            match self.sorter.newest() {
                Some(newest) if frame.timestamp.since(newest) <= SETBACK => {
                    self.set_back = Some(frame);
                }
                _ => self.sorter.put(&frame),
            }
        }
    }

    /// The earliest of the frames that come next in the lanes.
    fn next_of_lanes(&mut self) -> Result<Option<Frame>, SourceError> {
        for lane in &mut self.lanes {
            if lane.next.is_none() && !lane.ended {
                lane.next = lane.recording.next_frame()?.cloned();
                lane.ended = lane.next.is_none();
            }
        }
        let times = self.lanes.iter().enumerate();
        let times = times.filter_map(|(i, lane)| Some((lane.next.as_ref()?.timestamp, i)));
        Ok(times.min().and_then(|(_, earliest)| self.lanes[earliest].next.take()))
    }
}

/// The files of each lane, in the order in which they are named, by the buses that each of the `files` is known to have:
/// those that share a bus, directly or by way of others, are of one lane. A file of which no bus is known follows the lane
/// that has all `several` buses, where there is one.
fn lanes(files: &[Vec<BusNumber>], several: &[BusNumber]) -> Vec<Vec<usize>> {
    // Of each bus one that stands for all that are of its lane.
    let mut lane_of = BusNumber::ALL;
    for buses in files {
        let joined: Vec<BusNumber> = buses.iter().map(|bus| lane_of[*bus as usize]).collect();
        let shared = lane_of.iter_mut().filter(|lane| joined.contains(lane));
        shared.for_each(|lane| *lane = joined[0]);
    }
    let lane = |bus: &BusNumber| lane_of[*bus as usize];
    let all = several.first().map(lane).filter(|all| several.iter().all(|bus| lane(bus) == *all));
    let mut lanes: Vec<(Option<BusNumber>, Vec<usize>)> = Vec::new();
    for (file, buses) in files.iter().enumerate() {
        let lane = buses.first().map(lane).or(all);
        match lanes.iter_mut().find(|(known, _)| *known == lane) {
            Some((_, lane)) => lane.push(file),
            None => lanes.push((lane, vec![file])),
        }
    }
    lanes.into_iter().map(|(_, files)| files).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_share_a_bus_follow_each_other_and_others_run_beside_them() {
        use BusNumber::{First, Second, Third};
        let lanes = |files: &[&[BusNumber]], several: &[BusNumber]| {
            lanes(&files.iter().map(|buses| buses.to_vec()).collect::<Vec<_>>(), several)
        };
        let two = [First, Second];
        // One file for each bus, or several for each.
        assert_eq!(lanes(&[&[Second], &[First]], &two), [[0], [1]]);
        assert_eq!(lanes(&[&[First], &[Second], &[First], &[Second]], &two), [[0, 2], [1, 3]]);
        // Pieces of a recording of both, of which some begin with one bus, or have no frame that is meant.
        assert_eq!(lanes(&[&[First, Second], &[Second], &[First], &[]], &two), [[0, 1, 2, 3]]);
        assert_eq!(lanes(&[&[First], &[], &[Second], &[Second, First]], &two), [[0, 1, 2, 3]]);
        // A pipe beside a file of one bus.
        assert_eq!(lanes(&[&[First], &[]], &two), [[0], [1]]);
        // Two buses to one recorder, the third to another.
        let three = [First, Second, Third];
        let files: [&[BusNumber]; 4] = [&[Third], &[Second, First], &[First], &[Third]];
        assert_eq!(lanes(&files, &three), [[0, 3], [1, 2]]);
        let files: [&[BusNumber]; 4] = [&[Third], &[Second], &[First], &[First, Third]];
        assert_eq!(lanes(&files, &three), [vec![0, 2, 3], vec![1]]);
    }
}
