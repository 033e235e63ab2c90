//! Growth of exponential moments over the excursions of one transducer: a renewal process in which excursions begin with a
//! constant chance and exclude each other while they last.

use super::survival::Survival;

/// Largest exponent of a window, nats: e^600 leaves room for a sum of many such numbers.
const MAX_EXPONENT: f64 = 600.0;

/// Widest window, samples, so that neither time nor memory grows with what is asked for.
pub const MAX_WIDTH: usize = 4096;

/// X(w) = ln E exp(Σ g) over `w` successive samples of the stationary process, in which a sample inside an excursion of a
/// size has the gain g of this size, and other samples have none; in the order of `widths`.
///
/// `gains` are one for each of the sizes of `survival`, none below 0. An excursion begins with a sample that is in none with
/// `chance`. X is infinite where the exponent of a window could overflow, and for windows beyond [`MAX_WIDTH`]: a bound
/// without this θ stays valid.
pub fn log_moments(survival: &Survival, chance: f64, gains: &[f64], widths: &[usize]) -> Vec<f64> {
    let largest = gains.iter().copied().fold(0.0, f64::max);
    let fits = |width: usize| width <= MAX_WIDTH && largest * width as f64 <= MAX_EXPONENT;
    let widest = widths.iter().copied().filter(|width| fits(*width)).max().unwrap_or(0);
    let excursions = Excursions::of(survival, gains, widest);
    let moments = excursions.after_renewal(survival.ends(), chance, widest);
    // Rate of excursions a sample, and the share of samples that are in none.
    let rate = chance / (1.0 + chance * survival.mean_length());
    let free = 1.0 / (1.0 + chance * survival.mean_length());
    let at = |width: &usize| {
        if !fits(*width) {
            return f64::INFINITY;
        }
        if *width == 0 {
            return 0.0;
        }
        // Excursions that cover the first sample, with k samples left. Those that begin with it are counted here and in G: the
        // moment is too large by a part of `chance`, which is on the safe side.
        let ending = 1..(*width).min(excursions.lasting.len());
        let ended: f64 = ending.map(|k| excursions.lasting[k] * moments[width - k]).sum();
        let covering = excursions.remaining.get(*width).copied().unwrap_or(0.0);
        (free * moments[*width] + rate * (ended + covering)).ln()
    };
    widths.iter().map(at).collect()
}

/// Moments of single excursions, summed over the sizes. Each list is indexed by the number of samples, from 0 on, which is
/// not used.
struct Excursions {
    /// Σ e^(g k) over the excursions of exactly k samples.
    ending: Vec<f64>,
    /// Σ e^(g k) over those of at least k samples.
    lasting: Vec<f64>,
    /// Σ e^(g k) times the number of samples from the k-th on.
    remaining: Vec<f64>,
}

impl Excursions {
    fn of(survival: &Survival, gains: &[f64], widest: usize) -> Self {
        let reach = survival.reach().min(widest);
        let empty = || vec![0.0; reach + 1];
        let (mut ending, mut lasting, mut remaining) = (empty(), empty(), empty());
        let factors: Vec<f64> = gains.iter().map(|gain| gain.exp()).collect();
        let mut powers = vec![1.0; factors.len()];
        let dot = |powers: &[f64], row: &[f64]| powers.iter().zip(row).map(|(a, b)| a * b).sum();
        for k in 1..=reach {
            powers.iter_mut().zip(&factors).for_each(|(power, factor)| *power *= factor);
            ending[k] = dot(&powers, survival.ending(k));
            lasting[k] = dot(&powers, survival.lasting(k));
            remaining[k] = dot(&powers, survival.remaining(k));
        }
        Self { ending, lasting, remaining }
    }

    /// G(t) = E exp(Σ g) over the `t` samples after one in which no excursion lasts, for t from 0 to `widest`; `ends` are the
    /// lengths at which excursions end.
    fn after_renewal(&self, ends: &[usize], chance: f64, widest: usize) -> Vec<f64> {
        let mut moments = vec![1.0; widest + 1];
        for t in 1..=widest {
            // One that lasts to the end of the window, or ends within it.
            let lasting = self.lasting.get(t).copied().unwrap_or(0.0);
            let ended: f64 = ends
                .iter()
                .take_while(|length| **length < t)
                .map(|length| self.ending[*length] * moments[t - length])
                .sum();
            moments[t] = (1.0 - chance) * moments[t - 1] + chance * (lasting + ended);
        }
        moments
    }
}
