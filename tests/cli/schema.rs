//! The JSON Schema as `config --schema` prints it, against jsonschema in Python and against `check`.

use std::fs;
use tertius_testing::oracle;
use tertius_testing::support::{Scratch, changed, tertius, top};

/// Whether the schema in the file `path` takes each of `texts`.
fn taken(path: &str, texts: &[String]) -> Vec<bool> {
    let input = serde_json::to_string(texts).expect("JSON");
    let told = oracle::run("schema.py", &[path], &input);
    told.lines().map(|line| line == "valid").collect()
}

#[test]
fn the_schema_and_check_judge_alike() {
    let scratch = Scratch::new();
    let schema = scratch.write("schema.json", tertius(&["config", "--schema"], b"").ok().stdout);
    let defaults = tertius(&["config", "--defaults"], b"").ok().stdout;
    fs::copy(top().join("dbc/e-type.dbc"), scratch.path("e-type.dbc")).expect("it can be copied");
    let defaults = changed(&defaults, &[("\"../dbc/e-type.dbc\"", "\"e-type.dbc\"")]);
    let sound = [("clear = 1.0 ", "clear = 2.5 "), ("located = \"yellow\"", "located = \"red\"")];
    let mistakes = [
        ("\nsample_time = 0.02 ", "\nsampel_time = 0.02 "),
        ("[alarm]\n", "[alarm]\nsurplus = 1\n"),
        ("clear = 1.0 ", "clear = \"1.0\" "),
        ("clear = 1.0 ", "clear = -1.0 "),
        ("\ncylinders = 6 ", "\ncylinders = 7 "),
        ("\ncylinders = 6 ", "\n# "),
        ("located = \"yellow\"", "located = \"purple\""),
        ("q = [5e-9, 2e-4, 1e4] ", "q = [5e-9, 2e-4] "),
        ("\ncontrol_speed = ", "\n# "),
        ("node = 81 ", "node = 128 "),
        ("interface = \"can0\"", "interface = \"a name that is too long\""),
        ("listen = \"127.0.0.1:9481\"", "listen = \"somewhere\""),
    ];
    let changes = sound.iter().chain(&mistakes).map(|change| changed(&defaults, &[*change]));
    let texts: Vec<String> = std::iter::once(defaults.clone()).chain(changes).collect();
    for (n, (text, taken)) in texts.iter().zip(taken(&schema, &texts)).enumerate() {
        let run = tertius(&["check", &scratch.write("machine.toml", text)], b"");
        let is_sound = n <= sound.len();
        assert_eq!(taken, is_sound, "number {n} by the schema");
        assert_eq!(run.code, Some(if is_sound { 0 } else { 2 }), "number {n}: {}", run.stderr);
    }
}
