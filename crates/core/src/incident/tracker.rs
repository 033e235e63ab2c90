//! The incidents that are not closed, of all cylinders.

use super::cause::{Cause, fits, is_of_supply};
use super::drifting::is_of_drift;
use super::joining::Open;
use super::shared::Shared;
use super::{
    Ending, EventTiming, Incident, IncidentParameters, Progress, QUANTITIES, Quantities, Quantity,
    Scope,
};
use crate::alarm::detector::WarningPlace;
use crate::alarm::{Finding, State, Warning};
use crate::state::state;
use crate::time::{Span, Timestamp};
use crate::verdict::Fault;
use alloc::vec::Vec;

const P: &IncidentParameters = &IncidentParameters::DEFAULT;

/// Most incidents of a cylinder at once: of each transducer and of neither. A further one is taken for the newest of
/// these.
pub const MOST_AT_ONCE: usize = 3;

/// Places of the detectors of R1, R2 and R3.
const COMPARING: [WarningPlace; 3] = [WarningPlace::Fde1, WarningPlace::Fde2, WarningPlace::Fde3];

/// The incidents of a machine, in bounded memory.
#[derive(Clone, Debug)]
pub struct Incidents {
    cylinders: Vec<OfCylinder>,
    /// Those of the machine, in the order of [`Cause::ALL`].
    shared: [Option<Shared>; Cause::ALL.len()],
    /// Whether there is any of the machine, or one of a cylinder that belongs to one.
    shares: bool,
    /// When most cylinders were last found to show something in one moment.
    gathered: Option<Timestamp>,
    /// Number of incidents that were reported so far.
    count: u32,
    /// Number of those that began.
    begun: u32,
    /// Time within which what several cylinders show has one cause.
    moment: Span,
    /// Time after which what one cylinder is left with is its own, in the order of [`Cause::ALL`].
    alone: [Span; Cause::ALL.len()],
}

state! {
    Incidents { shared, shares, gathered, count, begun }
    parts { cylinders }
    but { moment, alone }
    sound |it| it.are_of_their_cylinders()
}

#[derive(Clone, Debug)]
struct OfCylinder {
    open: [Option<Open>; MOST_AT_ONCE],
    limits: [f64; QUANTITIES],
    timing: EventTiming,
}

state! {
    OfCylinder { open }
    but { limits, timing }
}

impl Incidents {
    /// The incidents of cylinders with these limits of their quantities, m, and these times; `sample_time` is that of the
    /// machine.
    pub fn new(
        cylinders: impl IntoIterator<Item = ([f64; QUANTITIES], EventTiming)>,
        sample_time: Span,
    ) -> Self {
        let of = |(limits, timing)| OfCylinder { open: [None; MOST_AT_ONCE], limits, timing };
        let cylinders: Vec<OfCylinder> = cylinders.into_iter().map(of).collect();
        // A cylinder without others has nothing in common with them.
        let cycles = if cylinders.len() < P.least { 0 } else { P.moment };
        Self {
            cylinders,
            shared: [None; Cause::ALL.len()],
            shares: false,
            gathered: None,
            count: 0,
            begun: 0,
            moment: Span::from_nanos(sample_time.as_nanos().saturating_mul(cycles.into())),
            alone: Cause::ALL.map(|cause| {
                Span::from_seconds(if cause == Cause::Drift { P.alone_drift } else { P.alone })
            }),
        }
    }

    /// Whether the incidents of each cylinder are its own.
    fn are_of_their_cylinders(&self) -> bool {
        let mut each = self.cylinders.iter().zip(1_u8..);
        each.all(|(cylinder, n)| {
            let mut open = cylinder.open.iter().flatten();
            open.all(|it| it.incident.scope == Scope::Cylinder(n))
        })
    }

