//! One connection to the broker: the state whenever it changes, and the news of the store one after the other.

use super::cursor::Cursor;
use super::link::{Link, within};
use super::message::{StateMessage, WILL};
use super::plan::MqttPlan;
use super::pulse::Pulse;
use super::trouble::MqttTrouble;
use crate::appliance::store::{NewsEntry, StoreReader};
use crate::appliance::telemetry::Telemetry;
use crate::appliance::telemetry::clock::Clock;
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::{
    ConnAck, ConnAckProperties, Connect, ConnectReturnCode, LastWill, Login, Packet, PingReq,
    PubAck, PubAckReason, Publish, PublishProperties,
};
use std::collections::VecDeque;
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::time::timeout;
use tracing::info;

/// Interval at which state and store are looked at.
pub(super) const LOOK: Duration = Duration::from_millis(500);

/// Most messages that are on their way, so that few come twice after a loss.
pub(super) const WINDOW: usize = 16;

/// Time without a packet after which the broker publishes the will, s.
pub(super) const KEEP_ALIVE: u16 = 20;

/// A state is worth nothing after so many periods without the next.
const STALE: u32 = 4;

/// What is published, for whatever broker is connected.
#[derive(Clone)]
pub(super) struct Desk {
    pub plan: Arc<MqttPlan>,
    pub telemetry: Arc<Telemetry>,
    pub clock: Arc<dyn Clock>,
    /// How far the news are published; `None` where nothing is kept.
    pub cursor: Option<Arc<Mutex<Cursor>>>,
    /// Number of connections so far.
    pub connections: Arc<AtomicU64>,
    /// Number of commands that nobody follows.
    pub ignored: Arc<AtomicU64>,
}

impl Desk {
    /// Notes that the broker has the news of `store` up to `number`.
    pub fn advance(&self, store: &str, number: i64) {
        if let Some(cursor) = &self.cursor {
            cursor.lock().unwrap_or_else(PoisonError::into_inner).advance(store, number);
        }
    }

    /// The next news, at most so many, and tells how many wait; `None` where there is no store, or where it cannot be
    /// read now, of which its writer tells.
    pub fn news(&self, most: usize) -> Option<Vec<NewsEntry>> {
        let cursor = self.cursor.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner);
        let after = |store: &str| cursor.number(store);
        let reader = StoreReader::open(self.plan.store.as_ref()?).ok()?;
        self.telemetry.mqtt_waiting(reader.news_behind(after).ok());
        reader.news(after, most).ok()
    }
}

/// A connection, from its begin to its end.
pub(super) struct Session {
    desk: Desk,
    link: Link,
    /// Packet identifiers that are not acknowledged, the oldest first.
    awaited: VecDeque<u16>,
    /// Store and number of the newest news among them.
    news: Option<(String, i64)>,
    last_id: u16,
    window: usize,
    pulse: Pulse,
    state: Option<(StateMessage, Instant)>,
}

impl Session {
    /// Connects.
    pub async fn open(desk: Desk) -> Result<Self, MqttTrouble> {
        let plan = &desk.plan;
        let credentials = plan.credentials()?;
        let mut link = Link::open(plan).await?;
        let connect = Connect {
            keep_alive: KEEP_ALIVE,
            client_id: plan.client(),
            clean_start: true,
            properties: None,
        };
        let will = LastWill::new(topic(plan, "state"), WILL, QoS::AtLeastOnce, true, None);
        let login = credentials.map(|[user, password]| Login::new(user, password));
        link.send(&Packet::Connect(connect, Some(will), login)).await?;
        let answer = match within(link.next()).await?? {
            Packet::ConnAck(answer) => answer,
            Packet::Disconnect(end) => return Err(MqttTrouble::Ended(end.reason_code)),
            _ => return Err(MqttTrouble::Unasked),
        };
        let (window, keep_alive) = agreed(&answer)?;
        link.largest = answer.properties.and_then(|it| it.max_packet_size);
        desk.telemetry.mqtt_up(Some(true));
        info!("published over MQTT: {} at {}:{}", plan.topic, plan.host, plan.port);
        Ok(Self {
            desk,
            link,
            awaited: VecDeque::new(),
            news: None,
            last_id: 0,
            window,
            pulse: Pulse::new(keep_alive),
            state: None,
        })
    }

    /// Publishes until the connection ends.
    pub async fn run(mut self) -> MqttTrouble {
        loop {
            if let Err(trouble) = self.turn().await {
                return trouble;
            }
        }
    }

    async fn turn(&mut self) -> Result<(), MqttTrouble> {
        self.publish_state().await?;
        self.forward().await?;
        if self.pulse.is_due() {
            self.pulse.asks();
            self.send(&Packet::PingReq(PingReq)).await?;
        }
        self.pulse.check()?;
        match timeout(LOOK, self.link.next()).await {
            Ok(packet) => self.take(packet?),
            Err(_) => Ok(()),
        }
    }

