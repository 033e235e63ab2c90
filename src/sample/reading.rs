//! What arrives of one cylinder within one cycle.

/// C1 or C2, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transducer {
    C1 = 0,
    C2 = 1,
}

/// A pressure of a cylinder, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressure {
    /// In the bottom chamber.
    Bottom = 0,
    /// In the rod chamber.
    Rod = 1,
    /// The load pressure P_L itself, where the machine sends it.
    Load = 2,
    /// The supply pressure P_S, the same for all cylinders.
    Supply = 3,
}

/// The places that a signal can fill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    Position(Transducer),
    Velocity(Transducer),
    Status(Transducer),
    Counter(Transducer),
    Command,
    /// Not monitored: read by who surveys a recording.
    Pressure(Pressure),
    /// Of the main spool; likewise.
    Spool,
}

impl Field {
    /// The bit of this field in [`Inputs::got`].
    pub const fn bit(self) -> u16 {
        match self {
            Self::Position(t) => 1 << (4 * t as u16),
            Self::Velocity(t) => 2 << (4 * t as u16),
            Self::Status(t) => 4 << (4 * t as u16),
            Self::Counter(t) => 8 << (4 * t as u16),
            Self::Command => 1 << 8,
            Self::Pressure(p) => 1 << (9 + p as u16),
            Self::Spool => 1 << 13,
        }
    }

    /// Whether it comes from a transducer.
    pub const fn is_reading(self) -> bool {
        !matches!(self, Self::Command | Self::Pressure(_) | Self::Spool)
    }
}

/// One reading of one transducer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// l, m.
    pub position: f64,
    /// The raw code of the position, where it is an integer.
    pub code: Option<i64>,
    /// l̇, m/s.
    pub velocity: Option<f64>,
    pub status: Option<u64>,
    pub counter: Option<u64>,
}

/// What has arrived so far in the open cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs {
    got: u16,
    readings: [Reading; 2],
    command: f64,
    pressures: [f64; 4],
    spool: f64,
}

impl Inputs {
    /// Forgets everything, for the next cycle.
    pub fn clear(&mut self) {
        self.got = 0;
        for reading in &mut self.readings {
            // Position and command stand behind `got`; writing all of it anew would cost more.
            (reading.code, reading.velocity) = (None, None);
            (reading.status, reading.counter) = (None, None);
        }
    }

    /// The fields that have arrived, by [`Field::bit`].
    pub const fn got(&self) -> u16 {
        self.got
    }

    /// Takes a position with its raw code.
    pub fn position(&mut self, transducer: Transducer, metres: f64, code: Option<i64>) {
        let reading = &mut self.readings[transducer as usize];
        (reading.position, reading.code) = (metres, code);
        self.got |= Field::Position(transducer).bit();
    }

    /// Takes a velocity, m/s; one that is not finite is bad data.
    #[must_use]
    pub fn velocity(&mut self, transducer: Transducer, metres_per_second: f64) -> bool {
        let finite = metres_per_second.is_finite();
        if finite {
            self.readings[transducer as usize].velocity = Some(metres_per_second);
            self.got |= Field::Velocity(transducer).bit();
        }
        finite
    }

    pub fn status(&mut self, transducer: Transducer, status: u64) {
        self.readings[transducer as usize].status = Some(status);
        self.got |= Field::Status(transducer).bit();
    }

    pub fn counter(&mut self, transducer: Transducer, counter: u64) {
        self.readings[transducer as usize].counter = Some(counter);
        self.got |= Field::Counter(transducer).bit();
    }

    /// Takes the command, m/s; one that is not finite is bad data.
    #[must_use]
    pub fn command(&mut self, metres_per_second: f64) -> bool {
        let finite = metres_per_second.is_finite();
        if finite {
            self.command = metres_per_second;
            self.got |= Field::Command.bit();
        }
        finite
    }

    /// u(k), m/s.
    pub fn command_value(&self) -> Option<f64> {
        (self.got & Field::Command.bit() != 0).then_some(self.command)
    }

    /// Takes a pressure, bar; one that is not finite is bad data.
    #[must_use]
    pub fn pressure(&mut self, pressure: Pressure, bar: f64) -> bool {
        let finite = bar.is_finite();
        if finite {
            self.pressures[pressure as usize] = bar;
            self.got |= Field::Pressure(pressure).bit();
        }
        finite
    }

    /// Takes a spool position, in its own unit; one that is not finite is bad data.
    #[must_use]
    pub fn spool(&mut self, position: f64) -> bool {
        let finite = position.is_finite();
        if finite {
            self.spool = position;
            self.got |= Field::Spool.bit();
        }
        finite
    }

    /// P_S, bar.
    pub fn supply_value(&self) -> Option<f64> {
        self.pressure_value(Pressure::Supply)
    }

    /// x_m, in its own unit.
    pub fn spool_value(&self) -> Option<f64> {
        (self.got & Field::Spool.bit() != 0).then_some(self.spool)
    }

    /// Those of the cylinder, bar, by [`Pressure`].
    pub fn pressures(&self) -> [Option<f64>; 3] {
        [Pressure::Bottom, Pressure::Rod, Pressure::Load].map(|which| self.pressure_value(which))
    }

    fn pressure_value(&self, pressure: Pressure) -> Option<f64> {
        let here = self.got & Field::Pressure(pressure).bit() != 0;
        here.then_some(self.pressures[pressure as usize])
    }

    /// The reading of `transducer`, if its position came, and with it all of status and counter
    /// that `required` names: without them it is not known to be good.
    pub fn reading(&self, transducer: Transducer, required: u16) -> Option<&Reading> {
        let vital = Field::Position(transducer).bit()
            | Field::Status(transducer).bit()
            | Field::Counter(transducer).bit();
        let wanted = (required & vital) | Field::Position(transducer).bit();
        (self.got & wanted == wanted).then(|| &self.readings[transducer as usize])
    }
}
