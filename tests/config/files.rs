//! The configuration and its DBC on disk.

use std::fs;
use std::path::Path;

use tertius::config::{ConfigError, Fingerprints, MACHINE_FILE, MAX_SIZE, load, relocate};
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

/// Where things are kept, who logs in and by what is nobody's business elsewhere, and changes nothing of what is judged.
#[test]
fn what_is_given_away_has_no_token_and_no_paths_of_the_site() {
    let digest = "8d1d2c4c9f6a1b1be0a6e4a77c6f9b0d5a0fbf2f5e0c4f4f7f0f4a3b2a7d6c19";
    let site = format!(
        "\n[http]\ntoken = \"{digest}\" # of Eva\ncertificate = \"/srv/site/page.crt\"\nkey = \"/srv/site/page.key\"\n\
         [mqtt]\nbroker = \"broker.example:8883\"\nuser = \"site-user\"\npassword = \"/srv/site/secret\"\n\
         authority = \"/srv/site/ca.crt\"\n[store]\nfile = \"/srv/site/kept.events\"\nsize = 64\n\
         [recorder]\nfolder = \"/srv/site/recordings\"\n"
    );
    let dbc = fs::read(top().join("dbc/e-type.dbc")).expect("it ships");
    let there = folder((EXAMPLE.to_owned() + &site).as_bytes(), Some(&dbc));
    let loaded = load(&there.path().join("config/machine.toml")).expect("it is sound");
    let files = loaded.portable(&[]).expect("it is TOML");
    let text = String::from_utf8(files[0].bytes.clone()).expect("text");
    for word in [digest, "/srv/site", "site-user", "Eva"] {
        assert!(!text.contains(word), "{word} is in\n{text}");
    }
    assert!(text.contains("size = 64"), "{text}");
    let here = tempfile::tempdir().expect("there is room");
    for file in &files {
        fs::write(here.path().join(&file.name), &file.bytes).expect("the folder is ours");
    }
    let elsewhere = load(&here.path().join(MACHINE_FILE)).expect("it is whole");
    assert_eq!(elsewhere.fingerprints(), loaded.fingerprints(), "it is the same machine");
}

/// The identities of the machine with this configuration and DBC.
fn fingerprints(config: &str, dbc: &[u8]) -> Fingerprints {
    let folder = folder(config.as_bytes(), Some(dbc));
    load(&folder.path().join("config/machine.toml")).expect("it is sound").fingerprints()
}

const CALIBRATED: &str =
    "\n[calibration]\nrecorded = \"2026-03-14\"\n\n[[cylinder]]\nn = 2\nc2_gain = 1.001\n";

/// Comments, blanks, the order of tables and the spelling of numbers are not what a machine is judged by.
#[test]
fn what_is_said_otherwise_has_the_same_identity() {
    let calibrated = format!("{EXAMPLE}{CALIBRATED}");
    let one = fingerprints(&calibrated, b"dbc");
    assert_eq!(one.recorded.as_deref(), Some("2026-03-14"));
    let digits = one.configuration.to_string();
    assert!(digits.len() == 8 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()), "{digits}");

    let table: toml::Table = calibrated.parse().expect("it is TOML");
    let bare = toml::to_string(&table).expect("it was TOML");
    assert!(!bare.contains('#') && bare != calibrated);
    let spelt = bare.replace("c2_gain = 1.001", "c2_gain = 1.0010e0");
    assert_ne!(spelt, bare);
    for same in [bare, spelt] {
        assert_eq!(fingerprints(&same, b"dbc"), one);
    }

    let found = folder(calibrated.as_bytes(), Some(b"dbc"));
    let loaded = load(&found.path().join("config/machine.toml")).expect("it is sound");
    let other = tempfile::tempdir().expect("a temporary folder");
    for file in loaded.portable(&[]).expect("it is TOML") {
        fs::write(other.path().join(file.name), file.bytes).expect("a file in it");
    }
    let moved = load(&other.path().join(MACHINE_FILE)).expect("it is sound");
    assert_ne!(moved.document.text(), loaded.document.text(), "its DBC is elsewhere");
    assert_eq!(moved.fingerprints(), one);
}

