//! Selection of the interface of a recording.

use std::fmt;

use tertius_core::frame::BusNumber;
use tertius_core::time::Span;

/// Interfaces whose frames are returned.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Interfaces {
    /// All interfaces, as if they were one bus.
    #[default]
    All,
    /// This interface, by its name or, where the format numbers them, by its number: 2 is `channel2`.
    Only(String),
    /// One bus: this interface, which the configuration names, if the recording has it; else the
    /// only one in the recording. Two others are [`Ambiguous`], since it cannot be told which is
    /// meant.
    One(String),
    /// The buses of a machine that has several.
    Several(SeveralInterfaces),
}

/// The interfaces of several buses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeveralInterfaces {
    /// Each bus with its interface, by name or number.
    pub buses: Vec<(BusNumber, String)>,
    /// Time by which frames of different interfaces may be out of order.
    pub disorder: Span,
}

/// What interfaces are called, before the number, that their format knows by number only.
const NUMBERED: [&str; 3] = ["channel", "bus", "if"];

/// Whether the interface `name` is the one that is `wanted` by its name or number.
fn is_named(name: &[u8], wanted: &str) -> bool {
    let number = |kind: &&str| name.strip_prefix(kind.as_bytes()) == Some(wanted.as_bytes());
    let is_number = || !wanted.is_empty() && wanted.bytes().all(|byte| byte.is_ascii_digit());
    name == wanted.as_bytes() || (is_number() && NUMBERED.iter().any(number))
}

impl Interfaces {
    /// Whether the interface `name` is one that is meant, as far as its name tells.
    pub fn mean(&self, name: &[u8]) -> bool {
        match self {
            Self::All => true,
            Self::Only(wanted) => is_named(name, wanted),
            Self::One(configured) => configured.as_bytes() == name,
            Self::Several(_) => self.bus(name).is_some(),
        }
    }

    /// The bus that the interface `name` is; `None` if it is none of several.
    pub fn bus(&self, name: &[u8]) -> Option<BusNumber> {
        let Self::Several(several) = self else { return Some(BusNumber::First) };
        let found = several.buses.iter().find(|(_, wanted)| is_named(name, wanted));
        found.map(|(bus, _)| *bus)
    }
}

/// What becomes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selected {
    Wanted,
    Other,
    /// The frame must be held back until [`Selection::is_decided`]. The frames held back are then
    /// wanted, unless a frame was [`Selected::Wanted`] meanwhile.
    Undecided,
}

/// There is more than one interface, and none is clearly meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ambiguous;

/// Number of frames of other interfaces among which the configured one is sought: some seconds of a
/// bus. It limits what is held back, and makes the answer depend on the frames alone, not on how
/// they are split into files or arrive through a pipe.
const LOOK_AHEAD: usize = 4096;

/// Decides which frames are wanted.
#[derive(Clone, Debug)]
pub struct Selection {
    interfaces: Interfaces,
    /// Interface that is read, with [`Interfaces::One`].
    read: Option<String>,
    /// Interface of the first frame, with [`Interfaces::One`], until one is decided.
    first: Option<String>,
    /// Whether there was another one beside it.
    several: bool,
    undecided: usize,
}

impl Selection {
    pub const fn new(interfaces: Interfaces) -> Self {
        Self { interfaces, read: None, first: None, several: false, undecided: 0 }
    }

    /// Whether no more frames are held back.
    pub const fn is_decided(&self) -> bool {
        !matches!(self.interfaces, Interfaces::One(_)) || self.read.is_some()
    }

    /// Decides on the next frame, which is of the interface `name`.
    ///
    /// # Errors
    /// This frame makes the selection [`Ambiguous`].
    pub fn judge(&mut self, name: &[u8]) -> Result<Selected, Ambiguous> {
        if let Some(wanted) = self.known(name) {
            return Ok(if wanted { Selected::Wanted } else { Selected::Other });
        }
        if self.read.is_some() {
            return Err(Ambiguous);
        }
        let name = String::from_utf8_lossy(name);
        if self.configured() == Some(&*name) {
            self.read = Some(name.into_owned());
            return Ok(Selected::Wanted);
        }
        self.undecided += 1;
        match &self.first {
            None => self.first = Some(name.into_owned()),
            Some(first) => self.several |= *first != name,
        }
        if self.undecided == LOOK_AHEAD {
            self.decide()?;
        }
        Ok(Selected::Undecided)
    }

