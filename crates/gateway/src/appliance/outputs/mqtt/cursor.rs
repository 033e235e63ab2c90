//! The newest news that the broker has, on disk, so that a restart goes on behind it.

use crate::appliance::aside::beside;
use crate::appliance::durable;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use tracing::warn;

/// First word of the file.
const KIND: &str = "tertius-mqtt-1";

/// Most bytes of the file that are of interest.
const LONGEST: usize = 200;

/// The place up to which the news of a store are published.
#[derive(Debug)]
pub(super) struct Cursor {
    path: PathBuf,
    place: Place,
    /// Whether it was told that the file cannot be written.
    told: bool,
}

/// A number in the store with this identity.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Place {
    store: String,
    number: i64,
}

impl Cursor {
    /// The cursor beside the store at `path`. Without one, or with one that cannot be read, all news of the store are
    /// published: doubles can be told, what is left out cannot.
    pub fn beside(path: &Path) -> Self {
        let path = beside(path, ".mqtt");
        let place = match fs::read(&path) {
            Ok(bytes) => parse(&bytes).unwrap_or_else(|| {
                warn!("{} is no cursor; all news of the event store are published", path.display());
                Place::default()
            }),
            Err(error) if error.kind() == ErrorKind::NotFound => Place::default(),
            Err(error) => {
                warn!("{}: {error}; all news of the event store are published", path.display());
                Place::default()
            }
        };
        Self { path, place, told: false }
    }

    /// Number of the newest news of `store` that are published; 0 for none, as of a store that is new here.
    pub fn number(&self, store: &str) -> i64 {
        if self.place.store == store { self.place.number } else { 0 }
    }

    /// Notes that the news of `store` are published up to `number`. If that cannot be written, it is known until the
    /// end of the program.
    pub fn advance(&mut self, store: &str, number: i64) {
        self.place = Place { store: store.to_owned(), number };
        match self.write() {
            Ok(()) => self.told = false,
            Err(error) if !self.told => {
                warn!(
                    "{} cannot be written: {error}; after a restart some events are published once more",
                    self.path.display()
                );
                self.told = true;
            }
            Err(_) => {}
        }
    }

    fn write(&self) -> io::Result<()> {
        let Place { store, number } = &self.place;
        durable::replace(&self.path, format!("{KIND} {store} {number}\n").as_bytes())
    }
}

fn parse(bytes: &[u8]) -> Option<Place> {
    let text = str::from_utf8(bytes.get(..bytes.len().min(LONGEST))?).ok()?;
    let mut words = text.strip_suffix('\n')?.split(' ');
    let (kind, store, number) = (words.next()?, words.next()?, words.next()?);
    let number = number.parse().ok().filter(|number| *number >= 0)?;
    (kind == KIND && words.next().is_none()).then(|| Place { store: store.to_owned(), number })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_outlives_the_program_and_belongs_to_one_store() {
        let folder = tempfile::tempdir().expect("there is room");
        let store = folder.path().join("kept.events");
        let mut cursor = Cursor::beside(&store);
        assert_eq!(cursor.number("a"), 0);
        cursor.advance("a", 17);
        let again = Cursor::beside(&store);
        assert_eq!([again.number("a"), again.number("b")], [17, 0]);
        for damaged in ["", "tertius-mqtt-1 a 17", "tertius-mqtt-1 a -3\n", "x a 17\n", "a\n\n"] {
            fs::write(beside(&store, ".mqtt"), damaged).expect("the folder is ours");
            assert_eq!(Cursor::beside(&store).number("a"), 0, "{damaged:?}");
        }
    }

    #[test]
    fn a_disk_that_fails_costs_nothing_but_doubles() {
        let mut cursor = Cursor::beside(Path::new("/nowhere/kept.events"));
        cursor.advance("a", 3);
        assert_eq!(cursor.number("a"), 3);
    }
}
