//! `tertius eds`: writes the gateway's electronic data sheet.

use super::files::{Inputs, Mark, Overwriting};
use super::machine::Machine;
use super::overriding::SetOptions;
use super::{Failure, node};
use crate::canopen::node::sheet::{self, SheetKind};
use clap::Args;
use std::path::{Path, PathBuf};

/// Writes the electronic data sheet (EDS) of the gateway as a CANopen node, for configuration tools
/// and masters.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  tertius eds --config config/e-type.toml --set canopen.node=true --output tertius.eds
  tertius eds --config config/e-type.toml --set canopen.node=true --dcf --output tertius.dcf

The configuration of a gateway that is a node has `node = true` in [canopen], and needs no --set.")]
pub struct Eds {
    /// The machine's configuration
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    #[command(flatten)]
    set: SetOptions,
    /// Writes a DCF instead: the sheet of the node as it is configured, with its number and bit rate
    #[arg(long)]
    dcf: bool,
    /// Where the sheet goes; without it, to standard output
    #[arg(long, short, value_name = "FILE", default_value = "-")]
    output: PathBuf,
    #[command(flatten)]
    overwriting: Overwriting,
}

/// Beginning of a sheet of this command.
const MARK: Mark = Mark::Parts(&["[FileInfo]", "CreatedBy=tertius eds"]);

impl Eds {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong configuration, or one without a node; an output that cannot be written.
    pub fn run(self) -> Result<(), Failure> {
        let machine = Machine::load(&self.config, &self.set.overrides()?)?;
        let design = node::design(&machine).ok_or_else(|| {
            Failure::Wrong(format!(
                "{}: the gateway is no CANopen node; `node = true` in [canopen] makes it one, or --set canopen.node=true",
                self.config.display()
            ))
        })?;
        let (kind, name) = match self.dcf {
            false => (SheetKind::Device, "tertius.eds"),
            true => (SheetKind::Configured, "tertius.dcf"),
        };
        let own = self.output.file_name().filter(|_| self.output != Path::new("-"));
        let name = own.map_or(name.into(), |own| own.to_string_lossy());
        let inputs = Inputs::new(machine.files(&self.config));
        let [output] = inputs.claim([(Some(&self.output), MARK)], self.overwriting)?;
        output.expect("it was asked for").write(&sheet::write(&design, kind, &name))
    }
}
