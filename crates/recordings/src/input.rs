//! One input of a recording: opened, recognised, decompressed, counted.

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use super::source::SourceError;

/// Number of bytes by which an input is recognised.
pub const HEAD: usize = 512;

const GZIP_MAGIC: &[u8] = &[0x1F, 0x8B];
const ZSTD_MAGIC: &[u8] = &[0x28, 0xB5, 0x2F, 0xFD];
/// A frame that zstd's decoder skips, as pzstd and others put first: the low half of the first byte
/// may be anything.
const ZSTD_SKIPPABLE: &[u8] = &[0x50, 0x2A, 0x4D, 0x18];
/// Size of the pieces in which compressed bytes are passed to the decompressor.
const COMPRESSED_PIECE: usize = 64 * 1024;
/// Size of the reads of decompressed bytes: flate2 loses what it had decoded in the call that meets
/// corrupt data, so small calls lose little.
const DECODED_PIECE: usize = 16 * 1024;

/// An input that is not open yet.
pub enum InputPlace {
    StandardInput,
    File(PathBuf),
    Reader { name: String, reader: Box<dyn Read + Send> },
}

impl InputPlace {
    /// The place of `path`; `-` is standard input.
    pub fn of(path: &Path) -> Self {
        if path.as_os_str() == "-" { Self::StandardInput } else { Self::File(path.to_owned()) }
    }

    /// Name for people.
    pub fn name(&self) -> String {
        match self {
            Self::StandardInput => "standard input".to_owned(),
            Self::File(path) => path.display().to_string(),
            Self::Reader { name, .. } => name.clone(),
        }
    }

    /// The size in bytes where it is known. A file that cannot be opened is refused at once, so
    /// that a mistyped last file is not discovered after the first ones were replayed.
    ///
    /// # Errors
    /// The file does not exist, may not be read or is a directory.
    pub fn check(&self) -> Result<Option<u64>, SourceError> {
        let Self::File(path) = self else { return Ok(None) };
        let failed = |error| SourceError::Open { file: self.name(), error };
        let metadata = fs::metadata(path).map_err(failed)?;
        if metadata.is_dir() {
            return Err(SourceError::Directory { file: self.name() });
        }
        if !metadata.is_file() {
            // Opening and closing a pipe would end its writer.
            return Ok(None);
        }
        File::open(path).map_err(failed)?;
        Ok(Some(metadata.len()))
    }

    /// Opens the input; its format is recognised with the first read.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn open(self) -> Result<Input, SourceError> {
        let name = self.name();
        let reader: Box<dyn Read + Send> = match self {
            Self::StandardInput => Box::new(io::stdin()),
            Self::Reader { reader, .. } => reader,
            Self::File(path) => match File::open(path) {
                Ok(file) => Box::new(file),
                Err(error) => return Err(SourceError::Open { file: name, error }),
            },
        };
        Ok(Input { name, head: Vec::new(), state: State::Fresh(Counted::new(reader)) })
    }
}

/// An open input that reads as plain text, whatever its compression.
pub struct Input {
    name: String,
    /// First bytes, decompressed.
    head: Vec<u8>,
    state: State,
}

type Pieces = BufReader<Whole<Prefixed>>;
type Prefixed = io::Chain<Cursor<Vec<u8>>, Counted>;

enum State {
    /// The first bytes were not examined yet.
    Fresh(Counted),
    Plain(Prefixed),
    Gzip(Box<flate2::bufread::MultiGzDecoder<Pieces>>),
    #[cfg(feature = "zstd")]
    Zstd(Box<zstd::stream::read::Decoder<'static, Pieces>>),
    /// The input failed while being recognised, or is just being recognised.
    Failed(Counted),
}

impl Input {
    pub fn name(&self) -> &str {
        &self.name
    }

    /// First bytes as far as they were read, decompressed: at most [`HEAD`].
    pub fn head(&self) -> &[u8] {
        &self.head
    }

    /// Bytes taken from the file so far, before decompression.
    pub fn consumed(&self) -> u64 {
        self.counted().count
    }

    fn counted(&self) -> &Counted {
        match &self.state {
            State::Fresh(counted) | State::Failed(counted) => counted,
            State::Plain(reader) => reader.get_ref().1,
            State::Gzip(decoder) => decoder.get_ref().get_ref().get_ref().get_ref().1,
            #[cfg(feature = "zstd")]
            State::Zstd(decoder) => decoder.get_ref().get_ref().get_ref().get_ref().1,
        }
    }

