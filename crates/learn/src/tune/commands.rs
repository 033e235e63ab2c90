//! The largest commands, and changes of them, that a recording teaches.

use super::CylinderModel;
use super::pause::Pause;
use crate::extremes::{LEAST_PEAKS, Maxima, four_digits};
use crate::survey::{Lull, Row, Surveyor};
use tertius_core::observe::commands::LearntCommands;

/// Blocks of a recording, for each of which one may have a command that is too rare to teach; of a long one only
/// [`LEAST_PEAKS`] have.
const RARE: u64 = 100;

/// Commands, and their changes from one cycle to the next, cylinder by cylinder.
///
/// What a recording has a few times is no tail: the residuals of the three great waves in it say little about those of the
/// fourth, and nothing about how often it comes. What counts is therefore not the largest, but one that enough blocks have.
#[derive(Clone, Debug)]
pub struct Commands {
    cylinders: Vec<Followed>,
}

#[derive(Clone, Debug)]
struct Followed {
    max_gap: u32,
    pause: Pause,
    lull: Lull,
    /// u where it rests, m/s.
    offset: f64,
    newest: Option<f64>,
    sizes: Maxima,
    changes: Maxima,
}

impl Commands {
    /// `block` is the number of cycles that count as one warning.
    pub fn new(cylinders: &[CylinderModel], block: u32) -> Self {
        let followed = |cylinder: &CylinderModel| Followed {
            max_gap: cylinder.max_gap,
            pause: Pause::default(),
            lull: Lull::default(),
            offset: cylinder.command_offset,
            newest: None,
            sizes: Maxima::new(block),
            changes: Maxima::new(block),
        };
        Self { cylinders: cylinders.iter().map(followed).collect() }
    }

    /// The largest that are taught to any cylinder, of four digits: as the threshold, they are the same for all of them.
    /// `None` where none was commanded to move.
    pub fn taught(&self) -> Option<LearntCommands> {
        let [size, change] =
            [|it: &Followed| taught(&it.sizes), |it: &Followed| taught(&it.changes)]
                .map(|of| self.cylinders.iter().filter_map(of).fold(0.0, f64::max));
        let moves = size > 0.0 && change > 0.0;
        moves.then(|| LearntCommands { size: four_digits(size), change: four_digits(change) })
    }
}

/// What enough blocks have.
fn taught(maxima: &Maxima) -> Option<f64> {
    let enough = (maxima.blocks() / RARE).clamp(1, LEAST_PEAKS) as usize;
    maxima.largest().get(enough - 1).copied()
}

impl Surveyor for Commands {
    fn row(&mut self, row: &Row) {
        let cylinder = &mut self.cylinders[usize::from(row.cylinder) - 1];
        if cylinder.lull.ends(row.t) {
            cylinder.changes.pause();
            cylinder.sizes.pause();
        }
        let follows = cylinder.pause.before(row.cycle, cylinder.max_gap) == Some(0);
        let before = cylinder.newest.filter(|_| follows && row.monitored);
        cylinder.newest = row.u;
        if let Some(command) = row.u.filter(|_| row.monitored) {
            cylinder.sizes.add(command - cylinder.offset);
        }
        if let Some(change) = row.u.zip(before).map(|(u, before)| u - before) {
            cylinder.changes.add(change);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.cylinders[usize::from(cylinder) - 1].pause.tell();
    }
}
