//! Levels of evidence from the theory of its tail, where a recording does not contradict the
//! theory.
//!
//! Where the model of the residuals is right, a nat of evidence is a factor of e in rarity, so that
//! the tail of healthy evidence has slope one in any recording. All cylinders together confirm or
//! correct the slope within bounds, in one test and not one for each. Values on a lattice are
//! counted with their ties.

use super::maxima::Maxima;
use super::per_second;

/// Slopes that are accepted: within (0, 1] evidence is rarer than it claims, and below the lower
/// bound the model of the residuals is wrong, not its tail.
const SLOPES: [f64; 2] = [0.75, 1.0];

/// Weight of slope one, in excesses.
const PRIOR: f64 = 20.0;

/// Farthest excess, nats: a tail of slope one exceeds it once in three thousand.
const FARTHEST: f64 = 8.0;

/// Part of the blocks in which the tail begins.
const PART: f64 = 0.1;

/// Most blocks in a tail.
const MOST: usize = 100;
/// Fewest blocks in a tail.
const LEAST: usize = 5;

/// Largest level of a detector, nats: with a higher one it would be useless, since a fault would
/// take so long that it is attributed to the environment.
pub const LARGEST_LEVEL: f64 = 30.0;

/// Result for one series of evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Level for the series' share of the wanted rate, nats, before [`Asked::level`].
    pub nats: f64,
    /// Level at which the tail begins, nats.
    pub floor: f64,
    /// Slope of the tail, per nat.
    pub slope: f64,
    /// Number of blocks beyond the floor.
    pub peaks: usize,
    /// Largest evidence, nats.
    pub worst: f64,
    /// Judged time, s.
    pub seconds: f64,
    /// Lowest level allowed, nats.
    pub least: f64,
    /// Slope by which the tail actually falls, per nat, where it is less than any accepted slope,
    /// beyond chance.
    pub slower: Option<f64>,
}

impl Asked {
    /// A level that is given, whatever the tail of the evidence is; the largest was `worst`, nats, in so many `seconds`.
    pub const fn given(level: f64, worst: f64, seconds: f64) -> Self {
        let (nats, floor, least) = (level, level, level);
        Self { nats, floor, slope: 1.0, peaks: 0, worst, seconds, least, slower: None }
    }

    /// The level that is used, nats.
    pub fn level(&self) -> f64 {
        self.nats.clamp(self.least, LARGEST_LEVEL)
    }

    /// How often the level is reached in a year, by the tail's actual slope.
    pub fn per_year(&self) -> f64 {
        let slope = self.slower.unwrap_or(self.slope);
        let beyond = (-slope * (self.level() - self.floor)).exp();
        self.peaks as f64 / self.seconds * beyond / per_second(1.0)
    }

    /// Whether the recording agrees with the theory: no peak exceeds the level, and the level does
    /// not hide faults.
    pub fn is_sound(&self) -> bool {
        self.nats <= LARGEST_LEVEL && self.worst <= self.level()
    }
}

/// Excesses of one series beyond its floor.
struct Excesses {
    floor: f64,
    values: Vec<f64>,
}

impl Excesses {
    /// The excesses; `None` with too few blocks.
    fn of(maxima: &Maxima) -> Option<Self> {
        let largest = maxima.largest();
        let tail = ((PART * maxima.blocks() as f64) as usize).clamp(LEAST, MOST);
        let floor = *largest.get(tail)?;
        // Strictly above, so that ties stay together.
        let above = largest.iter().take_while(|peak| **peak > floor);
        Some(Self { floor, values: above.map(|peak| peak - floor).collect() })
    }

    fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len().max(1) as f64
    }

    /// Whether they are larger than those of `slope`, beyond chance.
    fn is_strange(&self, slope: f64) -> bool {
        self.mean() * slope > 1.0 + 4.0 / (self.values.len().max(1) as f64).sqrt()
    }
}

/// The slope of all series together: a strange one is judged by itself.
fn joint(excesses: &[Option<Excesses>]) -> f64 {
    let [least, most] = SLOPES;
    let together = excesses.iter().flatten().filter(|it| !it.is_strange(most));
    let all: Vec<f64> = together.flat_map(|it| &it.values).map(|it| it.min(FARTHEST)).collect();
    ((PRIOR + all.len() as f64) / (PRIOR + all.iter().sum::<f64>())).clamp(least, most)
}

