//! Signals that share a bus with a cylinder, or seem to be one.

use super::likeness::{agreement, derivative, following, smooth};
use super::{BusTally, Catalogue, Finder, Proposal, find};
use tertius_core::frame::{Frame, Id, Kind};
use tertius_core::time::Timestamp;
use tertius_dbc::Database;

const PERIOD: f64 = 0.02;

/// A wave that no other one is like, between -1 and 1, or its derivative, 1/s.
#[derive(Clone, Copy)]
struct Wave([(f64, f64); 3]);

const MOTION: Wave = Wave([(0.5, 0.4), (1.0, 2.2), (1.7, 4.1)]);
const OTHER: Wave = Wave([(0.37, 1.4), (0.83, 0.3), (1.31, 5.9)]);

impl Wave {
    fn at(self, t: f64) -> f64 {
        self.0.iter().map(|(rate, phase)| (rate * t + phase).sin() / 3.0).sum()
    }

    fn speed(self, t: f64) -> f64 {
        self.0.iter().map(|(rate, phase)| rate * (rate * t + phase).cos() / 3.0).sum()
    }
}

/// A message with one signal: its time in the cycle, s, its unit, and what it reads.
struct Sender<'a> {
    offset: f64,
    unit: &'a str,
    name: &'a str,
    reading: &'a dyn Fn(f64) -> f64,
}

/// What is proposed for a minute of these senders, every cycle in the order of their offsets.
fn proposed(senders: &[Sender<'_>]) -> Proposal {
    let mut dbc = "VERSION \"\"\nBU_: M\n".to_owned();
    for (place, Sender { unit, name, .. }) in senders.iter().enumerate() {
        dbc += &format!(
            "BO_ {} M{place}: 2 M\n SG_ {name} : 0|16@1- (0.0001,0) [0|0] \"{unit}\" M\n",
            256 + place
        );
    }
    let database = Database::parse(&dbc).expect("a DBC");
    let catalogue = Catalogue::new(&database);
    let frames: Vec<(f64, Frame)> = (0..3000)
        .flat_map(|cycle| {
            senders.iter().enumerate().map(move |(place, sender)| {
                let t = f64::from(cycle) * PERIOD + sender.offset;
                let raw = ((sender.reading)(t) / 1e-4).round() as i16;
                let at = Timestamp::from_nanos((t * 1e9) as i64);
                let id = Id::standard(256 + place as u32).expect("an identifier");
                (t, Frame::new(at, id, Kind::Data, &raw.to_le_bytes()))
            })
        })
        .collect();
    let mut tally = BusTally::new(&catalogue);
    frames.iter().for_each(|(t, frame)| tally.take(&catalogue, *t, frame));
    let mut finder = Finder::new(&catalogue, &tally);
    frames.iter().for_each(|(t, frame)| finder.take(&catalogue, *t, frame));
    find(&catalogue, &tally, Some(&finder))
}

/// Two transducers, with what else is on the bus.
fn beside<'a>(offset: f64, others: impl IntoIterator<Item = Sender<'a>>) -> Proposal {
    let mut senders = Vec::from([
        Sender { offset, unit: "m", name: "X", reading: &|t| MOTION.at(t) },
        Sender {
            offset: offset + 4e-4,
            unit: "m",
            name: "X",
            reading: &|t| 0.98 * MOTION.at(t) + 0.01,
        },
    ]);
    senders.extend(others);
    senders.sort_by(|a, b| a.offset.total_cmp(&b.offset));
    proposed(&senders)
}

fn command(proposal: &Proposal) -> Option<&str> {
    proposal.line("signals.cylinder", "control_speed").map(|line| line.value.as_str())
}

#[test]
fn a_speed_that_is_sampled_later_in_the_cycle_does_not_lead() {
    let speed = |t: f64| MOTION.speed(t);
    let at = |offset| [Sender { offset, unit: "m/s", name: "Y", reading: &speed }];
    for offset in [0.002, 0.009, 0.017] {
        assert_eq!(beside(0.001, at(offset)).lines, [], "{offset} s");
    }
}

