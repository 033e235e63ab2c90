//! Marks by which files show who wrote them.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Mark by which an existing file shows that the same command wrote it.
#[derive(Clone, Copy, Debug)]
pub enum Mark<'a> {
    /// Comment of the tables of this command, see [`crate::tables::provenance`].
    Tables(&'a str),
    /// The generator of a page of this command.
    Page(&'a str),
    /// Beginning with the first text, followed by the others near the beginning, in this order.
    Parts(&'a [&'a str]),
    /// This text as the whole content.
    Text(&'a str),
    /// A Parquet file whose end says that this program made it.
    #[cfg_attr(
        not(feature = "parquet"),
        expect(dead_code, reason = "a program without tables writes none")
    )]
    Columns,
    /// No mark: a recording.
    None,
    /// No mark, since a person also writes such files: a configuration.
    Whole,
    /// No mark, since the command reads the file and decides itself.
    Judged,
}

/// Number of bytes read to recognise a mark.
const HEAD: u64 = 4096;

impl Mark<'_> {
    /// Whether the file `path` has the mark.
    pub fn is_on(self, path: &Path) -> io::Result<bool> {
        if matches!(self, Self::Columns) {
            return is_ours(path);
        }
        let longest = if let Self::Text(text) = self { text.len() as u64 + 1 } else { HEAD };
        let mut bytes = Vec::new();
        File::open(path)?.take(longest).read_to_end(&mut bytes)?;
        let head = String::from_utf8_lossy(&bytes);
        let first = head.lines().next().unwrap_or_default();
        Ok(match self {
            Self::Tables(command) => {
                first.starts_with("# By tertius ") && first.contains(&format!(" {command}, for "))
            }
            Self::Page(command) => head
                .split_once("<meta name=\"generator\" content=\"tertius ")
                .and_then(|(_, rest)| rest.split('"').next())
                .is_some_and(|by| by.ends_with(&format!(" {command}"))),
            Self::Parts(parts) => {
                let rest = |rest: &'_ str, part: &&str| rest.find(*part).map(|at| at + part.len());
                let mut text: &str = &head;
                parts.first().is_some_and(|first| text.starts_with(first))
                    && parts.iter().all(|part| {
                        rest(text, part).is_some_and(|at| {
                            text = &text[at..];
                            true
                        })
                    })
            }
            Self::Text(text) => bytes == text.as_bytes(),
            Self::Columns | Self::None | Self::Whole | Self::Judged => false,
        })
    }
}

/// Number of bytes at the end of a Parquet file in which it says who made it.
const TAIL: u64 = 4096;

/// Whether the Parquet file at `path` was made by this program, of any version.
fn is_ours(path: &Path) -> io::Result<bool> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
    let mut tail = Vec::new();
    file.take(TAIL).read_to_end(&mut tail)?;
    let says = |words: &[u8]| tail.windows(words.len()).any(|part| part == words);
    Ok(tail.ends_with(b"PAR1") && says(b"tertius ") && says(b" replay"))
}
