//! What all cylinders show together: of their sampling, of the supply, of the deck's attitude and of their stops.

use super::Monitor;
use super::cylinder::Cylinder;
use super::gate::Opening;
use super::sink::{Notice, Sink};
use crate::alarm::status::MAX_CYLINDERS;
use crate::decode::Value;
use crate::hexapod::{Inclination, Tilt, TiltChange, TiltLeg};
use crate::process::{OilSample, Process, ProcessParameters, SupplyWatch};
use crate::sequential::parameters::SamplingParameters;
use crate::sequential::{Archive, DwellHistory, Sampling, Sequential, stops};
use crate::time::Timestamp;

const _: () = assert!(MAX_CYLINDERS <= Sampling::MOST_CYLINDERS);

impl Monitor {
    /// Sequential detectors, with the numbers of their cylinders.
    pub fn sequential(&self) -> impl Iterator<Item = (u8, &Sequential)> {
        self.cylinders.iter().filter_map(Cylinder::sequential)
    }

    /// Makes the sequential detectors allow for the sampling that most of them see, and reports
    /// changes.
    pub(super) fn follow_sampling(&mut self, at: Timestamp, sink: &mut impl Sink) {
        if !self.clock.number().is_multiple_of(SamplingParameters::DEFAULT.every.into()) {
            return;
        }
        let Self { cylinders, sampling, .. } = self;
        let detectors = cylinders.iter().filter_map(Cylinder::sequential);
        let evidence = detectors.filter_map(|(_, detector)| detector.sampling());
        let (apart, change) = sampling.judge(evidence).unwrap_or_default();
        let detectors = cylinders.iter_mut().filter_map(Cylinder::sequential_mut);
        detectors.for_each(|detector| detector.allow(&apart));
        ask_others(cylinders);
        if let Some(changed) = change {
            sink.notice(&Notice::Timing { at, apart: changed.then_some(apart) });
        }
    }

    /// The supply of all cylinders, if it is watched.
    pub fn supply(&self) -> Option<&SupplyWatch> {
        self.supply.as_deref()
    }

    /// Judges the supply by all cylinders at the end of a cycle.
    pub(super) fn follow_supply(&mut self, at: Timestamp) {
        let odd = |cylinder: &Cylinder| cylinder.process().is_some_and(Process::has_odd_chambers);
        let odd = self.cylinders.iter().filter(|cylinder| odd(cylinder)).count();
        // All of them know the same.
        if odd > 0 || self.cylinders.first().is_some_and(|cylinder| cylinder.supply_is_odd) {
            self.follow_chambers(odd);
        }
        if self.supply.is_some() {
            self.watch_supply(at);
        }
    }

    /// Compares the supply's pressure with what all rods have taken.
    #[inline(never)]
    fn watch_supply(&mut self, at: Timestamp) {
        let is_open = self.gate.look(at).0 == Opening::Open;
        let Self { supply: Some(supply), cylinders, .. } = self else { return };
        supply.step(oil_sample(cylinders).as_ref(), is_open, at);
        if let Some((alarm, is_judging)) = supply.news() {
            for process in cylinders.iter_mut().filter_map(Cylinder::process_mut) {
                process.take_supply(alarm, is_judging);
            }
        }
    }

    /// Takes a cycle that did not come.
    pub(super) fn lose_supply(&mut self) {
        self.supply.iter_mut().for_each(|supply| supply.lose());
    }

    /// Forgets what was going on, after a time of which nothing is known.
    pub(super) fn interrupt_supply(&mut self) {
        self.supply.iter_mut().for_each(|supply| supply.interrupt());
    }

    /// Attributes chamber pressures that do not add up to the supply where most cylinders have them at once; `odd` do.
    #[cold]
    fn follow_chambers(&mut self, odd: usize) {
        let comparing = self.cylinders.iter().filter_map(Cylinder::process);
        let known = comparing.filter(|process| process.knows_chambers()).count();
        let ProcessParameters { many, least_many, .. } = ProcessParameters::DEFAULT;
        let is_odd = odd >= least_many && odd as f64 >= many * known as f64;
        self.cylinders.iter_mut().for_each(|cylinder| cylinder.supply_is_odd = is_odd);
    }

    /// The comparison of the deck's attitude with a sensor on it, if there is one.
    pub fn tilt(&self) -> Option<&Tilt> {
        self.tilt.as_deref()
    }

