//! What the Debian package is made of: every file is there or is made, and they fit together once installed.

use super::manual::{commands, configuration};
use std::fs;
use std::path::{Component, Path, PathBuf};
use tertius_testing::support::top;
use toml::{Table, Value};

/// A file of the package: where it comes from, and where it is installed, with its name.
struct Asset {
    source: String,
    path: PathBuf,
    mode: String,
}

/// The table that describes the package.
fn described() -> Table {
    let manifest: Table = read("Cargo.toml").parse().expect("TOML");
    manifest["package"]["metadata"]["deb"].as_table().expect("a table").clone()
}

fn read(path: &str) -> String {
    fs::read_to_string(top().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// All files; one with a wildcard stands for each that it matches, be it there or made by the example.
fn assets() -> Vec<Asset> {
    let made = made();
    let described = described();
    let rows = described["assets"].as_array().expect("a list");
    let expanded = rows.iter().flat_map(|row| {
        let text = |at: usize| row[at].as_str().expect("a text").to_owned();
        let (source, folder, mode) = (text(0), text(1), text(2));
        assert!(folder.ends_with('/'), "{source}: its folder ends with a slash");
        let sources = match source.rsplit_once('*') {
            None => vec![source],
            Some((before, after)) => matching(&made, before, after),
        };
        sources.into_iter().map(move |source| {
            let name = Path::new(&source).file_name().expect("a name");
            Asset { path: Path::new(&folder).join(name), source, mode: mode.clone() }
        })
    });
    expanded.collect()
}

fn matching(made: &[String], before: &str, after: &str) -> Vec<String> {
    let folder = top().join(before);
    let there: Vec<String> = match fs::read_dir(folder) {
        Ok(entries) if !before.starts_with("target/") => entries
            .map(|entry| {
                before.to_owned() + entry.expect("it is there").file_name().to_str().expect("UTF-8")
            })
            .collect(),
        _ => made.iter().filter(|path| path.starts_with(before)).cloned().collect(),
    };
    let found: Vec<String> = there.into_iter().filter(|path| path.ends_with(after)).collect();
    assert!(!found.is_empty(), "nothing is {before}*{after}");
    found
}

/// What `scripts/package` makes before the package is built.
fn made() -> Vec<String> {
    let pages = commands::pages().expect("they are written");
    let documents = pages.into_iter().chain(commands::completions()).chain([configuration::page()]);
    let paths = documents.map(|document| format!("target/package/usr/{}", document.path));
    let others = [
        "target/release/tertius",
        "target/package/third-party-notices.txt",
        "target/package/tertius.cdx.json",
    ];
    paths.chain(others.map(str::to_owned)).collect()
}

#[test]
fn every_file_of_the_package_is_there_or_is_made_and_all_that_is_made_is_in_it() {
    let (assets, made) = (assets(), made());
    for asset in &assets {
        let is_there = !asset.source.starts_with("target/") && top().join(&asset.source).is_file();
        assert!(is_there || made.contains(&asset.source), "{} is not there", asset.source);
        let mode = if asset.path.starts_with("usr/bin") { "755" } else { "644" };
        assert_eq!(asset.mode, mode, "{}", asset.source);
    }
    for made in made {
        assert!(assets.iter().any(|asset| asset.source == made), "{made} is not in the package");
    }
}

/// `path` without `..`.
fn resolved(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut path, component| {
        if component == Component::ParentDir {
            _ = path.pop()
        } else {
            path.push(component)
        }
        path
    })
}

#[test]
fn a_default_configuration_finds_its_dbc_where_both_are_installed() {
    let assets = assets();
    let configurations: Vec<&Asset> =
        assets.iter().filter(|asset| asset.path.starts_with("etc/tertius/config")).collect();
    assert!(!configurations.is_empty());
    for configuration in configurations {
        let table: Table = read(&configuration.source).parse().expect("TOML");
        let dbc = table["bus"]["dbc"].as_str().expect("a text");
        let path = resolved(&configuration.path.parent().expect("a folder").join(dbc));
        assert!(
            assets.iter().any(|asset| asset.path == path),
            "{}: no {}",
            configuration.source,
            path.display()
        );
    }
}

#[test]
fn the_schema_is_installed_where_the_documentation_points_editors_to() {
    let path = "usr/share/tertius/tertius.schema.json";
    assert!(
        assets().iter().any(|asset| asset.path == Path::new(path)),
        "{path} is not in the package"
    );
    for page in ["docs/CONFIGURATION.md", "docs/INSTALL.md"] {
        assert!(read(page).contains(&format!("/{path}")), "{page}: nothing of {path}");
    }
}

/// The value of a key of the unit that is there once.
fn of_unit<'a>(unit: &'a str, key: &str) -> &'a str {
    let mut values = unit.lines().filter_map(|line| line.strip_prefix(key)?.strip_prefix('='));
    let value = values.next().unwrap_or_else(|| panic!("no {key}"));
    assert_eq!(values.next(), None, "{key} twice");
    value
}

#[test]
fn the_service_runs_the_packaged_program_and_waits_for_a_configuration_that_the_package_does_not_bring()
 {
    let unit = read("config/systemd/tertius.service");
    let assets = assets();
    let call: Vec<&str> = of_unit(&unit, "ExecStart").split(' ').collect();
    let installed =
        |path: &str| assets.iter().any(|asset| Path::new("/").join(&asset.path) == Path::new(path));
    assert!(installed(call[0]), "{} is not in the package", call[0]);
    let at = call.iter().position(|word| *word == "--config").expect("it has a configuration");
    let configuration = of_unit(&unit, "ConditionPathExists");
    assert_eq!(call[at + 1], configuration);
    assert!(!installed(configuration), "a machine that nobody has configured would be monitored");

    // A wrong configuration is exit code 2, which another start does not mend.
    assert_eq!(
        (of_unit(&unit, "Restart"), of_unit(&unit, "RestartPreventExitStatus")),
        ("always", "2")
    );

    let units = described()["systemd-units"].clone();
    assert_eq!(units["unit-scripts"].as_str(), Some("config/systemd"));
    for key in ["enable", "start", "restart-after-upgrade"] {
        assert_eq!(units.get(key).and_then(Value::as_bool), Some(true), "{key}");
    }
}
