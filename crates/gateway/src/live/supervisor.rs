//! Keeps a gateway running for months: opens the port, and opens it again after each loss.

use super::gateway::{Gateway, Journal};
use crate::bus::{Port, PortError};
use std::time::Duration;

/// Longest wait of a turn for frames, which bounds the delay of deadlines and statuses.
const PATIENCE: Duration = Duration::from_millis(5);

/// First and longest wait between two attempts to open a port.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// Pause between attempts to send on an interface that accepts no frames.
const FULL_PAUSE: Duration = Duration::from_millis(2);

/// Opens a port, repeatedly.
pub trait Opener {
    /// # Errors
    /// Why there is none, for people.
    fn open(&mut self) -> Result<Box<dyn Port>, String>;
}

/// Request from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    GoOn,
    /// Read the configuration again.
    Reload,
    Stop,
}

/// Everything outside of the data path that the supervisor depends on.
pub trait Surroundings: Journal {
    /// The present request; asked after each turn.
    fn request(&mut self) -> Request;
    /// Waits at most for `time`, less if there is a request.
    fn wait(&mut self, time: Duration);
    /// Notes that a port is open.
    fn opened(&mut self, port: &dyn Port);
    /// Notes that the port is lost, or could not be opened. Called once for each new reason.
    fn lost(&mut self, reason: &str);
    /// Notes that the last status of a stopping gateway was not sent, for `reason`.
    fn report_not_sent(&mut self, reason: &str);
    /// Notes that `port` was open and is lost, whether or not the reason is new.
    fn closed(&mut self, gateway: &Gateway, port: &dyn Port) {
        _ = (gateway, port);
    }
    /// Notes a turn with a port that works: the proof of life.
    fn turned(&mut self, gateway: &Gateway, port: &dyn Port);
    /// Replaces `gateway` and the opener of its port, after [`Request::Reload`]; `None` to continue as
    /// before, because the new configuration is refused.
    fn reload(&mut self, gateway: &Gateway) -> Option<(Gateway, Box<dyn Opener>)>;
}

/// Runs `gateway` on the ports of `opener` until it is requested to stop, and returns the gateway
/// that ran last.
pub fn run(
    mut gateway: Gateway,
    mut opener: Box<dyn Opener>,
    surroundings: &mut impl Surroundings,
) -> Gateway {
    let mut back_off = BackOff::default();
    loop {
        match opener.open() {
            Ok(mut port) => {
                surroundings.opened(&*port);
                match serve(&mut gateway, &mut *port, &mut back_off, surroundings) {
                    End::Stop => return gateway,
                    End::Reloaded(new_gateway, new_opener) => {
                        (gateway, opener) = (*new_gateway, new_opener);
                        continue;
                    }
                    End::Lost(error) => {
                        gateway.lose(surroundings);
                        back_off.lost(&error.to_string(), surroundings);
                    }
                }
            }
            Err(reason) => back_off.lost(&reason, surroundings),
        }
        match surroundings.request() {
            Request::Stop => {
                surroundings.report_not_sent("the interface is not open");
                return gateway;
            }
            Request::Reload => {
                if let Some(reloaded) = surroundings.reload(&gateway) {
                    (gateway, opener) = reloaded;
                }
            }
            Request::GoOn => surroundings.wait(back_off.next()),
        }
    }
}

enum End {
    Stop,
    Reloaded(Box<Gateway>, Box<dyn Opener>),
    Lost(PortError),
}

fn serve(
    gateway: &mut Gateway,
    port: &mut dyn Port,
    back_off: &mut BackOff,
    surroundings: &mut impl Surroundings,
) -> End {
    loop {
        match gateway.turn(port, PATIENCE, surroundings) {
            Ok(turn) => {
                if turn.received > 0 {
                    back_off.works();
                }
                surroundings.turned(gateway, port);
                if turn.full && turn.received == 0 {
                    surroundings.wait(FULL_PAUSE);
                }
            }
            Err(error) => {
                surroundings.closed(gateway, port);
                return End::Lost(error);
            }
        }
        match surroundings.request() {
            Request::GoOn => {}
            Request::Stop => {
                if let Err(reason) = gateway.stop(port, FULL_PAUSE, surroundings) {
                    surroundings.report_not_sent(&reason.to_string());
                }
                return End::Stop;
            }
            Request::Reload => {
                if let Some((new_gateway, opener)) = surroundings.reload(gateway) {
                    return End::Reloaded(Box::new(new_gateway), opener);
                }
            }
        }
    }
}

/// Waits that double, and a reason that is reported once.
#[derive(Debug)]
struct BackOff {
    next: Duration,
    reason: Option<String>,
}

impl Default for BackOff {
    fn default() -> Self {
        Self { next: BACK_OFF.0, reason: None }
    }
}

impl BackOff {
    fn lost(&mut self, reason: &str, surroundings: &mut impl Surroundings) {
        if self.reason.as_deref() != Some(reason) {
            surroundings.lost(reason);
            self.reason = Some(reason.to_owned());
        }
    }

    fn next(&mut self) -> Duration {
        let now = self.next;
        self.next = (now * 2).min(BACK_OFF.1);
        now
    }

    fn works(&mut self) {
        *self = Self::default();
    }
}
