//! `[machine]` and `[bus]`.

use crate::kinds::{DURATION, MOST_CYLINDERS, number, numbers, text, whole};
use crate::schema::{Kind, Limits, Scalar, table};
use crate::text::TextRule;
use tertius_core::frame::BusNumber;

table! {
    pub struct Machine = MACHINE {
        name: String => text(TextRule::Name),
            "\"Ampelmann E-type\"", "the machine's name";
        cylinders: u8 =>
            whole(1, MOST_CYLINDERS as i128, "Fd_Status, the gateway's own frame, has room for six"),
            "6", "how many cylinders there are";
        sample_time: f64 =>
            number(Limits::least(1e-3, "the time between two SYNC frames, in seconds: below 1 ms CAN carries few \
                frames, and one that waits is in the next cycle; beyond 1 s a clock set back passes for disorder").most(1.0)),
            "0.02", "the sample time Ts, s";
        stroke: [f64; 2] => numbers(2, Limits::finite("the ends of the cylinder's reach in metres")),
            "[-1.5, 1.5]", "the cylinder's reach, retracted and extended, m";
        area_ratio: f64 = 0.5 =>
            number(Limits::above(0.0, "the rod side's area by the bottom side's, (3-5)").most(1.0)),
            "0.5", "the area ratio of (3-5), by which P_L follows from the chambers' pressures";
        /// Names are those in the DBC's VAL_ table of the state signal (or the thesis's four), ignoring letter
        /// case; or numbers as text.
        monitored_states: Option<Vec<String>> = None =>
            Kind::List { least: 1, most: 64, of: Scalar::Text(TextRule::Name) },
            "[\"engaged\"]", "the platform states in which FDE1 and FDE2 judge; absent: always";
        cycle_deadline: Option<f64> = None => number(Limits::above(0.0, DURATION)),
            "0.016", "readings later than this in their cycle are late, s; absent: 0.8 sample_time";
        max_gap: f64 = 0.1 =>
            number(Limits::least(0.0, "an observer that predicts for longer is only guessing").most(60.0)),
            "0.1", "an observer predicts over at most this long a gap, s";
    }
}

table! {
    pub struct Bus = BUS {
        interface: String => text(TextRule::Interface),
            "\"can0\"", "a SocketCAN interface, or virtual: the embedded bus";
        dbc: String => text(TextRule::Path),
            "\"../dbc/e-type.dbc\"", "the DBC file, relative to this file";
        bitrate: u32 = 500_000 => whole(10_000, 8_000_000, "CAN has 10 kbit/s to 8 Mbit/s"),
            "500000", "bit rate of the bus, bit/s; the gateway's share is computed from it";
        second: Option<OtherBus> = None => Kind::Table(&OTHER_BUS),
            "", "a second bus, whose signals are named second:MESSAGE.SIGNAL";
        third: Option<OtherBus> = None => Kind::Table(&OTHER_BUS),
            "", "a third bus";
        fourth: Option<OtherBus> = None => Kind::Table(&OTHER_BUS),
            "", "a fourth bus";
    }
}

table! {
    /// A bus beside the first one. Its messages are those of the same DBC; the gateway sends nothing on it.
    pub struct OtherBus = OTHER_BUS {
        interface: String => text(TextRule::Interface),
            "\"can1\"", "its SocketCAN interface";
    }
}

impl Bus {
    /// The interfaces of the configured buses, in their order.
    pub fn interfaces(&self) -> impl Iterator<Item = (BusNumber, &str)> {
        let others = [&self.second, &self.third, &self.fourth];
        let others = others.into_iter().map(|bus| bus.as_ref().map(|bus| bus.interface.as_str()));
        let all = [Some(self.interface.as_str())].into_iter().chain(others);
        BusNumber::ALL.into_iter().zip(all).filter_map(|(bus, name)| Some((bus, name?)))
    }

    /// Whether the machine has more than one bus.
    pub fn is_several(&self) -> bool {
        self.interfaces().count() > 1
    }
}
