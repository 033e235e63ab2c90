//! How cylinders and transducers are called, as samples to be joined with the others.

use super::{Out, View};
use prometheus_client::metrics::MetricType;
use std::fmt;
use tertius_core::sample::Transducer;

impl View {
    /// Writes a sample for each name; nothing for a machine without any.
    pub(super) fn names(&self, out: &mut Out<'_, '_>) -> fmt::Result {
        let facts = self.telemetry.facts();
        let names = &facts.names;
        if names.is_empty() {
            return Ok(());
        }
        let cylinders = || (1_usize..).zip(self.numbered().map(|(number, _)| number));
        let help = "Name of a cylinder, to be joined with other samples by the label cylinder.";
        let mut family = out.family("cylinder", help, None, MetricType::Info)?;
        for (n, number) in cylinders() {
            if let Some(name) = names.of_cylinder(n) {
                family.encode_info(&[("cylinder", number), ("name", name)])?;
            }
        }
        let help = "Name of a transducer, to be joined by the labels cylinder and transducer.";
        let mut family = out.family("transducer", help, None, MetricType::Info)?;
        for (n, number) in cylinders() {
            for which in Transducer::ALL {
                if let Some(name) = names.of_transducer(n, which) {
                    let transducer = ("transducer", which.name());
                    let labels = [("cylinder", number), transducer, ("name", name)];
                    family.encode_info(&labels)?;
                }
            }
        }
        Ok(())
    }
}
