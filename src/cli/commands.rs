//! The commands beside the demonstration.

use super::{
    Failure, calibrate, check, commission, config, convert, doctor, eds, evaluate, events, fleet,
    identify, init, inject, monitor, replay, run, simulate, token, tune,
};
use clap::Subcommand;

#[derive(Debug, Subcommand)]
pub enum Command {
    Init(init::Init),
    Run(run::Run),
    Replay(replay::Replay),
    Check(check::Check),
    Config(config::Config),
    Doctor(doctor::Doctor),
    Monitor(monitor::Monitor),
    Eds(eds::Eds),
    Events(events::Events),
    Convert(convert::Convert),
    Fleet(fleet::Fleet),
    Inject(inject::Inject),
    Commission(commission::Commission),
    Identify(identify::Identify),
    Simulate(simulate::Simulate),
    Evaluate(evaluate::Evaluate),
    Calibrate(calibrate::Calibrate),
    Tune(tune::Tune),
    Token(token::Token),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// A message for a person, with the exit code.
    pub fn run(self) -> Result<(), Failure> {
        match self {
            Self::Init(init) => init.run(),
            Self::Run(run) => run.run(),
            Self::Replay(replay) => replay.run(),
            Self::Check(check) => check.run(),
            Self::Config(config) => config.run(),
            Self::Doctor(doctor) => doctor.run(),
            Self::Monitor(monitor) => monitor.run(),
            Self::Eds(eds) => eds.run(),
            Self::Events(events) => events.run(),
            Self::Convert(convert) => convert.run(),
            Self::Fleet(fleet) => fleet.run(),
            Self::Inject(inject) => inject.run(),
            Self::Commission(commission) => commission.run(),
            Self::Identify(identify) => identify.run(),
            Self::Simulate(simulate) => simulate.run(),
            Self::Evaluate(evaluate) => evaluate.run(),
            Self::Calibrate(calibrate) => calibrate.run(),
            Self::Tune(tune) => tune.run(),
            Self::Token(token) => token.run(),
        }
    }
}
