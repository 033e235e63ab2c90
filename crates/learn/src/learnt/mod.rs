//! Frames kept of healthy recordings, so that the tables of a machine improve with each recording.
//!
//! ```text
//! kept pieces ─┐
//!              ├─→ what learns ─→ tables ─┐
//! recording ─→ judged by the tables that stand ─→ pieces ─→ kept
//! ```
//!
//! Among the data behind the tables, only the sums of least squares could simply be added up.
//! Tails, levels, dependence, weights and the trial depend on residuals that change with every
//! table before them, so that earlier sums would belong to other detectors. Therefore the frames
//! that the configuration reads are kept, packed in [`Piece`]s of a minute: learning from them and
//! from a new recording is learning from all recordings together. Beyond [`MOST_BYTES`] pieces are
//! dropped ([`thinning`]), first those in which the rods did what they also did in many others.
//!
//! - [`archive`]: the format of the file, with its checksum.
//! - [`seals`]: the configuration that the pieces belong to.
//! - [`parts`]: the recordings that were learnt, so that none counts twice.
//! - [`judging`]: whether a new recording is healthy by the present tables.

pub mod archive;
pub mod judging;
pub mod parts;
pub mod piece;
pub mod seals;
pub mod thinning;

pub use judging::{Judgement, Judging};
pub use parts::{Clash, Part, Parting};
pub use piece::{Damage, Packing, Piece};
pub use seals::{Broken, Seals};

/// Most bytes of all pieces: three hours of the simulated machine with its six cylinders at 50 Hz.
pub const MOST_BYTES: usize = 32 << 20;

/// Most parts that are remembered; the oldest are forgotten.
pub const MOST_PARTS: usize = 4096;

/// What is kept of one machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Learnt {
    /// Name of the machine.
    pub machine: String,
    /// Seals of the configuration with the tables that were learnt.
    pub seals: Seals,
    /// Parts that were learnt, in the order of time.
    pub parts: Vec<Part>,
    /// Pieces that are kept of them, in the order of time.
    pub pieces: Vec<Piece>,
}

impl Learnt {
    /// Bytes of all pieces.
    pub fn bytes(&self) -> usize {
        self.pieces.iter().map(Piece::bytes).sum()
    }

    /// Adds the parts and pieces of a recording.
    pub fn add(&mut self, parts: impl IntoIterator<Item = Part>, pieces: Vec<Piece>) {
        self.parts.extend(parts);
        self.parts.sort_by_key(|part| part.first);
        let beyond = self.parts.len().saturating_sub(MOST_PARTS);
        self.parts.drain(..beyond);
        self.pieces.extend(pieces);
        self.pieces.sort_by_key(Piece::first);
    }
}
