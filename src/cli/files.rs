//! The files of a command. What it reads is never overwritten, and what it writes is complete or
//! remains as it was before.

mod mark;

pub use mark::Mark;

use super::Failure;
use clap::Args;
use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::os::fd::AsFd;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, chown};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile, TempPath};

/// Whether existing files may be overwritten.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct Overwriting {
    /// Overwrites existing files. Without it, only an empty file is overwritten, or one that this
    /// command wrote, as its first lines show; recordings have no such lines. Files that the
    /// command reads are never overwritten
    #[arg(long)]
    force: bool,
}

/// One file, under all of its names.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Identity {
    /// Device and inode of a regular file.
    Known(u64, u64),
    /// Path of a file that does not exist yet.
    Future(PathBuf),
}

impl Identity {
    /// Identity of the regular file `path`, even before it exists; `None` for pipes and devices,
    /// which may be named more than once.
    fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) => Self::found(&found),
            Err(_) => leads_to(path).ok().map(Self::Future),
        }
    }

    fn found(found: &Metadata) -> Option<Self> {
        found.is_file().then(|| Self::Known(found.dev(), found.ino()))
    }
}

/// Whether both paths are one file, under any names.
pub fn is_same(one: &Path, other: &Path) -> bool {
    Identity::of(one).is_some_and(|identity| Identity::of(other) == Some(identity))
}

/// Whether both paths are one folder, under any names.
pub fn is_same_folder(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| fs::canonicalize(path).ok();
    real(one).is_some_and(|folder| real(other) == Some(folder))
}

/// Files that a command reads, known before anything is opened for writing.
#[derive(Debug, Default)]
pub struct Inputs(Vec<(PathBuf, Identity)>);

impl Inputs {
    /// The inputs `paths`; `-` is standard input.
    pub fn new<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Self {
        let identity = |path: &Path| match path.as_os_str().as_encoded_bytes() {
            b"-" => Identity::found(&descriptor(io::stdin()).ok()?.metadata().ok()?),
            _ => Identity::of(path),
        };
        let known = |path: &Path| Some((path.to_owned(), identity(path)?));
        Self(paths.into_iter().filter_map(known).collect())
    }

    /// Claims the outputs of a call, each with its mark, in the order given. Existing files are not
    /// touched before an output is finished.
    ///
    /// # Errors
    /// An output, or the file that a shell has redirected standard output to, is an input;
    /// two outputs are the same; or one exists and must not be overwritten, or cannot be written.
    pub fn claim<const N: usize>(
        &self,
        wanted: [(Option<&Path>, Mark); N],
        overwriting: Overwriting,
    ) -> Result<[Option<Claimed>; N], Failure> {
        if let Some(identity) = identity_of_output(Path::new("-")) {
            self.refuse("standard output", &identity)?;
        }
        let mut seen: Vec<Identity> = Vec::new();
        for path in wanted.iter().filter_map(|(path, _)| *path) {
            let Some(identity) = identity_of_output(path) else { continue };
            self.refuse(&path.display().to_string(), &identity)?;
            if seen.contains(&identity) {
                return Err(Failure::Wrong(format!(
                    "{} is to hold two outputs; name a file for each",
                    path.display()
                )));
            }
            seen.push(identity);
        }
        let mut claimed = [const { None }; N];
        for (place, (path, mark)) in claimed.iter_mut().zip(wanted) {
            if let Some(path) = path.filter(|_| !matches!(mark, Mark::Judged)) {
                *place = Some(Claimed::new(path, mark, overwriting)?);
            }
        }
        Ok(claimed)
    }

    fn refuse(&self, output: &str, identity: &Identity) -> Result<(), Failure> {
        let Some((input, _)) = self.0.iter().find(|(_, known)| known == identity) else {
            return Ok(());
        };
        Err(Failure::Wrong(format!(
            "{output} would be written over the input {}; name another file",
            input.display()
        )))
    }
}

/// Identity of an output; `-` is standard output.
fn identity_of_output(path: &Path) -> Option<Identity> {
    if is_standard(path) {
        return Identity::found(&descriptor(io::stdout()).ok()?.metadata().ok()?);
    }
    Identity::of(path)
}

fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn descriptor(of: impl AsFd) -> io::Result<File> {
    of.as_fd().try_clone_to_owned().map(File::from)
}

/// Destination of an output, used once the command has done its work.
#[derive(Debug)]
pub struct Claimed {
    /// Name as given.
    name: String,
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// A file that will replace the one at the path.
    Beside(NamedTempFile, PathBuf),
    /// A pipe or a device, which cannot be replaced and has no content to lose.
    Direct(PathBuf),
    /// The file behind standard output or standard error, at its present position.
    Open(File),
}

impl Claimed {
    fn new(path: &Path, mark: Mark, overwriting: Overwriting) -> Result<Self, Failure> {
        let fail = |error: io::Error| Failure::creating(path, &error);
        let name = path.display().to_string();
        if is_standard(path) {
            let place = Place::Open(descriptor(io::stdout()).map_err(fail)?);
            return Ok(Self { name: "standard output".to_owned(), place });
        }
        let there = match fs::metadata(path) {
            Ok(there) => Some(there),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(fail(error)),
        };
        let place = match &there {
            Some(there) if there.is_dir() => return Err(fail(ErrorKind::IsADirectory.into())),
            Some(there) if !there.is_file() => Place::Direct(path.to_owned()),
            Some(there) => match standard(there) {
                Some(file) => Place::Open(file),
                None => {
                    if there.len() > 0 && !overwriting.force && !mark.is_on(path).map_err(fail)? {
                        return Err(exists(&name, mark));
                    }
                    // Who may not write to it does not replace it, either.
                    OpenOptions::new().write(true).open(path).map_err(fail)?;
                    beside(path, Some(there), mark).map_err(fail)?
                }
            },
            None => beside(path, None, mark).map_err(fail)?,
        };
        Ok(Self { name, place })
    }