    /// Takes a warning in the order of time; [`Self::follow`] then reports what became of its incident.
    ///
    /// That C1 and C2 were never calibrated is no incident. What comes of it is one: the warning then changes.
    pub fn take(&mut self, warning: &Warning) {
        let cylinder = &mut self.cylinders[usize::from(warning.cylinder) - 1];
        if warning.finding.fault == Fault::NotCalibrated {
            cylinder.revise(&Warning { state: State::Cleared, ..*warning });
            return;
        }
        let raised = cylinder.take_out(warning);
        match warning.state {
            State::Changed if cylinder.revise(warning) => {}
            State::Raised | State::Changed => {
                if cylinder.raise(&raised, &mut self.begun) {
                    self.gather(&raised);
                }
            }
            State::Cleared => _ = cylinder.revise(warning),
        }
        if warning.state != State::Cleared
            && (is_of_drift(warning) || self.has_shared(Cause::Drift))
        {
            self.gather_drifts();
        }
    }

    fn all_open(&mut self) -> impl Iterator<Item = &mut Open> {
        self.cylinders.iter_mut().flat_map(|it| it.open.iter_mut().flatten())
    }

    /// Whether there is an incident of the machine for this cause.
    const fn has_shared(&self, cause: Cause) -> bool {
        self.shared[cause as usize].is_some()
    }

    /// Whether so many cylinders are most of them.
    fn are_most(&self, count: usize) -> bool {
        count >= P.least && count as f64 > P.most * self.cylinders.len() as f64
    }

    /// Notes that `warning` has begun an incident of a cylinder: if most cylinders have one that began in the same moment,
    /// they are the machine's, and so is what is wrong with the supply.
    fn gather(&mut self, warning: &Warning) {
        let (at, moment) = (warning.timestamp, self.moment);
        let is_near = |begin: Timestamp| at.since(begin) <= moment;
        let is_fresh = |open: &Open| {
            !open.is_reported() && open.shared.is_none() && is_near(open.incident.begin)
        };
        let has_fresh = |it: &&OfCylinder| it.open.iter().flatten().any(is_fresh);
        let count = self.cylinders.iter().filter(has_fresh).count();
        let is_many = self.are_most(count);
        if is_many {
            self.gathered = Some(at);
        }
        self.shares |= is_many || is_of_supply(warning);
        if self.gathered.is_some_and(is_near) {
            let fresh = self.all_open().filter(|it| is_fresh(it));
            fresh.for_each(|open| open.shared = Some(Cause::Moment));
        }
    }

    /// Takes the drifts of most cylinders for the machine's, and each further one while they stand.
    fn gather_drifts(&mut self) {
        let has_drift = |it: &&OfCylinder| it.open.iter().flatten().any(Open::is_drift);
        let count = self.cylinders.iter().filter(has_drift).count();
        let goes_on = self.has_shared(Cause::Drift);
        if !goes_on && !self.are_most(count) {
            return;
        }
        for open in self.all_open() {
            if open.is_drift() {
                open.shared = Some(Cause::Drift);
            } else if open.shared == Some(Cause::Drift) && open.incident.stands() {
                // A suspect was named, or another detector has found more: that is the cylinder's own.
                open.shared = None;
            }
        }
        self.shares = true;
    }

    /// Takes the cycle of the cylinder of `index` (from 0) that opened at `opened` and was evaluated at `at`,
    /// after its warnings. Passes to `report` each incident that was opened, revised or closed, and returns whether
    /// one is left that is not closed. One that began just now is reported when it is known whether other cylinders have it, too.
    #[cold]
    pub fn follow(
        &mut self,
        index: usize,
        [opened, at]: [Timestamp; 2],
        quantities: &Quantities,
        mut report: impl FnMut(&Incident),
    ) -> bool {
        let Self { cylinders, shared, count, moment, .. } = self;
        let OfCylinder { open: places, timing, .. } = &mut cylinders[index];
        for place in places.iter_mut() {
            let Some(open) = place else { continue };
            let difference = quantities[Quantity::R3 as usize];
            open.take_difference(difference);
            let stands = open.incident.stands();
            let own = open.own(quantities);
            if stands || open.newest == at {
                open.incident.reach(opened, &own);
            }
            open.incident.now = own;
            if open.newest == at {
                open.incident.part_by(difference, at);
            }
            if open.reported.is_none() {
                open.incident.outset.judged = core::array::from_fn(|i| quantities[i].is_some());
            }
            let is_over = !stands && at >= open.due(timing);
            if let Some(cause) = open.shared {
                if let Some(shared) = shared[cause as usize].as_mut().filter(|_| is_over) {
                    shared.release(open.ending());
                    *place = None;
                }
                continue;
            }
            // A clock that was set back does not keep it waiting.
            let begin = open.incident.begin;
            let waits = !open.is_reported() && (begin..begin.after(*moment)).contains(&at);
            if is_over || !waits {
                open.report_news(at, count, &mut report);
            }
            if is_over {
                report(&open.closed(at, open.ending()));
                *place = None;
            }
        }
        places.iter().any(Option::is_some)
    }

