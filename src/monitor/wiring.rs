//! Which signals of which messages go where.

use crate::decode::SignalPlan;
use crate::frame::Id;
use crate::sample::Field;

/// Where a decoded signal goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// The platform's state.
    State,
    /// A field of the cylinder of this index (from 0).
    Cylinder(u8, Field),
}

/// One signal on its way.
#[derive(Clone, Debug)]
pub struct Wire {
    pub plan: SignalPlan,
    pub target: Target,
}

/// A message that the monitor listens to.
#[derive(Clone, Debug)]
pub struct Line {
    pub id: Id,
    /// It opens a cycle.
    pub sync: bool,
    /// It carries a reading of a transducer.
    pub reading: bool,
    /// It carries anything of a cylinder, and so belongs to a cycle.
    pub cyclic: bool,
    pub wires: Vec<Wire>,
    /// Number of the cycle in which it last arrived.
    pub arrived: Option<u64>,
}

const NO_LINE: u16 = u16::MAX;

/// All messages that the monitor listens to, found by identifier without a search for standard
/// ones.
#[derive(Clone, Debug)]
pub struct Wiring {
    lines: Vec<Line>,
    standard: Box<[u16]>,
    extended: Vec<(Id, u16)>,
}

impl Wiring {
    pub fn new() -> Self {
        let identifiers = Id::STANDARD_MAX as usize + 1;
        Self { lines: Vec::new(), standard: vec![NO_LINE; identifiers].into(), extended: vec![] }
    }

    /// The place of the message `id`, made if it is not there yet.
    pub fn line(&mut self, id: Id) -> &mut Line {
        let place = self.find(id).unwrap_or_else(|| self.add(id));
        &mut self.lines[place]
    }

    /// The place of the message `id` among [`Self::lines`].
    #[inline]
    pub fn find(&self, id: Id) -> Option<usize> {
        let place = if id.is_extended() {
            let found = self.extended.binary_search_by_key(&id, |(id, _)| *id).ok()?;
            self.extended[found].1
        } else {
            self.standard[id.value() as usize]
        };
        (place != NO_LINE).then_some(usize::from(place))
    }

    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    pub(super) fn lines_mut(&mut self) -> &mut [Line] {
        &mut self.lines
    }

    fn add(&mut self, id: Id) -> usize {
        let place = self.lines.len();
        // A configuration names at most some dozen messages, far fewer than a u16 counts.
        let short = place as u16;
        if id.is_extended() {
            let at = self.extended.partition_point(|(known, _)| *known < id);
            self.extended.insert(at, (id, short));
        } else {
            self.standard[id.value() as usize] = short;
        }
        self.lines.push(Line {
            id,
            sync: false,
            reading: false,
            cyclic: false,
            wires: Vec::new(),
            arrived: None,
        });
        place
    }
}

impl Default for Wiring {
    fn default() -> Self {
        Self::new()
    }
}
