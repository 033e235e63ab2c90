//! A node on the bus that reads the gateway's frames, as the machine's controller would: by the DBC, and nothing else.

use crate::evaluate::stand::StandError;
use tertius_core::alarm::{OwnMessage, e2e};
use tertius_core::decode::SignalPlan;
use tertius_core::frame::{Frame, Id};
use tertius_core::time::{Span, Timestamp};
use tertius_dbc::Database;
use tertius_machine::plant::CYLINDERS;

/// A transducer that a warning blames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blamed {
    /// Cylinder index, from 0.
    pub leg: usize,
    /// 0: C1; 1: C2.
    pub which: usize,
    /// Fd_Warning.Detector.
    pub detector: u8,
    /// Fd_Warning.Fault, of its first table.
    pub fault: u8,
    /// Fd_Warning.Residual, m; `None` where it has none.
    pub residual: Option<f64>,
}

/// Reads Fd_Status, Fd_Warning and Fd_Estimate.
#[derive(Clone, Debug)]
pub struct Reader {
    status: Channel<1>,
    /// Time of the newest Fd_Status.
    alive: Option<Timestamp>,
    warning: Channel<7>,
    estimate: Channel<3>,
    /// Lengths of the newest cycle, m.
    lengths: [Option<f64>; CYLINDERS],
}

/// A message of the gateway: its signals, and its newest counter.
#[derive(Clone, Debug)]
struct Channel<const N: usize> {
    id: Id,
    signals: [SignalPlan; N],
    counter: Option<u8>,
}

/// A gateway without an Fd_Status for that long is not listened to: three of them are missing.
const SILENT: Span = Span::from_nanos(300_000_000);

/// Raw Fd_Warning.Residual of a warning without one, as dbc/e-type.dbc has it.
const NO_RESIDUAL: f64 = -32_768.0;

/// Fd_Warning.Suspect where C1 is blamed, and where C2 is.
const BLAMED: [f64; 2] = [1.0, 2.0];

impl Reader {
    /// A reader of the frames that `database` describes.
    ///
    /// # Errors
    /// It does not describe them.
    pub fn new(database: &Database) -> Result<Self, StandError> {
        let warning =
            ["Cylinder", "Detector", "Suspect", "Raised", "FaultTable", "Fault", "Residual"];
        Ok(Self {
            status: Channel::new(database, OwnMessage::Status, ["Mode"])?,
            alive: None,
            warning: Channel::new(database, OwnMessage::Warning, warning)?,
            estimate: Channel::new(
                database,
                OwnMessage::Estimate,
                ["Cylinder", "Valid", "Position"],
            )?,
            lengths: [None; CYLINDERS],
        })
    }

    /// Forgets the lengths of the cycle before.
    pub fn open(&mut self) {
        self.lengths = [None; CYLINDERS];
    }

    /// Lengths told of this cycle, m.
    pub const fn lengths(&self) -> [Option<f64>; CYLINDERS] {
        self.lengths
    }

    /// Takes a frame of the bus; the transducer that it blames. A frame that is damaged, repeated or somebody else's
    /// says nothing, nor does a gateway without a sign of life.
    pub fn take(&mut self, frame: &Frame) -> Option<Blamed> {
        if self.status.read(frame).is_some() {
            self.alive = Some(frame.timestamp);
        }
        if frame.timestamp.since(self.alive?) > SILENT {
            return None;
        }
        if let Some([cylinder, valid, position]) = self.estimate.read(frame) {
            if let Some(length) = leg(cylinder).and_then(|leg| self.lengths.get_mut(leg)) {
                *length = (valid == 1.0).then_some(position);
            }
            return None;
        }
        let [cylinder, detector, suspect, raised, table, fault, residual] =
            self.warning.read(frame)?;
        let which = BLAMED.iter().position(|blamed| *blamed == suspect)?;
        // The second table has faults of the process, which are no transducer's.
        if raised != 1.0 || table != 0.0 {
            return None;
        }
        let unit = self.warning.signals[6].factor().abs();
        let residual = Some(residual).filter(|it| (it / unit - NO_RESIDUAL).abs() > 0.5);
        let (leg, detector, fault) = (leg(cylinder)?, detector as u8, fault as u8);
        Some(Blamed { leg, which, detector, fault, residual })
    }
}

/// Index of a cylinder by its number on the bus.
fn leg(number: f64) -> Option<usize> {
    let leg = (number as usize).checked_sub(1)?;
    (leg < CYLINDERS).then_some(leg)
}

impl<const N: usize> Channel<N> {
    fn new(database: &Database, message: OwnMessage, names: [&str; N]) -> Result<Self, StandError> {
        let name = message.name();
        let unread = |error| StandError::Unread(format!("{error}"));
        let id = database.message(name).map_err(unread)?.id;
        let mut signals = Vec::with_capacity(N);
        for signal in names {
            let (_, signal) = database.signal(&format!("{name}.{signal}")).map_err(unread)?;
            signals.push(signal.plan.clone());
        }
        let signals = signals.try_into().expect("as many as there are names");
        Ok(Self { id, signals, counter: None })
    }

