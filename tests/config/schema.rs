//! The JSON Schema against jsonschema in Python: what ships is valid by it, and what it refuses is refused here, too.

use crate::common::{EXAMPLE, broken, refusal};
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::fs;
use tertius::config::json_schema;
use tertius::config::reference::{KeyEntry, entries};
use tertius_testing::oracle::{self, top};
use toml::{Table, Value};

/// What the schema says of each of `texts`.
fn verdicts(texts: &[String]) -> Vec<String> {
    let input = serde_json::to_string(texts).expect("JSON");
    let told = oracle::run("schema.py", &["config/tertius.schema.json"], &input);
    let told: Vec<String> = told.lines().map(str::to_owned).collect();
    assert_eq!(told.len(), texts.len());
    told
}

#[test]
fn every_shipped_configuration_is_valid() {
    let mut names = Vec::new();
    for folder in ["config", "tests/recordings"] {
        let entries = fs::read_dir(top().join(folder)).expect("it can be read");
        let paths = entries.map(|entry| entry.expect("it is there").path());
        // A plant is a file of another kind: what the simulator moves.
        let own = |name: &str| name.ends_with(".toml") && !name.ends_with("-plant.toml");
        names.extend(paths.filter(|path| own(&path.to_string_lossy())));
    }
    assert!(names.len() >= 8, "{names:?}");
    let texts: Vec<String> =
        names.iter().map(|path| fs::read_to_string(path).expect("it can be read")).collect();
    for (name, verdict) in names.iter().zip(verdicts(&texts)) {
        assert_eq!(verdict, "valid", "{}", name.display());
    }
}

/// All keys by their full names.
struct Keys(BTreeMap<String, KeyEntry>);

impl Keys {
    fn of(&self, path: &str) -> &KeyEntry {
        self.0.get(path).unwrap_or_else(|| panic!("there is no {path}"))
    }

    /// The names of the keys without which the table `path` is refused.
    fn required<'a>(&'a self, path: &'a str) -> impl Iterator<Item = &'a KeyEntry> {
        self.0.values().filter(move |key| key.table == path && key.is_required)
    }

    /// The table `path` of `root`, made with its required keys if it is not there; of a list, the first one.
    fn table<'a>(&self, root: &'a mut Table, path: &str) -> &'a mut Table {
        let mut table = root;
        let mut whole = String::new();
        for name in path.split('.').filter(|name| !name.is_empty()) {
            whole = if whole.is_empty() { name.to_owned() } else { format!("{whole}.{name}") };
            let is_list = self.of(&whole).values == "tables";
            let fresh = || {
                let keys = self.required(&whole).filter(|key| !key.is_table);
                let fresh =
                    Value::Table(keys.map(|key| (key.name.to_owned(), example(key))).collect());
                if is_list { Value::Array(vec![fresh]) } else { fresh }
            };
            let found = table.entry(name).or_insert_with(fresh);
            let found = if is_list { &mut found.as_array_mut().expect("a list")[0] } else { found };
            table = found.as_table_mut().expect("a table");
        }
        table
    }
}

fn example(key: &KeyEntry) -> Value {
    let table: Table = format!("value = {}", key.example).parse().expect("it is TOML");
    table["value"].clone()
}

/// Part of the schema that describes the key `path`.
fn described<'a>(schema: &'a Json, path: &str) -> &'a Json {
    let step = |at: &'a Json, name: &str| {
        let table = if at["type"] == "array" { &at["items"] } else { at };
        &table["properties"][name]
    };
    path.split('.').filter(|name| !name.is_empty()).fold(schema, step)
}

/// Values that `rule` does not allow.
fn wrong(rule: &Json, good: &Value) -> Vec<Value> {
    let text = |text: &str| Value::String(text.to_owned());
    let mut all = Vec::new();
    match rule["type"].as_str().expect("a type") {
        "boolean" => all.extend([text("yes"), Value::Integer(1)]),
        "string" => {
            all.extend([Value::Integer(7), Value::Boolean(true), text(""), text("\u{7}bell")]);
            let longest = rule["maxLength"].as_u64();
            all.extend(longest.map(|longest| Value::String("x".repeat(longest as usize + 1))));
        }
        "number" => {
            all.extend([text("0.1"), Value::Boolean(true)]);
            let beyond =
                |limit: f64, side: f64| Value::Float(limit + side * limit.abs().max(1.0) * 0.1);
            all.extend(rule["minimum"].as_f64().map(|limit| beyond(limit, -1.0)));
            all.extend(rule["maximum"].as_f64().map(|limit| beyond(limit, 1.0)));
            let excluded = [&rule["exclusiveMinimum"], &rule["exclusiveMaximum"]];
            all.extend(excluded.into_iter().filter_map(Json::as_f64).map(Value::Float));
        }
        "integer" => {
            all.extend([text("1"), Value::Float(1.5)]);
            all.extend(
                rule["minimum"].as_i64().and_then(|it| it.checked_sub(1)).map(Value::Integer),
            );
            all.extend(
                rule["maximum"].as_i64().and_then(|it| it.checked_add(1)).map(Value::Integer),
            );
        }
        "array" => {
            let list = good.as_array().expect("a list");
            all.push(Value::Integer(7));
            for bad in wrong(&rule["items"], &list[0]) {
                let mut list = list.clone();
                list[0] = bad;
                all.push(Value::Array(list));
            }
            let counted = |count: u64| Value::Array(vec![list[0].clone(); count as usize]);
            let few = rule["minItems"].as_u64().and_then(|least| least.checked_sub(1));
            let many = rule["maxItems"].as_u64().map(|most| most + 1);
            all.extend([few, many].into_iter().flatten().map(counted));
        }
        other => panic!("a key of type {other}"),
    }
    all
}

