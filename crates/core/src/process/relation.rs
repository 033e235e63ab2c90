//! What a process detector judges by.

/// A relation of what spool, pressures, rod and supply say of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Relation {
    /// The spool beside the command.
    Spool,
    /// The chambers' pressures beside the supply's.
    Chambers,
    /// The oil that passes the valve beside the rod's way.
    Flow,
    /// The forces on the piston beside its motion.
    Friction,
    /// The supply beside what all cylinders take.
    Supply,
}

/// Number of relations.
pub const RELATIONS: usize = Relation::ALL.len();

impl Relation {
    pub const ALL: [Self; 5] =
        [Self::Spool, Self::Chambers, Self::Flow, Self::Friction, Self::Supply];
    /// Those of a cylinder.
    pub const OF_CYLINDER: [Self; 4] = [Self::Spool, Self::Chambers, Self::Flow, Self::Friction];

    /// Its bit among the relations that a cycle was judged by.
    pub const fn bit(self) -> u8 {
        1 << self as u8
    }
}

// A cycle has a bit for each.
const _: () = assert!(RELATIONS <= u8::BITS as usize);
