//! The signals of each cylinder, by evidence first, and by name where there is none.

use super::catalogue::Catalogue;
use super::likeness::{following, smooth};
use super::naming;
use super::pairing::{SURE, Twins};
use super::pattern;
use super::tally::BusTally;
use super::track::Tracks;
use super::words::{Hint, Measure, measure, says};
use super::{Certainty, MOST_CYLINDERS, shown};
use std::collections::BTreeMap;

/// The keys of a cylinder's signals, in the order of the configuration.
pub(super) const KEYS: [&str; 12] = [
    "c1",
    "c1_velocity",
    "c1_status",
    "c1_counter",
    "c2",
    "c2_velocity",
    "c2_status",
    "c2_counter",
    "control_speed",
    "pressure_bottom",
    "pressure_rod",
    "spool",
];

/// A signal that was chosen for a key, and why.
#[derive(Clone, Debug)]
pub(super) struct Pick {
    pub signal: usize,
    pub certainty: Certainty,
    pub why: String,
}

/// The signals of one cylinder by their keys.
pub(super) type Picks = BTreeMap<&'static str, Pick>;

/// Cylinders in their order, and what is to be told of them.
pub(super) struct Assembled {
    pub cylinders: Vec<Picks>,
    pub lacks: Vec<String>,
}

/// The cylinders of pairs with a command.
pub(super) fn of_twins(
    catalogue: &Catalogue<'_>,
    tally: &BusTally,
    tracks: &Tracks,
    twins: &[Twins],
) -> Assembled {
    let mut lacks = Vec::new();
    if twins.len() > MOST_CYLINDERS {
        lacks.push(format!(
            "{} pairs of transducers with a command were found; a gateway monitors {MOST_CYLINDERS} cylinders, so the \
             others need one of their own",
            twins.len()
        ));
    }
    let assembly = Assembly { catalogue, tally, tracks };
    let names = |one: &Twins| {
        let command = one.command.map(|(signal, _)| signal);
        one.signals.into_iter().chain(command).map(|signal| catalogue.name(signal)).collect()
    };
    let named = naming::of_cylinders(&twins.iter().map(names).collect::<Vec<_>>());
    let mut cylinders: Vec<Picks> = twins
        .iter()
        .zip(&named)
        .map(|(one, name)| assembly.picks(one, name.as_deref(), &mut lacks))
        .collect();
    order(catalogue, &mut cylinders, &mut lacks);
    cylinders.truncate(MOST_CYLINDERS);
    Assembled { cylinders, lacks }
}

struct Assembly<'a> {
    catalogue: &'a Catalogue<'a>,
    tally: &'a BusTally,
    tracks: &'a Tracks,
}

