//! dbc/e-type.dbc, the layout of the default machine, read by can-dbc and by cantools.

use can_dbc::{ByteOrder, Dbc, MessageId, MultiplexIndicator};
use tertius::alarm::own::identifiers;
use tertius::alarm::{Detector, OwnMessage};
use tertius_testing::oracle;

fn e_type() -> Dbc {
    let text = std::fs::read_to_string(oracle::top().join("dbc/e-type.dbc")).expect("the file");
    Dbc::try_from(text.as_str()).expect("can-dbc reads it")
}

/// The layout itself, and a recording decoded by cantools and by hand, are compared in the script.
#[test]
fn cantools_reads_the_specified_layout_strictly() {
    let compared = oracle::run("e_type_dbc.py", &[], "");
    // Two cycles of 22 frames, two of each of the gateway's three own.
    assert_eq!(compared.trim(), "50");
}

#[test]
fn can_dbc_sees_distinct_messages_whose_signals_fit_and_do_not_overlap() {
    let dbc = e_type();
    let mut ids: Vec<_> = dbc.messages.iter().map(|message| message.id.raw()).collect();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), 25);
    for message in &dbc.messages {
        assert!(matches!(message.id, MessageId::Standard(id) if id <= 0x7FF), "{}", message.name);
        assert!(message.transmitter.is_some(), "{} has no sender", message.name);
        let mut used = 0u64;
        for signal in &message.signals {
            let place = format!("{}.{}", message.name, signal.name);
            assert_eq!(signal.byte_order, ByteOrder::LittleEndian, "{place}");
            assert_eq!(signal.multiplexer_indicator, MultiplexIndicator::Plain, "{place}");
            assert!(signal.start_bit + signal.size <= 8 * message.size, "{place} leaves it");
            let bits = ((1 << signal.size) - 1) << signal.start_bit;
            assert_eq!(used & bits, 0, "{place} overlaps");
            used |= bits;
        }
    }
}

/// A decimal of too few digits would move a position by picometres and the golden residuals with
/// it.
#[test]
fn can_dbc_reads_the_position_factor_to_the_last_bit() {
    let dbc = e_type();
    let positions: Vec<_> = dbc
        .messages
        .iter()
        .flat_map(|message| &message.signals)
        .filter(|signal| signal.name == "Position")
        .collect();
    assert_eq!(positions.len(), 13, "C1 and C2 of six cylinders, and the estimate");
    for signal in positions {
        assert_eq!((signal.factor, signal.offset), (3.0 / 27648.0, -1.5));
    }
}

#[test]
fn can_dbc_reads_the_platform_states() {
    let dbc = e_type();
    let states = dbc
        .value_descriptions_for_signal(MessageId::Standard(0x1C1), "PlatformState")
        .expect("a VAL_ table");
    let found: Vec<_> = states.iter().map(|state| (state.id, state.description.as_str())).collect();
    assert_eq!(found, [(0, "safe"), (1, "settled"), (2, "neutral"), (3, "engaged")]);
}

/// Whoever reads the frames by the DBC sees the words of the program's own tables.
#[test]
fn the_dbc_has_the_detectors_and_messages_of_the_program() {
    let dbc = e_type();
    let words = dbc
        .value_descriptions_for_signal(MessageId::Standard(0x2D1), "Detector")
        .expect("a VAL_ table");
    let words: Vec<_> = words.iter().map(|word| (word.id, word.description.as_str())).collect();
    assert_eq!(words, Detector::ALL.map(|detector| (detector as i64, detector.name())));
    let ids = identifiers(81).expect("81 is a node");
    for (message, id) in OwnMessage::ALL.into_iter().zip(ids) {
        let own = dbc.messages.iter().find(|own| own.name == message.name()).expect("it is there");
        assert_eq!((own.id.raw(), own.size), (id.value(), 8), "{}", own.name);
    }
}

/// `dbc/e-type-top.dbc` is this layout with one message more.
#[test]
fn the_layout_with_a_sensor_on_the_deck_only_adds_its_message() {
    let read = |name: &str| std::fs::read_to_string(oracle::top().join(name)).expect("the file");
    let (plain, top) = (read("dbc/e-type.dbc"), read("dbc/e-type-top.dbc"));
    let own = [
        "BO_ 434 ",
        " SG_ Roll : 0|16@1- (0.00001,",
        " SG_ Pitch : 16|16@1- (0.00001,",
        "CM_ BO_ 434 ",
    ];
    let rest = top.replace("BU_: Plc Mru Top ", "BU_: Plc Mru ");
    let rest = rest.lines().filter(|line| !own.iter().any(|own| line.starts_with(own)));
    // What the detectors are differs by the sensor.
    let alike = |line: &&str| !line.is_empty() && !line.starts_with("CM_ SG_ 721 Detector");
    assert!(rest.filter(alike).eq(plain.lines().filter(alike)));
    let count = |own: &str| top.lines().filter(|line| line.starts_with(own)).count();
    assert_eq!(own.map(count), [1; 4]);
}
