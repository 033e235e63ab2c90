//! The incidents that are not closed, of all cylinders.

use super::joining::Open;
use super::{Ending, Excursion, Incident, Part, Progress, QUANTITIES, Quantities, Quantity};
use crate::alarm::detector::PLACES;
use crate::alarm::{Finding, Level, State, Warning};
use crate::state::state;
use crate::time::{Span, Timestamp};
use crate::verdict::{Fault, Suspect};
use alloc::vec::Vec;

/// Most incidents of a cylinder at once: of each transducer and of neither. A further one is taken for the newest of
/// these.
pub const MOST_AT_ONCE: usize = 3;

/// The incidents of a machine, in bounded memory.
#[derive(Clone, Debug)]
pub struct Incidents {
    cylinders: Vec<OfCylinder>,
    /// Number of incidents so far.
    count: u32,
}

state! {
    Incidents { count }
    parts { cylinders }
    sound |it| it.are_of_their_cylinders()
}

#[derive(Clone, Debug)]
struct OfCylinder {
    open: [Option<Open>; MOST_AT_ONCE],
    limits: [f64; QUANTITIES],
    coincidence: Span,
}

state! {
    OfCylinder { open }
    but { limits, coincidence }
}

impl Incidents {
    /// The incidents of cylinders with these limits of their quantities, m, and with this time within which
    /// findings are of one event.
    pub fn new(cylinders: impl IntoIterator<Item = ([f64; QUANTITIES], Span)>) -> Self {
        let of =
            |(limits, coincidence)| OfCylinder { open: [None; MOST_AT_ONCE], limits, coincidence };
        Self { cylinders: cylinders.into_iter().map(of).collect(), count: 0 }
    }

    /// Whether the incidents of each cylinder are its own.
    fn are_of_their_cylinders(&self) -> bool {
        let mut each = self.cylinders.iter().zip(1_u8..);
        each.all(|(cylinder, n)| cylinder.open.iter().flatten().all(|it| it.incident.cylinder == n))
    }

    /// Takes a warning in the order of time; [`Self::follow`] then tells what became of its incident.
    ///
    /// That C1 and C2 were never calibrated is no incident. What comes of it is one: the warning then changes.
    pub fn take(&mut self, warning: &Warning) {
        let cylinder = &mut self.cylinders[usize::from(warning.cylinder) - 1];
        if warning.finding.fault == Fault::NotCalibrated {
            cylinder.revise(&Warning { state: State::Cleared, ..*warning });
            return;
        }
        match warning.state {
            State::Raised => cylinder.raise(warning, &mut self.count),
            State::Changed if !cylinder.revise(warning) => cylinder.raise(warning, &mut self.count),
            State::Changed => {}
            State::Cleared => _ = cylinder.revise(warning),
        }
    }

    /// Takes the cycle of the cylinder of `index` (from 0) that opened at `opened` and was evaluated at `at`,
    /// after its warnings. Passes to `say` each incident that was opened, revised or closed, and returns whether
    /// one is left that is not closed.
    #[cold]
    pub fn follow(
        &mut self,
        index: usize,
        [opened, at]: [Timestamp; 2],
        quantities: &Quantities,
        mut say: impl FnMut(&Incident),
    ) -> bool {
        let places = &mut self.cylinders[index].open;
        for place in places.iter_mut() {
            let Some(open) = place else { continue };
            open.difference = quantities[Quantity::R3 as usize];
            let stands = open.incident.stands();
            if stands || open.newest == at {
                open.incident.reach(opened, &open.own(quantities));
            }
            if let Some(incident) = open.news(at) {
                say(incident);
            }
            if !stands && at >= open.due() {
                let ending = if open.has_returned { Ending::Returned } else { Ending::Quiet };
                say(&open.closed(at, ending));
                *place = None;
            }
        }
        places.iter().any(Option::is_some)
    }

    /// Tells at `at`, after which there is nothing more, of every incident that is not closed.
    pub fn finish(&mut self, at: Timestamp, mut say: impl FnMut(&Incident)) {
        self.cut(at, &mut say);
        self.standing(at).for_each(|incident| say(&incident));
    }

    /// The incidents of which a warning stands, as told at `at`.
    pub fn standing(&self, at: Timestamp) -> impl Iterator<Item = Incident> {
        let open = self.cylinders.iter().flat_map(|cylinder| cylinder.open.iter().flatten());
        let standing = open.map(|open| open.incident).filter(Incident::stands);
        standing.map(move |incident| Incident {
            progress: Progress::Standing,
            timestamp: at,
            ..incident
        })
    }