    /// Opens the output.
    ///
    /// # Errors
    /// A pipe or device that cannot be opened.
    pub fn open(self) -> Result<Writer, Failure> {
        let (file, target) = match self.place {
            Place::Beside(file, path) => {
                let (file, temporary) = file.into_parts();
                (file, Some((temporary, path)))
            }
            Place::Direct(path) => {
                (File::create(&path).map_err(|error| Failure::creating(&path, &error))?, None)
            }
            Place::Open(file) => (file, None),
        };
        Ok(Writer { file: BufWriter::with_capacity(1 << 16, file), target, name: self.name })
    }

    /// Writes `text` as the whole output.
    ///
    /// # Errors
    /// The output cannot be written; the previous file then remains.
    pub fn write(self, text: &str) -> Result<(), Failure> {
        let mut writer = self.open()?;
        writer.put(text.as_bytes())?;
        writer.close()
    }
}

/// An output that is being written. It takes its place when it is finished; otherwise the previous
/// file remains.
#[derive(Debug)]
pub struct Writer {
    file: BufWriter<File>,
    /// Temporary path and final path.
    target: Option<(TempPath, PathBuf)>,
    name: String,
}

impl Writer {
    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file.write_all(bytes).map_err(|error| Failure::writing(&self.name, &error))
    }

    /// Writes `head` over the first bytes of a file, after everything else. What has gone to a pipe, a device or a
    /// file that a shell has opened stays as it is.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn replace_head(&mut self, head: &[u8]) -> io::Result<()> {
        if self.target.is_some() {
            self.file.seek(SeekFrom::Start(0))?;
            self.file.write_all(head)?;
        }
        Ok(())
    }

    /// Finishes as [`Self::finish`] does, for the command line.
    ///
    /// # Errors
    /// See [`Self::finish`].
    pub fn close(self) -> Result<(), Failure> {
        let name = self.name.clone();
        self.finish().map_err(|error| Failure::writing(&name, &error))
    }

    /// Flushes the buffer, and puts the file in its place.
    ///
    /// # Errors
    /// The output cannot be written; the previous file then remains.
    pub fn finish(self) -> io::Result<()> {
        self.settle()?.place()
    }

    /// Flushes the buffer and closes the file, which takes its place later, with others.
    ///
    /// # Errors
    /// The output cannot be written; the previous file then remains.
    pub fn settle(mut self) -> io::Result<Settled> {
        self.file.flush()?;
        Ok(Settled(self.target))
    }
}

/// An output that is written, but is not in its place yet. Dropped, it is deleted, and the previous file remains.
#[derive(Debug)]
pub struct Settled(Option<(TempPath, PathBuf)>);

impl Settled {
    /// Puts the file in its place.
    ///
    /// # Errors
    /// It cannot be put there; the previous file then remains.
    pub fn place(self) -> io::Result<()> {
        self.0.map_or(Ok(()), |(temporary, path)| Ok(temporary.persist(path)?))
    }
}

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn write_all(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

fn exists(name: &str, mark: Mark) -> Failure {
    let why = match mark {
        Mark::None => "it exists, and a recording does not show who wrote it",
        Mark::Text(_) => "it exists and holds something else",
        Mark::Whole => "it exists, and nothing shows that this command wrote it",
        _ => "it exists, and this command did not write it",
    };
    Failure::Wrong(format!("{name}: {why}; name another file, or write over it with --force"))
}

/// Standard output or standard error, if `there` is the file that it is redirected to; writing
/// continues at its position.
fn standard(there: &Metadata) -> Option<File> {
    let identity = Identity::found(there)?;
    [descriptor(io::stdout()), descriptor(io::stderr())].into_iter().flatten().find(|file| {
        file.metadata().is_ok_and(|open| Identity::found(&open).as_ref() == Some(&identity))
    })
}

/// A temporary file in the folder of the target of `path`, which is deleted unless it is finished.
fn beside(path: &Path, there: Option<&Metadata>, mark: Mark) -> io::Result<Place> {
    let target = leads_to(path)?;
    // What reads all of a folder's tables passes over hidden files.
    let mut prefix = OsString::from(if matches!(mark, Mark::Columns) { "." } else { "" });
    prefix.push(target.file_name().unwrap_or_default());
    prefix.push(".");
    let mut builder = Builder::new();
    builder.prefix(&prefix).suffix(".part");
    // Not `tempfile_in`, whose errors name the temporary file: a person knows only the output. The mode is that of any
    // new file, less what the umask takes.
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true).mode(0o666);
    let file = builder.make_in(folder(&target), |path| options.open(path))?;
    if let Some(there) = there {
        // Only the superuser can keep a file another's.
        _ = chown(file.path(), Some(there.uid()), Some(there.gid()));
        let permissions = Permissions::from_mode(there.mode() & 0o777);
        file.as_file().set_permissions(permissions)?;
    }
    Ok(Place::Beside(file, target))
}

/// Most links that are followed, as in the kernel.
const LINKS: usize = 40;

/// The file itself, even if it does not exist yet: a link remains one.
fn leads_to(path: &Path) -> io::Result<PathBuf> {
    let mut at = path.to_owned();
    for _ in 0..LINKS {
        match fs::read_link(&at) {
            Ok(next) => at = folder(&at).join(next),
            Err(_) => {
                let name = at.file_name().ok_or(ErrorKind::InvalidInput)?;
                return Ok(fs::canonicalize(folder(&at))?.join(name));
            }
        }
    }
    Err(io::Error::other("too many links lead on from it"))
}

/// The folder that `path` is in.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
