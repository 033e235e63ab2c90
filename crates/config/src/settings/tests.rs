use super::*;
use crate::schema::Table;

/// The file of all examples, or only of those that are required.
fn examples(path: &str, table: &Table, all: bool, text: &mut String) {
    let wanted = || table.keys.iter().filter(|key| all || key.is_required());
    for key in wanted().filter(|key| !key.example.is_empty()) {
        text.push_str(&format!("{}\n", key.written()));
    }
    for key in wanted() {
        let full = format!("{path}{}", key.name);
        let (header, inner) = match key.kind {
            Kind::Table(inner) => (format!("[{full}]\n"), inner),
            Kind::Tables(inner) => (format!("[[{full}]]\n"), inner),
            Kind::One(_) | Kind::List { .. } => continue,
        };
        text.push_str(&header);
        examples(&format!("{full}."), inner, all, text);
    }
}

/// Puts signals on each bus: an example is that of every further bus, but each has an interface of its own, and none is
/// there for nothing.
fn on_all_buses(text: &str) -> String {
    let mut text = text.to_owned();
    let further = [
        ("second", "can1", "c2 "),
        ("third", "can2", "control_speed "),
        ("fourth", "can3", "state "),
    ];
    for (bus, interface, key) in further {
        let (shared, own) =
            ["can1", interface].map(|it| format!("[bus.{bus}]\ninterface = \"{it}\"")).into();
        if text.contains(&shared) {
            text = text.replace(&shared, &own);
            text = text.replace(&format!("\n{key}= \""), &format!("\n{key}= \"{bus}:"));
        }
    }
    text
}

#[test]
fn the_examples_are_a_sound_configuration() {
    for all in [true, false] {
        let mut text = String::new();
        examples("", &ROOT, all, &mut text);
        // The example is of a transducer, and only a valve has it.
        let text = on_all_buses(&text.replace("full_speed = 1.0\n", ""));
        if let Err(error) = crate::parse("examples", &text) {
            panic!("{error}\n{text}");
        }
    }
}

/// The type alone, without the walk over the keys, is as strict.
#[test]
fn a_type_takes_its_own_keys_and_has_the_defaults_of_its_rows() {
    let read = |text: &str| toml::from_str::<Cylinder>(text);
    let cylinder = read("n = 3").expect("that is all that is required");
    assert_eq!((cylinder.n, cylinder.c2_gain, cylinder.c2_offset), (3, 1.0, 0.0));
    assert_eq!((cylinder.theta, &cylinder.sequential), (None, &None));
    let error = read("c2_gain = 1.1").expect_err("n is required").to_string();
    assert!(error.contains("missing field `n`"), "{error}");
    let error = read("n = 1\nm = 2").expect_err("m is not known").to_string();
    assert!(error.contains("unknown field `m`"), "{error}");
    let alarm: Alarm = toml::from_str("[levels]\nboth = \"red\"").expect("a level");
    assert_eq!(alarm.levels.both, tertius_core::alarm::Level::Red);
    assert_eq!(alarm.levels.critical, tertius_core::alarm::Level::Black);
    assert_eq!(toml::from_str::<Fde>("").expect("all have defaults"), Fde::default());
}
