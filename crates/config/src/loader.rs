//! Reads the configuration from the file system: the only part of this crate that reads files.

use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::overrides::Overrides;
use super::settings::Settings;
use super::{ConfigError, Document, MAX_SIZE, a_dbc, is_dbc, parse_with, too_long};

/// The longest DBC file, bytes.
pub const MAX_DBC_SIZE: usize = 64 << 20;

/// The longest EDS or DCF file, bytes.
pub const MAX_SHEET_SIZE: usize = 4 << 20;

/// An EDS or DCF as on disk.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// The path as the configuration has it.
    pub name: String,
    /// The path that it was read from.
    pub path: PathBuf,
    /// Its bytes; their encoding is found by its reader.
    pub text: Vec<u8>,
}

/// A configuration with the DBC that it names.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub settings: Settings,
    pub document: Document,
    /// Path that the DBC was read from.
    pub dbc_path: PathBuf,
    /// Bytes of the DBC as on disk; the DBC reader determines their encoding.
    pub dbc_text: Vec<u8>,
    /// The EDS and DCF files that it names, each once.
    pub sheets: Vec<Sheet>,
    /// Path of the file in which the gateway keeps its readings on the stops; the file need not
    /// exist.
    pub history_path: Option<PathBuf>,
    /// Path of the event store; the file need not exist.
    pub store_path: Option<PathBuf>,
}

impl Loaded {
    /// Whether the file has a model of its machine, or of one of its cylinders; otherwise the thesis's is taken.
    pub fn has_model(&self) -> bool {
        let own = |n: usize| self.document.has(&format!("cylinder[{n}].theta"));
        self.document.has("model") || (0..self.settings.cylinder.len()).any(own)
    }

    /// The file's name, and the overrides in force: `machine.toml, with --set fde.high=0.002`.
    pub fn title(&self) -> String {
        let overrides = self.document.overrides().all().iter().map(ToString::to_string);
        let overrides: Vec<String> = overrides.collect();
        match overrides.is_empty() {
            true => self.document.name().to_owned(),
            false => format!("{}, with {}", self.document.name(), overrides.join(" ")),
        }
    }

    /// Whether overrides make it another configuration than that of the file.
    pub fn differs_from_file(&self) -> bool {
        let values = |text: &str| text.parse::<toml::Table>().ok();
        values(self.document.text()) != values(self.document.effective())
    }

    /// Bytes of all files that say where signals are in frames: the DBC, and then each EDS or DCF.
    pub fn layout(&self) -> Vec<u8> {
        let sheets = self.sheets.iter().map(|sheet| sheet.text.as_slice());
        [self.dbc_text.as_slice()].into_iter().chain(sheets).collect::<Vec<_>>().concat()
    }
}

/// Reads a configuration and its DBC; the paths in it are relative to its folder.
///
/// # Errors
/// A file cannot be read, is too long or is not UTF-8, or [`super::parse`] refuses it.
pub fn load(path: &Path) -> Result<Loaded, ConfigError> {
    load_with(path, &Overrides::default())
}

/// As [`load`], with values of single keys from outside of the file. Paths among them are relative to the file's
/// folder, too.
///
/// # Errors
/// See [`load`] and [`super::parse_with`].
pub fn load_with(path: &Path, overrides: &Overrides) -> Result<Loaded, ConfigError> {
    let name = path.display().to_string();
    let bytes = match read(path, MAX_SIZE) {
        Ok(Some(bytes)) => bytes,
        Ok(None) => return Err(too_long(&name)),
        Err(error) => {
            let help = "give the path of a configuration, for example config/e-type.toml";
            return Err(ConfigError::of_file(&name, format!("cannot be read: {error}"), help));
        }
    };
    let text = String::from_utf8(bytes).map_err(|error| not_utf8(&name, &error))?;
    of_text(path, &text, overrides)
}

/// Reads the DBC of the configuration `text`, which is, or will be, in the file `path`.
///
/// # Errors
/// See [`load`].
pub fn load_text(path: &Path, text: &str) -> Result<Loaded, ConfigError> {
    of_text(path, text, &Overrides::default())
}

