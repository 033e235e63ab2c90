//! What is saved of a sequential detector.

use super::Sequential;
use crate::state::state;

state! {
    Sequential {
        clipping, baseline, slow, loss, thinning, history, search, noise, sooner, sampled_anew, may_be_timing,
        witness, skew, proportion, velocity, was_monitored, verdict, unknown, residual, peaks, alarm,
    }
    parts { excursions, pair }
    but { design, cycles, scales }
}