    /// The signals' values in a frame that is intact and new.
    fn read(&mut self, frame: &Frame) -> Option<[f64; N]> {
        if frame.id != self.id {
            return None;
        }
        let counter = e2e::check(frame.data(), self.id.value() as u16).ok()?;
        if self.counter.replace(counter) == Some(counter) {
            return None;
        }
        let mut values = [0.0; N];
        for (value, plan) in values.iter_mut().zip(&self.signals) {
            *value = plan.decode(frame).value()?.physical;
        }
        Some(values)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use tertius_core::alarm::status::Status;
    use tertius_core::alarm::{Detector, Encoder, Finding, Level, OwnFrame};
    use tertius_core::blame::Rule;
    use tertius_core::estimate::{Estimate, Source};
    use tertius_core::verdict::{Fault, Suspect};

    pub fn database() -> Database {
        let dbc = include_bytes!("../../../../../dbc/e-type.dbc");
        Database::parse(&tertius_dbc::text::from_bytes(dbc)).expect("it is sound")
    }

    fn at(milliseconds: i64) -> Timestamp {
        Timestamp::from_nanos(milliseconds * 1_000_000)
    }

    /// A gateway that was alive at 0 ms, and a reader that has heard of it.
    fn gateway() -> (Encoder, Reader) {
        let mut encoder = Encoder::new(81).expect("81 is a node");
        let mut reader = Reader::new(&database()).expect("it has them");
        let status = encoder.status(at(0), &Status::default());
        assert_eq!(reader.take(status.as_frame()), None);
        (encoder, reader)
    }

    fn warning(
        encoder: &mut Encoder,
        milliseconds: i64,
        suspect: Suspect,
        raised: bool,
    ) -> OwnFrame {
        let finding = Finding {
            fault: Fault::Abrupt,
            suspect,
            rule: Rule::OneObserver,
            level: Level::Yellow,
            residual: Some(-0.0601),
            threshold: None,
            evidence: None,
            device: None,
        };
        encoder.warning(at(milliseconds), 3, Detector::Fde2, &finding, raised)
    }

    #[test]
    fn a_warning_that_stands_blames_its_suspect() {
        let (mut encoder, mut reader) = gateway();
        let mut told = |suspect, raised| {
            let frame = warning(&mut encoder, 20, suspect, raised);
            reader.take(frame.as_frame())
        };
        let blamed = told(Suspect::C2, true).expect("C2 is blamed");
        assert_eq!((blamed.leg, blamed.which), (2, 1));
        assert_eq!((blamed.detector, blamed.fault), (Detector::Fde2 as u8, 1), "abrupt");
        assert!(blamed.residual.is_some_and(|it| (it + 0.0601).abs() < 1e-9), "{blamed:?}");
        assert_eq!(told(Suspect::C1, true).map(|it| it.which), Some(0));
        for suspect in [Suspect::Undecided, Suspect::Process] {
            assert_eq!(told(suspect, true), None, "{suspect:?} is no transducer");
        }
        assert_eq!(told(Suspect::C1, false), None, "it is cleared");
    }

    #[test]
    fn a_frame_that_is_damaged_or_repeated_says_nothing() {
        let (mut encoder, mut reader) = gateway();
        let frame = warning(&mut encoder, 20, Suspect::C1, true);
        let mut damaged = frame.as_frame().clone();
        damaged.buffer_mut()[4] ^= 2;
        assert_eq!(reader.take(&damaged), None);
        assert!(reader.take(frame.as_frame()).is_some());
        assert_eq!(reader.take(frame.as_frame()), None, "the counter stands still");
    }

    #[test]
    fn a_gateway_without_a_sign_of_life_is_not_listened_to() {
        let (mut encoder, mut reader) = gateway();
        let mut told = |reader: &mut Reader, milliseconds| {
            reader.take(warning(&mut encoder, milliseconds, Suspect::C1, true).as_frame()).is_some()
        };
        assert!(told(&mut reader, 300));
        assert!(!told(&mut reader, 301));
        let mut unheard = Reader::new(&database()).expect("it has them");
        assert!(!told(&mut unheard, 310), "it has never been alive");
    }

    #[test]
    fn a_length_is_that_of_its_cycle_and_only_where_it_is_valid() {
        let (mut encoder, mut reader) = gateway();
        for (cylinder, valid) in [(2, true), (5, false)] {
            let estimate =
                Estimate { position: 0.25, sigma: 1e-4, source: Source::Both, valid, without: 0.0 };
            let frame = encoder.estimate(at(20), cylinder, Some(&estimate));
            assert_eq!(reader.take(frame.as_frame()), None);
        }
        let [_, second, _, _, fifth, _] = reader.lengths();
        assert!(second.is_some_and(|it| (it - 0.25).abs() < 1e-4) && fifth.is_none());
        reader.open();
        assert_eq!(reader.lengths(), [None; CYLINDERS]);
    }
}