    /// Compares the deck's attitude at the end of a cycle, and tells the cylinders whose readings have parted, or whose only one
    /// is off.
    #[inline]
    pub(super) fn follow_tilt(&mut self, at: Timestamp) {
        if self.tilt.is_some() {
            self.compare_tilt(at);
        }
    }

    #[inline(never)]
    fn compare_tilt(&mut self, at: Timestamp) {
        let is_open = self.gate.look(at).0 == Opening::Open;
        let Self { tilt: Some(tilt), cylinders, .. } = self else { return };
        if !is_open {
            // On its stops the deck stands otherwise: what is usual there is another tilt.
            tilt.forget();
            return;
        }
        let leg = |leg: usize| cylinders.get(leg).map_or(TiltLeg::default(), Cylinder::tilt_leg);
        let judgement = tilt.step(&core::array::from_fn(leg));
        for (cylinder, nats) in cylinders.iter_mut().zip(judgement.parted) {
            if let Some(nats) = nats {
                cylinder.take_attitude_evidence(nats);
            }
        }
        let Some(change) = judgement.change else { return };
        // A machine may monitor fewer cylinders than it has legs.
        let Some(cylinder) = cylinders.get_mut(change.leg()) else { return };
        match change {
            TiltChange::Moved(error) => cylinder.take_tilt_error(at, &error),
            TiltChange::Returned(_) => cylinder.end_tilt_error(),
        }
    }

    /// Restores the dwells of an earlier monitor of the same machine.
    pub fn restore(&mut self, archive: &Archive) {
        for (cylinder, dwells) in self.cylinders.iter_mut().zip(&archive.cylinders) {
            cylinder.restore(dwells);
        }
    }

    /// Cylinder number and readings on the stop of each cylinder that keeps them.
    pub fn dwells(&self) -> impl Iterator<Item = (u8, &DwellHistory)> {
        self.cylinders.iter().filter_map(Cylinder::dwells)
    }

    /// Saves the dwells in `archive`. The dwells there of a cylinder that keeps none stay.
    pub fn save(&self, archive: &mut Archive) {
        for (n, dwells) in self.dwells() {
            if let Some(place) = archive.cylinders.get_mut(usize::from(n).wrapping_sub(1)) {
                place.clone_from(dwells);
            }
        }
    }

    /// Judges every cylinder after a rod was read on its stop. The others serve as the thermometer,
    /// so each is judged again with each reading.
    pub(super) fn judge_stops(&mut self, at: Timestamp) {
        let judged = stops::judge(self.dwells().map(|(_, dwells)| dwells));
        let known = self.cylinders.iter_mut().filter(|cylinder| cylinder.dwells().is_some());
        for (cylinder, judgement) in known.zip(judged) {
            if let Some(judgement) = judgement {
                cylinder.judge_stop(at, &judgement);
            }
        }
    }
}

/// Asks the other cylinders, for each with an alarm without a suspect, whether the sampling may be
/// the cause.
fn ask_others(cylinders: &mut [Cylinder]) {
    for index in 0..cylinders.len() {
        let Some(claim) = cylinders[index].sequential().and_then(|(_, it)| it.claim()) else {
            continue;
        };
        let others = cylinders.iter().enumerate().filter(|(other, _)| *other != index);
        let others = others.filter_map(|(_, cylinder)| cylinder.sequential());
        let evidence = others.filter_map(|(_, detector)| detector.evidence(&claim));
        let may_be_timing = !claim.is_contradicted(evidence);
        if let Some(detector) = cylinders[index].sequential_mut() {
            detector.allow_timing(may_be_timing);
        }
    }
}

/// The supply's pressure and every rod's length in the newest cycle; `None` if anything is missing.
fn oil_sample(cylinders: &[Cylinder]) -> Option<OilSample> {
    let mut sample = OilSample::default();
    for (length, cylinder) in sample.lengths.iter_mut().zip(cylinders) {
        let oil = cylinder.process()?.oil();
        *length = oil.length?;
        sample.pressure = oil.pressure?;
    }
    Some(sample)
}

/// Puts an angle where it is compared; returns 1 if no machine stands like that, or else 0.
pub(super) fn put_angle(tilt: Option<&mut Tilt>, which: Inclination, value: Value) -> u64 {
    u64::from(!tilt.is_none_or(|it| it.put(which, value.physical)))
}
