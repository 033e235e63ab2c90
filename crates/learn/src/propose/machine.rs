//! What a machine has once: its sample time, its Sync, the platform's state, stroke and supply pressure.

use super::catalogue::Catalogue;
use super::cylinders::{KEYS, Picks};
use super::likeness::ends;
use super::naming;
use super::pattern;
use super::tally::BusTally;
use super::track::Tracks;
use super::words::{Hint, says};
use super::{Certainty, NAMES, Proposal, ProposedLine, quoted};
use std::collections::BTreeMap;
use tertius_config::LONGEST_TAG;
use tertius_config::units::conversion;
use tertius_core::frame::Id;
use tertius_dbc::Signal;

/// Identifier of CANopen's SYNC.
const SYNC_ID: u32 = 0x080;

/// Share of a rod's way in a state from which its observers are to judge there.
const MOSTLY_MOVES: f64 = 0.25;

/// The sample time of a machine whose recording does not show it, s.
const USUAL_TIME: f64 = 0.02;

/// The usual bit rate of such a bus, bit/s.
const USUAL_BITRATE: u32 = 500_000;

/// The difference of C1 and C2 at which the thesis's machine trips, m.
const USUAL_CRITICAL: f64 = 0.05;

/// Number of names that a platform's state has at least.
const LEAST_NAMES: usize = 2;

struct Writer<'a> {
    catalogue: &'a Catalogue<'a>,
    tally: &'a BusTally,
    tracks: Option<&'a Tracks>,
    proposal: Proposal,
}

/// The whole proposal of a machine with these cylinders.
pub(super) fn proposal(
    catalogue: &Catalogue<'_>,
    tally: &BusTally,
    tracks: Option<&Tracks>,
    cylinders: &[Picks],
    lacks: Vec<String>,
) -> Proposal {
    let proposal = Proposal { lacks, ..Proposal::default() };
    let mut writer = Writer { catalogue, tally, tracks, proposal };
    let certainty = if tracks.is_some() { Certainty::Sure } else { Certainty::Guessed };
    let why = "as many pairs of transducers with a command";
    writer.line("machine", "cylinders", cylinders.len().to_string(), (certainty, why.to_owned()));
    writer.sample_time();
    writer.stroke(cylinders);
    let state = writer.state(cylinders);
    writer.bitrate();
    writer.sync();
    if let Some((signal, line)) = state {
        writer.line("signals", "state", quoted(catalogue.name(signal)), line);
        writer.proposal.lacks.push(
            "in which states the rods stand on their mechanical stops: set sequential.stop_states, or nothing is \
             read there"
                .to_owned(),
        );
    }
    writer.supply();
    for key in KEYS {
        writer.cylinder_key(key, cylinders);
    }
    writer.critical(cylinders);
    writer.names(cylinders);
    writer.proposal
}

/// Signals that may be the platform's state, the likeliest first.
pub(super) fn state_candidates(catalogue: &Catalogue<'_>, tally: &BusTally) -> Vec<usize> {
    let points = |signal: usize| {
        let listed = &catalogue.signals[signal];
        let named = listed.signal.values.len() >= LEAST_NAMES;
        let own = &listed.signal.name;
        let says = says(own, Hint::State) && !says(own, Hint::Status);
        let few = tally.signals[signal].count == 0 || tally.signals[signal].is_state();
        if few { 2 * u8::from(named) + u8::from(says) } else { 0 }
    };
    let all = 0..catalogue.signals();
    let mut found: Vec<usize> = all.filter(|signal| points(*signal) > 0).collect();
    found.sort_by_key(|signal| std::cmp::Reverse(points(*signal)));
    found
}

