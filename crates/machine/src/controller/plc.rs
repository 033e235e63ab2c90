//! The platform's states and the way between them (section 2-2-1, Figure 2-4).

/// A state of the platform; only neighbouring states follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum State {
    /// The valves' springs keep the cylinders retracted; the loop is open.
    Safe,
    /// The cylinders are kept retracted by a constant command.
    Settled,
    /// All cylinders stand at half their stroke.
    Neutral,
    /// The vessel's motion is compensated.
    Engaged,
}

impl State {
    /// All states, the lowest first.
    pub const ALL: [Self; 4] = [Self::Safe, Self::Settled, Self::Neutral, Self::Engaged];

    /// Its name in section 2-2-1 and in a DBC.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Safe => "safe",
            Self::Settled => "settled",
            Self::Neutral => "neutral",
            Self::Engaged => "engaged",
        }
    }
}

/// Phase of the platform in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    At(State),
    /// The platform is between two states: `progress`, 0 to 1, is done, and `rate` is its
    /// derivative, 1/s.
    Between {
        from: State,
        to: State,
        progress: f64,
        rate: f64,
    },
}

/// The sequence of states, driven by time alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plc {
    from: State,
    to: State,
    wanted: State,
    /// Samples since the last state was left or reached.
    samples: u32,
    transition: u32,
    dwell: u32,
    sample_time: f64,
}

impl Plc {
    /// A PLC in `state`; a transition takes `transition` seconds, and a state is kept for `dwell`
    /// seconds.
    pub fn new(state: State, transition: f64, dwell: f64, sample_time: f64) -> Self {
        let samples = |seconds: f64| (seconds / sample_time).round() as u32;
        let (transition, dwell) = (samples(transition).max(1), samples(dwell));
        Self { from: state, to: state, wanted: state, samples: 0, transition, dwell, sample_time }
    }

    /// Requests `state`; the platform passes through those in between. Safe is reached at once from
    /// anywhere: the valves are released.
    pub fn request(&mut self, state: State) {
        self.wanted = state;
        if state == State::Safe {
            (self.from, self.to, self.samples) = (state, state, 0);
        }
    }

    /// The state that is reported: during a transition the lower of both, since the higher is not
    /// yet reached or already left.
    pub fn state(&self) -> State {
        self.from.min(self.to)
    }

    /// The phase of this cycle; time then advances by one sample.
    pub fn step(&mut self) -> Phase {
        if self.from == self.to {
            if self.wanted != self.to && self.samples >= self.dwell {
                self.to = towards(self.from, self.wanted);
                self.samples = 0;
            }
        } else if self.samples >= self.transition_time() {
            self.from = self.to;
            self.samples = 0;
        }
        let phase = self.phase();
        self.samples = self.samples.saturating_add(1);
        phase
    }

    /// Duration of a transition, samples. Safe and settled differ in what holds the cylinders, not
    /// in their position.
    fn transition_time(&self) -> u32 {
        if self.from.min(self.to) == State::Safe { 0 } else { self.transition }
    }

    fn phase(&self) -> Phase {
        if self.from == self.to || self.transition_time() == 0 {
            return Phase::At(self.to);
        }
        let done = f64::from(self.samples) / f64::from(self.transition);
        // 10 s³ − 15 s⁴ + 6 s⁵: speed and acceleration are zero at both ends.
        let progress = done.powi(3) * (10.0 + done * (-15.0 + 6.0 * done));
        let slope = 30.0 * (done * (1.0 - done)).powi(2);
        let rate = slope / (f64::from(self.transition) * self.sample_time);
        Phase::Between { from: self.from, to: self.to, progress, rate }
    }
}

/// The neighbour of `from` on the way to `wanted`.
fn towards(from: State, wanted: State) -> State {
    let place = from as usize;
    match wanted.cmp(&from) {
        std::cmp::Ordering::Less => State::ALL[place - 1],
        std::cmp::Ordering::Equal => from,
        std::cmp::Ordering::Greater => State::ALL[place + 1],
    }
}
