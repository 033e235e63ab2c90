//! Why the publisher is not connected, or no more.

use super::plan::MqttFileError;
use rumqttc::v5::mqttbytes::Error as PacketError;
use rumqttc::v5::mqttbytes::v5::{ConnectReturnCode, DisconnectReasonCode, PubAckReason};
use std::io;
use thiserror::Error;

#[derive(Debug, Error)]
pub(super) enum MqttTrouble {
    #[error(transparent)]
    File(#[from] MqttFileError),
    #[error("it cannot be reached: {0}")]
    Unreachable(io::Error),
    #[error("{0:?} is no name and no address of a host")]
    Name(String),
    #[error("no encrypted connection: {0}")]
    Tls(io::Error),
    #[error("it does not answer within {0} s")]
    Silent(u64),
    #[error("the connection ended: {0}")]
    Lost(io::Error),
    #[error("it refuses the connection: {0:?}")]
    Refused(ConnectReturnCode),
    #[error("it ended the connection: {0:?}")]
    Ended(DisconnectReasonCode),
    #[error("it does not take what is published: {0:?}")]
    NotTaken(PubAckReason),
    #[error("it does not offer {0}, which is needed")]
    Lacks(&'static str),
    #[error("what it sends is not MQTT 5: {0}")]
    Packet(#[from] PacketError),
    #[error("it sends what nobody asked for")]
    Unasked,
}