impl Assembly<'_> {
    fn picks(&self, twins: &Twins, name: Option<&[String]>, lacks: &mut Vec<String>) -> Picks {
        let catalogue = self.catalogue;
        let order = naming::in_order(twins.signals.map(|signal| catalogue.name(signal)));
        let agreement = &twins.agreement;
        let unit = catalogue.unit(twins.signals[0]);
        let mut why = format!(
            "the two agree to {} over {} of travel",
            shown(agreement.spread, unit),
            shown(agreement.travel, unit)
        );
        if !(0.5..=2.0).contains(&agreement.gain) {
            lacks.push(format!(
                "{} is {:.3} times {}: scale the factor of one of them in the DBC",
                catalogue.name(twins.signals[0]),
                agreement.gain,
                catalogue.name(twins.signals[1])
            ));
            why += ", on different scales";
        }
        let mut picks = Picks::new();
        for (place, [position, velocity]) in
            order.into_iter().zip([["c1", "c1_velocity"], ["c2", "c2_velocity"]])
        {
            // That they are a pair is sure, and their order is not.
            let why = format!("{why}; which of them is C1 is told by their names alone");
            let signal = twins.signals[place];
            picks.insert(position, Pick { signal, certainty: Certainty::Guessed, why });
            if let Some((signal, found)) = twins.velocities[place] {
                let why =
                    format!("the derivative of {position}, correlation {:.3}", found.correlation);
                picks.insert(velocity, Pick { signal, certainty: Certainty::Sure, why });
            }
        }
        if let Some((signal, found)) = twins.command {
            let sure = found.correlation.abs() >= SURE;
            let certainty = if sure { Certainty::Sure } else { Certainty::Guessed };
            let sign = if found.correlation < 0.0 { ", in the other direction" } else { "" };
            let why = format!(
                "leads the rod's speed by {:.0} ms, correlation {:.3}{sign}",
                found.lead * self.tracks.period * 1e3,
                found.correlation.abs()
            );
            picks.insert("control_speed", Pick { signal, certainty, why });
            self.valve(signal, name, &mut picks);
        }
        beside_positions(catalogue, self.tally, &mut picks);
        picks
    }

    /// Pressures and spool, beside the command or elsewhere by their names.
    fn valve(&self, command: usize, name: Option<&[String]>, picks: &mut Picks) {
        pressures(self.catalogue, (command, name), picks);
        let driver = smooth(&self.tracks.clean(command));
        let spools = self.catalogue.answering(command, name).into_iter().filter_map(|signal| {
            let name = says(self.catalogue.name(signal), Hint::Spool);
            let unit = measure(self.catalogue.unit(signal));
            let used = picks.values().any(|pick| pick.signal == signal) || signal == command;
            if used
                || matches!(unit, Measure::Pressure)
                || !(name || self.tally.signals[signal].moves())
            {
                return None;
            }
            let spool = smooth(&self.tracks.clean(signal));
            let follows = following(&spool, &driver, self.tracks.period);
            let correlation = follows.map_or(0.0, |it| it.correlation.abs());
            // Elsewhere, readings of the rod follow the command, too.
            let is_beside = self.catalogue.beside(command).contains(&signal);
            (name || is_beside && correlation >= SURE).then_some((signal, correlation))
        });
        if let Some((signal, correlation)) = spools.max_by(|a, b| a.1.total_cmp(&b.1)) {
            let (certainty, why) = if correlation >= SURE {
                (Certainty::Sure, format!("follows the command, correlation {correlation:.3}"))
            } else {
                (Certainty::Guessed, "by its name".to_owned())
            };
            picks.insert("spool", Pick { signal, certainty, why });
        }
    }
}

/// The pressures beside the command, or of its cylinder: by their names, or two without a telling name in their order.
pub(super) fn pressures(
    catalogue: &Catalogue<'_>,
    (command, cylinder): (usize, Option<&[String]>),
    picks: &mut Picks,
) {
    let is_pressure = |signal: &usize| {
        let (name, unit) = (catalogue.name(*signal), catalogue.unit(*signal));
        unit == "bar" || unit.is_empty() && says(name, Hint::Pressure)
    };
    let found: Vec<usize> = catalogue
        .answering(command, cylinder)
        .into_iter()
        .filter(is_pressure)
        .filter(|signal| !says(catalogue.name(*signal), Hint::Supply))
        .collect();
    let named = |hint: Hint| {
        let own = |signal: usize| &catalogue.signals[signal].signal.name;
        found.iter().copied().find(|signal| says(own(*signal), hint))
    };
    let (sides, why) = match (named(Hint::Bottom), named(Hint::Rod), found.as_slice()) {
        (None, None, [first, second]) => {
            ([Some(*first), Some(*second)], "by its unit and its place beside the command")
        }
        (bottom, rod, _) => ([bottom, rod], "by its name and unit"),
    };
    for (key, signal) in ["pressure_bottom", "pressure_rod"].into_iter().zip(sides) {
        if let Some(signal) = signal {
            let pick = Pick { signal, certainty: Certainty::Guessed, why: why.to_owned() };
            picks.insert(key, pick);
        }
    }
}