fn of_text(path: &Path, text: &str, overrides: &Overrides) -> Result<Loaded, ConfigError> {
    let name = path.display().to_string();
    let (settings, document) = parse_with(&name, text, overrides)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let dbc_path = folder.join(&settings.bus.dbc);
    let dbc_text = read_dbc(&dbc_path, &document)?;
    let history_path = settings.sequential.history.as_ref().map(|history| folder.join(history));
    let store_path = settings.store.file.as_ref().map(|file| folder.join(file));
    let sheets = read_sheets(folder, &settings, &document)?;
    let mut inputs = vec![path, &dbc_path];
    inputs.extend(sheets.iter().map(|sheet| sheet.path.as_path()));
    for (key, written) in [("sequential.history", &history_path), ("store.file", &store_path)] {
        let Some(written) = written else { continue };
        refuse_overwriting((key, written), &inputs, &document)?;
        inputs.push(written);
    }
    Ok(Loaded { settings, document, dbc_path, dbc_text, sheets, history_path, store_path })
}

/// Refuses a path of a file that the gateway keeps, if it names one of these files: the gateway sets aside
/// what it cannot use, and writes a new one.
fn refuse_overwriting(
    (key, written): (&str, &Path),
    inputs: &[&Path],
    document: &Document,
) -> Result<(), ConfigError> {
    // Under whatever name, hard links among them.
    let identity = |path: &Path| fs::metadata(path).ok().map(|found| (found.dev(), found.ino()));
    let real = identity(written);
    let same = |input: &&&Path| real.is_some() && identity(input) == real || **input == written;
    let Some(input) = inputs.iter().find(same) else { return Ok(()) };
    let message = format!("`{key}` would overwrite {}", input.display());
    let help = "name a file of its own, for example one in /var/lib/tertius";
    let problem = document.problem(key, message, help);
    Err(document.refuse([problem]).expect("one problem is a refusal"))
}

fn read_dbc(path: &Path, document: &Document) -> Result<Vec<u8>, ConfigError> {
    let (message, help) = match read(path, MAX_DBC_SIZE) {
        Ok(Some(bytes)) => return Ok(bytes),
        Ok(None) => (
            format!("the DBC {} is longer than {MAX_DBC_SIZE} bytes", path.display()),
            "is this the right file?",
        ),
        Err(error) => (
            format!("the DBC {} cannot be read: {error}", path.display()),
            "`bus.dbc` is relative to the folder of this configuration; put the DBC there or \
             correct the path",
        ),
    };
    let problem = document.problem("bus.dbc", message, help);
    Err(document.refuse([problem]).expect("one problem is a refusal"))
}

fn read_sheets(
    folder: &Path,
    settings: &Settings,
    document: &Document,
) -> Result<Vec<Sheet>, ConfigError> {
    let mut sheets: Vec<Sheet> = Vec::new();
    for (index, device) in settings.devices().iter().enumerate() {
        if sheets.iter().any(|sheet| sheet.name == device.eds) {
            continue;
        }
        let path = folder.join(&device.eds);
        let shown = path.display();
        let (message, help) = match read(&path, MAX_SHEET_SIZE) {
            Ok(Some(text)) => {
                sheets.push(Sheet { name: device.eds.clone(), path, text });
                continue;
            }
            Ok(None) => (
                format!("the EDS {shown} is longer than {MAX_SHEET_SIZE} bytes"),
                "is this the right file?",
            ),
            Err(error) => (
                format!("the EDS {shown} cannot be read: {error}"),
                "`eds` is relative to the folder of this configuration; put the EDS there or correct \
                 the path",
            ),
        };
        let problem = document.problem(&format!("canopen.device[{index}].eds"), message, help);
        return Err(document.refuse([problem]).expect("one problem is a refusal"));
    }
    Ok(sheets)
}

/// The file's bytes; `None` if it is longer than `longest`, beyond which nothing is read.
fn read(path: &Path, longest: usize) -> io::Result<Option<Vec<u8>>> {
    // Opening a pipe waits for who writes to it, and it need not end. A folder is told by reading it.
    let kind = fs::metadata(path)?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        return Err(io::Error::other("it is a pipe or a device, expected a file"));
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(longest as u64 + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() <= longest).then_some(bytes))
}

fn not_utf8(name: &str, error: &std::string::FromUtf8Error) -> ConfigError {
    let sound = error.utf8_error().valid_up_to();
    let readable = String::from_utf8_lossy(error.as_bytes());
    // DBC files are seldom UTF-8, and advice on letters would lead astray.
    if is_dbc(&readable) {
        return a_dbc(name);
    }
    // What is sound is the same in both, so the place is, too.
    let document = Document::new(name, &readable);
    let message = format!("byte 0x{:02X} is not UTF-8", error.as_bytes()[sound]);
    let help = "save the file as UTF-8; letters such as µ and ° are often the cause".to_owned();
    let problem = document.problem_at(sound..sound + 1, "", message, help);
    document.refuse([problem]).expect("one problem is a refusal")
}
