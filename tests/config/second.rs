//! Cylinders without C2.

use crate::common::{EXAMPLE, broken, refusal};
use tertius::config::parse;

/// The example with this beside the `c2_offset` of its only [[cylinder]] table, which is of cylinder 1.
fn with(keys: &str) -> String {
    let text = broken("c2_gain = 1.0", "").replace("c2_offset = 0.0", keys);
    assert_ne!(text, EXAMPLE);
    text
}

#[test]
fn a_cylinder_without_c2_has_none_of_its_signals_and_the_others_have_all() {
    let (settings, _) = parse("machine.toml", &with("c2 = false")).expect("it is sound");
    let of_c2 = |n| settings.signals_of(n).filter(|(key, _)| key.starts_with("c2")).count();
    assert_eq!([1, 2, 6].map(|n| settings.has_c2(n)), [false, true, true]);
    assert_eq!([1, 2, 6].map(of_c2), [0, 2, 2]);
    assert!(settings.signals_of(1).any(|(key, _)| key == "c1_velocity"));
    let (both, _) = parse("machine.toml", EXAMPLE).expect("it is sound");
    assert!((1..=6).all(|n| both.has_c2(n)));
    let alone: String =
        EXAMPLE.lines().filter(|it| !it.starts_with("c2")).map(|it| format!("{it}\n")).collect();
    let (alone, _) = parse("machine.toml", &alone).expect("it is sound");
    assert!((1..=6).all(|n| !alone.has_c2(n)));
}

#[test]
fn what_belongs_to_a_c2_that_is_not_there_is_refused() {
    for (text, problem, help) in [
        (
            with("c2 = false\nc2_offset = 0.001"),
            "`cylinder[0].c2_offset` is there, but cylinder 1 has no C2",
            "leave it out",
        ),
        (
            with("c2 = false\nc2_gain = 1.002"),
            "`cylinder[0].c2_gain` is there, but cylinder 1 has no C2",
            "leave it out",
        ),
        (
            broken("c2 = \"Cyl{n}_C2.Position\"\n", ""),
            "`signals.cylinder.c2_velocity` is there, but `signals.cylinder.c2` is not",
            "name the position",
        ),
        (
            with("c2 = true")
                .lines()
                .filter(|it| !it.starts_with("c2_") && !it.contains("C2.Position"))
                .collect::<Vec<_>>()
                .join("\n"),
            "`cylinder[0].c2` is true, but [signals.cylinder] names no `c2`",
            "leave the key out",
        ),
        (with("c2 = \"\""), "`cylinder[0].c2`", "true or false"),
    ] {
        let lines = refusal(&text);
        assert!(lines[0].contains(problem), "\n{}\n{problem}", lines[0]);
        assert!(lines[0].contains(help), "\n{}\n{help}", lines[0]);
    }
}

/// Whether a cylinder has a C2 is no calibration.
#[test]
fn a_machine_that_only_lacks_a_c2_is_not_calibrated() {
    use tertius_testing::support::{Scratch, changed, top};
    let scratch = Scratch::new();
    let text = std::fs::read_to_string(top().join("config/e-type.toml")).expect("it ships");
    let dbc = top().join("dbc").display().to_string();
    let text = changed(&text, &[("../dbc", &dbc)]) + "\n[[cylinder]]\nn = 3\nc2 = false\n";
    let loaded =
        tertius::config::load(scratch.write("machine.toml", text).as_ref()).expect("sound");
    assert_eq!(loaded.fingerprints().calibration, None);
}
