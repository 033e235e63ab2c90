//! One machine that the monitors of all sets watch.

use super::cases::TransducerKind;
use crate::evaluate::grade::Grade;
use crate::evaluate::stand::{Stand, StandError};
use crate::evaluate::tried::Try;
use rand_chacha::ChaCha8Rng;
use tertius_core::alarm::{Detector, State, Warning};
use tertius_core::monitor::{Monitor, MonitorDesign, Record, Sink};
use tertius_core::verdict::Suspect;
use tertius_machine::inject::Wanted;
use tertius_machine::plant::CYLINDERS;
use tertius_machine::simulator::{Options, Simulator};

/// How long one healthy machine is watched, s.
pub const STRETCH: f64 = 600.0;

/// Residuals of a machine: R1 and R2 of each cylinder.
pub const RESIDUALS: usize = 2 * CYLINDERS;

/// What one set's observers saw of one healthy machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuietMachine {
    /// Warnings of FDE1 and FDE2 with the thesis's thresholds.
    pub raises: u64,
    /// The largest |R1| and |R2| of each block of judged time, by cylinder, m.
    pub blocks: [Vec<f64>; RESIDUALS],
}

/// Largest residual of the faulty transducer, |R1| or |R2|, while a fault was watched, for each
/// cylinder, m; 0 where none was judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faulty(pub [f64; CYLINDERS]);

/// Listens to one monitor on a healthy machine.
struct Listener {
    quiet: QuietMachine,
    /// Length of a block, cycles.
    block: u32,
    /// Largest value and number of cycles of each block that is not yet full.
    open: [(f64, u32); RESIDUALS],
}

impl Sink for Listener {
    fn warning(&mut self, warning: &Warning) {
        let observers = matches!(warning.detector, Detector::Fde1 | Detector::Fde2);
        self.quiet.raises += u64::from(observers && warning.state == State::Raised);
    }

    fn record(&mut self, record: &Record) {
        if record.gated {
            return;
        }
        for (transducer, residual) in record.residuals.into_iter().take(2).enumerate() {
            let Some(residual) = residual else { continue };
            let index = 2 * (usize::from(record.cylinder) - 1) + transducer;
            let (largest, cycles) = &mut self.open[index];
            *largest = largest.max(residual.abs());
            *cycles += 1;
            if *cycles == self.block {
                self.quiet.blocks[index].push(*largest);
                self.open[index] = (0.0, 0);
            }
        }
    }
}

/// The newest R1 and R2 of every cylinder.
#[derive(Default)]
struct Newest([[Option<f64>; 2]; CYLINDERS]);

impl Sink for Newest {
    fn warning(&mut self, warning: &Warning) {
        _ = warning;
    }

    fn record(&mut self, record: &Record) {
        let [r1, r2, _] = record.residuals;
        self.0[usize::from(record.cylinder) - 1] = [r1, r2];
    }
}

impl Stand<'_> {
    fn of_kind(&self, kind: TransducerKind, options: &Options) -> Result<Simulator, StandError> {
        match kind {
            TransducerKind::Steady => self.steady(Grade::Fine, options),
            TransducerKind::Fluctuating | TransducerKind::Coarse => {
                self.graded(kind.of_grade(), options)
            }
        }
    }

    /// Watches the healthy machine of `seed` for one stretch with the monitor of every set.
    pub(super) fn unseen(
        &self,
        sets: &[MonitorDesign],
        kind: TransducerKind,
        sea: [f64; 2],
        seed: u64,
    ) -> Result<Vec<QuietMachine>, StandError> {
        let options = Options { seed, sea: Some(sea), ..Options::default() };
        let mut simulator = self.of_kind(kind, &options)?;
        let listener = |design: &_| {
            let block = self.settings.warning_cycles();
            let listener =
                Listener { quiet: QuietMachine::default(), block, open: Default::default() };
            (Monitor::new(Clone::clone(design)), listener)
        };
        let mut watching: Vec<_> = sets.iter().map(listener).collect();
        for _ in 0..self.cycles(STRETCH) {
            simulator.step(&mut |frame| {
                watching.iter_mut().for_each(|(monitor, listener)| monitor.take(frame, listener));
            });
        }
        Ok(watching.into_iter().map(|(_, listener)| listener.quiet).collect())
    }

    /// Watches a machine with a fault on one transducer of each cylinder with the monitor of every set,
    /// for `watch` seconds from the first faulty reading.
    pub(super) fn seen(
        &self,
        sets: &[MonitorDesign],
        kind: TransducerKind,
        sea: [f64; 2],
        (wanted, watch): (Wanted, f64),
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Faulty>, StandError> {
        let cylinders = self.settings.machine.cylinders;
        let one = Try::draw(Some(wanted), None, cylinders, self.settings.observer.settle, rng);
        let faults = self.placed(&one)?;
        let options = Options { seed: one.seed, sea: Some(sea), faults, ..Options::default() };
        let mut simulator = self.of_kind(kind, &options)?;
        let begin = |design: &_| (Monitor::new(Clone::clone(design)), Newest::default());
        let mut watching: Vec<_> = sets.iter().map(begin).collect();
        let mut seen = vec![Faulty::default(); watching.len()];
        let latest = one.faults.iter().map(|fault| fault.at).fold(0.0, f64::max);
        let (watched, mut since) = (self.cycles(watch), [0_u64; CYLINDERS]);
        for _ in 0..self.cycles(latest + watch) + 2 {
            simulator.step(&mut |frame| {
                watching.iter_mut().for_each(|(monitor, newest)| monitor.take(frame, newest));
            });
            for (index, fault) in one.faults.iter().enumerate() {
                let cylinder = usize::from(fault.cylinder) - 1;
                if simulator.tallies()[index].altered == 0 || since[cylinder] > watched {
                    continue;
                }
                since[cylinder] += 1;
                let own = usize::from(fault.transducer == Suspect::C2);
                for ((_, newest), Faulty(seen)) in watching.iter().zip(&mut seen) {
                    let residual = newest.0[cylinder][own].map_or(0.0, f64::abs);
                    seen[cylinder] = seen[cylinder].max(residual);
                }
            }
        }
        Ok(seen)
    }
}
