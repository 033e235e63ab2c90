//! Which of a recording's interfaces is read.

use std::fmt;

/// The interfaces whose frames are given out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Interfaces {
    /// All, as if they were one bus.
    #[default]
    All,
    /// This one.
    Only(String),
    /// One bus: this interface, which the configuration names, where the recording has it; else the
    /// only one that there is. Two others are [`Ambiguous`]: nobody can tell which is meant.
    One(String),
}

/// What becomes of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Selected {
    Wanted,
    Other,
    /// It is to be held back until [`Selection::is_decided`]. Then the frames held back are wanted,
    /// unless a frame was [`Selected::Wanted`] meanwhile.
    Undecided,
}

/// More than one interface, and none that is meant for sure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ambiguous;

/// Frames of other interfaces that are looked at for the configured one, some seconds of a bus. It
/// bounds what is held back, and makes the answer depend on the frames alone: not on how they are
/// split into files or come through a pipe.
const LOOK_AHEAD: usize = 4096;

/// Decides, frame by frame.
#[derive(Clone, Debug)]
pub struct Selection {
    interfaces: Interfaces,
    /// Of [`Interfaces::One`]: the interface that is read.
    read: Option<String>,
    /// Of [`Interfaces::One`]: the interface of the first frame, while none is decided upon.
    first: Option<String>,
    /// There was another one beside it.
    several: bool,
    undecided: usize,
}

impl Selection {
    pub const fn new(interfaces: Interfaces) -> Self {
        Self { interfaces, read: None, first: None, several: false, undecided: 0 }
    }

    /// No frame is held back any more.
    pub const fn is_decided(&self) -> bool {
        !matches!(self.interfaces, Interfaces::One(_)) || self.read.is_some()
    }

    /// What becomes of the next frame, which is of the interface `name`.
    ///
    /// # Errors
    /// It is the one that makes it [`Ambiguous`].
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

    /// No frame follows that could change the answer.
    ///
    /// # Errors
    /// There is none.
    pub fn decide(&mut self) -> Result<(), Ambiguous> {
        if self.several && !self.is_decided() {
            return Err(Ambiguous);
        }
        self.read = self.read.take().or_else(|| self.first.clone());
        Ok(())
    }

    /// Whether frames of `name` are wanted, as far as it is settled: for as long as it is not, and for
    /// what would make it [`Ambiguous`], `None`.
    pub fn known(&self, name: &[u8]) -> Option<bool> {
        match &self.interfaces {
            Interfaces::All => Some(true),
            Interfaces::Only(wanted) => Some(wanted.as_bytes() == name),
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
            Interfaces::All | Interfaces::Only(_) => None,
        }
    }
}

impl fmt::Display for Interfaces {
    /// The name of the one that is meant.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str("all"),
            Self::Only(name) | Self::One(name) => f.write_str(name),
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
