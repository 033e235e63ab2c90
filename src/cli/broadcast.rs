//! Sends the frames of a simulated machine on an interface in real time.

use super::Failure;
use super::player::Pace;
use crate::bus::socket::{Options, SocketPort, is_virtual};
use crate::bus::{Identifiers, Port, PortError, Sent, Unrestricted, UnrestrictedPort};
use crate::frame::Frame;
use crate::report::times;
use crate::text::counted;
use crate::time::Timestamp;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Delay beyond which a frame counts as late: half a sample of 20 ms.
const LATE: Duration = Duration::from_millis(10);

/// Delay beyond which the schedule restarts, so that missed frames do not burst out.
const BEHIND: Duration = Duration::from_millis(100);

/// Longest time for which an interface may have no room for a frame.
const JAMMED: Duration = Duration::from_secs(1);

/// Longest sleep, after which signals are checked.
const NAP: Duration = Duration::from_millis(50);

/// Pause between two attempts to send on an interface without room.
const RETRY: Duration = Duration::from_millis(1);

/// An interface on which frames are sent at their times.
pub struct Broadcast<P> {
    name: String,
    port: P,
    pace: Pace,
    stop: Arc<AtomicBool>,
    /// An instant, and the frames' time at it.
    anchor: Option<(Instant, Timestamp)>,
    counts: Counts,
}

/// Counts of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Counts {
    sent: u64,
    late: u64,
    /// Number of times that the schedule restarted.
    anew: u64,
    worst: Duration,
}

impl Broadcast<Unrestricted<SocketPort>> {
    /// Opens `name`, and catches SIGINT and SIGTERM from then on.
    ///
    /// # Errors
    /// An interface that cannot send, or one of a real bus without permission.
    pub fn open(name: &str, pace: Pace, real_bus: bool) -> Result<Self, Failure> {
        let nothing = Options { identifiers: Identifiers::Only(vec![]), ..Options::default() };
        let port = Unrestricted::<SocketPort>::open(name, &nothing)
            .map_err(|error| Failure::Wrong(error.to_string()))?;
        if !real_bus && !is_virtual(name).map_err(|error| Failure::Failed(error.to_string()))? {
            return Err(Failure::Wrong(format!(
                "{name} is not a virtual interface (vcan or vxcan): a simulated machine would send \
                 transducer readings onto its bus, which a real machine there would take for its \
                own; on a test bench give --real-bus"
            )));
        }
        let stop = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM] {
            signal_hook::flag::register(signal, Arc::clone(&stop))
                .map_err(|error| Failure::Failed(format!("signals cannot be caught: {error}")))?;
        }
        tell!("to {}", port.description());
        Ok(Self::new(name, port, pace, stop))
    }
}

impl<P: UnrestrictedPort> Broadcast<P> {
    fn new(name: &str, port: P, pace: Pace, stop: Arc<AtomicBool>) -> Self {
        let (name, counts) = (name.to_owned(), Counts::default());
        Self { name, port, pace, stop, anchor: None, counts }
    }

    /// Sends the next frame when its time has come; returns `false` if it must stop instead.
    ///
    /// # Errors
    /// The interface no longer carries frames.
    pub fn send(&mut self, frame: &Frame) -> Result<bool, Failure> {
        Ok(self.await_time(frame.timestamp) && self.hand_over(frame)?)
    }

    /// Reports the counts of the frames that are not zero.
    pub fn report(&self) {
        let Counts { sent, late, anew, worst } = self.counts;
        tell!("{} sent on {}", counted(sent, "frame"), self.name);
        if late > 0 {
            tell!(
                "  {late} more than {} ms late, at the worst {:.1} ms",
                LATE.as_millis(),
                worst.as_secs_f64() * 1e3
            );
        }
        if anew > 0 {
            tell!(
                "  {} more than {} ms behind; it continued from there",
                times(anew),
                BEHIND.as_millis()
            );
        }
    }

    /// Waits until the machine's time is `stamp`; returns `false` if it must stop.
    fn await_time(&mut self, stamp: Timestamp) -> bool {
        let Pace::Times(times) = self.pace else { return self.goes_on() };
        let (instant, origin) = *self.anchor.get_or_insert((Instant::now(), stamp));
        let due =
            instant + Duration::from_secs_f64(stamp.since(origin).as_seconds().max(0.0) / times);
        loop {
            let left = due.saturating_duration_since(Instant::now());
            if left.is_zero() || !self.goes_on() {
                break;
            }
            std::thread::sleep(left.min(NAP));
        }
        let behind = Instant::now().saturating_duration_since(due);
        self.counts.late += u64::from(behind > LATE);
        self.counts.worst = self.counts.worst.max(behind);
        if behind > BEHIND {
            self.counts.anew += 1;
            self.anchor = Some((Instant::now(), stamp));
        }
        self.goes_on()
    }