    /// Takes the end of a cycle at `at`: passes to `report` each incident of the machine that was opened, revised or closed.
    #[inline]
    pub fn follow_machine(&mut self, at: Timestamp, report: impl FnMut(&Incident)) {
        if self.shares {
            self.sum_up(at, report);
        }
    }

    #[cold]
    fn sum_up(&mut self, at: Timestamp, mut report: impl FnMut(&Incident)) {
        for cause in Cause::ALL {
            let Self { cylinders, shared, count, .. } = self;
            let place = &mut shared[cause as usize];
            let each = cylinders.iter().enumerate();
            let mut members = each.flat_map(|(index, it)| {
                let own = it.open.iter().flatten().filter(|open| open.shared == Some(cause));
                own.map(move |open| (index, open))
            });
            let Some((index, first)) = members.next() else {
                if let Some(shared) = place.take() {
                    report(&shared.closed(at));
                }
                continue;
            };
            let shared = place.get_or_insert_with(|| {
                *count = count.saturating_add(1);
                Shared::new(*count, first)
            });
            shared.begin();
            shared.take(index, first);
            members.for_each(|(index, open)| shared.take(index, open));
            if let Some(incident) = shared.news(cause, at) {
                report(incident);
            }
            for open in self.all_open().filter(|it| it.shared == Some(cause)) {
                // It was a cylinder's own until others showed it, too.
                if open.reported.take().is_some() {
                    report(&open.closed(at, Ending::Joined));
                }
            }
            self.leave_alone(cause, at);
        }
        self.shares = self.shared.iter().any(Option::is_some);
    }

    /// Gives what stands of an incident of the machine back to the only cylinder that is left with it.
    fn leave_alone(&mut self, cause: Cause, at: Timestamp) {
        let Some(shared) = &self.shared[cause as usize] else { return };
        let stands = |open: &Open| open.shared == Some(cause) && open.incident.stands();
        let mut left = self.cylinders.iter_mut().filter(|it| it.open.iter().flatten().any(stands));
        let (Some(one), None) = (left.next(), left.next()) else { return };
        let was_shared = shared.incident.scope.cylinders().count() >= P.least;
        if was_shared && at >= shared.newest.after(self.alone[cause as usize]) {
            let own = one.open.iter_mut().flatten().filter(|open| stands(open));
            own.for_each(|open| open.shared = None);
        }
    }

    /// Reports at `at`, after which nothing follows, every incident that is not closed.
    pub fn finish(&mut self, at: Timestamp, mut report: impl FnMut(&Incident)) {
        self.cut(at, &mut report);
        let Self { cylinders, count, .. } = self;
        let open = cylinders.iter_mut().flat_map(|it| it.open.iter_mut().flatten());
        open.filter(|open| open.shared.is_none())
            .for_each(|open| open.report_news(at, count, &mut report));
        self.standing(at).for_each(|incident| report(&incident));
    }

    /// The incidents of which a warning stands, as reported at `at`.
    pub fn standing(&self, at: Timestamp) -> impl Iterator<Item = Incident> {
        let open = self.cylinders.iter().flat_map(|cylinder| cylinder.open.iter().flatten());
        let own = open.filter(|open| open.is_reported() && open.shared.is_none());
        let all =
            own.map(|it| it.incident).chain(self.shared.iter().flatten().map(|it| it.incident));
        all.filter(Incident::stands).map(move |incident| Incident {
            progress: Progress::Standing,
            timestamp: at,
            ..incident
        })
    }