#[test]
fn a_command_that_is_sampled_before_the_readings_of_its_cycle_leads() {
    // A third of a cycle before the rod, and the cycle opens with it: it stands before the longest pause.
    let ahead = |t: f64| MOTION.speed(t + PERIOD / 3.0);
    let still = |_: f64| 0.0;
    let mut others = vec![Sender { offset: 0.0, unit: "m/s", name: "Y", reading: &ahead }];
    others.extend([0.003, 0.006, 0.009, 0.012].map(|offset| Sender {
        offset,
        unit: "",
        name: "Z",
        reading: &still,
    }));
    let proposal = beside(0.0145, others);
    assert_eq!(command(&proposal), Some("\"M0.Y\""), "{:?}", proposal.lacks);
}

#[test]
fn what_correlates_by_chance_has_to_be_called_a_command() {
    // Nine tenths of it are the speed.
    let mixed = |t: f64| MOTION.speed(t + 0.1) + 0.45 * OTHER.speed(t);
    let with = |unit, name| {
        let other = Sender { offset: 0.006, unit, name, reading: &mixed };
        command(&beside(0.001, [other])).map(str::to_owned)
    };
    assert_eq!(with("", "Y"), None);
    assert_eq!(with("m/s", "Y").as_deref(), Some("\"M2.Y\""));
    assert_eq!(with("", "ValveDemand").as_deref(), Some("\"M2.ValveDemand\""));
}

#[test]
fn slow_signals_lead_by_no_quarter_of_their_period() {
    // Of ten samples a second: a third reading of the same length, mirrored, is its speed 1.3 s later.
    let wave = |k: usize| (1.2 * 0.1 * k as f64).sin();
    let readings: Vec<f64> = (0..600).map(wave).collect();
    let mirrored: Vec<f64> = readings.iter().map(|x| -x).collect();
    let found = following(&derivative(&readings), &smooth(&mirrored), 0.1);
    assert_eq!(found, None);
    // Its speed two samples ahead is found there.
    let speed: Vec<f64> = (0..600).map(|k| (1.2 * 0.1 * (k as f64 + 2.0)).cos()).collect();
    let found = following(&derivative(&readings), &smooth(&speed), 0.1).expect("it leads");
    assert!((found.lead - 2.0).abs() < 0.1 && found.correlation > 0.99, "{found:?}");
}

#[test]
fn coarse_readings_of_one_length_agree() {
    // It rests for half of the time, where all readings are the same count; those of its motion count as well.
    let motion = |k: usize| 0.4 * k.saturating_sub(1600) as f64;
    for (gain, offset) in [(1.0, 0.2), (1.001, 0.1), (1.003, 0.4), (0.999, 0.0)] {
        let first: Vec<f64> = (0..3000).map(|k| (gain * motion(k) + offset).round()).collect();
        let second: Vec<f64> = (0..3000).map(|k| motion(k).round()).collect();
        let found = agreement(&first, &second, 1.0).expect("they move");
        assert!(found.share > 0.99 && found.spread < 0.6, "{gain} {offset}: {found:?}");
        assert!((found.gain - gain).abs() < 2e-3, "{gain} {offset}: {found:?}");
    }
}

#[test]
fn messages_that_cannot_be_used_are_told() {
    let dbc = "VERSION \"\"\nBU_: M\nBO_ 1 Twice: 8 M\n SG_ A : 0|16@1- (1,0) [0|0] \"m\" M\n \
               SG_ B : 8|16@1- (1,0) [0|0] \"m\" M\nBO_ 2 Once: 8 M\n SG_ A : 0|16@1- (1,0) [0|0] \"m\" M\n";
    let database = Database::parse(dbc).expect("a DBC");
    let catalogue = Catalogue::new(&database);
    let lacks = find(&catalogue, &BusTally::new(&catalogue), None).lacks;
    assert!(lacks.iter().any(|it| it.contains("message Twice")), "{lacks:?}");
}
