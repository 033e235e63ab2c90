//! The tables of the process detectors, as the configuration reads them.

use super::digits::six;
use std::fmt::Write as _;
use tertius_config::settings::{
    ChambersTable, CylinderProcess, FlowTable, FrictionTable, SpoolTable, SupplyTable,
};

/// `[cylinder.process]` and its parts.
pub(super) fn table(process: &CylinderProcess) -> String {
    let CylinderProcess { sample_time, spool, chambers, flow, friction } = process;
    let mut text = format!("\n[cylinder.process]\nsample_time = {sample_time:?}\n");
    if let Some(spool) = spool {
        text += &of_spool(spool);
    }
    if let Some(chambers) = chambers {
        text += &of_chambers(chambers);
    }
    if let Some(flow) = flow {
        text += &of_flow(flow);
    }
    if let Some(friction) = friction {
        text += &of_friction(friction);
    }
    text
}

/// `[process.supply]`.
pub(super) fn of_supply(table: &SupplyTable) -> String {
    let SupplyTable { sample_time, reference, taught, pump, taken, deviation, mean_dependence } =
        table;
    format!(
        "\n[process.supply]\nsample_time = {sample_time:?}\nreference = {reference:.3}\ntaught = {}\npump = {}\n\
         taken = {}\ndeviation = {deviation:e}\nmean_dependence = {}\n",
        six(taught),
        six(pump),
        six(taken),
        six(mean_dependence),
    )
}

fn of_spool(table: &SpoolTable) -> String {
    let SpoolTable {
        retained,
        limit,
        curve,
        before,
        samples,
        deviation,
        timing,
        largest,
        mean_dependence,
        square_dependence,
    } = table;
    let mut text = "\n[cylinder.process.spool]\n".to_owned();
    _ = write!(
        text,
        "retained = {retained:e}\nlimit = {limit:?}\ncurve = {}\nbefore = {}\nsamples = {samples:?}\n\
         deviation = {deviation:e}\ntiming = {timing:e}\nlargest = {largest:?}\nmean_dependence = {}\n\
         square_dependence = {}\n",
        six(curve),
        six(before),
        six(mean_dependence),
        six(square_dependence),
    );
    text
}

fn of_chambers(table: &ChambersTable) -> String {
    let ChambersTable {
        coefficients,
        supplies,
        deviation,
        growth,
        mean_dependence,
        square_dependence,
    } = table;
    let mut text = "\n[cylinder.process.chambers]\n".to_owned();
    text.push_str(&of_supplies(supplies.as_ref()));
    _ = write!(
        text,
        "coefficients = {}\ndeviation = {deviation:e}\ngrowth = {growth:e}\nmean_dependence = {}\nsquare_dependence = {}\n",
        six(coefficients),
        six(mean_dependence),
        six(square_dependence),
    );
    text
}

fn of_flow(table: &FlowTable) -> String {
    let FlowTable {
        limit,
        curve,
        samples,
        between,
        leakage,
        compression,
        supplies,
        scatter_c1,
        scatter_c2,
    } = table;
    let mut text = "\n[cylinder.process.flow]\n".to_owned();
    _ = write!(
        text,
        "limit = {limit:?}\ncurve = {}\nsamples = {samples:?}\nbetween = {between:?}\nleakage = {leakage:e}\n\
         compression = {compression:e}\n{}scatter_c1 = {}\nscatter_c2 = {}\n",
        six(curve),
        of_supplies(supplies.as_ref()),
        six(scatter_c1),
        six(scatter_c2),
    );
    text
}

fn of_supplies(supplies: Option<&[f64; 2]>) -> String {
    supplies.map_or_else(String::new, |it| format!("supplies = {}\n", six(it)))
}

fn of_friction(table: &FrictionTable) -> String {
    let FrictionTable { coefficients, scatter } = table;
    format!(
        "\n[cylinder.process.friction]\ncoefficients = {}\nscatter = {}\n",
        six(coefficients),
        six(scatter),
    )
}
