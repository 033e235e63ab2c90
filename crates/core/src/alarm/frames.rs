//! The gateway's own frames: Fd_Status, Fd_Warning and Fd_Estimate, protected by E2E profile 5, and
//! those of its CANopen services, where it is a node.

use super::detector::Detector;
use super::e2e;
pub use super::own::{FRAME_BITS, identifiers};
use super::own::{OwnContent, OwnFrame, OwnMessage};
pub use super::services::service_identifiers;
use super::status::Status;
use super::warning::Finding;
use crate::estimate::Estimate;
use crate::frame::Id;
use crate::state::state;
use crate::time::Timestamp;
use crate::verdict::{Fault, Suspect};

/// Length of one count of Fd_Warning.Residual, m.
const RESIDUAL_UNIT: f64 = 1e-5;

/// Length of one count of Fd_Warning.Threshold, m.
const THRESHOLD_UNIT: f64 = 5e-5;

/// Value of Fd_Warning.Threshold beyond its scale.
const THRESHOLD_BEYOND: u64 = 255;

/// Value of Fd_Warning.Residual where the detector has none.
const NO_RESIDUAL: i16 = i16::MIN;

/// Start bit and length of the signals of Fd_Estimate, all unsigned and little-endian.
pub const ESTIMATE_LAYOUT: [(&str, u32, u32); 6] = [
    ("Crc", 0, 16),
    ("Counter", 16, 8),
    ("Cylinder", 24, 3),
    ("Valid", 27, 1),
    ("Position", 32, 16),
    ("Sigma", 48, 16),
];

/// A scale of counts: value = count × factor + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CountScale {
    /// Length of one count, m.
    pub factor: f64,
    /// Length of count 0, m.
    pub offset: f64,
}

impl CountScale {
    /// The count of `metres`, not yet rounded.
    fn counts(self, metres: f64) -> f64 {
        (metres - self.offset) * self.factor.recip()
    }

    fn metres(self, count: u16) -> f64 {
        f64::from(count) * self.factor + self.offset
    }
}

/// Scales of Fd_Estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimateScale {
    pub position: CountScale,
    pub sigma: CountScale,
}

impl Default for EstimateScale {
    /// Lengths in counts of the default machine's transducers (5-3), σ in micrometres.
    fn default() -> Self {
        Self {
            position: CountScale { factor: 3.0 / 27_648.0, offset: -1.5 },
            sigma: CountScale { factor: 1e-6, offset: 0.0 },
        }
    }
}

impl EstimateScale {
    /// Shortest and longest length that can be sent, m.
    pub fn lengths(&self) -> [f64; 2] {
        let [one, other] = [1, u16::MAX].map(|count| self.position.metres(count));
        [one.min(other), one.max(other)]
    }

    /// Largest σ that can be sent, m.
    pub fn largest_sigma(&self) -> f64 {
        self.sigma.metres(SIGMA_BEYOND - 1)
    }

    /// The count of a position; count 0 means a transducer without a signal and is not used.
    fn position_counts(&self, position: f64) -> Option<u16> {
        let counts = libm::round(self.position.counts(position));
        (1.0..=f64::from(u16::MAX)).contains(&counts).then_some(counts as u16)
    }

    /// The count of σ, rounded up, so that the estimate is never presented as more certain than it
    /// is.
    fn sigma_counts(&self, sigma: f64) -> u16 {
        let counts = libm::ceil(self.sigma.counts(sigma));
        if counts.is_nan() { SIGMA_BEYOND } else { counts as u16 }
    }
}

/// Value of Fd_Estimate.Sigma beyond its scale, or where σ is not known.
const SIGMA_BEYOND: u16 = u16::MAX;

/// Makes the gateway's frames and keeps their alive counters.
#[derive(Clone, Debug)]
pub struct Encoder {
    /// In the order of [`OwnMessage::ALL`].
    channels: [Channel; OwnMessage::ALL.len()],
    scale: EstimateScale,
}

state! {
    Encoder { channels }
    but { scale }
}

#[derive(Clone, Debug)]
struct Channel {
    message: OwnMessage,
    id: Id,
    counter: u8,
}

state! {
    Channel { counter }
    but { message, id }
}

impl Encoder {
    /// The encoder of the gateway with CANopen node number `node`; `None` unless it is 1 to 127.
    pub fn new(node: u8) -> Option<Self> {
        let ids = identifiers(node)?;
        let channel = |i: usize| Channel { message: OwnMessage::ALL[i], id: ids[i], counter: 0 };
        Some(Self { channels: core::array::from_fn(channel), scale: EstimateScale::default() })
    }

    /// This encoder with estimates on another scale.
    pub const fn on_scale(self, scale: EstimateScale) -> Self {
        Self { scale, ..self }
    }

    /// The identifier of Fd_Status.
    pub const fn status_id(&self) -> Id {
        self.channels[OwnMessage::Status as usize].id
    }

