//! From a draft to a message that is known to be sound.

use std::collections::HashSet;

use can_dbc::{ByteOrder, NumericValue, SignalExtendedValueType};

use super::draft::{Draft, DraftSignal};
use super::finding::{Concern, Finding, Findings, Severity};
use super::message::{Message, Signal};
use super::multiplex::{Routes, disjoint, is_float, is_multiplexor, is_signed};
use super::parse_error::ParseError;
use tertius_core::decode::{BitField, MultiplexGate, NoField, NumberForm, SignalPlan};
use tertius_core::frame::{Id, MAX_DATA};

/// Steps that the search for overlaps may take in one DBC: less than a second, and more than an
/// honest file needs.
pub(super) const OVERLAP_STEPS: u64 = 100_000_000;

const EXTENDED_FLAG: u64 = 1 << 31;

/// Judges `draft` and compiles it; `None` if it has an error, which then stands in its `refused`.
///
/// # Errors
/// `steps` are used up.
pub(super) fn compile(
    draft: &mut Draft,
    findings: &mut Findings,
    steps: &mut u64,
) -> Result<Option<Message>, ParseError> {
    let mut own = Vec::new();
    let id = message_id(draft, &mut own);
    check_message(draft, &mut own);
    let fields: Vec<Option<BitField>> =
        draft.signals.iter().map(|signal| check_signal(draft, signal, &mut own)).collect();
    let mut routes = Routes::resolve(draft);
    own.append(&mut routes.findings);
    let sound = |own: &[Finding]| own.iter().all(|found| found.severity < Severity::Error);
    // Overlaps are looked for among signals whose places and multiplexors are known.
    if sound(&own) {
        check_overlaps(draft, &fields, &routes, &mut own, steps)?;
    }
    let usable = sound(&own) && draft.refused.is_none();
    for finding in own {
        draft.judge(finding, findings);
    }
    let (true, Some(id), Some(fields)) =
        (usable, id, fields.into_iter().collect::<Option<Vec<_>>>())
    else {
        return Ok(None);
    };
    let signals = (0..fields.len()).map(|at| signal(draft, at, &fields, &routes)).collect();
    Ok(Some(Message {
        id,
        name: draft.name.clone(),
        short: draft.short.clone(),
        length: draft.length as usize,
        signals,
        comment: draft.comment.clone(),
        line: draft.line,
    }))
}

fn message_id(draft: &Draft, own: &mut Vec<Finding>) -> Option<Id> {
    let extended = draft.id & EXTENDED_FLAG != 0;
    let number = draft.id & !EXTENDED_FLAG;
    let id = u32::try_from(number)
        .ok()
        .and_then(|number| if extended { Id::extended(number) } else { Id::standard(number) });
    // Beyond 32 bits it was found while reading.
    if id.is_none() && u32::try_from(draft.id).is_ok() {
        let (what, remedy) = if extended {
            (
                format!("extended identifier 0x{number:X} is above 0x{:X}", Id::EXTENDED_MAX),
                "an extended identifier is 29 bits plus 2147483648 (bit 31)",
            )
        } else {
            (
                format!("standard identifier {number} (0x{number:X}) is above 0x7FF"),
                "if it is an extended one, add 2147483648 (bit 31) to it",
            )
        };
        own.push(draft.finding(Severity::Error, Concern::IdOutOfRange, None, what, remedy));
    }
    id
}

fn check_message(draft: &Draft, own: &mut Vec<Finding>) {
    let length = draft.length;
    if length > MAX_DATA as u64 {
        own.push(draft.finding(
            Severity::Error,
            Concern::MessageLength,
            None,
            format!("{length} bytes, but a frame has at most {MAX_DATA}"),
            "messages of several frames (transport protocols) are not supported",
        ));
    } else if length > 8 && ![12, 16, 20, 24, 32, 48, 64].contains(&length) {
        own.push(draft.finding(
            Severity::Warning,
            Concern::MessageLength,
            None,
            format!("{length} bytes is not a length of a CAN FD frame"),
            "frames are padded to 12, 16, 20, 24, 32, 48 or 64 bytes",
        ));
    }
    // Other statements know a signal by its short name, configurations by either.
    let mut names = HashSet::new();
    for signal in &draft.signals {
        let (short, long) = (signal.parsed.name.as_str(), signal.name());
        if !names.insert(short) || (long != short && !names.insert(long)) {
            own.push(draft.finding(
                Severity::Error,
                Concern::DuplicateName,
                Some(signal),
                "a second signal of this name".to_owned(),
                "rename one of them",
            ));
        }
    }
}

fn check_signal(draft: &Draft, signal: &DraftSignal, own: &mut Vec<Finding>) -> Option<BitField> {
    let parsed = &signal.parsed;
    let mut note = |severity, concern, what: String, remedy| {
        own.push(draft.finding(severity, concern, Some(signal), what, remedy));
    };
    if parsed.factor == 0.0 || !parsed.factor.is_finite() || !parsed.offset.is_finite() {
        note(
            Severity::Error,
            Concern::Scale,
            format!("factor {} and offset {}", parsed.factor, parsed.offset),
            "the factor must not be zero, and both must be finite",
        );
    }
    if is_multiplexor(signal) && (parsed.factor != 1.0 || parsed.offset != 0.0) {
        note(
            Severity::Warning,
            Concern::Multiplexing,
            "a multiplexor with factor and offset".to_owned(),
            "signals are selected by its raw number; give it (1,0)",
        );
    }
    let (low, high) = (number(parsed.min), number(parsed.max));
    if low > high || !low.is_finite() || !high.is_finite() {
        note(
            Severity::Warning,
            Concern::Limits,
            format!("the range [{low}|{high}]"),
            "the range is ignored; write the smaller number first, both finite",
        );
    }
    check_place(draft, signal, own)
}

