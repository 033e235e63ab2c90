//! What the reader of EDS and DCF files makes of files, for comparison with other readers.
//!
//! `cargo run --example eds_objects -- FILE…`
//!
//! Each file is a line `file PATH`, and then a line for each variable, each PDO of node 5 (`pdo …`) and each
//! finding (`finding …`); or the line `refused …`. Parts of a line have tabs between them.

use std::io::Write as _;
use tertius::canopen::eds::ObjectDictionary;
use tertius::canopen::pdo::{MappedObject, Pdos};
use tertius::dbc::text;

fn main() -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    for path in std::env::args().skip(1) {
        writeln!(out, "file\t{path}")?;
        let bytes = std::fs::read(&path)?;
        match ObjectDictionary::parse(&text::from_bytes(&bytes)) {
            Err(error) => writeln!(out, "refused\t{error}")?,
            Ok(dictionary) => {
                write!(out, "{dictionary}")?;
                for data_type in &dictionary.dummies {
                    writeln!(out, "dummy\t{data_type}")?;
                }
                for pdo in Pdos::of(&dictionary, 5).sound {
                    write!(out, "pdo\t{}\t0x{:X}", pdo.name(), pdo.id.value())?;
                    for object in &pdo.objects {
                        let MappedObject { index, sub_index, start, bits, .. } = object;
                        write!(out, "\t0x{index:04X}:{sub_index:02X}@{start}+{bits}")?;
                    }
                    writeln!(out)?;
                }
                for finding in dictionary.findings() {
                    writeln!(out, "finding\t{:?}\t{finding}", finding.severity)?;
                }
            }
        }
    }
    Ok(())
}