#[test]
fn what_says_something_else_has_another_identity() {
    let calibrated = format!("{EXAMPLE}{CALIBRATED}");
    let one = fingerprints(&calibrated, b"dbc");
    let with = |from: &str, to: &str| {
        assert_eq!(calibrated.matches(from).count(), 1, "{from}");
        fingerprints(&calibrated.replace(from, to), b"dbc")
    };
    let limit = with("low = 7.5e-4", "low = 7.6e-4");
    assert_ne!(limit.configuration, one.configuration);
    assert_eq!(limit.calibration, one.calibration, "a threshold is not measured");
    for measured in [
        with("c2_gain = 1.001", "c2_gain = 1.0010000000000001"),
        with("c2_gain = 1.001", "c2_offset = 1.001"),
        with("n = 2\nc2", "n = 3\nc2"),
        with("03-14", "03-15"),
    ] {
        assert_ne!(measured.configuration, one.configuration);
        assert_ne!(measured.calibration, one.calibration);
    }
    let dbc = fingerprints(&calibrated, b"DBC");
    assert_ne!(dbc.configuration, one.configuration);
    assert_eq!(dbc.calibration, one.calibration);
    let (bare, _) = EXAMPLE.split_once("[[cylinder]]").expect("it has one");
    assert_eq!(fingerprints(bare, b"dbc").calibration, None);
}

#[test]
fn a_day_that_is_none_is_refused() {
    for day in
        ["", "14.3.2026", "2026-3-14", "2026-00-14", "2026-13-01", "2026-03-32", "2026-03-14Z"]
    {
        let config = format!("{EXAMPLE}\n[calibration]\nrecorded = \"{day}\"\n");
        let folder = folder(config.as_bytes(), Some(b""));
        let said = refusal(folder.path(), "config/machine.toml");
        assert!(said.contains("a day as YYYY-MM-DD") && said.contains("2026-03-14"), "{said}");
    }
}

#[test]
fn in_another_folder_a_configuration_names_the_same_files() {
    let old = top().join("config");
    let text = fs::read_to_string(old.join("e-type-canopen.toml")).expect("it is there");
    let moved = relocate(&text, &old.display().to_string()).expect("it is TOML");
    let new = folder(moved.as_bytes(), None);
    let [before, after] = [old.join("e-type-canopen.toml"), new.path().join("config/machine.toml")]
        .map(|path| load(&path).expect("all is found"));
    let sheets = before.sheets.iter().map(|it| &it.path);
    assert!(sheets.eq(after.sheets.iter().map(|it| &it.path)));
    assert_eq!(before.dbc_path, after.dbc_path);
}

#[test]
fn only_relative_paths_change_with_the_folder() {
    let text = "\
[bus]
dbc = \"../dbc/e-type.dbc\" # of the maker
[sequential]
history = \"/var/lib/tertius/e-type.dwells\"
[store]
file = 'events'
[http]
listen = \"127.0.0.1:9481\"
certificate = \"page.crt\"
key = \"page.key\"
[mqtt]
authority = \"system\"
password = \"secret\"
[recorder]
folder = \"recordings\"
[canopen]
device = [{ eds = \"a.eds\" }, { eds = \"/b.eds\" }]
";
    let moved = relocate(text, "/etc/tertius").expect("it is TOML");
    let changes = [
        ("\"../dbc/e-type.dbc\"", "\"/etc/tertius/../dbc/e-type.dbc\""),
        ("'events'", "\"/etc/tertius/events\""),
        ("\"page.crt\"", "\"/etc/tertius/page.crt\""),
        ("\"page.key\"", "\"/etc/tertius/page.key\""),
        ("\"secret\"", "\"/etc/tertius/secret\""),
        ("\"recordings\"", "\"/etc/tertius/recordings\""),
        ("\"a.eds\"", "\"/etc/tertius/a.eds\""),
    ];
    let expected = changes.iter().fold(text.to_owned(), |text, (a, b)| text.replace(a, b));
    assert_eq!(moved, expected);
    let authority = "[mqtt]\nauthority = \"ca.crt\"\n";
    let moved = relocate(authority, "/").expect("it is TOML");
    assert_eq!(moved, "[mqtt]\nauthority = \"/ca.crt\"\n");
}