/// Counters, status bits, and velocities that no motion has shown, in the messages of the positions.
pub(super) fn beside_positions(catalogue: &Catalogue<'_>, tally: &BusTally, picks: &mut Picks) {
    for (position, [velocity, status, counter]) in [
        ("c1", ["c1_velocity", "c1_status", "c1_counter"]),
        ("c2", ["c2_velocity", "c2_status", "c2_counter"]),
    ] {
        let Some(pick) = picks.get(position) else { continue };
        let position = pick.signal;
        for signal in catalogue.beside(position) {
            // Two readings in one message share its counter and status.
            let taken = |pick: &Pick| pick.signal == signal;
            let own = &catalogue.signals[signal].signal.name;
            let plan = &catalogue.signals[signal].signal.plan;
            if !catalogue.signals[position].signal.plan.is_on_page_of(plan) {
                continue;
            }
            let seen = &tally.signals[signal];
            let unit = measure(catalogue.unit(signal));
            let (key, certainty, why) = if seen.counts() {
                (counter, Certainty::Sure, "counts its frames".to_owned())
            } else if seen.count == 0 && says(own, Hint::Counter) {
                (counter, Certainty::Guessed, "by its name".to_owned())
            } else if says(own, Hint::Status) && (seen.count == 0 || seen.is_state()) {
                let why = if seen.is_zero() { "by its name; always 0 here" } else { "by its name" };
                (status, Certainty::Guessed, why.to_owned())
            } else if says(own, Hint::Velocity)
                && unit == Measure::Speed
                && !picks.values().any(taken)
            {
                (velocity, Certainty::Guessed, "by its name and unit".to_owned())
            } else {
                continue;
            };
            picks.entry(key).or_insert(Pick { signal, certainty, why });
        }
    }
}

/// Puts the cylinders into the order of their numbers, and adds those that their names tell of.
fn order(catalogue: &Catalogue<'_>, cylinders: &mut Vec<Picks>, lacks: &mut Vec<String>) {
    let names = |key: &str| -> Option<Vec<&str>> {
        cylinders.iter().map(|picks| Some(catalogue.name(picks.get(key)?.signal))).collect()
    };
    let required = ["c1", "c2", "control_speed"].map(names);
    let [Some(first), second, Some(command)] = &required else { return };
    let of_all = |numbers: &Vec<u32>| -> Option<(Vec<u32>, [String; 2])> {
        let of = |names: &Vec<&str>| pattern::of_numbers(names, numbers);
        second.as_ref().is_none_or(|names| of(names).is_some()).then_some(())?;
        Some((numbers.clone(), [of(first)?, of(command)?]))
    };
    let numbered = pattern::numbers(first).iter().find_map(of_all);
    let Some((numbers, patterns)) = numbered else {
        cylinders.sort_by_key(|picks| picks.get("c1").map(|pick| pick.signal));
        return;
    };
    let exists = |n: u32| {
        let has = |it: &String| catalogue.find(&it.replace(pattern::PLACE, &n.to_string()));
        patterns.iter().all(|pattern| has(pattern).is_some())
    };
    let most = (1..=MOST_CYLINDERS as u32).take_while(|n| exists(*n)).count() as u32;
    if numbers.iter().any(|n| *n > most) {
        cylinders.sort_by_key(|picks| picks.get("c1").map(|pick| pick.signal));
        return;
    }
    let mut places: Vec<Option<Picks>> = vec![None; most as usize];
    for (n, picks) in numbers.iter().zip(cylinders.drain(..)) {
        places[*n as usize - 1] = Some(picks);
    }
    for (n, _) in (1..).zip(&places).filter(|(_, place)| place.is_none()) {
        let n: u32 = n;
        lacks.push(format!(
            "cylinder {n} is proposed by its names alone: the recording does not show that its transducers agree \
             and follow its command"
        ));
    }
    cylinders.extend(places.into_iter().map(Option::unwrap_or_default));
    complete(catalogue, cylinders);
}

/// Adds the signals of a cylinder that are named like those of the others.
pub(super) fn complete(catalogue: &Catalogue<'_>, cylinders: &mut [Picks]) {
    for key in KEYS {
        let known: Vec<(u32, &str)> = (1..)
            .zip(cylinders.iter())
            .filter_map(|(n, picks)| Some((n, catalogue.name(picks.get(key)?.signal))))
            .collect();
        let (numbers, names): (Vec<u32>, Vec<&str>) = known.into_iter().unzip();
        let Some(pattern) = pattern::of_numbers(&names, &numbers) else { continue };
        for (n, picks) in (1_u32..).zip(cylinders.iter_mut()) {
            let name = pattern.replace(pattern::PLACE, &n.to_string());
            if let Some(signal) = catalogue.find(&name) {
                let why = "named like those of the other cylinders".to_owned();
                let pick = Pick { signal, certainty: Certainty::Guessed, why };
                picks.entry(key).or_insert(pick);
            }
        }
    }
}
