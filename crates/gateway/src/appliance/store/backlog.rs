//! What waits to be written, in bounded memory.

use super::note::Note;
use super::plan::Plan;
use std::collections::VecDeque;

/// Most entries that wait, about 3 MB. Warnings give way first, an incident's older revisions next.
const MOST: usize = 2048;

/// Notes that wait, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Backlog {
    notes: VecDeque<Note>,
    /// Notes that gave way and are not yet told.
    lost: u64,
}

impl Backlog {
    pub fn is_empty(&self) -> bool {
        self.notes.is_empty() && self.lost == 0
    }

    pub fn notes(&self) -> impl Iterator<Item = &Note> {
        self.notes.iter()
    }

    pub fn len(&self) -> usize {
        self.notes.len()
    }

    /// Number of notes that wait and are about what happened, and not about the program itself.
    pub fn waiting(&self) -> u64 {
        let is_own = |note: &&Note| matches!(note, Note::Begin(_) | Note::End(_));
        (self.notes.len() - self.notes.iter().filter(is_own).count()) as u64
    }

    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Counts notes that never came here.
    pub fn lose(&mut self, notes: u64) {
        self.lost += notes;
    }

    pub fn push(&mut self, note: Note) {
        if self.notes.len() >= MOST {
            self.give_way();
        }
        self.notes.push_back(note);
    }

    /// Takes out everything; what is written is gone from here.
    pub fn clear(&mut self) -> VecDeque<Note> {
        self.lost = 0;
        std::mem::take(&mut self.notes)
    }

    /// Takes out the acts, which are answered instead of kept while nothing can be written.
    pub fn take_acts(&mut self) -> Vec<Note> {
        let (acts, others) =
            std::mem::take(&mut self.notes).into_iter().partition(|it| matches!(it, Note::Act(_)));
        self.notes = others;
        Vec::from_iter::<VecDeque<Note>>(acts)
    }

    /// The newest monitor that began among what waits, which a store that starts anew needs first.
    pub fn begins(&self) -> bool {
        self.notes.iter().any(|it| matches!(it, Note::Begin(Some(_))))
    }

    /// Puts the begin of a monitor before everything else.
    pub fn begin_first(&mut self, plan: Plan) {
        self.notes.push_front(Note::Begin(Some(Box::new(plan))));
    }

    fn give_way(&mut self) {
        let light = self.notes.iter().position(Note::is_light);
        let place = light.or_else(|| self.superseded());
        if self.notes.remove(place.unwrap_or(0)).is_some() {
            self.lost += 1;
        }
    }

    /// Place of an incident of which something newer waits.
    fn superseded(&self) -> Option<usize> {
        let number = |note: &Note| match note {
            Note::Incident(incident) => Some(incident.number),
            _ => None,
        };
        self.notes.iter().enumerate().position(|(place, note)| {
            let own = number(note);
            own.is_some() && self.notes.iter().skip(place + 1).any(|later| number(later) == own)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples;
    use super::*;

    #[test]
    fn a_storm_of_warnings_takes_no_incident_away() {
        let mut backlog = Backlog::default();
        for number in 1..=10 {
            backlog.push(Note::Incident(samples::incident(number)));
        }
        (0..10_000).for_each(|_| backlog.push(Note::Warning(samples::warning())));
        assert_eq!(backlog.len(), MOST);
        assert_eq!(backlog.lost(), 10_010 - MOST as u64);
        let incidents = backlog.notes().filter(|it| matches!(it, Note::Incident(_))).count();
        assert_eq!(incidents, 10);
        for number in 1..=3000 {
            backlog.push(Note::Incident(samples::incident(number % 1500)));
        }
        assert_eq!(backlog.len(), MOST, "bounded");
        let mut numbers: Vec<u32> = backlog
            .notes()
            .filter_map(|note| match note {
                Note::Incident(incident) => Some(incident.number),
                _ => None,
            })
            .collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), 1500, "something of each incident is left");
    }
}
