//! An output that is compressed on its way.

use super::Failure;
use super::files::{Claimed, Writer};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::{self, Write};

/// How an output is compressed, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    None,
    Gzip,
    Zstd,
}

impl Packing {
    /// The name without the ending that tells the compression, and the compression.
    pub fn of(name: &str) -> (&str, Self) {
        let endings = [(".gz", Self::Gzip), (".zst", Self::Zstd)];
        let found = endings.iter().find_map(|(ending, packing)| {
            let (stem, end) = name.split_at_checked(name.len().checked_sub(ending.len())?)?;
            end.eq_ignore_ascii_case(ending).then_some((stem, *packing))
        });
        found.unwrap_or((name, Self::None))
    }
}

/// An output that is being written, compressed or not.
pub struct PackedWriter {
    /// Name for people.
    name: String,
    stream: Stream,
}

enum Stream {
    Plain(Writer),
    Gzip(GzEncoder<Writer>),
    Zstd(zstd::Encoder<'static, Writer>),
}

impl PackedWriter {
    /// Opens an output that is called `name`.
    ///
    /// # Errors
    /// It cannot be opened.
    pub fn open(claimed: Claimed, name: String, packing: Packing) -> Result<Self, Failure> {
        let file = claimed.open()?;
        let stream = match packing {
            Packing::None => Stream::Plain(file),
            Packing::Gzip => Stream::Gzip(GzEncoder::new(file, Compression::default())),
            Packing::Zstd => {
                let encoder = zstd::Encoder::new(file, zstd::DEFAULT_COMPRESSION_LEVEL);
                Stream::Zstd(encoder.map_err(|error| Failure::writing(&name, &error))?)
            }
        };
        Ok(Self { name, stream })
    }

    /// Writes all of `bytes`.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn put(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        let result = match &mut self.stream {
            Stream::Plain(file) => file.write_all(bytes),
            Stream::Gzip(packer) => packer.write_all(bytes),
            Stream::Zstd(packer) => packer.write_all(bytes),
        };
        self.told(result)
    }

    /// Ends the compression and puts the file in its place, with `head` over its first bytes where they can still be
    /// replaced: not what was compressed or has gone to a pipe.
    ///
    /// # Errors
    /// The output cannot be written; the previous file then remains.
    pub fn close(self, head: Option<Vec<u8>>) -> Result<(), Failure> {
        let Self { name, stream } = self;
        let told = |error: io::Error| Failure::writing(&name, &error);
        let mut file = match stream {
            Stream::Plain(mut file) => {
                if let Some(head) = head {
                    file.replace_head(&head).map_err(told)?;
                }
                file
            }
            Stream::Gzip(packer) => packer.finish().map_err(told)?,
            Stream::Zstd(packer) => packer.finish().map_err(told)?,
        };
        file.flush().map_err(told)?;
        file.close()
    }

    fn told(&self, result: io::Result<()>) -> Result<(), Failure> {
        result.map_err(|error| Failure::writing(&self.name, &error))
    }
}
