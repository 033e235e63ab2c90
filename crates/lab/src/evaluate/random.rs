//! Random numbers that do not depend on who draws them, nor when.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The numbers of a `stream`, all from the plan's `seed`. No two machines of a plan share a stream unless they are to be
/// the same machine.
pub(super) fn random(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}
