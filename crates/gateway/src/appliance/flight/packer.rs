//! Packs blocks: lines of `candump -l`, compressed piece by piece. Pieces one after the other are a file that
//! any zstd reads, so a frame is packed once, in however many recordings it is.

use super::block::Block;
use std::io;
use tertius_core::monitor::{DesignChecksum, SavedState};
use tertius_core::time::Timestamp;
use tertius_recordings::append_log_line;
use zstd::bulk::Compressor;
use zstd::zstd_safe::CParameter;

/// zstd's level, and its window as a power of two of bytes. Its memory follows from them: about 1 MB.
const LEVEL: i32 = 3;
const WINDOW: u32 = 17;

/// The frames of a block, packed.
#[derive(Debug)]
pub(super) struct Piece {
    /// Time stamps of the first and the last frame; `None` where there are only losses.
    pub ends: Option<[Timestamp; 2]>,
    /// Time up to which everything is in this piece or an earlier one.
    pub until: Timestamp,
    pub frames: u64,
    /// Number of frames lost before those of this piece.
    pub lost: u64,
    /// A whole zstd frame, or nothing.
    pub bytes: Box<[u8]>,
    /// State of the monitor before the first frame, as a file.
    pub state: Option<Box<[u8]>>,
}

impl Piece {
    /// Bytes in memory.
    pub fn size(&self) -> usize {
        self.bytes.len() + self.state.as_ref().map_or(0, |state| state.len())
    }
}

/// Packs blocks, with buffers that it keeps.
pub(super) struct Packer {
    /// Names of the buses, by number.
    interfaces: Vec<String>,
    design: DesignChecksum,
    text: Vec<u8>,
    compressor: Compressor<'static>,
}

impl Packer {
    /// A packer whose lines have `interfaces` as the names of the buses, and whose states are of `design`.
    ///
    /// # Errors
    /// There is no memory for the compressor.
    pub fn new(interfaces: &[String], design: DesignChecksum) -> io::Result<Self> {
        let mut compressor = Compressor::new(LEVEL)?;
        compressor.set_parameter(CParameter::WindowLog(WINDOW))?;
        compressor.set_parameter(CParameter::ChecksumFlag(true))?;
        Ok(Self { interfaces: interfaces.to_owned(), design, text: Vec::new(), compressor })
    }

    /// The piece of `block`; `None` if nothing is in it.
    ///
    /// # Errors
    /// The compressor's.
    pub fn pack(&mut self, block: &mut Block) -> io::Result<Option<Piece>> {
        self.text.clear();
        let mut ends = None;
        let mut frames = 0;
        for frame in block.frames() {
            let name = self.interfaces.get(frame.bus.index()).map_or("can0", String::as_str);
            append_log_line(&mut self.text, name, &frame);
            let [first, _] = ends.unwrap_or([frame.timestamp; 2]);
            ends = Some([first, frame.timestamp]);
            frames += 1;
        }
        let begin = ends.map_or(block.until, |[first, _]| first);
        let monitor = block.state.take();
        let state = monitor.map(|it| SavedState::of(&it, self.design, begin).to_bytes().into());
        if frames == 0 && block.lost == 0 && state.is_none() {
            return Ok(None);
        }
        let bytes = match frames {
            0 => Vec::new(),
            _ => self.compressor.compress(&self.text)?,
        };
        let (until, lost) = (block.until, block.lost);
        Ok(Some(Piece { ends, until, frames, lost, bytes: bytes.into(), state }))
    }
}