    /// Decides, since no frame follows that could change the answer.
    ///
    /// # Errors
    /// No interface is clearly meant.
    pub fn decide(&mut self) -> Result<(), Ambiguous> {
        if self.several && !self.is_decided() {
            return Err(Ambiguous);
        }
        self.read = self.read.take().or_else(|| self.first.clone());
        Ok(())
    }

    /// Whether frames of `name` are wanted; `None` while this is open, and for an interface that
    /// would make the selection [`Ambiguous`].
    pub fn known(&self, name: &[u8]) -> Option<bool> {
        match &self.interfaces {
            Interfaces::All => Some(true),
            Interfaces::Only(_) | Interfaces::Several(_) => Some(self.interfaces.mean(name)),
            Interfaces::One(configured) => {
                let read = self.read.as_ref()?;
                let wanted = read.as_bytes() == name;
                (wanted || read == configured).then_some(wanted)
            }
        }
    }

    fn configured(&self) -> Option<&str> {
        match &self.interfaces {
            Interfaces::One(name) => Some(name),
            Interfaces::All | Interfaces::Only(_) | Interfaces::Several(_) => None,
        }
    }
}

impl fmt::Display for Interfaces {
    /// Writes the names of the interfaces that are meant.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Only(name) | Self::One(name) => f.write_str(name),
            Self::Several(several) => {
                let names: Vec<&str> =
                    several.buses.iter().map(|(_, name)| name.as_str()).collect();
                f.write_str(&names.join(" or "))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one() -> Selection {
        Selection::new(Interfaces::One("can0".to_owned()))
    }

    fn judged(selection: &mut Selection, names: &[&str]) -> Vec<Result<Selected, Ambiguous>> {
        names.iter().map(|name| selection.judge(name.as_bytes())).collect()
    }

    #[test]
    fn the_configured_one_is_read_wherever_it_first_comes() {
        use Selected::{Other, Undecided, Wanted};
        let found = judged(&mut one(), &["can0", "can1", "can0", "can2"]);
        assert_eq!(found, [Ok(Wanted), Ok(Other), Ok(Wanted), Ok(Other)]);
        let found = judged(&mut one(), &["can1", "can2", "can0", "can1", "can0"]);
        assert_eq!(found, [Ok(Undecided), Ok(Undecided), Ok(Wanted), Ok(Other), Ok(Wanted)]);
    }

    #[test]
    fn an_interface_without_a_name_is_chosen_by_its_number() {
        use Selected::{Other, Wanted};
        let mut selection = Selection::new(Interfaces::Only("2".to_owned()));
        let names = ["channel2", "bus2", "if2", "2", "channel12", "channel21", "can2", "channel"];
        let found: Vec<_> = judged(&mut selection, &names).into_iter().flatten().collect();
        assert_eq!(found, [Wanted, Wanted, Wanted, Wanted, Other, Other, Other, Other]);
        let mut selection = Selection::new(Interfaces::Only("can2".to_owned()));
        assert_eq!(judged(&mut selection, &["can2", "channelcan2"]), [Ok(Wanted), Ok(Other)]);
    }

    #[test]
    fn one_of_another_name_is_read_until_there_are_two() {
        let mut selection = one();
        assert_eq!(judged(&mut selection, &["vcan0"; 100]), [Ok(Selected::Undecided); 100]);
        assert!(!selection.is_decided());
        assert_eq!((selection.decide(), selection.is_decided()), (Ok(()), true));
        assert_eq!(selection.judge(b"vcan0"), Ok(Selected::Wanted));
        assert_eq!(selection.judge(b"can0"), Err(Ambiguous), "it comes too late");
        assert_eq!(selection.judge(b"can1"), Err(Ambiguous));
    }

    #[test]
    fn two_others_are_for_the_user_to_choose_from() {
        let mut selection = one();
        assert_eq!(judged(&mut selection, &["can1", "can2"]), [Ok(Selected::Undecided); 2]);
        assert_eq!(selection.decide(), Err(Ambiguous));
        let mut selection = one();
        let names: Vec<&str> = (0..LOOK_AHEAD).map(|i| ["can1", "can2"][i % 2]).collect();
        assert_eq!(judged(&mut selection, &names).last(), Some(&Err(Ambiguous)));
    }
}
