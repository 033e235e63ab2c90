//! Answers to the requests of one client.

use super::map::registers;
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::Clock;
use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::OwnedSemaphorePermit;
use tokio_modbus::server::Service;
use tokio_modbus::{ExceptionCode, Request, Response};

/// Most registers of one request (Modbus Application Protocol V1.1b3, section 6.4).
const MOST_REGISTERS: u16 = 125;

/// Time for an answer and for a new connection, so that clients that do not pause take no more than a hundred of them a
/// second.
pub(super) const PACE: Duration = Duration::from_millis(10);

/// Reads the telemetry for one client; there is nothing that a client could write.
pub(super) struct Reading {
    pub telemetry: Arc<Telemetry>,
    pub clock: Arc<dyn Clock>,
    /// Its place among the clients, which it has until the connection ends.
    pub _place: OwnedSemaphorePermit,
}

impl Reading {
    /// The answer to `request`. Input and holding registers are the same, as many masters know only the latter.
    fn answer(&self, request: &Request<'_>) -> Result<Response, ExceptionCode> {
        match *request {
            Request::ReadInputRegisters(address, count) => {
                self.read(address, count).map(Response::ReadInputRegisters)
            }
            Request::ReadHoldingRegisters(address, count) => {
                self.read(address, count).map(Response::ReadHoldingRegisters)
            }
            _ => Err(ExceptionCode::IllegalFunction),
        }
    }

    fn read(&self, address: u16, count: u16) -> Result<Vec<u16>, ExceptionCode> {
        if !(1..=MOST_REGISTERS).contains(&count) {
            return Err(ExceptionCode::IllegalDataValue);
        }
        let sheet = registers(&self.telemetry.snapshot(self.clock.uptime()));
        let found = sheet.read(address, count).map(<[u16]>::to_vec);
        found.ok_or(ExceptionCode::IllegalDataAddress)
    }
}

impl Service for Reading {
    type Request = Request<'static>;
    type Response = Response;
    type Exception = ExceptionCode;
    type Future = Pin<Box<dyn Future<Output = Result<Response, ExceptionCode>> + Send>>;

    fn call(&self, request: Self::Request) -> Self::Future {
        let answer = self.answer(&request);
        self.telemetry.modbus_answered(answer.is_ok());
        Box::pin(async move {
            tokio::time::sleep(PACE).await;
            answer
        })
    }
}
