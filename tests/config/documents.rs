//! The list of keys in docs/CONFIGURATION.md and the default configuration follow from the declarations.
//!
//! `UPDATE_GOLDEN=1 cargo test --test config documents` writes the list anew, and puts keys that are missing
//! into the default configuration.

use std::fmt::Write as _;
use std::{env, fs};

use tertius::config::reference::{KeyEntry, entries};
use tertius_testing::oracle::top;

const BEGIN: &str =
    "<!-- The list of keys, by `UPDATE_GOLDEN=1 cargo test --test config documents` -->\n";
const ADVICE: &str = "write it anew: UPDATE_GOLDEN=1 cargo test --test config documents";

fn updates() -> bool {
    env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1")
}

/// Compares a file with what it should be, or makes it so.
fn compare(path: &str, found: &str, expected: &str) {
    if updates() && found != expected {
        fs::write(top().join(path), expected).expect("it can be written");
    } else {
        assert!(found == expected, "{path} does not follow from the declarations; {ADVICE}");
    }
}

/// The rows of a table of the file.
fn rows(entries: &[KeyEntry], table: &str) -> String {
    let mut text =
        String::from("\n| key | values | default | purpose |\n| --- | --- | --- | --- |\n");
    for entry in entries.iter().filter(|entry| entry.table == table && !entry.is_table) {
        let default = match &entry.default {
            Some(default) => format!("`{default}`"),
            None if entry.is_required => format!("required, as `{}`", entry.example),
            None => format!("none, as `{}`", entry.example),
        };
        let KeyEntry { name, values, what, .. } = entry;
        let [values, what] = [values, *what].map(|text| text.replace('|', "\\|"));
        _ = writeln!(text, "| `{name}` | {values} | {default} | {what} |");
    }
    text
}

#[test]
fn the_documentation_lists_the_keys() {
    let entries = entries();
    let mut list = BEGIN.to_owned();
    for table in entries.iter().filter(|entry| entry.is_table) {
        let header = match table.values.as_str() {
            "tables" => format!("[[{}]]", table.path),
            _ => format!("[{}]", table.path),
        };
        let need = if table.is_required { ", which is required" } else { "" };
        let what = table.what;
        _ = write!(
            list,
            "\n### `{header}`\n\nThe table{need}: {what}.\n{}",
            rows(&entries, &table.path)
        );
    }
    let path = "docs/CONFIGURATION.md";
    let found = fs::read_to_string(top().join(path)).expect("it is there");
    let (before, _) = found.split_once(BEGIN).expect("the list begins there");
    compare(path, &found, &format!("{before}{list}"));
}

#[test]
fn the_schema_follows_from_the_keys() {
    let path = "config/tertius.schema.json";
    let found = fs::read_to_string(top().join(path)).unwrap_or_default();
    compare(path, &found, &tertius::config::json_schema());
}

/// Where the lines of a table begin and end in the default configuration; commented ones count.
fn lines_of<'a>(text: &'a str, table: &str) -> Vec<&'a str> {
    let header = |line: &str| line.trim_start_matches(['#', ' ']).starts_with('[');
    let own = format!("[{table}]");
    let is_own = |line: &str| line.starts_with(&own) || line == format!("# {own}");
    let start = |line: &&str| !is_own(line);
    text.lines().skip_while(start).skip(1).take_while(|line| !header(line)).collect()
}

#[test]
fn the_default_configuration_has_every_key_with_its_default() {
    let path = "config/e-type.toml";
    let found = fs::read_to_string(top().join(path)).expect("it is there");
    let mut expected = found.clone();
    // Of tables that are alike the file has the beginning only, or nothing; nor has it what is learnt.
    let lists = ["cylinder", "canopen.device", "bus.third", "bus.fourth", "process.supply"];
    let whole = |entry: &&KeyEntry| {
        !entry.is_table && !lists.iter().any(|list| entry.table.starts_with(list))
    };
    for entry in entries().iter().filter(whole) {
        let lines = lines_of(&expected, &entry.table);
        let start = format!("{} = ", entry.name);
        let own = lines.iter().find(|line| line.trim_start_matches("# ").starts_with(&start));
        let Some(line) = own else {
            let value = match &entry.default {
                Some(default) => format!("{start}{default}"),
                None => format!("# {start}{}", entry.example),
            };
            let last = lines.iter().rfind(|line| !line.trim().is_empty()).expect("it has lines");
            let added = format!("{last}\n{value:<31} # {}", entry.what);
            expected = expected.replacen(last, &added, 1);
            continue;
        };
        let value: toml::Table = line.trim_start_matches("# ").parse().expect("it is TOML");
        // A table that is commented out is an example, for the gateway is no node by default.
        if let Some(default) = entry.default.as_ref().filter(|_| entry.table != "canopen") {
            let default: toml::Table = format!("{start}{default}").parse().expect("it is TOML");
            assert_eq!(value, default, "{}", entry.path);
        }
    }
    compare(path, &found, &expected);
}
