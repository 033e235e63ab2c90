//! State and events published to a broker over MQTT 5, as JSON or as Sparkplug B. Nothing is subscribed to but, of
//! Sparkplug, the command to say everything anew.
//!
//! ```text
//! Telemetry ─ state ─→ Session ─→ broker      retained; a will takes its place when the gateway is gone
//! StoreReader ─ news ─↗      └─→ Cursor       each event once or more, in order, over outages and restarts
//! ```
//!
//! The publisher is a thread of its own, which only reads what the data path has stored and what the event store has
//! on disk: neither waits for the broker. An outage costs no memory, since what is to be published is in the store.

mod cursor;
mod link;
mod message;
mod plan;
mod pulse;
mod session;
mod sparkplug;
mod trouble;

use super::{Output, OutputPlan};
use crate::appliance::realtime;
use crate::appliance::telemetry::Recorder;
use cursor::Cursor;
pub use plan::{Authority, MqttFileError, MqttPlan};
use session::{Desk, Session};
pub use sparkplug::EdgeNode;
use sparkplug::SparkplugSession;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tokio::sync::oneshot;
use tracing::{info, warn};
use trouble::MqttTrouble;

/// Stack of the thread, bytes.
const STACK_SIZE: usize = 512 * 1024;

/// Most threads that look for the broker's name at once.
const NAME_THREADS: usize = 1;

/// Pauses before the next attempt: the first, which doubles, and the longest.
const PAUSES: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(60)];

/// A running publisher; it ends when this is dropped, and the broker then publishes the will.
#[derive(Debug)]
pub struct MqttPublisher {
    _stop: oneshot::Sender<()>,
}

impl MqttPublisher {
    /// Publishes by `plan` what `recorder` writes.
    ///
    /// # Errors
    /// The system provides no thread.
    pub fn start(plan: MqttPlan, recorder: &Recorder) -> io::Result<Self> {
        Self::with_pauses(plan, recorder, PAUSES)
    }

    /// The same, which tries again after pauses from the first to the second of `pauses`.
    ///
    /// # Errors
    /// The system provides no thread.
    pub fn with_pauses(
        plan: MqttPlan,
        recorder: &Recorder,
        pauses: [Duration; 2],
    ) -> io::Result<Self> {
        let (telemetry, clock) = (recorder.telemetry().clone(), recorder.clock().clone());
        // It looks for the broker's name. With a name server that hangs, the next attempt waits for this thread, too.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .max_blocking_threads(NAME_THREADS)
            .thread_name("mqtt-name")
            .build()?;
        let (stop, stopped) = oneshot::channel();
        let work = move || {
            realtime::be_ordinary();
            let cursor =
                plan.store.as_deref().map(|path| Arc::new(Mutex::new(Cursor::beside(path))));
            let (connections, ignored) = (Arc::default(), Arc::default());
            let (plan, own) = (Arc::new(plan), telemetry.clone());
            let desk = Desk { plan, telemetry: own, clock, cursor, connections, ignored };
            runtime.spawn(publish(desk, pauses));
            // Ends with an error once the sender is dropped.
            _ = runtime.block_on(stopped);
            // A name server that does not answer is not waited for.
            runtime.shutdown_background();
            telemetry.mqtt_up(None);
        };
        std::thread::Builder::new().name("mqtt".to_owned()).stack_size(STACK_SIZE).spawn(work)?;
        Ok(Self { _stop: stop })
    }
}

/// The publisher, and its plan.
#[derive(Debug, Default)]
pub struct MqttOutput(Option<(MqttPlan, MqttPublisher)>);

impl Output for MqttOutput {
    fn follow(&mut self, plan: &OutputPlan, recorder: &Recorder) {
        let wanted = MqttPlan::of(plan);
        if self.0.as_ref().map(|(plan, _)| plan) == wanted.as_ref() {
            return;
        }
        // The one before goes first: a broker knows both by the same name.
        if self.0.take().is_some() && wanted.is_none() {
            info!("nothing is published over MQTT any more");
        }
        let Some(plan) = wanted else { return };
        if plan.store.is_none() {
            info!("without `store.file` no events are published over MQTT, only the state");
        }
        if plan.login.is_some() && plan.authority.is_none() {
            warn!(
                "the password for {}:{} is sent unencrypted; `mqtt.authority` encrypts",
                plan.host, plan.port
            );
        }
        match MqttPublisher::start(plan.clone(), recorder) {
            Ok(publisher) => self.0 = Some((plan, publisher)),
            Err(error) => warn!("nothing is published over MQTT: {error}"),
        }
    }
}

/// Connects again and again until the task is dropped.
async fn publish(desk: Desk, [first, longest]: [Duration; 2]) {
    let mut pause = first;
    let mut told = String::new();
    desk.telemetry.mqtt_up(Some(false));
    loop {
        // How many wait is known during an outage, too.
        desk.news(0);
        let began = Instant::now();
        // A task of its own: whatever a stranger sends, the next attempt follows.
        let ended = tokio::spawn(converse(desk.clone())).await;
        desk.telemetry.mqtt_failed();
        let unreadable = |_| "what it sends cannot be read".to_owned();
        let trouble = ended.map_or_else(unreadable, |trouble| trouble.to_string());
        if began.elapsed() > longest {
            // It was a connection of use, and not one that comes and goes.
            (pause, told) = (first, String::new());
        }
        if trouble != told {
            let MqttPlan { host, port, .. } = &*desk.plan;
            warn!("no MQTT to {host}:{port}: {trouble}; trying again, events wait in the store");
            told = trouble;
        }
        tokio::time::sleep(pause).await;
        pause = (2 * pause).min(longest);
    }
}

/// One connection, and why it ended.
async fn converse(desk: Desk) -> MqttTrouble {
    match desk.plan.sparkplug.clone() {
        None => match Session::open(desk).await {
            Ok(session) => session.run().await,
            Err(trouble) => trouble,
        },
        Some(edge) => match SparkplugSession::open(desk, edge).await {
            Ok(session) => session.run().await,
            Err(trouble) => trouble,
        },
    }
}
