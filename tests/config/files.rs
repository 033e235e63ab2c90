//! The configuration and its DBC on disk.

use std::fs;
use std::path::Path;

use tertius::config::{ConfigError, MACHINE_FILE, MAX_SIZE, load};
use tertius_testing::top;

const EXAMPLE: &str = include_str!("example.toml");

/// A machine's folder: `config/machine.toml` and, if wanted, the DBC that it names.
fn folder(config: &[u8], dbc: Option<&[u8]>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for name in ["config", "dbc"] {
        fs::create_dir(folder.path().join(name)).expect("a folder in it");
    }
    fs::write(folder.path().join("config/machine.toml"), config).expect("a file in it");
    if let Some(dbc) = dbc {
        fs::write(folder.path().join("dbc/e-type.dbc"), dbc).expect("a file in it");
    }
    folder
}

/// What is said about it, without the folder's name.
fn refusal(folder: &Path, file: &str) -> String {
    let error: ConfigError = load(&folder.join(file)).expect_err("it is broken");
    error.to_string().replace(&folder.display().to_string(), "F")
}

#[test]
fn the_dbc_is_found_from_the_configuration_and_kept_as_it_is() {
    let dbc = b"VERSION \"\" // \xb0C in Latin-1";
    let folder = folder(EXAMPLE.as_bytes(), Some(dbc));
    let loaded = load(&folder.path().join("config/machine.toml")).expect("it is sound");
    assert_eq!(loaded.dbc_text, dbc);
    assert_eq!(loaded.dbc_path, folder.path().join("config/../dbc/e-type.dbc"));
    assert_eq!(loaded.settings.machine.cylinders, 6);
    assert_eq!(loaded.document.text(), EXAMPLE);
    assert!(loaded.document.name().ends_with("config/machine.toml"));
}

#[test]
fn a_missing_dbc_is_reported_at_its_key() {
    let folder = folder(EXAMPLE.as_bytes(), None);
    assert_eq!(
        refusal(folder.path(), "config/machine.toml"),
        "F/config/machine.toml:10:7: the DBC F/config/../dbc/e-type.dbc cannot be read: No such \
         file or directory (os error 2) (`bus.dbc` is relative to the folder of this \
         configuration; put the DBC there or correct the path)"
    );
}

#[test]
fn an_unreadable_configuration_says_why() {
    let folder = folder(EXAMPLE.as_bytes(), None);
    for (file, reason) in
        [("config/nothing.toml", "No such file or directory"), ("config", "Is a directory")]
    {
        let line = refusal(folder.path(), file);
        assert!(line.starts_with(&format!("F/{file}: cannot be read: {reason}")), "{line}");
    }
}

#[test]
fn text_that_is_not_utf8_is_refused_at_its_byte() {
    let mut bytes = "[machine]\n# µ 27 ".as_bytes().to_vec();
    bytes.extend(b"\xb0C\n");
    let folder = folder(&bytes, None);
    let line = refusal(folder.path(), "config/machine.toml");
    let start = "F/config/machine.toml:2:8: byte 0xB0 is not UTF-8 (save the file as UTF-8";
    assert!(line.starts_with(start), "{line}");
}

#[test]
fn a_file_that_cannot_be_a_configuration_is_not_read_to_its_end() {
    let folder = folder(&vec![b'#'; MAX_SIZE + 1], None);
    let line = refusal(folder.path(), "config/machine.toml");
    assert!(line.starts_with("F/config/machine.toml: longer than 1048576 bytes ("), "{line}");
    let endless = load(Path::new("/dev/zero")).expect_err("it has no end");
    assert!(endless.to_string().contains("it is a pipe or a device, expected a file"), "{endless}");
}

#[test]
fn a_machine_in_one_folder_is_the_same_machine() {
    let path = top().join("config/e-type-canopen.toml");
    let there = load(&path).expect("it ships");
    let sheets = there.sheets.len();
    assert!(sheets > 1, "it has EDS files");
    let taken = "encoder.eds";
    let files = there.portable(&[taken]).expect("it is TOML");
    assert!(files.iter().all(|file| !file.name.contains('/') && file.name != taken));
    assert!(files.iter().any(|file| file.name == "2-encoder.eds"));
    let folder = tempfile::tempdir().expect("there is room");
    for file in &files {
        fs::write(folder.path().join(&file.name), &file.bytes).expect("the folder is ours");
    }
    let here = load(&folder.path().join(MACHINE_FILE)).expect("it is whole");
    assert_eq!(here.layout(), there.layout());
    let line = |text: &str| text.lines().count();
    assert_eq!(line(here.document.text()), line(there.document.text()), "comments stay");
    // Nothing but paths is another.
    let mut settings = here.settings.clone();
    settings.bus.dbc.clone_from(&there.settings.bus.dbc);
    settings.canopen.device.clone_from(&there.settings.canopen.device);
    assert_eq!(settings, there.settings);
}
