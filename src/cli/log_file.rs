//! A recording that a command writes: a file, or standard output.

use super::Failure;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Where a recording goes.
pub struct Out {
    writer: BufWriter<Box<dyn Write>>,
    name: String,
}

impl Out {
    /// # Errors
    /// A file that cannot be created.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let (writer, name): (Box<dyn Write>, _) = if path == Path::new("-") {
            (Box::new(io::stdout()), "standard output".to_owned())
        } else {
            let file = File::create(path).map_err(|error| Failure::creating(path, &error))?;
            (Box::new(file), path.display().to_string())
        };
        Ok(Self { writer: BufWriter::with_capacity(1 << 16, writer), name })
    }

    /// # Errors
    /// The output cannot be written.
    pub fn write(&mut self, line: &[u8]) -> Result<(), Failure> {
        self.writer.write_all(line).map_err(|error| Failure::writing(&self.name, &error))
    }

    /// Writes out what is buffered.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn close(mut self) -> Result<(), Failure> {
        self.writer.flush().map_err(|error| Failure::writing(&self.name, &error))
    }
}
