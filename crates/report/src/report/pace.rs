//! The pace of a recording: whether the Sync that the configuration names came, and how long a cycle took.

use tertius_core::frame::{BusNumber, Frame, Id};
use tertius_core::monitor::MonitorDesign;
use tertius_core::monitor::subscriptions::Subscription;
use tertius_core::time::Timestamp;

/// Intervals from which the usual one is taken.
const FIRST: usize = 255;

/// Fewest intervals that tell how long a cycle is.
const LEAST: usize = 50;

/// Largest difference of a cycle from the sample time that is passed over, as a part of it. Two clocks differ by less
/// than a thousandth.
const TOLERANCE: f64 = 0.005;

/// Longest time between two frames of a message that are one, as of a bus that is recorded on two interfaces, as a part
/// of the sample time.
const REPETITION: f64 = 0.05;

/// What a configuration says of the cycle, and the recording does not show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum OffPace {
    /// The Sync did not come.
    NoSync(String),
    /// A cycle took another time than the sample time.
    SampleTime(String),
}

/// Times the message that comes once a cycle.
#[derive(Clone, Debug)]
pub struct RecordedPace {
    /// Sample time of the configuration, s.
    sample_time: f64,
    /// The Sync of the configuration, and its name there.
    sync: Option<(Beat, String)>,
    /// A message with readings that comes once a cycle.
    reading: Option<Beat>,
}

/// Intervals of one message.
#[derive(Clone, Debug)]
struct Beat {
    of: (BusNumber, Id),
    frames: u64,
    last: Option<Timestamp>,
    /// Up to [`FIRST`] intervals, ns, from which `usual` is taken.
    first: Vec<i64>,
    usual: Option<i64>,
    /// Sum and number of the intervals that are about the usual one: without lost frames and pauses.
    sum: i64,
    count: u64,
}

impl RecordedPace {
    /// The pace by `design`, of a machine with this `sample_time`, s, and the message of this name as `sync`.
    pub fn new(design: &MonitorDesign, sample_time: f64, sync: Option<&str>) -> Self {
        let all = design.subscriptions.all();
        let opens = all.iter().find(|message| message.sync);
        let once = |it: &&Subscription| it.reading && !it.by_timer && it.pages() == 1;
        let beat = |it: &Subscription| Beat::new((it.bus, it.id));
        Self {
            sample_time,
            sync: opens.zip(sync).map(|(opens, name)| (beat(opens), name.to_owned())),
            reading: all.iter().find(once).map(beat),
        }
    }

    /// Takes a data frame.
    pub fn take(&mut self, frame: &Frame) {
        let least = (1e9 * REPETITION * self.sample_time) as i64;
        let sync = self.sync.as_mut().map(|(beat, _)| beat);
        let own = |beat: &&mut Beat| beat.of == (frame.bus, frame.id);
        if let Some(beat) = sync.into_iter().chain(&mut self.reading).find(own) {
            beat.take(frame.timestamp, least);
        }
    }

    /// What is off, with what to do about it.
    pub fn off(&self) -> Vec<OffPace> {
        let sync = self.sync.as_ref().filter(|(beat, _)| beat.frames > 0);
        let missing = self.sync.as_ref().filter(|_| sync.is_none()).and_then(|(beat, name)| {
            let readings = self.reading.as_ref().filter(|it| it.frames as usize >= LEAST)?.frames;
            Some(OffPace::NoSync(format!(
                "`signals.sync`: no frame of {name} ({}) came in {readings} cycles that were looked at, though it \
                 opens each by the configuration; the first reading of each opened it instead, and a late one may be \
                 counted into the wrong cycle. Record the bus with its Sync, name the message that opens a cycle, or \
                 leave the key out if there is none",
                beat.of.1
            )))
        });
        let timed = match sync {
            Some((beat, name)) => Some((beat, name.clone())),
            None => self.reading.as_ref().map(|beat| (beat, format!("0x{}", beat.of.1))),
        };
        let differs = timed.and_then(|(beat, name)| self.differs(beat, &name));
        missing.into_iter().chain(differs).collect()
    }

    /// Remark on a recording that is to be learnt from, if there is one.
    ///
    /// # Errors
    /// Another sample time: what is learnt would be of no machine.
    pub fn of_a_lesson(&self) -> Result<Option<String>, String> {
        let mut remark = None;
        for off in self.off() {
            match off {
                OffPace::NoSync(text) => remark = Some(text),
                OffPace::SampleTime(text) => {
                    return Err(format!("{text}. Nothing is learnt from this recording"));
                }
            }
        }
        Ok(remark)
    }

    fn differs(&self, beat: &Beat, name: &str) -> Option<OffPace> {
        let (mean, count) = beat.mean()?;
        let off = mean / self.sample_time - 1.0;
        let (percent, more) = (1e2 * off.abs(), if off > 0.0 { "more" } else { "less" });
        (off.abs() > TOLERANCE).then(|| {
            OffPace::SampleTime(format!(
                "`machine.sample_time`: {name} came every {:.3} ms, on average of {count} cycles, {percent:.1} % {more} \
                 than the {:.3} ms of the configuration: models, times and thresholds are those of another machine. \
                 Correct the key and commission again; if it is right, the recording's time stamps are not",
                1e3 * mean,
                1e3 * self.sample_time
            ))
        })
    }
}

impl Beat {
    const fn new(of: (BusNumber, Id)) -> Self {
        Self { of, frames: 0, last: None, first: Vec::new(), usual: None, sum: 0, count: 0 }
    }

    /// Takes a frame at `at`; one within `least` ns of the last one is the same.
    fn take(&mut self, at: Timestamp, least: i64) {
        let interval = self.last.map_or(i64::MAX, |last| at.since(last).as_nanos());
        if (0..least).contains(&interval) {
            return;
        }
        self.frames += 1;
        if self.last.replace(at).is_none() || interval < 0 {
            return;
        }
        match self.usual {
            Some(usual) => self.add(interval, usual),
            None => {
                self.first.push(interval);
                if self.first.len() == FIRST {
                    self.settle();
                }
            }
        }
    }

    /// Takes the usual interval from the first ones, and counts these.
    fn settle(&mut self) {
        let mut first = std::mem::take(&mut self.first);
        first.sort_unstable();
        let usual = first[first.len() / 2];
        self.usual = Some(usual);
        first.into_iter().for_each(|interval| self.add(interval, usual));
    }

    fn add(&mut self, interval: i64, usual: i64) {
        if interval > usual / 2 && interval < usual + usual / 2 {
            self.sum = self.sum.saturating_add(interval);
            self.count += 1;
        }
    }

    /// Mean interval, s, and of how many; `None` from too few.
    fn mean(&self) -> Option<(f64, u64)> {
        let mut settled = self.clone();
        if self.usual.is_none() && self.first.len() >= LEAST {
            settled.settle();
        }
        let Self { sum, count, .. } = settled;
        (count as usize >= LEAST).then(|| (1e-9 * sum as f64 / count as f64, count))
    }
}

impl OffPace {
    /// For a person.
    pub fn text(&self) -> &str {
        match self {
            Self::NoSync(text) | Self::SampleTime(text) => text,
        }
    }
}