    /// Closes at `at` the incidents of which no warning stands, since what follows cannot be told to
    /// belong to them.
    pub fn cut(&mut self, at: Timestamp, mut say: impl FnMut(&Incident)) {
        for place in self.cylinders.iter_mut().flat_map(|cylinder| &mut cylinder.open) {
            if let Some(open) = place.take_if(|open| !open.incident.stands()) {
                let ending = if open.has_returned { Ending::Returned } else { Ending::Cut };
                say(&open.closed(at, ending));
            }
        }
    }
}

impl OfCylinder {
    fn raise(&mut self, warning: &Warning, count: &mut u32) {
        let (coincidence, limits) = (self.coincidence, self.limits);
        let taken = self.newest(|open| open.takes(warning, coincidence));
        let free = || self.open.iter().position(Option::is_none);
        let Some(place) = taken.or_else(free).or_else(|| self.newest(|_| true)) else { return };
        let open = self.open[place].get_or_insert_with(|| {
            *count = count.saturating_add(1);
            Open::new(Incident::new(*count, warning, limits))
        });
        open.incident.raise(warning);
        open.follow(warning, coincidence);
    }

    /// Place of the incident that began last of those for which `is` holds.
    fn newest(&self, is: impl Fn(&Open) -> bool) -> Option<usize> {
        let number = |place: &usize| {
            let open = self.open[*place].as_ref().filter(|open| is(open));
            open.map(|open| open.incident.number)
        };
        (0..MOST_AT_ONCE).filter(|place| number(place).is_some()).max_by_key(number)
    }

    /// Takes a warning that has changed or cleared into the incident of which it stands; returns whether there is one.
    fn revise(&mut self, warning: &Warning) -> bool {
        let mut open = self.open.iter_mut().flatten();
        let stands =
            |open: &&mut Open| open.incident.parts[warning.place].is_some_and(|part| part.stands);
        let Some(open) = open.find(stands) else { return false };
        open.incident.revise(warning);
        if warning.state == State::Cleared {
            open.clear(warning);
        }
        true
    }
}

impl Incident {
    /// An incident that begins with `warning`, which it does not yet include.
    fn new(number: u32, warning: &Warning, limits: [f64; QUANTITIES]) -> Self {
        Self {
            number,
            cylinder: warning.cylinder,
            progress: Progress::Opened,
            timestamp: warning.timestamp,
            begin: warning.timestamp,
            onset: warning.timestamp,
            end: None,
            suspect: Suspect::Undecided,
            fault: Fault::Unclassified,
            gain: None,
            size: None,
            level: Level::None,
            parts: [None; PLACES],
            peaks: [None; QUANTITIES],
            limits,
        }
    }

    fn raise(&mut self, warning: &Warning) {
        let (raised, finding) = (warning.timestamp, warning.finding);
        let part = self.parts[warning.place].get_or_insert(Part {
            raised,
            raises: 0,
            stands: true,
            finding,
            has_cleared: false,
        });
        part.raises = part.raises.saturating_add(1);
        part.stands = true;
        part.take(&finding);
        self.level = self.level.max(finding.level);
        self.fuse();
    }

    fn revise(&mut self, warning: &Warning) {
        let Some(part) = &mut self.parts[warning.place] else { return };
        if warning.state == State::Cleared {
            (part.stands, part.has_cleared) = (false, true);
            return;
        }
        part.take(&warning.finding);
        self.level = self.level.max(warning.finding.level);
        self.fuse();
    }

    fn reach(&mut self, opened: Timestamp, quantities: &Quantities) {
        for (peak, value) in self.peaks.iter_mut().zip(quantities) {
            let Some(value) = *value else { continue };
            if peak.is_none_or(|peak| value.abs() > peak.value.abs()) {
                *peak = Some(Excursion { value, at: opened });
            }
        }
    }
}

impl Part {
    /// Takes what its detector says now.
    fn take(&mut self, finding: &Finding) {
        let Finding { fault, suspect, evidence, device, .. } = *finding;
        let own = &mut self.finding;
        if !self.has_cleared {
            (own.fault, own.suspect) = (fault, suspect);
            own.evidence = evidence.or(own.evidence);
            own.device = device.or(own.device);
            return;
        }
        if own.suspect == Suspect::Undecided {
            own.suspect = suspect;
            if let (Some(own), Some(new)) = (&mut own.evidence, evidence) {
                (own.location, own.by) = (new.location, new.by);
            }
        }
        if own.fault == Fault::Unclassified && own.gain().is_none() {
            own.fault = fault;
        }
    }
}
