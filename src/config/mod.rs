//! The configuration: from a TOML file to settings that are known to be sound.

pub mod settings;