/// The signal's bits, if they are valid; errors where they are not a float's or lie outside the
/// message.
fn check_place(draft: &Draft, signal: &DraftSignal, own: &mut Vec<Finding>) -> Option<BitField> {
    let parsed = &signal.parsed;
    let mut error = |concern, what: String, remedy| {
        own.push(draft.finding(Severity::Error, concern, Some(signal), what, remedy));
    };
    let float_bits = match signal.value_type {
        Some(SignalExtendedValueType::IEEEfloat32Bit) => Some(32),
        Some(SignalExtendedValueType::IEEEdouble64bit) => Some(64),
        _ => None,
    };
    if let Some(bits) = float_bits
        && bits != parsed.size
    {
        error(
            Concern::SignalLength,
            format!("a {bits}-bit float in {} bits", parsed.size),
            "SIG_VALTYPE_ 1 is 32 bits, 2 is 64 bits; correct type or length",
        );
    }
    let mut outside = |end: String| {
        error(
            Concern::OutsideMessage,
            format!("{end}, but the message has {} bytes", draft.length),
            "correct start bit or length, or the message's length (Motorola signals start at \
             their highest bit)",
        );
    };
    let motorola = parsed.byte_order == ByteOrder::BigEndian;
    match BitField::new(parsed.start_bit, parsed.size, motorola, is_signed(signal)) {
        Ok(field) => {
            if field.needs() as u64 > draft.length {
                outside(format!("it ends in byte {}, counted from 1", field.needs()));
            }
            Some(field)
        }
        Err(NoField::Beyond) => {
            outside(format!("{} bits from bit {} on", parsed.size, parsed.start_bit));
            None
        }
        Err(NoField::Length) => {
            let what = format!("a length of {} bits", parsed.size);
            error(Concern::SignalLength, what, "a signal has 1 to 64 bits");
            None
        }
    }
}

/// Errors for signals that share bits with an earlier one while both are in the frame. A deliberate
/// overlap cannot be told from a mistake that takes two redundant readings from one place.
fn check_overlaps(
    draft: &Draft,
    fields: &[Option<BitField>],
    routes: &Routes,
    own: &mut Vec<Finding>,
    steps: &mut u64,
) -> Result<(), ParseError> {
    let occupied: Vec<[u64; 8]> =
        fields.iter().map(|field| field.map_or([0; 8], |field| field.occupied())).collect();
    for (at, signal) in draft.signals.iter().enumerate() {
        for earlier in 0..at {
            let shared = occupied[at].iter().zip(&occupied[earlier]).any(|(a, b)| a & b != 0);
            let cost = if shared { meeting_cost(routes, at, earlier) } else { 1 };
            *steps = steps.checked_sub(cost).ok_or_else(|| ParseError::TooComplex {
                line: draft.line,
                message: draft.name.clone(),
            })?;
            if shared && can_meet(routes, at, earlier) {
                own.push(draft.finding(
                    Severity::Error,
                    Concern::Overlap,
                    Some(signal),
                    format!("it shares bits with {}", draft.signals[earlier].name()),
                    "correct the start bit or length of one of them",
                ));
                break;
            }
        }
    }
    Ok(())
}

/// Whether one frame can carry both signals: no multiplexor on the way to both selects only one of
/// them.
fn can_meet(routes: &Routes, a: usize, b: usize) -> bool {
    !routes.way(a).any(|on_a| {
        routes.way(b).any(|on_b| {
            on_a.multiplexor == on_b.multiplexor && disjoint(&on_a.ranges, &on_b.ranges)
        })
    })
}

fn meeting_cost(routes: &Routes, a: usize, b: usize) -> u64 {
    let ranges = |at| routes.way(at).map(|route| route.ranges.len() as u64).sum::<u64>() + 1;
    ranges(a) * routes.way(b).count().max(1) as u64
        + ranges(b) * routes.way(a).count().max(1) as u64
}

fn number(value: NumericValue) -> f64 {
    match value {
        NumericValue::Uint(number) => number as f64,
        NumericValue::Int(number) => number as f64,
        NumericValue::Double(number) => number,
    }
}

/// The signal `at`; its message has no error.
fn signal(draft: &Draft, at: usize, fields: &[BitField], routes: &Routes) -> Signal {
    let source = &draft.signals[at];
    let parsed = &source.parsed;
    let form = match (is_float(source), parsed.size) {
        (false, 64) if !is_signed(source) => NumberForm::Unsigned64,
        (false, _) => NumberForm::Integer,
        (true, 32) => NumberForm::Float32,
        (true, _) => NumberForm::Float64,
    };
    let mut gates: Vec<MultiplexGate> = routes
        .way(at)
        .map(|route| MultiplexGate {
            field: fields[route.multiplexor],
            ranges: route.ranges.clone(),
        })
        .collect();
    gates.reverse();
    let range = [number(parsed.min), number(parsed.max)];
    let meant = range != [0.0, 0.0] && range[0] <= range[1] && range.iter().all(|x| x.is_finite());
    Signal {
        name: source.name().to_owned(),
        short: source.long.as_ref().map(|_| parsed.name.clone()),
        unit: parsed.unit.clone(),
        range: meant.then_some(range),
        values: source.values.clone(),
        comment: source.comment.clone(),
        plan: SignalPlan::new(fields[at], form, parsed.factor, parsed.offset, gates.into()),
        line: source.line,
    }
}