    fn hand_over(&mut self, frame: &Frame) -> Result<bool, Failure> {
        let started = Instant::now();
        loop {
            match self.port.send_unrestricted(frame) {
                Ok(Sent::Taken) => {
                    self.counts.sent += 1;
                    return Ok(true);
                }
                Ok(Sent::Full) if !self.goes_on() => return Ok(false),
                Ok(Sent::Full) if started.elapsed() < JAMMED => std::thread::sleep(RETRY),
                Ok(Sent::Full) => {
                    return Err(Failure::Failed(format!(
                        "{} accepts no more frames: nobody on its bus acknowledges them; connect \
                         another node",
                        self.name
                    )));
                }
                Err(PortError::Io(error)) => {
                    let name = &self.name;
                    let message = format!("{name} cannot carry the frame {}: {error}", frame.id);
                    return Err(Failure::Failed(message));
                }
                Err(error) => return Err(Failure::Failed(format!("{}: {error}", self.name))),
            }
        }
    }

    fn goes_on(&self) -> bool {
        !self.stop.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::embedded::{BusState, Clock, EmbeddedBus};
    use crate::frame::{Id, Kind};
    use crate::time::Span;

    fn frame(at: f64) -> Frame {
        let id = Id::standard(0x181).expect("eleven bits");
        Frame::new(Timestamp::default().after(Span::from_seconds(at)), id, Kind::Data, &[1])
    }

    fn broadcast(bus: &EmbeddedBus, pace: Pace) -> Broadcast<impl UnrestrictedPort + use<>> {
        let port = bus.open_unrestricted(&Identifiers::Only(vec![]), 1).expect("it is up");
        Broadcast::new("virtual", port, pace, Arc::default())
    }

    #[test]
    fn frames_go_out_in_their_own_time_at_the_speed_asked_for() {
        let bus = EmbeddedBus::new(Clock::System);
        let mut broadcast = broadcast(&bus, Pace::Times(10.0));
        let started = Instant::now();
        assert!(broadcast.send(&frame(5.0)).expect("the first sets the time"));
        assert!(started.elapsed() < Duration::from_millis(100));
        assert!(broadcast.send(&frame(7.0)).expect("it is up"));
        assert!(started.elapsed() >= Duration::from_millis(200), "2 s, ten times as fast");
        assert_eq!(broadcast.counts.sent, 2);
    }

    #[test]
    fn what_was_missed_is_counted_and_does_not_burst_out() {
        let bus = EmbeddedBus::new(Clock::System);
        let mut broadcast = broadcast(&bus, Pace::Times(1.0));
        // As if it had been stopped for ten seconds.
        let before = Instant::now().checked_sub(Duration::from_secs(10)).expect("it is up");
        broadcast.anchor = Some((before, Timestamp::default()));
        assert!(broadcast.send(&frame(1.0)).expect("it is up"));
        assert_eq!((broadcast.counts.late, broadcast.counts.anew), (1, 1));
        assert!(broadcast.counts.worst >= Duration::from_secs(9));
        let started = Instant::now();
        assert!(broadcast.send(&frame(1.05)).expect("it is up"));
        assert!(
            started.elapsed() >= Duration::from_millis(45),
            "after the other, as in the machine"
        );
    }

    #[test]
    fn a_bus_that_goes_or_takes_nothing_ends_it() {
        let bus = EmbeddedBus::new(Clock::System);
        let mut gone = broadcast(&bus, Pace::Max);
        let mut jammed = broadcast(&bus, Pace::Max);
        bus.set_state(BusState::Jammed);
        let told = jammed.send(&frame(0.0)).expect_err("nobody acknowledges").to_string();
        assert!(told.contains("nobody on its bus acknowledges"), "{told}");
        jammed.stop.store(true, Ordering::Relaxed);
        assert!(!jammed.send(&frame(0.0)).expect("it was told to stop"));
        bus.set_state(BusState::Down);
        let told = gone.send(&frame(0.0)).expect_err("down").to_string();
        assert!(told.contains("virtual: the interface is down"), "{told}");
    }
}