    /// Encodes Fd_Status.
    pub fn status(&mut self, at: Timestamp, status: &Status) -> OwnFrame {
        let mut payload = Payload::default();
        for (n, pair) in status.transducers.iter().enumerate() {
            for (c, health) in pair.iter().enumerate() {
                payload.put(24 + 4 * n as u32 + 2 * c as u32, 2, health.bits());
            }
        }
        payload.put(48, 3, status.level as u64);
        payload.put(51, 3, status.mode as u64);
        payload.put(54, 6, u64::from(status.active_warnings).min(63));
        let channel = &mut self.channels[OwnMessage::Status as usize];
        payload.put(60, 3, status.without_c2(channel.counter));
        channel.protect(at, payload)
    }

    /// Encodes Fd_Warning.
    pub fn warning(
        &mut self,
        at: Timestamp,
        cylinder: u8,
        detector: Detector,
        finding: &Finding,
        raised: bool,
    ) -> OwnFrame {
        self.channels[OwnMessage::Warning as usize]
            .protect(at, Payload::of_warning(cylinder, detector, finding, raised))
    }

    /// Encodes Fd_Estimate. An estimate that is not valid, or does not fit the scales, has no
    /// position and is sent as invalid, never as the nearest length that fits.
    pub fn estimate(
        &mut self,
        at: Timestamp,
        cylinder: u8,
        estimate: Option<&Estimate>,
    ) -> OwnFrame {
        let sigma =
            self.scale.sigma_counts(estimate.map_or(f64::INFINITY, |estimate| estimate.sigma));
        let position = estimate
            .filter(|estimate| estimate.valid && sigma != SIGMA_BEYOND)
            .and_then(|estimate| self.scale.position_counts(estimate.position));
        let mut payload = Payload::default();
        payload.put(24, 3, u64::from(cylinder));
        payload.put(27, 1, u64::from(position.is_some()));
        payload.put(32, 16, u64::from(position.unwrap_or(0)));
        payload.put(48, 16, u64::from(sigma));
        self.channels[OwnMessage::Estimate as usize].protect(at, payload)
    }
}

impl Channel {
    fn protect(&mut self, at: Timestamp, payload: Payload) -> OwnFrame {
        let mut data = payload.0.to_le_bytes();
        // The data ID is the identifier, which has 11 bits.
        e2e::protect(&mut data, self.id.value() as u16, self.counter);
        self.counter = self.counter.wrapping_add(1);
        OwnFrame::new(OwnContent::Message(self.message), at, self.id, &data)
    }
}

/// Bytes 3 to 7 of the Fd_Warning of a finding, which an emergency message has, too.
pub fn warning_bytes(
    cylinder: u8,
    detector: Detector,
    finding: &Finding,
    raised: bool,
) -> [u8; 8 - e2e::HEADER] {
    let payload = Payload::of_warning(cylinder, detector, finding, raised).0.to_le_bytes();
    core::array::from_fn(|i| payload[e2e::HEADER + i])
}

/// A payload of eight bytes, little-endian.
#[derive(Default)]
struct Payload(u64);

impl Payload {
    fn of_warning(cylinder: u8, detector: Detector, finding: &Finding, raised: bool) -> Self {
        let mut payload = Self::default();
        payload.put(24, 3, u64::from(cylinder));
        payload.put(27, 3, detector as u64);
        let (table, fault) = fault_code(finding.fault);
        payload.put(30, 3, fault);
        payload.put(33, 2, suspect_code(finding.suspect));
        payload.put(35, 3, finding.level as u64);
        payload.put(38, 1, u64::from(raised));
        payload.put(39, 1, table);
        payload.put(40, 16, residual_counts(finding.residual) as u16 as u64);
        payload.put(56, 8, threshold_counts(finding.threshold));
        payload
    }

    /// Puts the low `length` bits of `value` at bit `start`.
    fn put(&mut self, start: u32, length: u32, value: u64) {
        self.0 |= (value & ((1 << length) - 1)) << start;
    }
}

fn residual_counts(residual: Option<f64>) -> i16 {
    // The conversion saturates; the lowest count is kept for "none".
    residual.map_or(NO_RESIDUAL, |r| (libm::round(r / RESIDUAL_UNIT) as i16).max(-i16::MAX))
}

fn threshold_counts(threshold: Option<f64>) -> u64 {
    threshold.map_or(0, |t| (libm::round(t / THRESHOLD_UNIT) as u64).min(THRESHOLD_BEYOND))
}

/// Values of Fd_Warning.FaultTable and Fd_Warning.Fault. The second table has the faults of the process; a reader
/// that does not know it sees a fault of the first one, beside a suspect that is the process.
pub const fn fault_code(fault: Fault) -> (u64, u64) {
    match fault {
        // The last two have no code of their own.
        Fault::Unclassified | Fault::NotCalibrated | Fault::ValveDeadBand => (0, 0),
        Fault::Abrupt => (0, 1),
        Fault::Noise => (0, 2),
        Fault::Incipient => (0, 3),
        Fault::OutOfRange => (0, 4),
        Fault::BrokenWire => (0, 5),
        Fault::Frozen => (0, 6),
        Fault::Stale => (0, 7),
        Fault::Leakage => (1, 1),
        Fault::ValveSticking => (1, 2),
        Fault::ValveOffset => (1, 3),
        Fault::Supply => (1, 4),
        Fault::Friction => (1, 5),
        Fault::PressureSensor => (1, 6),
        Fault::Command => (1, 7),
    }
}

