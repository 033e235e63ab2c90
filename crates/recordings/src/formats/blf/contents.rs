//! What containers hold, one after the other: inflated whole, and checked before any object of it is used.

use flate2::{Decompress, FlushDecompress, Status};

use super::object::OBJECT;
use crate::reason::Reason;

/// Bytes that are inflated at a time.
const INFLATED: usize = 32 * 1024;
/// Most bytes that a container may inflate to: more than a hundred times what Vector's tools and python-can write.
const MOST_INFLATED: usize = 16 << 20;
/// Most bytes that may stand behind the compressed data of a container: they fill it up to a multiple of four.
const FILL: usize = 3;

const DAMAGED: Reason = Reason::Text(
    "the data of a container by zlib are damaged: they do not inflate to what their checksum says; its frames are left out",
);
const TOO_LONG: Reason = Reason::Text(
    "a container inflates to more than 16 MiB, expected 128 KiB or so; its frames are left out",
);

/// A container that is being read, or an object outside of any, which is taken for one that is not compressed.
pub struct Container {
    /// Place of its first byte.
    pub at: u64,
    /// Bytes of its data that are still to come.
    pub left: usize,
    /// Bytes behind them.
    pub padding: usize,
    /// Of compressed data, what inflates them.
    pub inflater: Option<Box<Inflater>>,
}

/// Inflates the data of a container.
pub struct Inflater {
    zlib: Decompress,
    /// Whether their end was reached, and with it a checksum that is right.
    ended: bool,
    /// Bytes that came behind it.
    behind: usize,
}

impl Inflater {
    pub fn new() -> Self {
        Self { zlib: Decompress::new(true), ended: false, behind: 0 }
    }

    /// Adds what `data` inflate to to `bytes`, by way of `room`: the room that a vector has would be filled with zeros at
    /// each call.
    fn inflate(&mut self, data: &[u8], room: &mut [u8], bytes: &mut Vec<u8>) -> Result<(), Reason> {
        let mut used = 0;
        while !self.ended {
            let (taken, had) = (self.zlib.total_in(), self.zlib.total_out());
            let status = self.zlib.decompress(&data[used..], room, FlushDecompress::None);
            let status = status.map_err(|_| DAMAGED)?;
            used += (self.zlib.total_in() - taken) as usize;
            let more = (self.zlib.total_out() - had) as usize;
            bytes.extend_from_slice(&room[..more]);
            if self.zlib.total_out() > MOST_INFLATED as u64 {
                return Err(TOO_LONG);
            }
            self.ended = status == Status::StreamEnd;
            if more < room.len() {
                break;
            }
        }
        if self.ended {
            self.behind += data.len() - used;
        }
        Ok(())
    }

    const fn is_sound(&self) -> bool {
        self.ended && self.behind <= FILL
    }
}

/// The bytes of objects, which may begin in one container and end in the next.
#[derive(Default)]
pub struct Contents {
    /// From the first byte that was not used when the newest container began.
    bytes: Vec<u8>,
    used: usize,
    /// Where those end that may be used: what follows is of a container that is not checked yet.
    sound: usize,
    /// Whether something is missing in front of `used`, so that it may be within an object.
    torn: bool,
    /// Room for what is inflated at a time.
    room: Vec<u8>,
}

impl Contents {
    /// The bytes that may be used.
    pub fn unused(&self) -> &[u8] {
        &self.bytes[self.used..self.sound]
    }

    pub fn take(&mut self, bytes: usize) {
        self.used += bytes;
    }

    /// Goes on at the next object if something is missing before it.
    pub fn mend(&mut self) {
        if !self.torn {
            return;
        }
        let unused = self.unused();
        let next = memchr::memmem::find(unused, OBJECT);
        // It may begin with the last bytes.
        let rest = unused.len().saturating_sub(OBJECT.len() - 1);
        self.torn = next.is_none();
        self.used += next.unwrap_or(rest);
    }

    /// Whether an object has begun that did not end.
    pub fn has_begun(&self) -> bool {
        !self.torn && self.unused().contains(&OBJECT[0])
    }

    /// Adds the next `data` of a container. Those that are compressed may be used once all of them were added.
    ///
    /// # Errors
    /// The container is damaged, or too long: nothing of it can be used.
    pub fn add(&mut self, container: &mut Container, data: &[u8]) -> Result<(), Reason> {
        self.bytes.drain(..self.used);
        (self.sound, self.used) = (self.sound - self.used, 0);
        container.left -= data.len();
        let Some(inflater) = &mut container.inflater else {
            self.bytes.extend_from_slice(data);
            self.sound = self.bytes.len();
            return Ok(());
        };
        self.room.resize(INFLATED, 0);
        inflater.inflate(data, &mut self.room, &mut self.bytes)?;
        if container.left == 0 {
            if !inflater.is_sound() {
                return Err(DAMAGED);
            }
            self.sound = self.bytes.len();
        }
        Ok(())
    }

    /// Drops the container that is being read, and the object that began before it and would end in it.
    pub fn lose(&mut self) {
        self.bytes.clear();
        (self.used, self.sound, self.torn) = (0, 0, true);
    }
}