impl Writer<'_> {
    fn line(
        &mut self,
        table: &'static str,
        key: &'static str,
        value: String,
        (certainty, why): (Certainty, String),
    ) {
        self.proposal.lines.push(ProposedLine { table, key, value, certainty, why });
    }

    fn sample_time(&mut self) {
        let found = self.tracks.map(Tracks::mean_period);
        let Some(period) = found else {
            let why = "no recording shows it".to_owned();
            return self.line(
                "machine",
                "sample_time",
                USUAL_TIME.to_string(),
                (Certainty::Guessed, why),
            );
        };
        // A clock runs slightly fast or slow; nobody sets 19.98 ms.
        let steps =
            [1e-2, 1e-3, 1e-4, 1e-5].into_iter().map(|step| ((period / step).round() * step, step));
        let near =
            |(rounded, _): &(f64, f64)| (rounded / period - 1.0).abs() < 3e-3 && *rounded > 0.0;
        let (rounded, step) = steps.clone().find(near).unwrap_or((period, 1e-6));
        let digits = (-step.log10()).round() as usize;
        let why = format!("{} comes every {:.3} ms", self.opener(), period * 1e3);
        let value = format!("{rounded:.digits$}");
        let value =
            if value.contains('.') { value.trim_end_matches('0').to_owned() } else { value };
        self.line("machine", "sample_time", value, (Certainty::Sure, why));
    }

    fn bitrate(&mut self) {
        let why = "the usual rate; correct it if the bus has another one".to_owned();
        self.line("bus", "bitrate", USUAL_BITRATE.to_string(), (Certainty::Guessed, why));
    }

    /// The limit of C1 − C2 at which the machine itself trips, which is in its controller and on no bus.
    fn critical(&mut self, cylinders: &[Picks]) {
        if !cylinders.iter().any(|picks| picks.contains_key("c2")) {
            return;
        }
        let why = "the limit of another machine (thesis); correct it to the C1 − C2, m, at which this one trips";
        let value = format!("{USUAL_CRITICAL:?}");
        self.line("comparator", "critical", value, (Certainty::Guessed, why.to_owned()));
    }

    fn opener(&self) -> String {
        let opener = self.tracks.map(Tracks::opener);
        opener.map_or(String::new(), |message| self.catalogue.messages[message].name.clone())
    }

    fn stroke(&mut self, cylinders: &[Picks]) {
        let signals: Vec<usize> =
            cylinders.iter().filter_map(|picks| Some(picks.get("c1")?.signal)).collect();
        let Some(&first) = signals.first() else { return };
        let unit = self.catalogue.unit(first).to_owned();
        let known = conversion(&unit);
        if known.is_none() && !unit.is_empty() {
            self.proposal.lacks.push(format!(
                "{} is in {unit:?}, which is not known: lengths are metres; scale factor, offset and range of the \
                 positions in the DBC to \"m\" (`tertius check` names each one), and the stroke below with them",
                self.catalogue.name(first)
            ));
        }
        let [times, per] = known.unwrap_or([1.0; 2]);
        let ranges: Option<Vec<[f64; 2]>> =
            signals.iter().map(|signal| self.catalogue.signals[*signal].signal.range).collect();
        let outward = |[low, high]: [f64; 2]| {
            // Beyond the counts at the ends, which are no round numbers.
            let step = 10_f64.powf(((high - low).log10() - 3.0).round());
            [(low / step).floor() * step, (high / step).ceil() * step]
        };
        let of = |ranges: &[[f64; 2]]| {
            let lows: Vec<f64> = ranges.iter().flatten().copied().collect();
            let (low, high) = ends(&lows);
            outward([low, high].map(|end| end * times / per))
        };
        let (ends, line) = match ranges {
            Some(ranges) => {
                (of(&ranges), (Certainty::Guessed, "the range of C1 in the DBC".to_owned()))
            }
            None => {
                let seen = |signal: &usize| {
                    let tally = &self.tally.signals[*signal];
                    (tally.count > 0).then_some([tally.low, tally.high])
                };
                let ranges: Vec<[f64; 2]> = signals.iter().filter_map(seen).collect();
                if ranges.is_empty() {
                    let why = "neither the DBC nor a recording tells it: correct it".to_owned();
                    ([-1.0, 1.0], (Certainty::Guessed, why))
                } else {
                    let why =
                        "where the recording has been; the rods may reach further: correct it";
                    (of(&ranges), (Certainty::Guessed, why.to_owned()))
                }
            }
        };
        let number = |value: f64| {
            let rounded = (value * 1e6).round() / 1e6;
            format!("{:?}", if rounded == 0.0 { 0.0 } else { rounded })
        };
        self.line("machine", "stroke", format!("[{}, {}]", number(ends[0]), number(ends[1])), line);
    }

    fn sync(&mut self) {
        let catalogue = self.catalogue;
        let opener = self.tracks.map(Tracks::opener);
        let is_sync = |place: usize| {
            let message = catalogue.messages[place];
            let name = message.name.to_lowercase();
            let counts = |signal: &Signal| says(&signal.name, Hint::Counter);
            message.length <= 1
                || (!message.signals.is_empty() && message.signals.iter().all(counts))
                || name.contains("sync")
                || Some(message.id) == Id::standard(SYNC_ID)
        };
        let named = || {
            (0..catalogue.messages())
                .find(|place| catalogue.messages[*place].name.to_lowercase().starts_with("sync"))
        };
        if let Some(opener) = opener.filter(|place| is_sync(*place)) {
            let gap = self.tally.gap(opener) * 1e3;
            let why = format!("opens each cycle, after {gap:.1} ms without a frame");
            let name = quoted(&catalogue.messages[opener].name);
            return self.line("signals", "sync", name, (Certainty::Sure, why));
        }
        match named().filter(|_| opener.is_none()) {
            Some(place) => {
                let name = quoted(&catalogue.messages[place].name);
                self.line("signals", "sync", name, (Certainty::Guessed, "by its name".to_owned()));
            }
            None => self.proposal.lacks.push(
                "no message such as Sync opens each cycle: the first reading of a cycle does"
                    .to_owned(),
            ),
        }
    }

    /// The platform's state, and the states in which the machine moves.
    fn state(&mut self, cylinders: &[Picks]) -> Option<(usize, (Certainty, String))> {
        let used = |signal: usize| {
            let of = |picks: &Picks| {
                picks.values().any(|pick| self.catalogue.beside(pick.signal).contains(&signal))
            };
            cylinders.iter().any(of)
        };
        let candidates = state_candidates(self.catalogue, self.tally);
        let found = candidates.into_iter().find(|signal| {
            let own = &self.catalogue.signals[*signal].signal.name;
            !used(*signal) && says(own, Hint::State)
        });
        let Some(signal) = found else {
            self.proposal.lacks.push(
                "no signal is the platform's state by its name: FDE1 and FDE2 would always judge"
                    .to_owned(),
            );
            return None;
        };
        let ways = self.ways(signal, cylinders);
        let total: f64 = ways.values().sum();
        let moving: Vec<i64> = ways
            .iter()
            .filter(|(_, way)| **way >= MOSTLY_MOVES * total && total > 0.0)
            .map(|it| *it.0)
            .collect();
        let name = |number: i64| {
            let name = self.catalogue.signals[signal].signal.value_name(number);
            name.map_or_else(|| number.to_string(), str::to_owned)
        };
        let names: Vec<String> = moving.iter().map(|number| name(*number)).collect();
        let told = (
            Certainty::Guessed,
            match ways.len() {
                0 | 1 => "by its name".to_owned(),
                seen => format!("by its name; {seen} states in the recording"),
            },
        );
        if names.is_empty() {
            self.proposal.lacks.push(
                "no recording shows in which states the machine moves: set machine.monitored_states, or FDE1 and \
                 FDE2 always judge"
                    .to_owned(),
            );
        } else {
            let list = names.iter().map(|name| quoted(name)).collect::<Vec<_>>().join(", ");
            let share = moving.iter().filter_map(|number| ways.get(number)).sum::<f64>() / total;
            let certainty = if ways.len() > 1 { Certainty::Sure } else { Certainty::Guessed };
            let why = format!("{:.0} % of the rods' way is made there", 100.0 * share);
            self.line("machine", "monitored_states", format!("[{list}]"), (certainty, why));
        }
        Some((signal, told))
    }

    /// The rods' way in each value of a state.
    fn ways(&self, state: usize, cylinders: &[Picks]) -> BTreeMap<i64, f64> {
        let mut ways = BTreeMap::new();
        let Some(tracks) = self.tracks else { return ways };
        let states = tracks.held(state);
        let plan = &self.catalogue.signals[state].signal.plan;
        for signal in cylinders.iter().filter_map(|picks| Some(picks.get("c1")?.signal)) {
            let values = tracks.clean(signal);
            // Over some cycles, so that the noise of a rod at rest is no way.
            let far = 8;
            for k in (far..values.len().min(states.len())).step_by(far) {
                let way = (values[k] - values[k - far]).abs();
                if way.is_finite() && states[k].is_finite() {
                    *ways.entry(plan.unscaled(states[k]).round() as i64).or_insert(0.0) += way;
                }
            }
        }
        ways
    }

    fn supply(&mut self) {
        let catalogue = self.catalogue;
        let is_supply = |signal: &usize| {
            catalogue.unit(*signal) == "bar"
                && says(&catalogue.signals[*signal].signal.name, Hint::Supply)
        };
        if let Some(signal) = (0..catalogue.signals()).find(is_supply) {
            let line = (Certainty::Guessed, "by its name and unit".to_owned());
            self.line("signals", "supply", quoted(catalogue.name(signal)), line);
        } else {
            let lack = "supply: nothing found that its name calls the supply's pressure in bar";
            self.proposal.lacks.push(lack.to_owned());
        }
    }

    /// The names by which the signals tell the cylinders apart; none where one of them has none, as with numbers.
    fn names(&mut self, cylinders: &[Picks]) {
        let catalogue = self.catalogue;
        let own = |picks: &Picks| -> Vec<&str> {
            let keys = ["c1", "c2", "control_speed"].into_iter();
            keys.filter_map(|key| Some(catalogue.name(picks.get(key)?.signal))).collect()
        };
        let signals: Vec<Vec<&str>> = cylinders.iter().map(own).collect();
        let found = naming::of_cylinders(&signals);
        let spelled = signals.iter().zip(&found).map(|(own, words)| {
            let name = naming::spelled(own.first()?, words.as_deref()?)?;
            (name.chars().count() <= LONGEST_TAG).then(|| name.to_owned())
        });
        let Some(names) = spelled.collect::<Option<Vec<String>>>() else { return };
        let list: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        let why = "what the names of each one's signals have in common".to_owned();
        self.proposal.names = names;
        let (table, key) = NAMES;
        self.line(table, key, format!("[{}]", list.join(", ")), (Certainty::Guessed, why));
    }

    fn cylinder_key(&mut self, key: &'static str, cylinders: &[Picks]) {
        let picks: Option<Vec<_>> = cylinders.iter().map(|picks| picks.get(key)).collect();
        let Some(picks) = picks else {
            let having = cylinders.iter().filter(|picks| picks.contains_key(key)).count();
            let lack = match having {
                0 if ["c1_velocity", "c2_velocity", "pressure_bottom", "pressure_rod", "spool"]
                    .contains(&key) =>
                {
                    format!("{key}: nothing found")
                }
                0 => return,
                _ => format!(
                    "{key}: found for {having} of {} cylinders only, and left out",
                    cylinders.len()
                ),
            };
            return self.proposal.lacks.push(lack);
        };
        let names: Vec<&str> = picks.iter().map(|pick| self.catalogue.name(pick.signal)).collect();
        let certainty = picks.iter().map(|pick| pick.certainty).min().unwrap_or(Certainty::Guessed);
        // The least certain one speaks for all.
        let why =
            picks.iter().find(|pick| pick.certainty == certainty).map(|pick| pick.why.clone());
        let sure = picks.iter().filter(|pick| pick.certainty == Certainty::Sure).count();
        let mut why = why.unwrap_or_default();
        if certainty == Certainty::Guessed && sure > 0 {
            why = format!("{why}; of {sure} cylinders the recording shows it");
        } else if certainty == Certainty::Sure && picks.len() > 1 {
            why = format!("{why} (cylinder 1)");
        }
        self.line("signals.cylinder", key, quoted(&pattern::pattern(&names)), (certainty, why));
    }
}
