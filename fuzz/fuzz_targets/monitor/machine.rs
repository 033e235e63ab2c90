//! The shipped machine.

use std::sync::LazyLock;

use tertius::alarm::{OwnMessage, frames};
use tertius::config;
use tertius::config::design;
use tertius::dbc::Database;
use tertius::frame::Id;
use tertius::monitor::MonitorDesign;

pub static MACHINE: LazyLock<MonitorDesign> = LazyLock::new(|| {
    let text = include_str!("../../../config/e-type.toml");
    let (settings, _) = config::parse("e-type.toml", text).expect("it ships");
    let database = Database::parse(include_str!("../../../dbc/e-type.dbc")).expect("it ships");
    design::judging(&settings, &database).expect("they fit each other")
});

/// Identifiers of the gateway at the shipped node: Fd_Status, Fd_Warning, Fd_Estimate.
pub static OWN: LazyLock<[Id; OwnMessage::ALL.len()]> =
    LazyLock::new(|| frames::identifiers(81).expect("a node"));
