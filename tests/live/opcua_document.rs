//! The nodes of OPC UA in docs/OPCUA.md follow from the points of the telemetry, and those from the same state as the
//! registers of Modbus.
//!
//! `UPDATE_GOLDEN=1 cargo test --test live opcua_document` writes them anew.

use std::fmt::Write as _;
use std::{env, fs};
use tertius::appliance::outputs::modbus::map::described;
use tertius::appliance::telemetry::points::{Point, PointKind, PointUnit, Points};
use tertius::appliance::telemetry::snapshot::Snapshot;
use tertius_testing::oracle::top;

const BEGIN: &str =
    "<!-- The nodes, by `UPDATE_GOLDEN=1 cargo test --test live opcua_document` -->\n";

fn row(list: &mut String, point: &Point) {
    let Point { name, unit, kind, meaning, .. } = point;
    let (kind, choices) = match kind {
        PointKind::Whole => ("Int64", String::new()),
        PointKind::Real => ("Double", String::new()),
        PointKind::Time => ("UtcTime", String::new()),
        PointKind::Choice(names) => {
            let named = names.iter().enumerate().map(|(place, name)| format!("{place} {name}"));
            ("UInt32", format!(": {}", named.collect::<Vec<_>>().join(", ")))
        }
    };
    let node = name.replacen("cylinder_1_", "cylinder_n_", 1);
    let meaning = meaning.replace('|', "\\|");
    _ = writeln!(list, "| `{node}` | {kind} | {} | {meaning}{choices} |", unit.symbol());
}

#[test]
fn the_document_lists_the_nodes() {
    let points = Points::new(&Snapshot::unknown(1));
    let mut list = BEGIN.to_owned();
    for (title, points) in [("The machine", &points.machine), ("Cylinder n", &points.cylinders[0])]
    {
        _ = write!(list, "\n### {title}\n\n| node | type | unit | meaning |\n");
        list.push_str("| --- | --- | --- | --- |\n");
        points.iter().for_each(|point| row(&mut list, point));
    }
    let path = top().join("docs/OPCUA.md");
    let found = fs::read_to_string(&path).expect("it is there");
    let (before, _) = found.split_once(BEGIN).expect("the list begins there");
    let expected = format!("{before}{list}");
    if env::var_os("UPDATE_GOLDEN").is_some_and(|value| value == "1") && found != expected {
        fs::write(path, expected).expect("it can be written");
    } else {
        let advice = "write it anew: UPDATE_GOLDEN=1 cargo test --test live opcua_document";
        assert!(found == expected, "docs/OPCUA.md does not follow from the points; {advice}");
    }
}

/// Who knows one of the two knows the other.
#[test]
fn the_names_and_units_are_those_of_the_registers() {
    let points = Points::new(&Snapshot::unknown(6));
    let mut points: Vec<(String, &str)> =
        points.all().map(|it| (it.name.clone(), it.unit.symbol())).collect();
    // A point in time says by itself in what unit it is.
    let unit = |name: &str, unit: &'static str| match name.ends_with("incident_begin") {
        true => PointUnit::None.symbol(),
        false => unit,
    };
    let registers = described();
    let mut registers: Vec<(String, &str)> = registers
        .iter()
        .filter(|it| it.name != "map_version")
        .map(|it| (it.name.clone(), unit(&it.name, it.unit)))
        .collect();
    points.sort();
    registers.sort();
    assert_eq!(points, registers);
}
