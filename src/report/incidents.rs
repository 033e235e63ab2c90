//! The incidents of a replay.

use crate::alarm::Level;
use crate::incident::{Incident, Progress};
use crate::story;

/// Most incidents that are kept; of further ones the mildest gives way, and all are counted.
pub const KEPT: usize = 200;

/// Incidents of a replay.
#[derive(Clone, Debug, Default)]
pub struct Incidents {
    kept: Vec<Incident>,
    count: u64,
}

impl Incidents {
    /// Takes an incident that was opened, revised or closed.
    pub fn take(&mut self, incident: &Incident) {
        if let Some(known) = self.kept.iter_mut().rfind(|known| known.number == incident.number) {
            *known = *incident;
            return;
        }
        if incident.progress == Progress::Opened {
            self.count += 1;
        }
        if self.kept.len() < KEPT {
            self.kept.push(*incident);
            return;
        }
        let mildest = self.kept.iter_mut().max_by_key(|known| story::severity(known));
        if let Some(mildest) = mildest.filter(|known| known.level < incident.level) {
            *mildest = *incident;
        }
    }

    /// Number of incidents.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Number of incidents beyond [`KEPT`].
    pub const fn left_out(&self) -> u64 {
        self.count - self.kept.len() as u64
    }

    /// The incidents that are kept, the worst first, and of one level in the order of their begin.
    pub fn by_severity(&self) -> Vec<&Incident> {
        let mut all: Vec<&Incident> = self.kept.iter().collect();
        all.sort_by_key(|incident| story::severity(incident));
        all
    }

    /// The worst one: of the highest level that with the largest difference, relative to its limit.
    pub fn worst(&self) -> Option<&Incident> {
        let share = |incident: &Incident| {
            let worst = incident.worst();
            worst.map_or(0.0, |(quantity, peak)| {
                peak.value.abs() / incident.limits[quantity as usize]
            })
        };
        let level = self.kept.iter().map(|incident| incident.level).max().unwrap_or(Level::None);
        let worst = self.kept.iter().filter(|incident| incident.level == level);
        worst.max_by(|a, b| share(a).total_cmp(&share(b)))
    }

    /// Number of incidents of the cylinder `n` (from 1) that are kept.
    pub fn of_cylinder(&self, n: usize) -> usize {
        self.kept.iter().filter(|incident| usize::from(incident.cylinder) == n).count()
    }
}