    fn take(&mut self, packet: Packet) -> Result<(), MqttTrouble> {
        match packet {
            Packet::PubAck(PubAck { pkid, reason, .. }) => {
                let known = self.awaited.iter().position(|id| *id == pkid);
                let known = known.ok_or(MqttTrouble::Unasked)?;
                let taken =
                    matches!(reason, PubAckReason::Success | PubAckReason::NoMatchingSubscribers);
                self.desk.telemetry.mqtt_answered(taken);
                if !taken {
                    return Err(MqttTrouble::NotTaken(reason));
                }
                self.awaited.remove(known);
            }
            Packet::PingResp(_) if self.pulse.is_waiting() => self.pulse.answered(),
            Packet::Disconnect(end) => return Err(MqttTrouble::Ended(end.reason_code)),
            _ => return Err(MqttTrouble::Unasked),
        }
        self.pulse.goes_on(!self.awaited.is_empty());
        if self.awaited.is_empty()
            && let Some((store, number)) = self.news.take()
        {
            self.desk.advance(&store, number);
        }
        Ok(())
    }

    /// Publishes the state where it is another one, or the last one is old.
    async fn publish_state(&mut self) -> Result<(), MqttTrouble> {
        let Desk { plan, telemetry, clock, .. } = &self.desk;
        let state = StateMessage::new(telemetry, clock.uptime(), clock.system());
        let is_known = self
            .state
            .as_ref()
            .is_some_and(|(known, since)| known.is_like(&state) && since.elapsed() < plan.period);
        if is_known || self.awaited.len() >= self.window {
            return Ok(());
        }
        let expiry = plan.period.saturating_mul(STALE).as_secs().max(u64::from(KEEP_ALIVE));
        let (topic, text) = (topic(plan, "state"), state.to_json());
        let expiry = u32::try_from(expiry).ok();
        self.state = Some((state, Instant::now()));
        self.publish(&topic, text, true, expiry).await?;
        self.desk.telemetry.mqtt_state_sent();
        Ok(())
    }

    /// Publishes what comes next of the news, once all before it are taken.
    async fn forward(&mut self) -> Result<(), MqttTrouble> {
        if !self.awaited.is_empty() {
            return Ok(());
        }
        let topic = topic(&self.desk.plan, "events");
        for entry in self.desk.news(self.window).unwrap_or_default() {
            self.news = Some((entry.store.clone(), entry.number));
            let text = serde_json::to_string(&entry).unwrap_or_default();
            self.publish(&topic, text, false, None).await?;
            self.desk.telemetry.mqtt_event_sent();
        }
        Ok(())
    }

    async fn publish(
        &mut self,
        topic: &str,
        text: String,
        retain: bool,
        expiry: Option<u32>,
    ) -> Result<(), MqttTrouble> {
        let properties = PublishProperties {
            payload_format_indicator: Some(1),
            message_expiry_interval: expiry,
            content_type: Some("application/json".to_owned()),
            ..PublishProperties::default()
        };
        let mut message = Publish::new(topic, QoS::AtLeastOnce, text, Some(properties));
        self.last_id = self.last_id.checked_add(1).unwrap_or(1);
        (message.pkid, message.retain) = (self.last_id, retain);
        self.awaited.push_back(self.last_id);
        self.pulse.awaits();
        self.send(&Packet::Publish(message)).await
    }

    async fn send(&mut self, packet: &Packet) -> Result<(), MqttTrouble> {
        self.pulse.sent();
        self.link.send(packet).await
    }
}

/// Most messages on their way and the keep-alive, s, by which broker and gateway can do.
pub(super) fn agreed(answer: &ConnAck) -> Result<(usize, u16), MqttTrouble> {
    if answer.code != ConnectReturnCode::Success {
        return Err(MqttTrouble::Refused(answer.code));
    }
    let Some(ConnAckProperties {
        receive_max, max_qos, retain_available, server_keep_alive, ..
    }) = &answer.properties
    else {
        return Ok((WINDOW, KEEP_ALIVE));
    };
    if *max_qos == Some(0) {
        return Err(MqttTrouble::Lacks("QoS 1"));
    }
    if *retain_available == Some(0) {
        return Err(MqttTrouble::Lacks("retained messages"));
    }
    let window = receive_max.map_or(WINDOW, |most| WINDOW.min(usize::from(most.max(1))));
    Ok((window, server_keep_alive.map_or(KEEP_ALIVE, |seconds| seconds.clamp(1, KEEP_ALIVE))))
}

fn topic(plan: &MqttPlan, last: &str) -> String {
    format!("{}/{last}", plan.topic)
}
