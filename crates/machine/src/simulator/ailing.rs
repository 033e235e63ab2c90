//! Faults of the machine itself, in their time.

use crate::inject::{Fault, Wanted, Window};
use crate::plant::{Ailment, CYLINDERS, MOST_LATE, Wear};
use tertius_core::time::Span;

/// The faults of a machine, and what they need to remember.
#[derive(Clone, Debug, Default)]
pub struct Ailing {
    /// Cylinder, from 0.
    faults: Vec<(usize, Ailment, Window)>,
    /// Commanded spool positions of the last cycles, the newest first.
    commands: [[f64; CYLINDERS]; MOST_LATE + 1],
}

impl Ailing {
    /// Those of `faults` that are the machine's; the others are of readings.
    pub fn new(faults: &[Fault]) -> Self {
        let of_the_machine = |fault: &Fault| {
            let Wanted::Machine(ailment) = fault.wanted else { return None };
            let leg = usize::from(fault.cylinder).wrapping_sub(1);
            (leg < CYLINDERS).then_some((leg, ailment, fault.window))
        };
        Self {
            faults: faults.iter().filter_map(of_the_machine).collect(),
            commands: [[0.0; CYLINDERS]; MOST_LATE + 1],
        }
    }

    fn present(&self, time: f64) -> impl Iterator<Item = (usize, Ailment)> {
        let elapsed = Span::from_seconds(time);
        let there = move |window: &Window| window.age(elapsed).is_some();
        self.faults.iter().filter(move |(_, _, window)| there(window)).map(|it| (it.0, it.1))
    }

    /// The spool positions that the valves are told at `time`, s, for the controller's `commands`, and the
    /// bands in which the spools stick.
    pub fn told(&mut self, time: f64, commands: &[f64; CYLINDERS]) -> [[f64; CYLINDERS]; 2] {
        self.commands.rotate_right(1);
        self.commands[0] = *commands;
        let (mut told, mut bands) = (*commands, [0.0_f64; CYLINDERS]);
        for (leg, ailment) in self.present(time) {
            match ailment {
                Ailment::LateCommand { cycles } => {
                    told[leg] += self.commands[cycles.min(MOST_LATE)][leg] - self.commands[0][leg];
                }
                Ailment::WrongCommand { gain } => told[leg] += gain * self.commands[0][leg],
                Ailment::SpoolOffset { size } => told[leg] += size,
                Ailment::Sticking { band } => bands[leg] = bands[leg].max(band),
                _ => {}
            }
        }
        [told.map(|spool| spool.clamp(-1.0, 1.0)), bands]
    }

    /// What differs in each cylinder from `usual` at `time`, s.
    pub fn wear(&self, time: f64, usual: Wear) -> [Wear; CYLINDERS] {
        let mut wear = [usual; CYLINDERS];
        for (leg, ailment) in self.present(time) {
            wear[leg].add(ailment);
        }
        wear
    }

    /// Part by which the supply's set point is lower at `time`, s.
    pub fn supply_lost(&self, time: f64) -> f64 {
        let part = |(_, ailment)| match ailment {
            Ailment::SupplyLoss { part } => part,
            _ => 0.0,
        };
        self.present(time).map(part).fold(0.0, f64::max)
    }
}
