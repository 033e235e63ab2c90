//! A configuration and all that it names, as files of one folder, so that it can be read elsewhere.

use super::identity::SITE;
use super::loader::Loaded;
use std::collections::BTreeMap;
use toml_edit::{ArrayOfTables, DocumentMut, Item, TableLike, TomlError};

/// Name of the configuration among the files.
pub const MACHINE_FILE: &str = "machine.toml";

/// A file of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortableFile {
    /// Name in the folder.
    pub name: String,
    pub bytes: Vec<u8>,
}

impl Loaded {
    /// The configuration, as [`MACHINE_FILE`], with its DBC and its EDS files, as they were read, and with the overrides in force: paths are
    /// replaced by names in one folder. What is of the site and of no use elsewhere is left out: where things are kept, the
    /// digest of the token, certificates and who logs in at a broker. Everything else stays. Names in `taken` are not used.
    ///
    /// # Errors
    /// The configuration is not TOML, which cannot be of one that was loaded.
    pub fn portable(&self, taken: &[&str]) -> Result<Vec<PortableFile>, TomlError> {
        let mut document: DocumentMut = self.document.effective().parse()?;
        let taken = taken.iter().chain([&MACHINE_FILE]).map(|name| (*name).to_owned());
        let mut names = Names(taken.collect());
        let mut files = vec![PortableFile { name: MACHINE_FILE.to_owned(), bytes: Vec::new() }];

        let dbc = names.of(&self.settings.bus.dbc);
        let bus = document.get_mut("bus").and_then(Item::as_table_like_mut);
        replace(bus, "dbc", &dbc);
        files.push(PortableFile { name: dbc, bytes: self.dbc_text.clone() });

        let mut sheets = BTreeMap::new();
        for sheet in &self.sheets {
            let name = names.of(&sheet.name);
            sheets.insert(sheet.name.as_str(), name.clone());
            files.push(PortableFile { name, bytes: sheet.text.clone() });
        }
        let canopen = document.get_mut("canopen").and_then(Item::as_table_like_mut);
        let devices = canopen.and_then(|canopen| canopen.get_mut("device"));
        let devices = devices.and_then(Item::as_array_of_tables_mut);
        for device in devices.into_iter().flat_map(ArrayOfTables::iter_mut) {
            let name = device.get("eds").and_then(Item::as_str).and_then(|eds| sheets.get(eds));
            if let Some(name) = name.cloned() {
                replace(Some(device), "eds", &name);
            }
        }
        for (table, key) in SITE {
            if let Some(table) = document.get_mut(table).and_then(Item::as_table_like_mut) {
                table.remove(key);
            }
        }
        files[0].bytes = document.to_string().into_bytes();
        Ok(files)
    }
}

/// Replaces the text of a key; comments stay.
fn replace(table: Option<&mut dyn TableLike>, key: &str, text: &str) {
    if let Some(value) = table.and_then(|table| table.get_mut(key)).and_then(Item::as_value_mut) {
        let decor = value.decor().clone();
        *value = text.into();
        *value.decor_mut() = decor;
    }
}

/// Names that are taken.
struct Names(Vec<String>);

impl Names {
    /// The name of the file `path`, with a number before it if another one has it.
    fn of(&mut self, path: &str) -> String {
        let own = path.rsplit('/').next().unwrap_or(path);
        let numbered = (2..).map(|n| format!("{n}-{own}"));
        let mut names = std::iter::once(own.to_owned()).chain(numbered);
        let free = names.find(|name| !self.0.contains(name)).unwrap_or_default();
        self.0.push(free.clone());
        free
    }
}
