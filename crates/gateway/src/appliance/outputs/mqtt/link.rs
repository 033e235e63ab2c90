//! The connection to the broker: packets over TCP, encrypted or not.

use super::plan::MqttPlan;
use super::trouble::MqttTrouble;
use bytes::BytesMut;
use rumqttc::v5::mqttbytes::Error as PacketError;
use rumqttc::v5::mqttbytes::v5::Packet;
use std::future::Future;
use std::io::{self, ErrorKind};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_rustls::rustls::pki_types::ServerName;

/// Longest wait for the broker, for whatever it is.
pub(super) const ANSWER: Duration = Duration::from_secs(15);

/// Largest packet that is received: acknowledgements are small.
const LARGEST: u32 = 16 * 1024;

trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}
impl<S: AsyncRead + AsyncWrite + Send + Unpin> Stream for S {}

pub(super) struct Link {
    stream: Box<dyn Stream>,
    received: BytesMut,
    /// Largest packet that the broker takes, bytes.
    pub largest: Option<u32>,
}

impl Link {
    /// Connects by `plan`.
    pub async fn open(plan: &MqttPlan) -> Result<Self, MqttTrouble> {
        let connector = plan.connector()?;
        let host = plan.host.trim_matches(['[', ']']);
        let connected = within(TcpStream::connect((host, plan.port))).await?;
        let stream = connected.map_err(MqttTrouble::Unreachable)?;
        _ = stream.set_nodelay(true);
        let stream: Box<dyn Stream> = match connector {
            None => Box::new(stream),
            Some(connector) => {
                let name = ServerName::try_from(host.to_owned());
                let name = name.map_err(|_| MqttTrouble::Name(host.to_owned()))?;
                let encrypted = within(connector.connect(name, stream)).await?;
                Box::new(encrypted.map_err(MqttTrouble::Tls)?)
            }
        };
        Ok(Self { stream, received: BytesMut::new(), largest: None })
    }

    pub async fn send(&mut self, packet: &Packet) -> Result<(), MqttTrouble> {
        let mut bytes = BytesMut::new();
        packet.write(&mut bytes, self.largest)?;
        let stream = &mut self.stream;
        let written = async {
            stream.write_all(&bytes).await?;
            stream.flush().await
        };
        within(written).await?.map_err(MqttTrouble::Lost)
    }

    /// The next packet. Nothing is lost where the wait for it is given up.
    pub async fn next(&mut self) -> Result<Packet, MqttTrouble> {
        loop {
            match Packet::read(&mut self.received, Some(LARGEST)) {
                Err(PacketError::InsufficientBytes(_)) => {}
                other => return Ok(other?),
            }
            let read = self.stream.read_buf(&mut self.received).await;
            if read.map_err(MqttTrouble::Lost)? == 0 {
                return Err(MqttTrouble::Lost(io::Error::from(ErrorKind::UnexpectedEof)));
            }
        }
    }
}

/// What `awaited` gives within [`ANSWER`].
pub(super) async fn within<T>(awaited: impl Future<Output = T>) -> Result<T, MqttTrouble> {
    timeout(ANSWER, awaited).await.map_err(|_| MqttTrouble::Silent(ANSWER.as_secs()))
}