    /// Closes at `at` the incidents of which no warning stands, since what follows cannot be reported to
    /// belong to them.
    pub fn cut(&mut self, at: Timestamp, mut report: impl FnMut(&Incident)) {
        let Self { cylinders, shared, count, .. } = self;
        for place in cylinders.iter_mut().flat_map(|cylinder| &mut cylinder.open) {
            if let Some(mut open) = place.take_if(|open| !open.incident.stands()) {
                let ending = if open.has_returned { Ending::Returned } else { Ending::Cut };
                match open.shared.and_then(|cause| shared[cause as usize].as_mut()) {
                    Some(shared) => shared.release(ending),
                    None => {
                        open.report_news(at, count, &mut report);
                        report(&open.closed(at, ending));
                    }
                }
            }
        }
        self.follow_machine(at, report);
    }
}

impl Open {
    /// Reports it at `at`, if it says something new, with the next number if it is reported for the first time.
    fn report_news(&mut self, at: Timestamp, count: &mut u32, report: &mut impl FnMut(&Incident)) {
        if !self.is_reported() {
            *count = count.saturating_add(1);
            self.incident.number = *count;
        }
        if let Some(incident) = self.news(at) {
            report(incident);
        }
    }
}

impl OfCylinder {
    /// Takes a warning that is raised into the incident that it belongs to; returns whether it begins one.
    fn raise(&mut self, warning: &Warning, begun: &mut u32) -> bool {
        let (timing, limits) = (self.timing, self.limits);
        let takes = |open: &Open| fits(open.shared, warning) && open.takes(warning, &timing);
        let taken = self.newest(takes);
        let free = || self.open.iter().position(Option::is_none);
        let elsewhere =
            COMPARING.map(|place| self.open.iter().flatten().any(|it| it.has_standing(place)));
        let Some(place) = taken.or_else(free).or_else(|| self.newest(|_| true)) else {
            return false;
        };
        let begins = self.open[place].is_none();
        let open = self.open[place].get_or_insert_with(|| {
            *begun = begun.saturating_add(1);
            Open::new(*begun, Incident::new(warning, elsewhere, limits))
        });
        if begins && is_of_supply(warning) {
            open.shared = Some(Cause::Supply);
        }
        // What is raised now, the quantities of the cycle have.
        if warning.state == State::Changed {
            open.incident.reach_by(warning);
        }
        open.incident.raise(warning);
        open.follow(warning, timing.coincidence);
        open.date_naming(warning, timing.coincidence);
        begins
    }

    /// Place of the incident that began last of those for which `is` holds.
    fn newest(&self, is: impl Fn(&Open) -> bool) -> Option<usize> {
        let order = |place: &usize| {
            let open = self.open[*place].as_ref().filter(|open| is(open));
            open.map(|open| open.order)
        };
        (0..MOST_AT_ONCE).filter(|place| order(place).is_some()).max_by_key(order)
    }

    /// Takes a warning out of the incident that it has turned out not to belong to, and returns it as it was raised: its fault
    /// began then, and was that large. Returns any other warning as it is.
    fn take_out(&mut self, warning: &Warning) -> Warning {
        if warning.state != State::Changed {
            return *warning;
        }
        let mut open = self.open.iter_mut().flatten();
        let is_left = |open: &&mut Open| {
            open.incident.parts[warning.place].is_some_and(|part| part.stands)
                && open.is_left_by(warning)
        };
        let part =
            open.find(is_left).and_then(|it| it.incident.give_up(warning.place, warning.timestamp));
        let Some(part) = part else {
            return *warning;
        };
        let Finding { residual, threshold, .. } = part.finding;
        let finding = Finding { residual, threshold, ..warning.finding };
        Warning { timestamp: part.raised, finding, ..*warning }
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

impl Open {
    fn has_standing(&self, place: WarningPlace) -> bool {
        self.incident.part(place).is_some_and(|part| part.stands)
    }

    /// Notes whether the suspect was named by a `warning` that sees the fault go.
    fn date_naming(&mut self, warning: &Warning, coincidence: Span) {
        let by_observer =
            matches!(self.incident.namer(), Some(WarningPlace::Fde1 | WarningPlace::Fde2));
        let (begin, has_returned) = (self.incident.begin, self.has_returned && by_observer);
        let Some(named) = &mut self.incident.named else { return };
        if named.at == warning.timestamp && named.at.since(begin) > coincidence {
            named.by_its_end |= has_returned;
        }
    }
}
