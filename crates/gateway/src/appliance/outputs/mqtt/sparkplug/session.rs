//! One connection to the broker as an edge node of Sparkplug B: births, what changes, and the news of the store.

use super::EdgeNode;
use super::births::{Message, Published};
use super::payload::{Metric, MetricValue, Payload};
use crate::appliance::outputs::mqtt::link::{Link, within};
use crate::appliance::outputs::mqtt::pulse::Pulse;
use crate::appliance::outputs::mqtt::session::{Desk, KEEP_ALIVE, LOOK, WINDOW, agreed};
use crate::appliance::outputs::mqtt::trouble::MqttTrouble;
use crate::appliance::telemetry::points::Points;
use prost::Message as _;
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::{
    Connect, Filter, LastWill, Login, Packet, PingReq, PubAck, Publish, Subscribe,
    SubscribeReasonCode,
};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tertius_core::time::Timestamp;
use tokio::time::timeout;
use tracing::info;

/// Shortest time from one birth to the next that somebody asks for.
const REBIRTH: Duration = Duration::from_secs(1);

/// The only command that is followed (6.4.8).
const REBIRTH_COMMAND: &str = "Node Control/Rebirth";

/// Name of the number of the connection, which is in its births and in its death.
const CONNECTION: &str = "bdSeq";

/// Name of the events of the store.
const EVENT: &str = "event";

/// Name of the number of commands that were ignored.
const IGNORED: &str = "commands_ignored";

/// A connection, from its begin to its end.
pub(in crate::appliance::outputs::mqtt) struct SparkplugSession {
    desk: Desk,
    edge: EdgeNode,
    link: Link,
    pulse: Pulse,
    /// Number of the connection, 0 to 255.
    connection: u64,
    /// Number of the next message, 0 to 255.
    seq: u8,
    told: Option<Published>,
    /// Store and number of the newest news that are sent, but of which the broker has not said that it goes on.
    news: Option<(String, i64)>,
    /// When the last birth was.
    born: Instant,
    /// Events before this are of the past.
    since: Timestamp,
    ignored: u64,
}

impl SparkplugSession {
    /// Connects, subscribes to commands, and is born.
    pub async fn open(desk: Desk, edge: EdgeNode) -> Result<Self, MqttTrouble> {
        let credentials = desk.plan.credentials()?;
        let mut link = Link::open(&desk.plan).await?;
        let connection = desk.connections.fetch_add(1, Ordering::Relaxed) % 256;
        let since = desk.clock.system();
        let death = Payload {
            timestamp: Some(millis(since)),
            metrics: vec![Metric::whole(CONNECTION, millis(since), connection)],
            seq: None,
        };
        let connect = Connect {
            keep_alive: KEEP_ALIVE,
            client_id: desk.plan.client(),
            clean_start: true,
            properties: None,
        };
        let will = death.encode_to_vec();
        let will = LastWill::new(edge.topic("NDEATH", None), will, QoS::AtLeastOnce, false, None);
        let login = credentials.map(|[user, password]| Login::new(user, password));
        link.send(&Packet::Connect(connect, Some(will), login)).await?;
        let keep_alive = match within(link.next()).await?? {
            Packet::ConnAck(answer) => {
                let (_, keep_alive) = agreed(&answer)?;
                link.largest = answer.properties.and_then(|it| it.max_packet_size);
                keep_alive
            }
            Packet::Disconnect(end) => return Err(MqttTrouble::Ended(end.reason_code)),
            _ => return Err(MqttTrouble::Unasked),
        };
        let filter = Filter::new(edge.topic("NCMD", None), QoS::AtLeastOnce);
        let mut subscribe = Subscribe::new(filter, None);
        subscribe.pkid = 1;
        link.send(&Packet::Subscribe(subscribe)).await?;
        match within(link.next()).await?? {
            Packet::SubAck(answer)
                if matches!(answer.return_codes[..], [SubscribeReasonCode::Success(_)]) => {}
            Packet::SubAck(_) => return Err(MqttTrouble::Lacks("commands to the edge node")),
            Packet::Disconnect(end) => return Err(MqttTrouble::Ended(end.reason_code)),
            _ => return Err(MqttTrouble::Unasked),
        }
        desk.telemetry.mqtt_up(Some(true));
        info!(
            "published over MQTT as Sparkplug B: {edge} at {}:{}",
            desk.plan.host, desk.plan.port
        );
        let mut session = Self {
            ignored: desk.ignored.load(Ordering::Relaxed),
            desk,
            edge,
            link,
            pulse: Pulse::new(keep_alive),
            connection,
            seq: 0,
            told: None,
            news: None,
            born: Instant::now(),
            since,
        };
        session.bear().await?;
        Ok(session)
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
        self.publish_changes().await?;
        self.forward().await?;
        if self.pulse.is_due() {
            self.ping().await?;
        }
        self.pulse.check()?;
        match timeout(LOOK, self.link.next()).await {
            Ok(packet) => self.take(packet?).await,
            Err(_) => Ok(()),
        }
    }

