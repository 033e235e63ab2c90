//! Levels of evidence by what theory says of its tail, where a recording does not contradict it.
//!
//! A nat of evidence is a factor of e in rarity where the model of the residuals is right, so that the
//! tail of healthy evidence has slope one, whatever the recording. It is confirmed or corrected within
//! bounds, by all cylinders together: one test, not one for each. What lies on a lattice is counted
//! with its ties.

use super::maxima::Maxima;
use super::per_second;

/// Slopes that are believed: in (0, 1] evidence is rarer than it says, and below the lower bound the
/// model of the residuals is wrong and not its tail.
const SLOPES: [f64; 2] = [0.75, 1.0];

/// Slope one weighs as much as so many excesses.
const PRIOR: f64 = 20.0;

/// An excess of slope one is beyond it once in three thousand, nats.
const FARTHEST: f64 = 8.0;

/// The tail begins below this part of the blocks, …
const PART: f64 = 0.1;

/// … at most so many of them, and at least so many.
const MOST: usize = 100;
const LEAST: usize = 5;

/// The largest level that a detector is given, nats: with more it has lost its sense, as a fault takes so
/// long that it is none of its own any more.
pub const LARGEST_LEVEL: f64 = 30.0;

/// What one series of evidence came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// The level that it takes for its share of the wanted rate, nats, before [`Asked::level`].
    pub nats: f64,
    /// Where its tail begins, nats.
    pub floor: f64,
    /// Of its tail, per nat.
    pub slope: f64,
    /// Blocks beyond the floor.
    pub peaks: usize,
    /// The largest, nats.
    pub worst: f64,
    /// The time that was judged, s.
    pub seconds: f64,
    /// No level is less, nats.
    pub least: f64,
    /// What the tail falls by in truth, per nat, where that is less than any slope that is believed,
    /// beyond chance.
    pub slower: Option<f64>,
}

impl Asked {
    /// The level that is given.
    pub fn level(&self) -> f64 {
        self.nats.clamp(self.least, LARGEST_LEVEL)
    }

    /// How often its level is reached in a year, by what the tail falls by in truth.
    pub fn per_year(&self) -> f64 {
        let slope = self.slower.unwrap_or(self.slope);
        let beyond = (-slope * (self.level() - self.floor)).exp();
        self.peaks as f64 / self.seconds * beyond / per_second(1.0)
    }

    /// The recording goes on as theory has it: no peak is beyond the level, and that is none that
    /// hides faults.
    pub fn is_sound(&self) -> bool {
        self.nats <= LARGEST_LEVEL && self.worst <= self.level()
    }
}

/// The excesses beyond the floor of one series.
struct Excesses {
    floor: f64,
    values: Vec<f64>,
}

impl Excesses {
    /// `None` of too few blocks.
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

    /// They are larger than those of `slope`, beyond chance.
    fn is_strange(&self, slope: f64) -> bool {
        self.mean() * slope > 1.0 + 4.0 / (self.values.len().max(1) as f64).sqrt()
    }
}

/// The slope of all that belong together: a strange one is judged by itself, and what no tail of
/// slope one has is no more than it is rare.
fn joint(excesses: &[Option<Excesses>]) -> f64 {
    let [least, most] = SLOPES;
    let together = excesses.iter().flatten().filter(|it| !it.is_strange(most));
    let all: Vec<f64> = together.flat_map(|it| &it.values).map(|it| it.min(FARTHEST)).collect();
    ((PRIOR + all.len() as f64) / (PRIOR + all.iter().sum::<f64>())).clamp(least, most)
}

/// What the levels of several series have to be that `per_year` false alarms a year are shared by, all
/// equally, and none less than `least_level`, nats; `None` for one with too few blocks. Blocks are of cycles of
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

    /// Minutes and hours ask for the same: what a year brings follows from the slope.
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
