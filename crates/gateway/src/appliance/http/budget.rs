//! The memory that readers can make the gateway use, and the memory that it uses by itself.

use super::READERS;
use super::audience::{self, MOST_WATCHERS};
use super::connections::{CONNECTIONS, ENCRYPTED, HEAD_SIZE, RECEIVE_BUFFER, SEND_BUFFER};
use super::sending::{DOWNLOADS, PIECE, STACK_SIZE, WAITING};
use super::shared::LARGEST_ANSWER;
use crate::appliance::flight;
use crate::appliance::store::READ_CACHE;

/// Upper bound of the gateway's memory, bytes, however its readers behave. It is below `MemoryMax` of the unit, at which the kernel
/// ends the gateway. Every buffer that a reader can fill is a term of it.
pub const MEMORY: usize =
    AT_REST + flight::MOST_BYTES + SOCKETS + STREAM + ANSWERS + READING + SENDING;

/// The gateway alone, with page, store, recorder and Modbus, as `clients_of_every_kind_that_read_nothing_cost_little`
/// measures it, and the telemetry of its other clients.
pub const AT_REST: usize = 10 << 20;

/// Of each connection: the socket's buffers, which the kernel makes twice as large as it is asked to, and for both directions
/// those of hyper and rustls.
const SOCKETS: usize = (CONNECTIONS + MOST_WATCHERS)
    * (2 * (SEND_BUFFER + RECEIVE_BUFFER) + 2 * HEAD_SIZE + 2 * ENCRYPTED);

/// Events that wait for those who watch: the same for all of them.
const STREAM: usize = (audience::WAITING + 2) * LARGEST_EVENT;

/// An event with all cylinders and as many incidents as there can be, bytes.
const LARGEST_EVENT: usize = 64 * 1024;

/// Answers that wait to be read.
const ANSWERS: usize = CONNECTIONS * LARGEST_ANSWER;

/// The threads that make them: rows, and what they become.
const READING: usize = READERS * (READ_CACHE + 3 * LARGEST_ANSWER);

/// Recordings and exports: pieces that are made, wait, and are being sent. Only exports read the store.
const SENDING: usize =
    2 * DOWNLOADS * ((WAITING + 3) * PIECE + STACK_SIZE) + DOWNLOADS * READ_CACHE;
