//! Whatever stands in a configuration, it is read or refused; never a panic.

use proptest::prelude::*;
use tertius::config::settings::Settings;
use tertius::config::{ConfigError, MAX_PROBLEMS, parse};

const EXAMPLE: &str = include_str!("example.toml");
const SHIPPED: &str = include_str!("../../config/e-type.toml");

/// A refusal says something, within bounds, at places that the text has.
fn sound(error: &ConfigError, text: &str) {
    assert!((1..=MAX_PROBLEMS).contains(&error.problems().len()));
    let lines = text.split('\n').count();
    for problem in error.problems() {
        assert!(!problem.message().is_empty() && !problem.to_string().contains('\n'));
        let place = problem.place().expect("every problem of a text has a place");
        assert!(place.line <= lines && text.get(place.span.clone()).is_some());
    }
    assert!(!format!("{:?}", error.report()).is_empty());
}

/// What is accepted can be computed with.
fn finite(settings: &Settings) {
    let machine = &settings.machine;
    assert!((1..=6).contains(&machine.cylinders) && machine.sample_time > 0.0);
    assert!(machine.stroke[0] < machine.stroke[1]);
    assert!(settings.cycle_deadline() < machine.sample_time);
    assert!(settings.fde.low > 0.0 && settings.fde.low <= settings.fde.high);
    assert!(settings.comparator_low() > 0.0);
    for n in 1..=machine.cylinders {
        let ((theta, gamma), (gain, offset)) = (settings.model_of(n), settings.comparator_of(n));
        assert!(theta.iter().chain(&gamma).all(|value| value.is_finite()));
        assert!((0.5..=2.0).contains(&gain) && offset.is_finite());
    }
}

fn examine(text: &str) {
    match parse("any.toml", text) {
        Ok((settings, _)) => finite(&settings),
        Err(error) => sound(&error, text),
    }
}

/// Pieces that mean something to the reader.
fn piece() -> impl Strategy<Value = String> {
    let words = [
        "[",
        "]",
        "[[",
        "]]",
        "{",
        "}",
        "=",
        ".",
        ",",
        "\"",
        "'",
        "\"\"\"",
        "#",
        "\n",
        "\r\n",
        "nan",
        "-inf",
        "1e400",
        "0x7F",
        "-1",
        "0",
        "1.5",
        "true",
        "1999-12-31",
        "{n}",
        "n = 1\n",
        "[machine]\n",
        "[fde]\n",
        "[[cylinder]]\n",
        "low",
        "theta",
        "µ",
        "\u{feff}",
        "\0",
        "\\u00",
    ];
    prop_oneof![3 => prop::sample::select(words.to_vec()).prop_map(str::to_owned), 1 => ".{0,4}"]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        examine(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn any_pieces_are_read_or_refused(pieces in prop::collection::vec(piece(), 0..60)) {
        examine(&pieces.concat());
    }

    #[test]
    fn a_changed_configuration_is_read_or_refused(
        shipped in any::<bool>(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0usize..12, piece()), 1..6),
    ) {
        let mut text: Vec<char> = if shipped { SHIPPED } else { EXAMPLE }.chars().collect();
        for (at, length, new) in changes {
            let start = at.index(text.len() + 1);
            let end = (start + length).min(text.len());
            text.splice(start..end, new.chars());
        }
        examine(&text.into_iter().collect::<String>());
    }

    #[test]
    fn an_unknown_key_is_always_refused_by_its_name(
        name in "[a-z][a-z_0-9]{0,8}_x",
        line in 0usize..200,
        quoted in any::<bool>(),
    ) {
        // Behind any line of the shipped file that is not inside a value: all of its lines.
        let mut lines: Vec<&str> = SHIPPED.lines().collect();
        let line = line % (lines.len() + 1);
        let key = if quoted { format!("\"{name}\" = 1") } else { format!("{name}.y = [nan]") };
        lines.insert(line, &key);
        let text = lines.join("\n");
        let error = parse("any.toml", &text).expect_err("unknown keys are refused");
        sound(&error, &text);
        prop_assert_eq!(error.problems().len(), 1);
        let problem = &error.problems()[0];
        prop_assert_eq!(problem.place().map(|place| place.line), Some(line + 1));
        let end = format!("has an unknown key, `{name}`");
        prop_assert!(problem.message().ends_with(&end));
        prop_assert!(problem.help().contains("the nearest known key is `"));
    }
}