/// Configurations with one mistake, each with the name of the key that is wrong in it.
fn mutants() -> Vec<(String, String)> {
    let schema: Json = serde_json::from_str(&json_schema()).expect("JSON");
    let keys = Keys(entries().into_iter().map(|key| (key.path.clone(), key)).collect());
    let sound: Table = EXAMPLE.parse().expect("it is TOML");
    let mut all = Vec::new();
    let mut add = |table: &str, name: &str, change: &dyn Fn(&mut Table)| {
        let mut mutant = sound.clone();
        change(keys.table(&mut mutant, table));
        all.push((name.to_owned(), toml::to_string(&mutant).expect("TOML")));
    };
    for key in keys.0.values().filter(|key| !key.is_table) {
        for bad in wrong(described(&schema, &key.path), &example(key)) {
            add(&key.table, key.name, &|table| _ = table.insert(key.name.to_owned(), bad.clone()));
        }
        if key.is_required {
            add(&key.table, key.name, &|table| _ = table.remove(key.name));
        }
    }
    for table in keys.0.values().filter(|key| key.is_table) {
        add(&table.path, "surplus", &|inner| {
            _ = inner.insert("surplus".to_owned(), Value::Integer(1))
        });
        add(&table.table, table.name, &|outer| {
            _ = outer.insert(table.name.to_owned(), Value::Integer(1))
        });
        if table.is_required {
            add(&table.table, table.name, &|outer| _ = outer.remove(table.name));
        }
    }
    all
}

#[test]
fn what_the_schema_refuses_is_refused_by_check_too() {
    let mutants = mutants();
    assert!(mutants.len() > 550, "{}", mutants.len());
    let texts: Vec<String> = mutants.iter().map(|(_, text)| text.clone()).collect();
    for ((name, text), verdict) in mutants.iter().zip(verdicts(&texts)) {
        assert!(verdict.starts_with("refused\t"), "the schema takes it, {name} is wrong:\n{text}");
        let lines = refusal(text);
        let named = lines
            .iter()
            .any(|line| line.contains(&format!("{name}`")) || line.contains(&format!("{name}]")));
        assert!(
            named || lines.iter().any(|line| line.contains(name)),
            "{name} is not in {lines:?}"
        );
    }
}

/// What only `tertius check` refuses: how keys fit each other, and what JSON cannot tell. docs/CONFIGURATION.md lists it.
const BEYOND_THE_SCHEMA: [(&str, &str, &str); 22] = [
    // Keys that have to fit each other.
    ("stroke = [-1.5, 1.5]", "stroke = [1.5, -1.5]", "must run upwards"),
    ("sample_time = 0.02 ", "sample_time = 0.02\ncycle_deadline = 0.03", "half of the sample time"),
    ("[model]", "[plausibility]\nstale = 0.01\n[model]", "at least the sample time"),
    ("[model]", "[plausibility]\nvalid_raw = [9, 1]\n[model]", "must run upwards"),
    ("low = 7.5e-4", "low = 1.1e-3", "must not be above `fde.high`"),
    ("bound = 1.5e-3", "bound = 1.5e-3\nlow = 2e-3", "must not be above `comparator.bound`"),
    ("critical = 0.05", "critical = 0.001", "must be below `comparator.critical`"),
    ("[model]", "[sequential]\nmaintenance = 0.06\n[model]", "must be below `comparator.critical`"),
    ("[model]", "[gateway]\nbus_share = 0.001\n[model]", "it must be at least"),
    ("[model]", "[estimate]\nsend = true\n[model]", "with `estimate.send`"),
    ("[model]", "[canopen]\nheartbeat = 1.0\n[model]", "is of no effect"),
    ("[model]", "[http]\ncertificate = \"a.crt\"\n[model]", "belong together"),
    ("c1 = \"Cyl{n}_C1.Position\"", "c1 = \"Cyl1_C1.Position\"", "{n} is missing"),
    ("c1 = \"Cyl{n}_C1.Position\"", "c1 = \"{A,B}.Position\"", "lists 2 names"),
    ("c2 = \"Cyl{n}_C2.Position\"", "c2 = \"Cyl{n}_C1.Position\"", "the same signal"),
    ("c1 = \"Cyl{n}_C1.Position\"", "c1 = \"object 0x6020:01\"", "no [[canopen.device]]"),
    ("cylinders = 6", "cylinders = 6.0", "must be a whole number"),
    ("high = 1.0e-3", "high = nan", "finite"),
    ("high = 1.0e-3", "high = inf", "finite"),
    ("[model]", "[http]\nlisten = \"300.0.0.1:9481\"\n[model]", "ADDRESS:PORT"),
    (
        "name = \"Ampelmann E-type\"",
        "name = \"ØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØ\
      ØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØØ\"",
        "at most 200 bytes",
    ),
    ("\nn = 1\n", "\nn = 1\n[[cylinder]]\nn = 1\n", "table above already"),
];

#[test]
fn what_only_check_can_say() {
    let texts = BEYOND_THE_SCHEMA.map(|(from, to, _)| broken(from, to));
    for ((from, to, words), verdict) in BEYOND_THE_SCHEMA.iter().zip(verdicts(&texts)) {
        assert_eq!(verdict, "valid", "{to}: the schema can say it, so that it is no exception");
        let lines = refusal(&broken(from, to));
        assert!(lines.iter().any(|line| line.contains(words)), "{words:?} is not in {lines:?}");
    }
}
