//! From the two passes over a recording to a proposal.

use super::catalogue::Catalogue;
use super::cylinders::{self, Assembled};
use super::pairing::{Field, Twins};
use super::tally::BusTally;
use super::track::Tracks;
use super::words::{Hint, Measure, measure, says};
use super::{Proposal, guessing, machine};

/// Most periods of the bus that are looked at, the one with the most signals first.
const MOST_CLASSES: usize = 8;

/// Most signals whose values are kept, the most promising of all periods.
const MOST_SIGNALS: usize = 192;

/// Most signals that may be the platform's state.
const MOST_STATES: usize = 16;

/// Prepares the second pass over a recording and concludes from it.
#[derive(Clone, Debug)]
pub struct Finder {
    /// One for each period of the bus.
    tracks: Vec<Tracks>,
    /// Signals that move and were left out, since there are too many.
    left_out: usize,
}

impl Finder {
    /// The second pass, by what the first one counted.
    pub fn new(catalogue: &Catalogue<'_>, tally: &BusTally) -> Self {
        let mut classes = tally.classes();
        classes.truncate(MOST_CLASSES);
        let mut promising: Vec<usize> =
            classes.iter().flat_map(|(_, signals)| signals).copied().collect();
        promising.sort_by_key(|signal| std::cmp::Reverse(promise(catalogue, *signal)));
        let left_out = promising.split_off(promising.len().min(MOST_SIGNALS));
        let mut tracks = Vec::new();
        let states: Vec<usize> =
            machine::state_candidates(catalogue, tally).into_iter().take(MOST_STATES).collect();
        for (period, mut signals) in classes {
            signals.retain(|signal| !left_out.contains(signal));
            let Some(opener) = tally.opener(period).filter(|_| signals.len() > 1) else { continue };
            signals.extend(states.iter().filter(|state| !tally.signals[**state].moves()));
            tracks.push(Tracks::new(catalogue, period, opener, &signals));
        }
        Self { tracks, left_out: left_out.len() }
    }

    /// Takes the next frame of the second pass, `t` seconds after the first one.
    pub fn take(&mut self, catalogue: &Catalogue<'_>, t: f64, frame: &tertius_core::frame::Frame) {
        for tracks in &mut self.tracks {
            tracks.take(catalogue, t, frame);
        }
    }
}

/// How much a signal promises by its unit and name.
fn promise(catalogue: &Catalogue<'_>, signal: usize) -> u8 {
    let unit = match measure(catalogue.unit(signal)) {
        Measure::Length => 3,
        Measure::Speed => 2,
        Measure::Open => 1,
        Measure::Pressure | Measure::Other => 0,
    };
    let name = catalogue.name(signal);
    unit + u8::from([Hint::Position, Hint::Command].iter().any(|hint| says(name, *hint))) * 4
}

/// The proposal of a recording; by names alone, if nothing moves in it or there is none.
pub fn find(catalogue: &Catalogue<'_>, tally: &BusTally, finder: Option<&Finder>) -> Proposal {
    let mut lacks = Vec::new();
    let mut best: Option<(&Tracks, Vec<Twins>)> = None;
    let mut unlead = Vec::new();
    for tracks in finder.iter().flat_map(|finder| &finder.tracks) {
        let (driven, alone): (Vec<_>, Vec<_>) = Field::new(catalogue, tally, tracks)
            .twins()
            .into_iter()
            .partition(|twins| twins.command.is_some());
        unlead.extend(alone.into_iter().map(|twins| (tracks, twins)));
        if driven.len() > best.as_ref().map_or(0, |(_, twins)| twins.len()) {
            best = Some((tracks, driven));
        }
    }
    if let Some((why, count)) = &catalogue.refused {
        let others = if *count > 1 { format!(", and {} more", count - 1) } else { String::new() };
        lacks.push(format!("not looked at, as the DBC contradicts itself: {why}{others}"));
    }
    if let Some(left_out) = finder.map(|it| it.left_out).filter(|count| *count > 0) {
        lacks.push(format!("{left_out} of the signals that move were not looked at: too many"));
    }
    if finder.is_some() && tally.known > 0 && best.is_none() {
        lacks.push(stillness(catalogue, tally, &unlead));
    }
    let assembled = match &best {
        Some((tracks, twins)) => Some(cylinders::of_twins(catalogue, tally, tracks, twins)),
        None => guessing::by_names(catalogue, tally),
    };
    let tracks = best.as_ref().map(|(tracks, _)| *tracks);
    match assembled {
        Some(Assembled { cylinders, lacks: more }) => {
            lacks.extend(more);
            machine::proposal(catalogue, tally, tracks, &cylinders, lacks)
        }
        None => Proposal { lacks, ..Proposal::default() },
    }
}

/// Why a recording shows no cylinder.
fn stillness(catalogue: &Catalogue<'_>, tally: &BusTally, alone: &[(&Tracks, Twins)]) -> String {
    if let Some((_, twins)) = alone.first() {
        let [first, second] = twins.signals.map(|signal| catalogue.name(signal));
        return format!(
            "{first} and {second} agree while they move, but no signal of the same period leads their motion"
        );
    }
    let moving = tally.signals.iter().filter(|signal| signal.moves()).count();
    let recorded = tally.signals.iter().filter(|signal| signal.count > 0).count();
    format!(
        "of {recorded} signals in the recording {moving} move, and no two of them agree as two readings of one \
         length do; a recording of the machine in motion is needed"
    )
}
