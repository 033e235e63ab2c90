//! The incidents of a replay.

use crate::story;
use tertius_core::incident::{Incident, Progress};

/// Most incidents that are kept; of further ones the mildest gives way, and all are counted.
pub const KEPT: usize = 200;

/// Incidents of a replay.
#[derive(Clone, Debug, Default)]
pub struct Incidents {
    kept: Vec<Incident>,
    count: u64,
    /// Number of incidents of each cylinder alone, in order.
    counts: Vec<u64>,
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
            if let Some(number) = incident.scope.cylinder() {
                let number = usize::from(number);
                self.counts.resize(self.counts.len().max(number), 0);
                self.counts[number - 1] += 1;
            }
        }
        if self.kept.len() < KEPT {
            self.kept.push(*incident);
            return;
        }
        let mildest = self.kept.iter_mut().max_by(|a, b| story::order(a, b));
        if let Some(mildest) = mildest.filter(|known| story::order(incident, known).is_lt()) {
            *mildest = *incident;
        }
    }

    /// Number of incidents.
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// Number of incidents beyond [`KEPT`].
    pub fn left_out(&self) -> u64 {
        self.count() - self.kept.len() as u64
    }

    /// The incidents that are kept, the worst first.
    pub fn by_severity(&self) -> Vec<&Incident> {
        let mut all: Vec<&Incident> = self.kept.iter().collect();
        all.sort_by(|a, b| story::order(a, b));
        all
    }

    /// The worst one, which is the first of [`Self::by_severity`].
    pub fn worst(&self) -> Option<&Incident> {
        self.kept.iter().min_by(|a, b| story::order(a, b))
    }

    /// Number of incidents of the cylinder `n` (from 1) alone.
    pub fn of_cylinder(&self, n: usize) -> u64 {
        self.counts.get(n - 1).copied().unwrap_or(0)
    }
}