    /// Reads as [`Read::read`] does.
    ///
    /// # Errors
    /// The file cannot be read or its compressed data are damaged.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if matches!(self.state, State::Fresh(_)) {
            self.recognise()?;
        }
        let piece = buffer.len().min(DECODED_PIECE);
        let length = match &mut self.state {
            State::Plain(reader) => reader.read(buffer),
            State::Gzip(decoder) => decoder.read(&mut buffer[..piece]),
            #[cfg(feature = "zstd")]
            State::Zstd(decoder) => decoder.read(&mut buffer[..piece]),
            State::Fresh(_) | State::Failed(_) => Ok(0),
        }?;
        let lacking = HEAD - self.head.len();
        self.head.extend_from_slice(&buffer[..length.min(lacking)]);
        Ok(length)
    }

    /// Why `error` ended the input early, for people.
    pub fn explain(&self, error: &io::Error) -> String {
        let kind = match self.state {
            _ if self.counted().failed => None,
            State::Gzip(_) => Some("gzip"),
            #[cfg(feature = "zstd")]
            State::Zstd(_) => Some("zstd"),
            _ => None,
        };
        let Some(kind) = kind else {
            return format!("reading failed: {error}; the rest is lost");
        };
        if error.kind() == io::ErrorKind::UnexpectedEof {
            format!("the {kind} data are truncated ({error}); what comes after is lost")
        } else {
            format!("the {kind} data are corrupt ({error}); the rest is lost")
        }
    }

    fn recognise(&mut self) -> io::Result<()> {
        let nothing = State::Failed(Counted::new(Box::new(io::empty())));
        let State::Fresh(mut counted) = std::mem::replace(&mut self.state, nothing) else {
            return Ok(());
        };
        let mut magic = Vec::with_capacity(ZSTD_MAGIC.len());
        let read = (&mut counted).take(ZSTD_MAGIC.len() as u64).read_to_end(&mut magic);
        if let Err(error) = read {
            self.state = State::Failed(counted);
            return Err(error);
        }
        let is_gzip = magic.starts_with(GZIP_MAGIC);
        let is_zstd = magic.starts_with(ZSTD_MAGIC) || is_skippable(&magic);
        let prefixed = Cursor::new(magic).chain(counted);
        if !is_gzip && !is_zstd {
            self.state = State::Plain(prefixed);
            return Ok(());
        }
        let pieces =
            BufReader::with_capacity(COMPRESSED_PIECE, Whole { reader: prefixed, failure: None });
        self.state = if is_gzip {
            State::Gzip(Box::new(flate2::bufread::MultiGzDecoder::new(pieces)))
        } else {
            unpack_zstd(pieces)?
        };
        Ok(())
    }
}

#[cfg(feature = "zstd")]
fn unpack_zstd(pieces: Pieces) -> io::Result<State> {
    Ok(State::Zstd(Box::new(zstd::stream::read::Decoder::with_buffer(pieces)?)))
}

#[cfg(not(feature = "zstd"))]
fn unpack_zstd(_: Pieces) -> io::Result<State> {
    let what = "it is compressed by zstd, which this program was built without (feature zstd)";
    Err(io::Error::new(io::ErrorKind::Unsupported, what))
}

fn is_skippable(magic: &[u8]) -> bool {
    let same = |(place, byte): (usize, &u8)| {
        let masked = if place == 0 { byte & 0xF0 } else { *byte };
        masked == ZSTD_SKIPPABLE[place]
    };
    magic.len() == ZSTD_SKIPPABLE.len() && magic.iter().enumerate().all(same)
}

/// Counts the bytes that pass, and knows whether it was the reader that failed.
struct Counted {
    reader: Box<dyn Read + Send>,
    count: u64,
    failed: bool,
}

impl Counted {
    fn new(reader: Box<dyn Read + Send>) -> Self {
        Self { reader, count: 0, failed: false }
    }
}

impl Read for Counted {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.reader.read(buffer);
        match &read {
            Ok(length) => self.count += *length as u64,
            Err(error) => self.failed |= error.kind() != io::ErrorKind::Interrupted,
        }
        read
    }
}

/// Fills the whole buffer at each call, so that a decompressor sees the same pieces, and loses the
/// same bytes to damage, whatever the sizes of the reads.
struct Whole<R> {
    reader: R,
    /// Error met after bytes that had to be returned first.
    failure: Option<io::Error>,
}

impl<R> Whole<R> {
    fn get_ref(&self) -> &R {
        &self.reader
    }
}

impl<R: Read> Read for Whole<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Some(error) = self.failure.take() {
            return Err(error);
        }
        let mut length = 0;
        while length < buffer.len() {
            match self.reader.read(&mut buffer[length..]) {
                Ok(0) => break,
                Ok(more) => length += more,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if length == 0 => return Err(error),
                Err(error) => {
                    self.failure = Some(error);
                    break;
                }
            }
        }
        Ok(length)
    }
}
