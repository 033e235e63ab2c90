//! What is saved of a device.

use super::{DeviceReason, DeviceReport, DeviceState, DeviceWatch};
use crate::sample::emergency::Emergency;
use crate::state::{StateError, StateReader, StateWriter, Stateful, Whole, choice, state, whole};

choice! { DeviceState { Initialising, Stopped, Operational, PreOperational } }

whole! { DeviceReport { node, reason } }

state! {
    DeviceWatch { age, state, fresh, fault, reported, complaint }
    but { design, sends_readings }
}

impl DeviceReason {
    const fn emergency(&self) -> Option<Emergency> {
        match self {
            Self::Emergency(emergency) => Some(*emergency),
            Self::HeartbeatLost => None,
        }
    }
}

impl Stateful for DeviceReason {
    const SHAPE: u64 = Option::<Emergency>::SHAPE;

    fn save(&self, into: &mut StateWriter) {
        self.emergency().save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl Whole for DeviceReason {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        Ok(Option::read(from)?.map_or(Self::HeartbeatLost, Self::Emergency))
    }
}
