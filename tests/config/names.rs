//! Names of cylinders and transducers.

use crate::common::{EXAMPLE, broken, refusal, refused};
use tertius::config::parse;
use tertius::sample::Transducer::{C1, C2};

/// The example with these keys in its only [[cylinder]] table, which is of cylinder 1, and this behind it.
fn with(keys: &str, more: &str) -> String {
    broken("c2_offset = 0.0", &format!("c2_offset = 0.0\n{keys}")) + more
}

#[test]
fn a_name_stands_beside_the_number_and_never_instead_of_it() {
    let text = with(
        "name = \"FwdPort\"\nc1_name = \"LT-101A\"",
        "\n[[cylinder]]\nn = 3\nc2_name = \"Längenmessung 3 (neu)\"\n",
    );
    let names = parse("machine.toml", &text).expect("it is sound").0.names();
    assert_eq!(names.cylinder(1_u8), "cylinder 1 (FwdPort)");
    assert_eq!([names.short(1_u8), names.short(2_u8)], ["1 FwdPort", "2"]);
    assert_eq!(names.cylinder(3_u8), "cylinder 3");
    assert_eq!(names.transducer(1_u8, C1), "C1 (LT-101A)");
    assert_eq!(names.transducer(1_u8, C2), "C2");
    assert_eq!(names.transducer(3_u8, C2), "C2 (Längenmessung 3 (neu))");
    assert_eq!([names.of_cylinder(0_usize), names.of_cylinder(7_usize)], [None, None]);
    assert!(!names.is_empty());
    let none = parse("machine.toml", EXAMPLE).expect("it is sound").0.names();
    assert!(none.is_empty());
    assert_eq!([none.cylinder(6_u8), none.transducer(6_u8, C2)], ["cylinder 6", "C2"]);
}

#[test]
fn what_is_no_name_for_people_is_refused_with_its_place() {
    let line = EXAMPLE[..EXAMPLE.find("c2_offset = 0.0").expect("it is there")].lines().count() + 2;
    let long = "x".repeat(33);
    for (value, must) in [
        ("", "not empty"),
        ("   ", "not empty"),
        (long.as_str(), "at most 32 characters long"),
        ("Fwd\\u001b[31mPort", "without control characters"),
        ("Fwd\\nPort", "without control characters"),
        ("Fwd\\u202eP", "without invisible characters"),
        ("Fwd\\u200bPort", "without invisible characters"),
        (" FwdPort", "without spaces at its ends"),
        ("2", "a name, and not a number, C1 or C2"),
        ("c2", "a name, and not a number, C1 or C2"),
    ] {
        for key in ["name", "c1_name", "c2_name"] {
            refused(
                "c2_offset = 0.0",
                &format!("c2_offset = 0.0\n{key} = \"{value}\""),
                &format!("{line}:{}: `cylinder[0].{key}` is", key.len() + 4),
                &format!("must be {must} (it is shown beside the number"),
            );
        }
    }
    let longest = "ä".repeat(32);
    assert!(parse("machine.toml", &with(&format!("name = \"{longest}\""), "")).is_ok());
}

#[test]
fn a_name_is_that_of_one_thing() {
    for (keys, more, problem) in [
        (
            "name = \"FwdPort\"",
            "\n[[cylinder]]\nn = 2\nname = \"FWDPORT\"\n",
            "`cylinder[1].name` is \"FWDPORT\", and so is `cylinder[0].name`",
        ),
        (
            "c1_name = \"LT-1\"\nc2_name = \"LT-1\"",
            "",
            "`cylinder[0].c2_name` is \"LT-1\", and so is `cylinder[0].c1_name`",
        ),
        (
            "name = \"A\"",
            "\n[[cylinder]]\nn = 2\nc1_name = \"A\"\n",
            "`cylinder[1].c1_name` is \"A\", and so is `cylinder[0].name`",
        ),
        (
            "",
            "\n[[cylinder]]\nn = 2\nc2 = false\nc2_name = \"LT-2B\"\n",
            "`cylinder[1].c2_name` is there, but cylinder 2 has no C2",
        ),
    ] {
        let lines = refusal(&with(keys, more));
        assert_eq!(lines.len(), 1, "{lines:#?}");
        let [file, line, column, rest] =
            lines[0].splitn(4, ':').collect::<Vec<_>>().try_into().expect("file, line, column");
        assert_eq!(file, "machine.toml");
        assert!(line.parse::<usize>().is_ok() && column.parse::<usize>().is_ok(), "{}", lines[0]);
        assert!(rest.trim_start().starts_with(problem), "{}\n{problem}", lines[0]);
    }
}

/// A name is given and not measured.
#[test]
fn names_are_no_calibration_and_leave_its_identity() {
    use tertius_testing::support::{Scratch, changed, top};
    let scratch = Scratch::new();
    let text = std::fs::read_to_string(top().join("config/e-type.toml")).expect("it ships");
    let dbc = top().join("dbc").display().to_string();
    let of = |name: &str, cylinder: &str| {
        let text = changed(&text, &[("../dbc", &dbc)]) + "\n[[cylinder]]\nn = 3\n" + cylinder;
        let loaded = tertius::config::load(scratch.write(name, text).as_ref()).expect("sound");
        loaded.fingerprints()
    };
    let named = "name = \"FwdPort\"\nc1_name = \"LT-3A\"\nc2_name = \"LT-3B\"\n";
    assert_eq!(of("named.toml", named).calibration, None);
    let measured = of("measured.toml", "c2_gain = 1.001\n");
    let both = of("both.toml", &format!("{named}c2_gain = 1.001\n"));
    assert_eq!(both.calibration, measured.calibration);
    assert_ne!(both.configuration, measured.configuration);
}
