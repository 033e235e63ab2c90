//! The registers of Modbus TCP in docs/modbus.csv and docs/MODBUS.md follow from the map.
//!
//! `UPDATE_GOLDEN=1 cargo test --test live modbus_document` writes them anew.

use std::fmt::Write as _;
use std::{env, fs};
use tertius::appliance::outputs::modbus::map::described;
use tertius::appliance::outputs::modbus::sheet::RegisterEntry;
use tertius_testing::oracle::top;

const BEGIN: &str =
    "<!-- The registers, by `UPDATE_GOLDEN=1 cargo test --test live modbus_document` -->\n";

/// Compares a file with what it should be, or makes it so.
fn compare(path: &str, found: &str, expected: &str) {
    if env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") && found != expected {
        fs::write(top().join(path), expected).expect("it can be written");
    } else {
        let advice = "write it anew: UPDATE_GOLDEN=1 cargo test --test live modbus_document";
        assert!(found == expected, "{path} does not follow from the map; {advice}");
    }
}

#[test]
fn the_documents_list_the_registers() {
    let entries = described();
    let mut csv = String::from("address,registers,type,name,unit,meaning\n");
    for RegisterEntry { address, kind, name, unit, meaning } in &entries {
        let registers = if kind.name() == "u16" { 1 } else { 2 };
        _ = writeln!(csv, "{address},{registers},{},{name},{unit},\"{meaning}\"", kind.name());
    }
    let path = "docs/modbus.csv";
    compare(path, &fs::read_to_string(top().join(path)).unwrap_or_default(), &csv);

    let mut list = BEGIN.to_owned();
    let mut table = |title: &str, of: &dyn Fn(&RegisterEntry) -> Option<[String; 2]>| {
        _ = write!(list, "\n### {title}\n\n| address | type | name | unit | meaning |\n");
        list.push_str("| --- | --- | --- | --- | --- |\n");
        for entry in &entries {
            let Some([address, name]) = of(entry) else { continue };
            let RegisterEntry { kind, unit, meaning, .. } = entry;
            let meaning = meaning.replace('|', "\\|");
            _ = writeln!(list, "| {address} | {} | `{name}` | {unit} | {meaning} |", kind.name());
        }
    };
    table("The machine", &|entry| {
        (entry.address < 100).then(|| [entry.address.to_string(), entry.name.clone()])
    });
    table("Cylinder n", &|entry| {
        let own = (100..200).contains(&entry.address);
        let name = || entry.name.replacen("cylinder_1", "cylinder_n", 1);
        own.then(|| [format!("100 n + {}", entry.address - 100), name()])
    });
    let path = "docs/MODBUS.md";
    let found = fs::read_to_string(top().join(path)).expect("it is there");
    let (before, _) = found.split_once(BEGIN).expect("the list begins there");
    compare(path, &found, &format!("{before}{list}"));
}
