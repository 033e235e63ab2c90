//! What holds for any text and any signal.

use crate::dbc_support::{Dice, random_dbc};
use proptest::prelude::*;
use tertius::dbc::Database;
use tertius::decode::{Decoded, Inserted, Raw};
use tertius::frame::{Frame, Id, Kind, MAX_DATA};
use tertius::time::Timestamp;

const SINK: [&str; 4] = [
    include_str!("../dbc/intel.dbc"),
    include_str!("../dbc/floats.dbc"),
    include_str!("../dbc/multiplexed.dbc"),
    include_str!("../dbc/nested.dbc"),
];

/// Reads everything that a database offers; only a panic is wrong.
fn use_all(text: &str) {
    let Ok(database) = Database::parse(text) else { return };
    for finding in database.findings() {
        let _ = finding.to_string();
    }
    let lines = text.lines().count().max(text.split('\r').count()) + 1;
    assert!(database.findings().iter().all(|finding| (1..=lines).contains(&finding.line)));
    for message in database.messages() {
        assert!(message.length <= MAX_DATA);
        assert_eq!(database.message(&message.name).map(|found| found.id), Ok(message.id));
        for length in [0, message.length, MAX_DATA] {
            let kind = Kind::Fd { flags: 0 };
            let frame = Frame::new(Timestamp::default(), message.id, kind, &[0xA5; 64][..length]);
            for signal in &message.signals {
                assert!(signal.plan.needed_length() <= message.length);
                let short = length < signal.plan.needed_length();
                let decoded = signal.plan.decode(&frame);
                assert!(short || decoded != Decoded::Short);
                assert!(!short || decoded.value().is_none());
            }
        }
    }
    let _ = database.signal("Narrow.Position").map_err(|error| error.to_string());
}

/// Words of the format in any order reach deeper than random characters.
fn words() -> impl Strategy<Value = String> {
    let words = [
        "BO_",
        "SG_",
        "VAL_",
        "SIG_VALTYPE_",
        "SG_MUL_VAL_",
        "CM_",
        "BA_",
        "NS_",
        "BU_",
        "1",
        "2147483649",
        "70000",
        "4294967296",
        "A",
        "B",
        ":",
        ";",
        "|",
        "@",
        "0",
        "8",
        "64",
        "+",
        "-",
        "(1,0)",
        "(1.,.5)",
        "[0|0]",
        "\"\"",
        "\"",
        "m",
        "m1",
        "m1M",
        "M",
        "\n",
        "\n ",
        "\r\n",
        "//",
        ",",
        "1-3",
        "é",
        "\\",
        "BO_ 1 A: 8 X\n",
        " SG_ B : 0|8@1+ (1,0) [0|0] \"\" X\n",
        " SG_ C m1 : 8|8@0- (1,0) [0|0] \"\" X\n",
        " SG_ D M : 16|8@1+ (1,0) [0|0] \"\" X\n",
        "SG_MUL_VAL_ 1 C D 1-2;\n",
        "SIG_VALTYPE_ 1 B : 1;\n",
    ];
    prop::collection::vec(prop::sample::select(words.to_vec()), 0..60)
        .prop_map(|words| words.join(" "))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]

    #[test]
    fn any_text_is_parsed_or_refused(text in any::<String>()) {
        use_all(&text);
    }

    #[test]
    fn any_words_are_parsed_or_refused(text in words()) {
        use_all(&text);
    }

    #[test]
    fn any_bytes_are_text(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        use_all(&tertius::dbc::text::from_bytes(&bytes));
    }

    #[test]
    fn a_damaged_file_is_parsed_or_refused(
        which in 0..SINK.len(),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..4_usize, any::<char>()), 1..6),
    ) {
        let mut characters: Vec<char> = SINK[which].chars().collect();
        for (place, how, other) in cuts {
            let at = place.index(characters.len());
            match how {
                0 => { characters.remove(at); }
                1 => characters.insert(at, other),
                2 => characters[at] = other,
                _ => {
                    let piece: Vec<char> = characters[at..].iter().copied().take(40).collect();
                    characters.splice(at..at, piece);
                }
            }
        }
        use_all(&characters.into_iter().collect::<String>());
    }

    #[test]
    fn what_is_put_in_comes_out_and_nothing_else_changes(
        start in 0..512_u64, length in 1..=64_u64, motorola: bool, signed: bool, raw: i128,
        bytes in prop::collection::vec(any::<u8>(), 64),
    ) {
        let order = u8::from(!motorola);
        let sign = if signed { '-' } else { '+' };
        let text = format!(
            "BO_ 1 M: 64 A\n SG_ S : {start}|{length}@{order}{sign} (1,0) [0|0] \"\" A\n"
        );
        let database = Database::parse(&text).unwrap();
        prop_assume!(database.findings().is_empty());
        let plan = &database.signal("M.S").unwrap().1.plan;
        let (low, high) = plan.raw_limits().unwrap();
        let number = low + raw.rem_euclid(high - low + 1);
        let raw = if signed { Raw::Signed(number as i64) } else { Raw::Unsigned(number as u64) };
        let id = Id::standard(1).unwrap();
        let mut frame = Frame::new(Timestamp::default(), id, Kind::Fd { flags: 0 }, &bytes);
        let before = plan.decode(&frame).value().unwrap().raw;
        prop_assert_eq!(plan.insert(raw, frame.buffer_mut()), Inserted::Whole);
        prop_assert_eq!(plan.decode(&frame).value().unwrap().raw, raw);
        prop_assert_eq!(raw.as_i128(), Some(number));
        prop_assert_eq!(plan.insert(before, frame.buffer_mut()), Inserted::Whole);
        prop_assert_eq!(frame.data(), &bytes[..]);
    }

    #[test]
    fn floats_go_in_and_out(bits: u64, start in 0..64_u64, motorola: bool, double: bool) {
        let order = u8::from(!motorola);
        let (length, kind) = if double { (64, 2) } else { (32, 1) };
        let text = format!(
            "BO_ 1 M: 64 A\n SG_ S : {start}|{length}@{order}- (1,0) [0|0] \"\" A\n\
             SIG_VALTYPE_ 1 S : {kind};\n"
        );
        let database = Database::parse(&text).unwrap();
        let plan = &database.signal("M.S").unwrap().1.plan;
        let number =
            if double { f64::from_bits(bits) } else { f64::from(f32::from_bits(bits as u32)) };
        let kind = Kind::Fd { flags: 0 };
        let mut frame = Frame::new(Timestamp::default(), Id::standard(1).unwrap(), kind, &[0; 64]);
        prop_assert_eq!(plan.insert(Raw::Float(number), frame.buffer_mut()), Inserted::Whole);
        let value = plan.decode(&frame).value().unwrap();
        prop_assert!(value.physical == number || (number.is_nan() && value.physical.is_nan()));
    }

    #[test]
    fn random_valid_databases_have_no_findings(seed: u64) {
        let text = random_dbc(&mut Dice(seed), 4);
        let database = Database::parse(&text).unwrap();
        prop_assert_eq!(database.findings(), &[]);
        prop_assert_eq!(database.messages().len(), 4);
        use_all(&text);
    }
}
