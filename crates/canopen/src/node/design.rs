//! Everything that a node is made from.

/// Everything a node is made from.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeDesign {
    /// Node number, 1 to 127.
    pub node: u8,
    /// Time between heartbeats after each reset, ms; 0 for none.
    pub heartbeat: u16,
    /// Shortest heartbeat time that can be set over SDO, ms: so that heartbeats do not take the bus
    /// share from warnings.
    pub shortest_heartbeat: u16,
    /// Whether the node becomes operational without an NMT master.
    pub autostart: bool,
    /// Version of the program, `major.minor.patch`.
    pub version: String,
    /// Name of the machine.
    pub machine: String,
    /// Sample time, s.
    pub sample_time: f64,
    /// Thresholds of each cylinder.
    pub cylinders: Vec<CylinderThresholds>,
    /// Whether Fd_Estimate is sent.
    pub sends_estimates: bool,
    /// Cylinders with a calibration of the sequential detector, bit 0 for cylinder 1.
    pub calibrated: u8,
    /// Identity of the configuration with its DBC.
    pub configuration: u32,
    /// Identity of the calibration; 0 where there is none.
    pub calibration: u32,
    /// CRC-32 of the DBC, and of the EDS files of devices behind it.
    pub database: u32,
    /// Bit rate of the bus, bit/s.
    pub bitrate: u32,
}

impl NodeDesign {
    /// Major and minor number of the version.
    pub(super) fn revision(&self) -> [u16; 2] {
        let mut parts = self.version.split('.').map(|part| part.parse().unwrap_or(0));
        [parts.next().unwrap_or(0), parts.next().unwrap_or(0)]
    }
}

/// Thresholds of a cylinder, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderThresholds {
    /// Lower and upper threshold of R1 and R2.
    pub observer: [f64; 2],
    /// Lower and upper threshold of R3.
    pub difference: [f64; 2],
    /// |C1 − C2| at which the machine itself trips.
    pub critical: f64,
}
