//! A recording in progress: the frames so far, and what is told of its incident.

use super::manifest::{Extent, Manifest, utc};
use super::packer::Piece;
use super::plan::{FRAMES_FILE, FlightPlan, MANIFEST, STATE_FILE};
use super::ring::{MOST_BYTES, Ring};
use std::io;
use std::sync::Arc;
use tertius_core::incident::{Incident, Scope};
use tertius_core::time::{Span, Timestamp};

/// Most lines of an incident that are kept: it is opened, revised a few times and closed.
const MOST_TOLD: usize = 64;

/// Frames that are going to be written.
#[derive(Debug)]
pub(super) struct Recording {
    /// Time that names it.
    at: Timestamp,
    /// Time at which its last frames have come.
    end: Timestamp,
    /// Time of its opening.
    opened: Timestamp,
    pieces: Vec<Arc<Piece>>,
    bytes: usize,
    /// Number of its incident; `None` on demand.
    number: Option<u32>,
    told: Vec<Incident>,
    /// Whether it has grown too long for further pieces.
    is_full: bool,
}

/// A file of a recording.
pub(super) struct RecordedFile<'a> {
    pub name: &'a str,
    pub parts: Vec<&'a [u8]>,
}

impl Recording {
    /// The recording of an incident that was opened now.
    pub fn of(incident: &Incident, ring: &Ring, plan: &FlightPlan) -> Self {
        let before = plan.before.as_nanos().saturating_neg();
        let from = incident.begin.after(Span::from_nanos(before));
        let end = incident.timestamp.after(plan.after);
        let recording = Self::new(incident.begin, [incident.timestamp, end], ring.since(from));
        Self { number: Some(incident.number), ..recording }
    }

    /// The recording of what is in the ring.
    pub fn on_demand(now: Timestamp, ring: &Ring) -> Self {
        Self::new(now, [now, now], ring.whole())
    }

    fn new(at: Timestamp, [opened, end]: [Timestamp; 2], pieces: Vec<Arc<Piece>>) -> Self {
        let bytes = pieces.iter().map(|piece| piece.size()).sum();
        Self { at, end, opened, pieces, bytes, number: None, told: Vec::new(), is_full: false }
    }

    /// Adds frames.
    pub fn take(&mut self, piece: &Arc<Piece>) {
        self.is_full |= self.bytes + piece.size() > MOST_BYTES;
        if !self.is_full {
            self.bytes += piece.size();
            self.pieces.push(Arc::clone(piece));
        }
    }

    /// Number of its incident; `None` on demand.
    pub const fn number(&self) -> Option<u32> {
        self.number
    }

    /// Notes the newest state of its incident.
    pub fn note(&mut self, incident: &Incident) {
        if self.told.len() < MOST_TOLD {
            self.told.push(*incident);
        }
    }

    /// Whether all of its frames have come by `now`, or no more are of use, because the clock was set back.
    pub fn is_over(&self, now: Timestamp) -> bool {
        now >= self.end || now < self.opened
    }

    /// Name of its folder, which sorts by time.
    pub fn name(&self) -> String {
        let stamp = utc(self.at).map(|at| at.strftime("%Y%m%dT%H%M%SZ").to_string());
        let stamp = stamp.unwrap_or_else(|| "00000000T000000Z".to_owned());
        match self.told.first() {
            Some(Incident { scope: Scope::Cylinder(cylinder), number, .. }) => {
                format!("{stamp}-cylinder-{cylinder}-incident-{number}")
            }
            Some(Incident { number, .. }) => format!("{stamp}-machine-incident-{number}"),
            None => format!("{stamp}-on-demand"),
        }
    }

    /// The manifest; `None` if there is not a single frame.
    ///
    /// # Errors
    /// It cannot be put into words.
    pub fn manifest(&self, plan: &FlightPlan, now: Timestamp) -> io::Result<Option<Vec<u8>>> {
        let mut ends = self.pieces.iter().filter_map(|piece| piece.ends);
        let Some([first, last]) = ends.next() else { return Ok(None) };
        let extent = Extent {
            ends: [first, ends.next_back().map_or(last, |[_, last]| last)],
            frames: self.pieces.iter().map(|piece| piece.frames).sum(),
            lost: self.pieces.iter().map(|piece| piece.lost).sum(),
            complete: !self.is_full && now >= self.end,
        };
        Manifest::new(plan, self.at, extent, &self.told)?.to_bytes().map(Some)
    }

    /// Its files.
    pub fn files<'a>(&'a self, plan: &'a FlightPlan, manifest: &'a [u8]) -> Vec<RecordedFile<'a>> {
        let frames = self.pieces.iter().map(|piece| &*piece.bytes).collect();
        let machine = plan.files.iter().map(|file| (file.name.as_str(), vec![&*file.bytes]));
        let own = [(FRAMES_FILE, frames), (MANIFEST, vec![manifest])];
        let state = self.pieces.first().and_then(|piece| piece.state.as_deref());
        let all = machine.chain(own).chain(state.map(|state| (STATE_FILE, vec![state])));
        all.map(|(name, parts)| RecordedFile { name, parts }).collect()
    }
}

impl RecordedFile<'_> {
    /// Its size, bytes.
    pub fn size(&self) -> u64 {
        self.parts.iter().map(|part| part.len() as u64).sum()
    }
}
