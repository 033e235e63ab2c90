//! `tertius.toml(5)`, from the table of keys.

use super::roff::{Document, Page};
use tertius::config::reference::{KeyEntry, entries};

const NAME: &str = "tertius.toml";

/// The page of the configuration file.
pub fn page() -> Document {
    let mut page = Page::new(NAME, "5");
    page.heading("NAME");
    page.roff("tertius.toml \\- configuration of a machine that tertius(1) monitors");
    page.heading("DESCRIPTION");
    page.paragraph(
        "A configuration describes one machine, in TOML: its bus, its signals in a DBC, and how they are judged. \
         The file may have any name; the service of the package reads /etc/tertius/machine.toml. Paths in it are \
         relative to the file.",
    );
    page.paragraph(
        "Lengths are metres, times seconds, and speeds metres per second. A key that is left out has its default. \
         An unknown key, a wrong type and a value out of range are errors: check the file after each change with",
    );
    page.block(&["tertius check /etc/tertius/machine.toml"]);
    page.paragraph("Numbers in brackets, such as (4-1), are the equations of Claassen's thesis (TU Delft, 2018).");
    page.heading("KEYS");
    let entries = entries();
    for table in entries.iter().filter(|entry| entry.is_table) {
        let header = match table.values.as_str() {
            "tables" => format!("[[{}]]", table.path),
            _ => format!("[{}]", table.path),
        };
        page.subheading(&header);
        let need = if table.is_required { "Required: " } else { "Optional: " };
        page.paragraph(&format!("{need}{}.", table.what));
        for key in entries.iter().filter(|key| key.table == table.path && !key.is_table) {
            describe(&mut page, key);
        }
    }
    page.heading("FILES");
    page.entry(
        "/etc/tertius/config/e-type.toml",
        "",
        "The default, with a comment for each number.",
    );
    page.heading("SEE ALSO");
    page.paragraph("tertius(1), tertius-check(1), tertius-commission(1), tertius-run(1)");
    page.document(NAME, "5")
}

fn describe(page: &mut Page, key: &KeyEntry) {
    page.entry(key.name, "", &format!("{}.", capitalised(key.what)));
    let otherwise = match &key.default {
        Some(default) => format!("Default: {default}."),
        None if key.is_required => format!("Required, for example {}.", key.example),
        None => format!("No default; for example {}.", key.example),
    };
    page.more(&format!("Values: {}. {otherwise}", key.values));
}

fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters
        .next()
        .map_or(String::new(), |first| first.to_uppercase().chain(characters).collect())
}