const fn suspect_code(suspect: Suspect) -> u64 {
    match suspect {
        Suspect::Undecided => 0,
        Suspect::C1 => 1,
        Suspect::C2 => 2,
        Suspect::Process => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blame::Rule;
    use crate::estimate::Source;

    /// What a reader makes of a warning who knows nothing of the second table, and the table.
    fn told(fault: Fault, suspect: Suspect) -> [u64; 3] {
        let (residual, threshold, evidence, device) = (None, None, None, None);
        let level = crate::alarm::Level::Yellow;
        let rule = Rule::OneObserver;
        let finding =
            Finding { fault, suspect, rule, level, residual, threshold, evidence, device };
        let [low, high, ..] = warning_bytes(3, Detector::Process, &finding, true);
        let bits = u64::from(low) | u64::from(high) << 8;
        [bits >> 6 & 7, bits >> 9 & 3, bits >> 15]
    }

    #[test]
    fn faults_of_the_process_are_of_the_second_table_and_accuse_no_transducer() {
        let old = [
            Fault::Unclassified,
            Fault::Abrupt,
            Fault::Noise,
            Fault::Incipient,
            Fault::OutOfRange,
            Fault::BrokenWire,
            Fault::Frozen,
            Fault::Stale,
        ];
        for (code, fault) in (0..).zip(old) {
            assert_eq!(told(fault, Suspect::C1), [code, 1, 0], "{fault:?}");
        }
        for (fault, code) in [
            (Fault::Leakage, 1),
            (Fault::ValveSticking, 2),
            (Fault::ValveOffset, 3),
            (Fault::Supply, 4),
            (Fault::Friction, 5),
            (Fault::PressureSensor, 6),
            (Fault::Command, 7),
        ] {
            assert_eq!(told(fault, Suspect::Process), [code, 3, 1], "{fault:?}");
        }
        let of_no_table = |fault: &Fault| fault_code(*fault).0 == 0;
        assert_eq!(told(Fault::NotCalibrated, Suspect::Undecided), [0, 0, 0]);
        assert_eq!(told(Fault::ValveDeadBand, Suspect::Process), [0, 3, 0]);
        assert_eq!(Fault::ALL.iter().filter(|it| of_no_table(it)).count(), old.len() + 2);
    }

    /// Fields valid, position and σ of the frame for an estimate.
    fn sent(position: f64, sigma: f64, valid: bool) -> [u64; 3] {
        let estimate = Estimate { position, sigma, source: Source::Both, valid, without: 0.0 };
        let mut encoder = Encoder::new(81).expect("81 is a node");
        let frame = encoder.estimate(Timestamp::default(), 5, Some(&estimate));
        let data = frame.as_frame().data();
        let payload = u64::from_le_bytes(data.try_into().expect("eight bytes"));
        assert_eq!((frame.as_frame().id.value(), payload >> 24 & 7), (0x3D1, 5));
        [payload >> 27 & 1, payload >> 32 & 0xFFFF, payload >> 48]
    }

    #[test]
    fn an_estimate_is_on_the_scales_of_the_transducers() {
        assert_eq!(sent(0.0, 1.2e-4, true), [1, 13_824, 120]);
        assert_eq!(sent(1.5, 1.201e-4, true), [1, 27_648, 121], "never surer than it is");
        assert_eq!(sent(-1.5 + 3.0 / 27_648.0, 0.0, true), [1, 1, 0]);
    }

    #[test]
    fn scales_reach_as_far_as_their_counts() {
        let position = CountScale { factor: -1e-4, offset: 3.0 };
        let scale = EstimateScale { position, ..EstimateScale::default() };
        let [shortest, longest] = scale.lengths();
        assert!((shortest - (3.0 - 6.5535)).abs() < 1e-12, "{shortest}");
        assert!((longest - 2.9999).abs() < 1e-12, "count 0 is no length: {longest}");
        assert!((scale.largest_sigma() - 0.065_534).abs() < 1e-12, "65535 is anything beyond");
    }

    #[test]
    fn what_is_not_valid_or_has_no_place_on_the_scales_is_sent_as_invalid() {
        assert_eq!(sent(0.0, 1e-4, false), [0, 0, 100]);
        assert_eq!(sent(0.0, 0.065535, true), [0, 0, 65_535], "that much or more");
        for sigma in [0.2, f64::INFINITY, f64::NAN] {
            assert_eq!(sent(0.0, sigma, true), [0, 0, 65_535], "{sigma}");
        }
        for position in [-1.5, -1.6, 5.7, 1e9, f64::NAN, f64::NEG_INFINITY] {
            assert_eq!(sent(position, 1e-4, true), [0, 0, 100], "{position}");
        }
        let mut encoder = Encoder::new(81).expect("81 is a node");
        let nothing = encoder.estimate(Timestamp::default(), 1, None);
        assert_eq!(nothing.as_frame().data()[3..], [1, 0, 0, 0xFF, 0xFF]);
    }
}
