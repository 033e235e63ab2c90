//! The scale of the gateway's own Fd_Estimate, as given by the DBC.

use super::connector::Connector;
use super::flaw::Flaw;
use tertius_core::alarm::frames::{CountScale, ESTIMATE_LAYOUT, Encoder, EstimateScale};
use tertius_core::decode::Decoded;
use tertius_core::frame::{Frame, Kind};
use tertius_core::time::Timestamp;
use tertius_dbc::{LookupError, Message, Signal};

/// Name of the message in a DBC.
const NAME: &str = "Fd_Estimate";

/// Length of the gateway's frames, bytes.
const LENGTH: usize = 8;

/// Source of the scale, for messages.
enum Origin<'a> {
    Dbc {
        position: &'a Signal,
        sigma: &'a Signal,
    },
    /// The gateway's default, since the DBC has no such message.
    Gateway,
}

impl<'a> Connector<'a> {
    /// Encoder of the gateway's frames. Estimates that are sent have to fit their scale: a length
    /// of the stroke without a count would always be sent as invalid.
    pub(super) fn encoder(&mut self) -> Option<Encoder> {
        let encoder = Encoder::new(self.settings.gateway.node);
        if encoder.is_none() {
            self.flaws.push(Flaw::new("gateway.node", "not a CANopen node", "use 1 to 127"));
        }
        let sends = self.settings.estimate.send;
        match self.estimate_scale() {
            Ok((scale, origin)) => {
                if sends {
                    self.flaws.extend(self.misfits(scale, &origin));
                }
                encoder.map(|encoder| encoder.on_scale(scale))
            }
            Err(flaw) => {
                self.flaws.extend(sends.then_some(flaw));
                encoder
            }
        }
    }

    fn estimate_scale(&self) -> Result<(EstimateScale, Origin<'a>), Flaw> {
        const HELP: &str =
            "write it as dbc/e-type.dbc has it, with factors and offsets of your own";
        let flaw = |message: String| Flaw::new("bus.dbc", message, HELP);
        let message = match self.database.message(NAME) {
            Ok(message) => message,
            Err(LookupError::Message { .. }) => {
                return Ok((EstimateScale::default(), Origin::Gateway));
            }
            Err(error) => return Err(flaw(error.to_string())),
        };
        check_layout(message).map_err(flaw)?;
        let signal = |name: &str| {
            let lacks = || format!("line {} of the DBC: {NAME} has no {name}", message.line);
            message.signal(name).ok_or_else(lacks)
        };
        let (position, sigma) = (signal("Position").map_err(flaw)?, signal("Sigma").map_err(flaw)?);
        for signal in [position, sigma] {
            if !(signal.unit.is_empty() || signal.unit == "m") {
                let Signal { name, unit, line, .. } = signal;
                let found = format!("line {line} of the DBC: {NAME}.{name} is in {unit:?}");
                return Err(flaw(format!("{found}, expected \"m\"")));
            }
        }
        let scale = |signal: &Signal| CountScale {
            factor: signal.plan.factor(),
            offset: signal.plan.offset(),
        };
        let both = EstimateScale { position: scale(position), sigma: scale(sigma) };
        Ok((both, Origin::Dbc { position, sigma }))
    }

    /// What does not fit the scale.
    fn misfits(&self, scale: EstimateScale, origin: &Origin<'_>) -> Vec<Flaw> {
        const HELP: &str = "give the DBC an Fd_Estimate with a factor, an offset and a range that have \
                            room for it, or send no estimates";
        let (position, sigma, place) = match origin {
            Origin::Dbc { position, sigma } => (
                position.range,
                sigma.range,
                [position, sigma].map(|signal| format!("line {} of the DBC: ", signal.line)),
            ),
            Origin::Gateway => {
                let default = || format!("the DBC has no {NAME}, and on the gateway's own scale ");
                (None, None, [default(), default()])
            }
        };
        let mut flaws = Vec::new();
        let [lowest, highest] = self.settings.machine.stroke;
        let [least, most] = within(scale.lengths(), position);
        // The end of the stroke may be the count that no reading has.
        let count = scale.position.factor.abs() * (1.0 + 1e-6);
        if least > lowest + count || most < highest - count {
            let message = format!(
                "{}{NAME}.Position reaches from {least:.4} m to {most:.4} m, but `machine.stroke` is \
                 [{lowest:?}, {highest:?}]: lengths beyond that could never be sent",
                place[0]
            );
            flaws.push(Flaw::new("estimate.send", message, HELP));
        }
        let bound = self.settings.estimate.bound;
        let [_, most] = within([0.0, scale.largest_sigma()], sigma);
        // Without a rising scale there is no σ to be sent at all.
        if !(bound <= most * (1.0 + 1e-9) && scale.sigma.factor > 0.0) {
            let message = format!(
                "{}{NAME}.Sigma reaches to {most:.6} m, but `estimate.bound` is {bound:?}",
                place[1]
            );
            flaws.push(Flaw::new("estimate.bound", message, HELP));
        }
        flaws
    }
}

/// The part of `lengths` that is also within `range`.
fn within(lengths: [f64; 2], range: Option<[f64; 2]>) -> [f64; 2] {
    let [least, most] = lengths;
    range.map_or(lengths, |[low, high]| [least.max(low), most.min(high)])
}

/// Refuses bits or a checksum other than the gateway's: with such a DBC other nodes would read
/// nonsense.
fn check_layout(message: &Message) -> Result<(), String> {
    if message.length != LENGTH {
        let Message { line, length, .. } = message;
        return Err(format!(
            "line {line} of the DBC: {NAME} has {length} bytes, expected {LENGTH}"
        ));
    }
    for (name, start, length) in ESTIMATE_LAYOUT {
        let Some(signal) = message.signal(name) else { continue };
        if !stands_at(message, signal, start, length) {
            return Err(format!(
                "line {} of the DBC: {NAME}.{name} is not where the gateway sends it, \
                 {start}|{length}@1+",
                signal.line
            ));
        }
    }
    Ok(())
}

/// Whether `signal` is the unsigned little-endian number of `length` bits from bit `start` on, and no
/// other bit.
fn stands_at(message: &Message, signal: &Signal, start: u32, length: u32) -> bool {
    let all = (1_u64 << length) - 1;
    let field = all << start;
    [(0, 0), (1 << start, 1), (field, all), (!field, 0), (u64::MAX, all)].into_iter().all(
        |(payload, number)| {
            let data = payload.to_le_bytes();
            let frame = Frame::new(Timestamp::default(), message.id, Kind::Data, &data);
            let read = match signal.plan.decode(&frame) {
                Decoded::Value(value) => value.raw.as_i128(),
                Decoded::Absent | Decoded::Short => None,
            };
            read == Some(number.into())
        },
    )
}
