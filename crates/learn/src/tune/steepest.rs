//! The largest change of command that a recording teaches.

use super::CylinderModel;
use super::pause::Pause;
use crate::extremes::{LEAST_PEAKS, Maxima};
use crate::survey::{Lull, Row, Surveyor};

/// Blocks of a recording, for each of which one may have a change that is too rare to teach; of a long one only
/// [`LEAST_PEAKS`] have.
const RARE: u64 = 100;

/// Changes of the command from one cycle to the next, cylinder by cylinder.
///
/// What a recording has a few times is no tail: the residuals of the three great waves in it say little about those of the
/// fourth, and nothing about how often it comes. The change is therefore not the largest, but one that enough blocks have.
#[derive(Clone, Debug)]
pub struct Steepest {
    cylinders: Vec<Followed>,
}

#[derive(Clone, Debug)]
struct Followed {
    max_gap: u32,
    pause: Pause,
    lull: Lull,
    newest: Option<f64>,
    changes: Maxima,
}

impl Steepest {
    /// `block` is the number of cycles that count as one warning.
    pub fn new(cylinders: &[CylinderModel], block: u32) -> Self {
        let followed = |cylinder: &CylinderModel| Followed {
            max_gap: cylinder.max_gap,
            pause: Pause::default(),
            lull: Lull::default(),
            newest: None,
            changes: Maxima::new(block),
        };
        Self { cylinders: cylinders.iter().map(followed).collect() }
    }

    /// Largest change that is taught to any cylinder, m/s: as the threshold, it is one for all of them. `None` where none
    /// was commanded to move.
    pub fn taught(&self) -> Option<f64> {
        let of = |cylinder: &Followed| {
            let blocks = cylinder.changes.blocks();
            let enough = (blocks / RARE).clamp(1, LEAST_PEAKS) as usize;
            cylinder.changes.largest().get(enough - 1).copied()
        };
        self.cylinders.iter().filter_map(of).max_by(f64::total_cmp).filter(|change| *change > 0.0)
    }
}

impl Surveyor for Steepest {
    fn row(&mut self, row: &Row) {
        let cylinder = &mut self.cylinders[usize::from(row.cylinder) - 1];
        if cylinder.lull.ends(row.t) {
            cylinder.changes.pause();
        }
        let follows = cylinder.pause.before(row.cycle, cylinder.max_gap) == Some(0);
        let before = cylinder.newest.filter(|_| follows && row.monitored);
        cylinder.newest = row.u;
        if let Some(change) = row.u.zip(before).map(|(u, before)| u - before) {
            cylinder.changes.add(change);
        }
    }

    fn gap(&mut self, cylinder: u8) {
        self.cylinders[usize::from(cylinder) - 1].pause.tell();
    }
}