/// The levels with which several series share `per_year` false alarms a year equally, none below
/// `least_level`, nats; `None` for a series with too few blocks. Blocks consist of cycles of
/// `sample_time` seconds.
pub fn levels(
    series: &[&Maxima],
    per_year: f64,
    sample_time: f64,
    least_level: f64,
) -> Vec<Option<Asked>> {
    let excesses: Vec<_> = series.iter().map(|maxima| Excesses::of(maxima)).collect();
    let joint = joint(&excesses);
    let [least, most] = SLOPES;
    let share = per_second(per_year) / series.len().max(1) as f64;
    let asked = |(maxima, excesses): (&&Maxima, &Option<Excesses>)| {
        let excesses = excesses.as_ref()?;
        let (count, mean) = (excesses.values.len() as f64, excesses.mean());
        let strange = excesses.is_strange(joint);
        let own = || ((PRIOR + count) / (PRIOR + count * mean)).clamp(least, most);
        let slope = if strange { own() } else { joint };
        let seconds = (maxima.blocks() * u64::from(maxima.block())) as f64 * sample_time;
        let rarer = (count.max(1.0) / (seconds * share)).max(1.0);
        Some(Asked {
            nats: excesses.floor + rarer.ln() / slope,
            floor: excesses.floor,
            slope,
            peaks: excesses.values.len(),
            worst: maxima.worst(),
            seconds,
            least: least_level,
            slower: excesses.is_strange(least).then(|| 1.0 / mean),
        })
    };
    series.iter().zip(&excesses).map(asked).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAST_LEVEL: f64 = 21.87;

    /// Blocks of 10 s whose largest evidence is exponential with this slope.
    fn maxima(blocks: u32, slope: f64) -> Maxima {
        let mut maxima = Maxima::new(1);
        for k in 0..blocks {
            let beyond = (f64::from(k * 7919 % blocks) + 0.5) / f64::from(blocks);
            maxima.add(2.0 - beyond.ln() / slope);
        }
        maxima
    }

    fn asked(series: &[Maxima]) -> Vec<Asked> {
        let series: Vec<_> = series.iter().collect();
        levels(&series, 1.0, 10.0, LEAST_LEVEL)
            .into_iter()
            .map(|it| it.expect("there are blocks"))
            .collect()
    }

    /// Minutes and hours give the same level: the number a year follows from the slope.
    #[test]
    fn as_theory_has_it_the_length_of_the_recording_does_not_matter() {
        let levels: Vec<f64> = [60, 180, 720]
            .map(|blocks| asked(&[(); 6].map(|()| maxima(blocks, 1.0)))[0])
            .map(|it| {
                assert!(it.is_sound() && (0.9..=1.0).contains(&it.slope), "{it:?}");
                assert_eq!(it.level(), LEAST_LEVEL);
                it.nats
            })
            .to_vec();
        assert!(levels.iter().all(|level| (17.0..20.5).contains(level)), "{levels:?}");
    }

    #[test]
    fn a_tail_that_falls_more_slowly_is_corrected_together_and_within_bounds() {
        let six = asked(&[(); 6].map(|()| maxima(360, 0.85)));
        assert!(six.iter().all(|it| (it.slope - 0.85).abs() < 0.04), "{six:?}");
        // No slope below 0.75 is believed, and it is told what that comes to.
        let heavy = asked(&[(); 6].map(|()| maxima(360, 0.3)));
        assert!(heavy.iter().all(|it| it.slope == 0.75), "{heavy:?}");
        assert!(six.iter().all(|it| it.slower.is_none()), "{six:?}");
        assert!(heavy.iter().all(|it| it.slower.is_some_and(|slope| slope < 0.4)), "{heavy:?}");
        assert!(heavy.iter().all(|it| it.per_year() > 100.0), "{heavy:?}");
    }

    #[test]
    fn one_strange_cylinder_does_not_blind_the_others() {
        let mut series = [(); 6].map(|()| maxima(180, 1.0)).to_vec();
        let before = asked(&series);
        series[2].add(80.0);
        let after = asked(&series);
        assert!(!after[2].is_sound() && after[2].worst == 80.0, "{:?}", after[2]);
        for other in [0, 1, 3, 4, 5] {
            assert!(after[other].is_sound(), "{:?}", after[other]);
            assert!((after[other].level() / before[other].level() - 1.0).abs() < 0.15);
        }
    }

    #[test]
    fn evidence_on_a_lattice_keeps_its_ties_together() {
        let mut lattice = Maxima::new(1);
        (0..300_u32).for_each(|k| lattice.add(if k % 3 == 0 { 4.0 } else { 2.0 }));
        lattice.add(5.0);
        let asked = asked(&[lattice])[0];
        assert_eq!((asked.floor, asked.peaks), (4.0, 1));
        assert!(asked.is_sound() && asked.slope > 0.95, "{asked:?}");
    }

    #[test]
    fn too_few_blocks_ask_for_nothing() {
        let (few, many) = (maxima(5, 1.0), maxima(60, 1.0));
        let levels = levels(&[&few, &many], 1.0, 10.0, LEAST_LEVEL);
        assert!(levels[0].is_none() && levels[1].is_some());
    }
}
