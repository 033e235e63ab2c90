//! Values of single keys of the configuration for one call: `--set KEY=VALUE`, and the environment.

use super::Failure;
use crate::config::{Override, Overrides};
use clap::Args;

/// Values instead of those in the configuration's file.
#[derive(Args, Clone, Debug, Default)]
pub struct SetOptions {
    /// Gives a key of the configuration this value instead of that in the file; may be repeated, as in --set
    /// bus.interface=can1 --set fde.high=0.002. The environment does so, too, as in TERTIUS_FDE__HIGH=0.002; --set
    /// takes precedence over it
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = Override::of_argument)]
    set: Vec<Override>,
}

impl SetOptions {
    /// The overrides in force for this call: those of the environment in the order of their names, and then those of
    /// the command line.
    ///
    /// # Errors
    /// A variable's value is not UTF-8.
    pub fn overrides(&self) -> Result<Overrides, Failure> {
        let mut variables = Vec::new();
        for (name, value) in std::env::vars_os() {
            let Some(name) = name.to_str() else { continue };
            if Override::of_variable(name, "").is_none() {
                continue;
            }
            let value = value.to_str().ok_or_else(|| {
                Failure::Wrong(format!("the environment's {name} is not UTF-8; set it anew"))
            })?;
            variables.push((name.to_owned(), value.to_owned()));
        }
        variables.sort();
        let variables =
            variables.iter().filter_map(|(name, value)| Override::of_variable(name, value));
        Ok(Overrides::new(variables.chain(self.set.iter().cloned())))
    }

    /// Whether the command line has an override.
    pub fn are_given(&self) -> bool {
        !self.set.is_empty()
    }
}