    async fn take(&mut self, packet: Packet) -> Result<(), MqttTrouble> {
        match packet {
            Packet::PingResp(_) if self.pulse.is_waiting() => {
                self.pulse.answered();
                // The broker answers in order: it has everything before the ping.
                if let Some((store, number)) = self.news.take() {
                    self.desk.advance(&store, number);
                }
                Ok(())
            }
            Packet::Publish(message) => {
                if message.qos == QoS::AtLeastOnce {
                    self.send(&Packet::PubAck(PubAck::new(message.pkid, None))).await?;
                }
                self.obey(&message).await
            }
            Packet::Disconnect(end) => Err(MqttTrouble::Ended(end.reason_code)),
            _ => Err(MqttTrouble::Unasked),
        }
    }

    /// Follows the one command that there is; everything else is counted.
    async fn obey(&mut self, message: &Publish) -> Result<(), MqttTrouble> {
        let metrics = Payload::decode(message.payload.clone()).map(|it| it.metrics);
        let Ok(metrics) = metrics else {
            self.ignore(1);
            return Ok(());
        };
        let is_rebirth = |it: &&Metric| {
            it.name.as_deref() == Some(REBIRTH_COMMAND)
                && it.value == Some(MetricValue::Boolean(true))
        };
        let asked = metrics.iter().filter(is_rebirth).count();
        let is_early = self.born.elapsed() < REBIRTH;
        let followed = usize::from(asked > 0 && !is_early);
        // A message without a metric is one that says nothing, too.
        self.ignore(metrics.len().max(1) - followed);
        if followed > 0 { self.bear().await } else { Ok(()) }
    }

    fn ignore(&self, commands: usize) {
        self.desk.ignored.fetch_add(commands as u64, Ordering::Relaxed);
    }

    /// Says everything anew: what there is, in which unit, and how it is now.
    async fn bear(&mut self) -> Result<(), MqttTrouble> {
        let (points, at) = self.now();
        (self.seq, self.born) = (0, Instant::now());
        self.ignored = self.desk.ignored.load(Ordering::Relaxed);
        let (told, mut messages) = Published::birth(points, at);
        if let Some(first) = messages.first_mut() {
            first.metrics.extend([
                Metric::whole(CONNECTION, at, self.connection),
                Metric::boolean(REBIRTH_COMMAND, at, false),
                Metric::whole(IGNORED, at, self.ignored),
                Metric::text(EVENT, at, None),
            ]);
        }
        self.told = Some(told);
        for message in messages {
            self.publish("BIRTH", message, at).await?;
            self.desk.telemetry.mqtt_state_sent();
        }
        Ok(())
    }

    /// Publishes the values that have changed.
    async fn publish_changes(&mut self) -> Result<(), MqttTrouble> {
        let (points, at) = self.now();
        let period = self.desk.plan.period;
        let Some(told) = &mut self.told else { return Ok(()) };
        let Some(mut messages) = told.changes(&points, period, at) else {
            // Another number of cylinders: other devices.
            return self.bear().await;
        };
        let ignored = self.desk.ignored.load(Ordering::Relaxed);
        if ignored != self.ignored {
            self.ignored = ignored;
            let metrics = vec![Metric::whole(IGNORED, at, ignored)];
            messages.push(Message { device: None, metrics });
        }
        for message in messages {
            self.publish("DATA", message, at).await?;
            self.desk.telemetry.mqtt_state_sent();
        }
        Ok(())
    }

    /// Publishes what comes next of the news, once the broker has everything before.
    async fn forward(&mut self) -> Result<(), MqttTrouble> {
        if self.pulse.is_waiting() {
            return Ok(());
        }
        for entry in self.desk.news(WINDOW).unwrap_or_default() {
            self.news = Some((entry.store.clone(), entry.number));
            let text = serde_json::to_string(&entry).unwrap_or_default();
            let metric = Metric::text(EVENT, millis(entry.at_s), Some(text));
            let metric = if entry.at_s < self.since { metric.historical() } else { metric };
            let message = Message { device: None, metrics: vec![metric] };
            let at = millis(self.desk.clock.system());
            self.publish("DATA", message, at).await?;
            self.desk.telemetry.mqtt_event_sent();
        }
        if self.news.is_some() { self.ping().await } else { Ok(()) }
    }

    async fn ping(&mut self) -> Result<(), MqttTrouble> {
        self.pulse.asks();
        self.send(&Packet::PingReq(PingReq)).await
    }

    /// All values, and the time by the system's clock, ms since 1970.
    fn now(&self) -> (Points, u64) {
        let Desk { telemetry, clock, .. } = &self.desk;
        (Points::new(&telemetry.snapshot(clock.uptime())), millis(clock.system()))
    }

    /// Publishes a message of the node (`NDATA`) or of a device (`DDATA`).
    async fn publish(
        &mut self,
        kind: &str,
        Message { device, metrics }: Message,
        at: u64,
    ) -> Result<(), MqttTrouble> {
        let owner = if device.is_some() { "D" } else { "N" };
        let topic = self.edge.topic(&format!("{owner}{kind}"), device.as_deref());
        let seq = Some(u64::from(self.seq));
        self.seq = self.seq.wrapping_add(1);
        let payload = Payload { timestamp: Some(at), metrics, seq };
        let message = Publish::new(topic, QoS::AtMostOnce, payload.encode_to_vec(), None);
        self.send(&Packet::Publish(message)).await
    }

    async fn send(&mut self, packet: &Packet) -> Result<(), MqttTrouble> {
        self.pulse.sent();
        self.link.send(packet).await
    }
}

/// `at` in milliseconds since 1970.
fn millis(at: Timestamp) -> u64 {
    u64::try_from(at.as_nanos() / 1_000_000).unwrap_or_default()
}
