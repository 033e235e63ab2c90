//! DBC files of any bytes, and frames of any bytes for what they define: no panic, nothing read
//! beyond a payload, and what is put into a frame comes out again.
//!
//! Up to the first zero byte the input is the DBC; the rest is the payload.

#![no_main]

use libfuzzer_sys::fuzz_target;
use tertius::dbc::{Database, Message, text};
use tertius::decode::{Decoded, Inserted, Raw, SignalPlan};
use tertius::frame::{Frame, Kind, MAX_DATA};
use tertius::time::Timestamp;

fn decode_all(message: &Message, payload: &[u8]) {
    let kinds = [Kind::Data, Kind::Fd { flags: 0 }, Kind::Remote { length: 8 }, Kind::Error];
    for kind in kinds {
        let frame = Frame::new(Timestamp::default(), message.id, kind, payload);
        let carries = matches!(kind, Kind::Data | Kind::Fd { .. });
        for signal in &message.signals {
            let short = payload.len() < signal.plan.needed_length();
            let decoded = signal.plan.decode(&frame);
            assert!(carries || decoded == Decoded::Absent);
            assert!(!short || decoded.value().is_none());
            assert!(short || decoded != Decoded::Short);
        }
    }
}

fn insert_all(message: &Message, payload: &[u8]) {
    let kind = Kind::Fd { flags: 0 };
    let mut frame = Frame::new(Timestamp::default(), message.id, kind, &[0; MAX_DATA]);
    frame.buffer_mut()[..payload.len()].copy_from_slice(payload);
    let mut word = [0; 8];
    word[..payload.len().min(8)].copy_from_slice(&payload[..payload.len().min(8)]);
    let bits = u64::from_le_bytes(word);
    let raws = [Raw::Unsigned(bits), Raw::Signed(bits as i64), Raw::Float(f64::from_bits(bits))];
    for signal in &message.signals {
        for raw in raws {
            insert(&signal.plan, raw, &mut frame);
        }
        let _ = signal.plan.insert_physical(f64::from_bits(bits), frame.buffer_mut());
    }
}

fn insert(plan: &SignalPlan, raw: Raw, frame: &mut Frame) {
    let inserted = plan.insert(raw, frame.buffer_mut());
    if plan.is_multiplexed() || plan.is_float() {
        return;
    }
    let read = plan.decode(frame).value().expect("the frame is long enough").raw;
    match inserted {
        Inserted::Whole if !matches!(raw, Raw::Float(_)) => {
            assert_eq!(read.as_i128(), raw.as_i128())
        }
        Inserted::Clamped(clamped) => assert_eq!(read.as_i128(), clamped.as_i128()),
        Inserted::Whole | Inserted::NotANumber => {}
    }
}

fuzz_target!(|data: &[u8]| {
    let end = data.iter().position(|&byte| byte == 0).unwrap_or(data.len());
    let payload = data.get(end + 1..).unwrap_or(&[]);
    let payload = &payload[..payload.len().min(MAX_DATA)];
    let Ok(database) = Database::parse(&text::from_bytes(&data[..end])) else { return };
    for finding in database.findings() {
        assert!(!finding.to_string().is_empty());
    }
    for message in database.messages() {
        assert!(message.length <= MAX_DATA);
        let found = database.message(&message.name).expect("it is in the database");
        assert_eq!(found.id, message.id);
        decode_all(message, payload);
        insert_all(message, payload);
    }
});
