//! What holds for the EDS reader with any text.

use proptest::prelude::*;
use tertius::canopen::eds::{MAX_FINDINGS, ObjectDictionary, Severity};
use tertius::canopen::pdo::{Pdos, scale};
use tertius::dbc::text;

const FILES: [&[u8]; 7] = [
    include_bytes!("../eds/types.eds"),
    include_bytes!("../eds/latin1.eds"),
    include_bytes!("../eds/node_id.eds"),
    include_bytes!("../eds/configured.dcf"),
    include_bytes!("../eds/pdos.eds"),
    include_bytes!("../../dbc/encoder.eds"),
    include_bytes!("../../dbc/valve.eds"),
];

/// Reads everything that a dictionary offers: its lines are lines of the text, and what it offers is
/// found, or refused with a reason.
fn use_all(text: &str) {
    let Ok(dictionary) = ObjectDictionary::parse(text) else { return };
    let lines = text.lines().count().max(text.split('\r').count()) + 1;
    let findings = dictionary.findings();
    assert!(findings.iter().all(|finding| (1..=lines).contains(&finding.line)));
    assert!(findings.is_sorted_by_key(|finding| finding.line) && findings.len() <= MAX_FINDINGS);
    let errors = findings.iter().filter(|finding| finding.severity == Severity::Error).count();
    assert!(dictionary.refused().count() <= errors + dictionary.findings_left_out());
    for object in dictionary.objects() {
        for (sub_index, variable) in &object.variables {
            assert_eq!(dictionary.variable(object.index, *sub_index), Ok(variable));
            assert!((1..=lines).contains(&variable.line));
            let node_ids = [None, Some(1), Some(127)];
            let values = node_ids.map(|id| variable.configured().and_then(|it| it.whole(id)));
            assert!(values[0].is_none() || values.iter().all(|value| *value == values[0]));
        }
    }
    for (address, finding) in dictionary.refused() {
        // Of an object with an error in its head, sub-objects with sections of their own are there.
        let found = dictionary.variable(address.index, address.sub_index.unwrap_or(0));
        assert!(found.is_err() || address.sub_index.is_none(), "{finding}");
    }
    assert!(dictionary.to_string().lines().count() < 66_000);
    for pdo in Pdos::of(&dictionary, 127).sound {
        assert!((1..=8).contains(&pdo.length));
        for object in &pdo.objects {
            assert!(usize::from(object.start) + usize::from(object.bits) <= 8 * pdo.length);
            if let Ok(scale) = scale(&dictionary, 127, object.index) {
                assert!(scale.factor > 0.0 && scale.factor.is_finite());
                assert!(object.plan(&scale).is_none_or(|plan| plan.needed_length() <= pdo.length));
            }
        }
    }
}

/// Words of the format in any order reach deeper than random characters.
fn words() -> impl Strategy<Value = String> {
    let words = [
        "\n",
        "\r\n",
        "\r",
        "=",
        ";",
        " ; ",
        "#",
        "[",
        "]",
        "$NODEID",
        "+",
        "-",
        "0x",
        "0",
        "017",
        "08",
        "0xFFFFFFFFFFFFFFFFFF",
        "255",
        "é",
        "\u{FEFF}",
        "[1000]\n",
        "[1000sub0]\n",
        "[1000sub1]\n",
        "[1000subFF]\n",
        "[1000Name]\n",
        "[1000Value]\n",
        "[A0sub1]\n",
        "[A0]\n",
        "[DeviceInfo]\n",
        "[DeviceComissioning]\n",
        "[DummyUsage]\n",
        "[OptionalObjects]\n",
        "1=0x1000\n",
        "ParameterName=a\n",
        "ObjectType=7\n",
        "ObjectType=8\n",
        "ObjectType=9\n",
        "ObjectType=2\n",
        "DataType=0xA0\n",
        "DataType=5\n",
        "DataType=4\n",
        "DataType=9\n",
        "DataType=10\n",
        "DataType=8\n",
        "AccessType=rw\n",
        "DefaultValue=",
        "ParameterValue=",
        "LowLimit=",
        "HighLimit=",
        "PDOMapping=1\n",
        "CompactSubObj=254\n",
        "CompactSubObj=1\n",
        "SubNumber=2\n",
        "NodeID=5\n",
        "NrOfEntries=1\n",
        "1=x\n",
        "1e3",
        "00 ff",
    ];
    prop::collection::vec(prop::sample::select(words.to_vec()), 0..80).prop_map(|it| it.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(10_000) })]

    #[test]
    fn any_text_is_read_or_refused(text in any::<String>()) {
        use_all(&text);
    }

    #[test]
    fn any_words_are_read_or_refused(text in words()) {
        use_all(&text);
    }

    #[test]
    fn a_damaged_file_is_read_or_refused(
        which in 0..FILES.len(),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..5_usize, any::<u8>()), 1..8),
    ) {
        let mut bytes = FILES[which].to_vec();
        for (place, how, other) in cuts {
            let at = place.index(bytes.len());
            match how {
                0 => { bytes.remove(at); }
                1 => bytes.insert(at, other),
                2 => bytes[at] = other,
                3 => { bytes.drain(at..(at + 60).min(bytes.len() - 1).max(at)); }
                _ => {
                    let piece: Vec<u8> = bytes[at..].iter().copied().take(60).collect();
                    bytes.splice(at..at, piece);
                }
            }
        }
        use_all(&text::from_bytes(&bytes));
    }

    #[test]
    fn a_number_is_read_as_it_is_written(number in any::<u32>(), node_id in 1..128_u8) {
        let texts = [
            format!("{number}"), format!("0x{number:X}"), format!("0{number:o}"),
            format!("$NODEID+{number}"), format!("0x{number:08x} + $nodeid"),
        ];
        for (place, text) in texts.iter().enumerate() {
            let text = format!("[2000]\nParameterName=a\nDataType=7\nAccessType=ro\nDefaultValue={text}");
            let dictionary = ObjectDictionary::parse(&text).unwrap();
            let value = dictionary.variable(0x2000, 0).unwrap().default.clone().unwrap();
            let added = if place < 3 { 0 } else { i128::from(node_id) };
            prop_assert_eq!(value.whole(Some(node_id)), Some(i128::from(number) + added));
        }
    }
}
