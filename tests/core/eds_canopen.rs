//! EDS and DCF files against Python's canopen, an independent reader.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use tertius::canopen::eds::ObjectDictionary;
use tertius::canopen::pdo::{MappedObject, Pdo, Pdos};
use tertius::dbc::text;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const NAMES: [&str; 7] = [
    "tests/eds/types.eds",
    "tests/eds/latin1.eds",
    "tests/eds/node_id.eds",
    "tests/eds/configured.dcf",
    "tests/eds/pdos.eds",
    "dbc/encoder.eds",
    "dbc/valve.eds",
];

/// The PDOs of node 5, in the script's words.
fn pdos(dictionary: &ObjectDictionary) -> Vec<String> {
    let place = |it: &MappedObject| {
        format!("0x{:04X}:{:02X}@{}+{}", it.index, it.sub_index, it.start, it.bits)
    };
    let line = |pdo: &Pdo| {
        let mut words = vec!["pdo".to_owned(), pdo.name(), format!("0x{:X}", pdo.id.value())];
        words.extend(pdo.objects.iter().map(place));
        words.join("\t")
    };
    Pdos::of(dictionary, 5).sound.iter().map(line).collect()
}

/// What canopen makes of the files, a list of lines for each.
fn canopen(paths: &[PathBuf]) -> Vec<Vec<String>> {
    let found = Command::new(Path::new(ROOT).join("scripts/oracle-python")).output().unwrap();
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    let python = String::from_utf8(found.stdout).unwrap();
    let output = Command::new(python.trim())
        .env("PYTHONIOENCODING", "utf-8")
        .arg(Path::new(ROOT).join("tests/oracle/eds.py"))
        .args(paths)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut files: Vec<Vec<String>> = Vec::new();
    for line in String::from_utf8(output.stdout).unwrap().lines() {
        match files.last_mut() {
            _ if line.starts_with("file\t") => files.push(Vec::new()),
            Some(lines) => lines.push(line.to_owned()),
            None => panic!("{line}"),
        }
    }
    files
}

/// What both have of a variable. canopen makes those of `CompactSubObj` when they are asked for, and then
/// neither names them nor maps them as the file says; of their number it knows the type alone.
fn essence(line: &str, compact: &BTreeSet<&str>) -> String {
    let parts: Vec<&str> = line.split('\t').collect();
    match parts[0] {
        number if compact.contains(number) && number.ends_with(":00") => parts[..3].join(" "),
        one if compact.contains(one) => [&parts[..4], &parts[5..6]].concat().join(" "),
        _ => line.to_owned(),
    }
}

#[test]
fn every_dialect_reads_as_in_canopen() {
    let paths: Vec<PathBuf> = NAMES.iter().map(|name| Path::new(ROOT).join(name)).collect();
    let files = canopen(&paths);
    assert_eq!(files.len(), paths.len());
    let (mut variables, mut carried) = (0, 0);
    for (path, theirs) in paths.iter().zip(&files) {
        let bytes = std::fs::read(path).unwrap();
        let dictionary = ObjectDictionary::parse(&text::from_bytes(&bytes)).unwrap();
        assert_eq!(dictionary.refused().count(), 0, "{}", path.display());
        let listing = dictionary.to_string();
        let dummies = dictionary.dummies.iter().map(|it| format!("dummy\t{it}"));
        let lines = dummies.chain(listing.lines().map(str::to_owned));
        let ours: Vec<String> = lines.chain(pdos(&dictionary)).collect();
        let compact: BTreeSet<&str> = theirs
            .iter()
            .filter_map(|it| it.strip_prefix("compact\t")?.split('\t').next())
            .collect();
        let theirs: Vec<&str> =
            theirs.iter().map(|it| it.strip_prefix("compact\t").unwrap_or(it)).collect();
        assert_eq!(ours.len(), theirs.len(), "{}", path.display());
        for (ours, theirs) in ours.iter().zip(theirs) {
            assert_eq!(essence(ours, &compact), essence(theirs, &compact), "{}", path.display());
        }
        carried += ours.iter().filter(|it| it.starts_with("pdo")).count();
        variables += listing.lines().count();
    }
    assert!(variables >= 200 && carried == 8, "{variables} variables, {carried} PDOs");
}
