//! What is kept of healthy recordings, so that a machine gets better with each of them.
//!
//! ```text
//! kept pieces ─┐
//!              ├─→ what learns ─→ tables ─┐
//! recording ─→ judged by the tables that stand ─→ pieces ─→ kept
//! ```
//!
//! Of what the tables are made from, only the sums of least squares would add up by themselves. Tails,
//! levels, dependence, weights and the trial are of residuals that change with every table before them, so
//! that sums of earlier ones would be of other detectors. Therefore the frames themselves are kept, those
//! that the configuration reads, packed in [`Piece`]s of a minute: what is learnt from them and from a new
//! recording is what is learnt from all recordings together. Beyond [`MOST_BYTES`] pieces go
//! ([`thinning`]), first those where the rods did what they did in many others.
//!
//! - [`archive`]: the bytes of the file, sealed.
//! - [`seals`]: the configuration that they belong to.
//! - [`parts`]: which recordings were learnt, so that none counts twice.
//! - [`judging`]: whether the tables that stand take a new recording for healthy.

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

/// The most that all pieces may have, bytes: three hours of the simulated machine with its six cylinders at 50 Hz.
pub const MOST_BYTES: usize = 32 << 20;

/// The most parts that are remembered; of more, the oldest are forgotten.
pub const MOST_PARTS: usize = 4096;

/// What is kept of one machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Learnt {
    /// The machine's name.
    pub machine: String,
    /// Of the configuration with the tables that were learnt from it.
    pub seals: Seals,
    /// What was learnt, in the order of time.
    pub parts: Vec<Part>,
    /// What is kept of that, in the order of time.
    pub pieces: Vec<Piece>,
}

impl Learnt {
    /// The bytes of all pieces.
    pub fn bytes(&self) -> usize {
        self.pieces.iter().map(Piece::bytes).sum()
    }

    /// Adds what a recording came to.
    pub fn add(&mut self, parts: impl IntoIterator<Item = Part>, pieces: Vec<Piece>) {
        self.parts.extend(parts);
        self.parts.sort_by_key(|part| part.first);
        let beyond = self.parts.len().saturating_sub(MOST_PARTS);
        self.parts.drain(..beyond);
        self.pieces.extend(pieces);
        self.pieces.sort_by_key(Piece::first);
    }
}
