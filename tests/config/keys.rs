//! Keys that are unknown, missing or of the wrong type.

use crate::common::{EXAMPLE, refusal, refused};

#[test]
fn unknown_keys_name_the_nearest() {
    refused(
        "sample_time =",
        "sampletime =",
        "4:1: [machine] has an unknown key, `sampletime`",
        "(the nearest known key is `sample_time`; [machine] knows name, cylinders, sample_time, \
         stroke, area_ratio, monitored_states, cycle_deadline, max_gap)",
    );
    refused(
        "[fde]",
        "[fdi]",
        "33:2: the top level has an unknown key, `fdi`",
        "the nearest known key is `fde`; the top level knows machine, bus,",
    );
    refused(
        "c2_gain",
        "C2-gian",
        "43:1: [[cylinder]] number 1 has an unknown key, `C2-gian`",
        "the nearest known key is `c2_gain`; [[cylinder]] number 1 knows n, name, c1_name, c2_name, c2, c2_gain,",
    );
    refused(
        "critical = 0.05",
        "settle = 0.05",
        "39:1: [comparator] has an unknown key, `settle`",
        "(`settle` is a key of [observer]; the nearest known key is ",
    );
}

#[test]
fn missing_keys_name_their_table_and_what_they_are_for() {
    refused(
        "cylinders = 6\n",
        "",
        "1:2: [machine] lacks `cylinders`",
        "(how many cylinders there are; for example cylinders = 6)",
    );
    refused(
        "control_speed = \"Cyl{n}_Valve.ControlSpeed\"\n",
        "",
        "16:10: [signals.cylinder] lacks `control_speed`",
        "for example control_speed = \"Cyl{n}_Valve.ControlSpeed\")",
    );
    refused("\nn = 1\n", "\n", "41:1: [[cylinder]] number 1 lacks `n`", "for example n = 1");
    let (_, rest) = EXAMPLE.split_once("[bus]").expect("the example has a bus");
    let lines = refusal(&format!("[bus]{rest}"));
    assert_eq!(
        lines,
        ["machine.toml:1:1: the top level lacks [machine] (what the machine is; write [machine] \
          with name = \"Ampelmann E-type\", cylinders = 6, sample_time = 0.02, stroke = [-1.5, \
          1.5])"]
    );
    let lines = refusal("");
    assert_eq!(lines.len(), 3);
    assert!(lines[2].contains("write [signals.cylinder] with c1 = "), "{}", lines[2]);
}

#[test]
fn wrong_types_say_what_was_found_and_expected() {
    for (from, to, start) in [
        (
            "cylinders = 6",
            "cylinders = 6.0",
            "3:13: `machine.cylinders` is a number with a fraction, but must be a whole number",
        ),
        (
            "sample_time = 0.02",
            "sample_time = \"0.02\"",
            "4:15: `machine.sample_time` is a string, but must be a number",
        ),
        (
            "name = \"Ampelmann E-type\"",
            "name = 1999-12-31",
            "2:8: `machine.name` is a date or time, but must be a string",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = 1.5",
            "5:10: `machine.stroke` is a number with a fraction, but must be a list of 2 values, each a number",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [-1.5, true]",
            "5:17: `machine.stroke[1]` is true or false, but must be a number",
        ),
        (
            "stroke = [-1.5, 1.5]",
            "stroke = [-1.5]",
            "5:10: `machine.stroke` is a list of 1, but must be one of 2",
        ),
        (
            "[\"engaged\"]",
            "[]",
            "6:20: `machine.monitored_states` is a list of 0, but must be one of 1 to 64",
        ),
        (
            "[[cylinder]]",
            "[cylinder]",
            "41:1: `cylinder` is a table, but must be tables written as [[cylinder]]",
        ),
        (
            "[fde]                         # R1 and R2, m\nlow = 7.5e-4\nhigh = 1.0e-3\n",
            "[[fde]]\n",
            "33:1: `fde` is a list, but must be a table",
        ),
    ] {
        refused(from, to, start, "; for example ");
    }
}
