//! Several buses: their tables, and the signals that are on them.

use crate::common::{EXAMPLE, refusal};
use tertius::config::parse;
use tertius::config::settings::bus_of;
use tertius::frame::BusNumber;

const SECOND: &str = "[bus.second]\ninterface = \"can1\"\n[signals]";

/// The example with these tables and its C2 on the second bus.
fn with(tables: &str) -> String {
    let text = EXAMPLE.replacen("[signals]", tables, 1);
    text.replace("\"Cyl{n}_C2", "\"second:Cyl{n}_C2")
}

#[test]
fn buses_have_interfaces_and_signals_name_their_bus() {
    let (settings, _) = parse("machine.toml", &with(SECOND)).expect("it is sound");
    let interfaces: Vec<_> = settings.bus.interfaces().collect();
    let second = BusNumber::Second;
    assert_eq!(interfaces, [(BusNumber::First, "can0"), (second, "can1")]);
    let c2 = settings.signals.cylinder.c2.expect("it is named");
    assert_eq!(bus_of(&c2), Some((second, "Cyl{n}_C2.Position")));
    assert_eq!(bus_of("Sync"), Some((BusNumber::First, "Sync")));
    assert_eq!(bus_of("sixth:Sync"), None);
}

#[test]
fn buses_and_signals_that_do_not_fit_each_other_are_refused() {
    let third = SECOND.replace("[bus.second]", "[bus.third]");
    let both = |other: &str| format!("{other}{SECOND}");
    for (text, found, help) in [
        (
            with("[signals]"),
            "`signals.cylinder.c2` is on the second bus, but there is no [bus.second]",
            "can1",
        ),
        (
            EXAMPLE.replacen("[signals]", SECOND, 1),
            "[bus.second] is configured, but no signal is on it",
            "leave the table out",
        ),
        (
            with(&third).replace("second:", "third:"),
            "there is a [bus.third], but no [bus.second]",
            "without gaps",
        ),
        (
            with(&SECOND.replace("can1", "can0")),
            "`bus.second.interface` is \"can0\", which another bus has already",
            "of its own",
        ),
        (
            with(&SECOND.replace("can1", "virtual")),
            "`bus.second.interface` is \"virtual\" beside \"can0\"",
            "a single one",
        ),
        (
            with(&both("[bus.fifth]\ninterface = \"can7\"\n")),
            "[bus] has an unknown key, `fifth`",
            "second, third, fourth",
        ),
        (
            with(SECOND).replace("second:Cyl{n}_C2.Position", "other:Cyl{n}_C2.Position"),
            "`signals.cylinder.c2` is \"other:Cyl{n}_C2.Position\", but must be of the form",
            "on another bus than the first",
        ),
    ] {
        let lines = refusal(&text);
        assert!(lines[0].contains(found) && lines[0].contains(help), "{found}:\n{lines:#?}");
    }
}
