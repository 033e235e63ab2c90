//! What lets clients through to the server: few at a time, at a pace, and as long as they are not silent.

use crate::appliance::outputs::patience::Patience;
use std::io::{self, ErrorKind};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Most clients at once; further ones are turned away.
pub(super) const CLIENTS: usize = 8;

/// Largest piece of a message (OPC 10000-6, 7.1.2), bytes.
pub(super) const LARGEST: usize = 65_536;

/// Time for a piece of a message and for a new connection, so that clients that do not pause take no more than a
/// hundred of them a second.
const PACE: Duration = Duration::from_millis(10);

/// Pause after a connection that could not be accepted, for example for lack of file descriptors.
const PAUSE: Duration = Duration::from_millis(100);

/// Header of every piece: its kind, and its length.
const HEADER: usize = 8;

/// Lets clients of `listener` through to the server at `within`, until the task is dropped.
pub(super) async fn admit(listener: TcpListener, within: SocketAddr, silence: Duration) {
    let places = Arc::new(Semaphore::new(CLIENTS));
    loop {
        let Ok((client, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        // Without a place the stream is closed here.
        if let Ok(place) = Arc::clone(&places).try_acquire_owned() {
            _ = client.set_nodelay(true);
            tokio::spawn(relay(Patience::new(client, silence), within, place));
        }
        // The next one is accepted after this, so that whoever connects without end costs little.
        tokio::time::sleep(PACE).await;
    }
}

/// Passes on what a client and the server say to each other, until one of them ends it.
///
/// While a client does not take an answer nothing more is taken from it, so that little waits for it.
async fn relay(
    mut client: Patience<TcpStream>,
    within: SocketAddr,
    _place: OwnedSemaphorePermit,
) -> io::Result<()> {
    let mut server = TcpStream::connect(within).await?;
    server.set_nodelay(true)?;
    let (mut asked, mut answered) = (Vec::with_capacity(LARGEST), Vec::with_capacity(LARGEST));
    loop {
        let whole = piece(&asked)?;
        tokio::select! {
            biased;
            read = server.read_buf(&mut answered) => {
                if read? == 0 {
                    return client.shutdown().await;
                }
                client.write_all(&answered).await?;
                client.flush().await?;
                answered.clear();
            }
            read = client.read_buf(&mut asked), if whole.is_none() => {
                if read? == 0 {
                    return Ok(());
                }
            }
            () = tokio::time::sleep(PACE), if whole.is_some() => {
                let rest = asked.split_off(whole.unwrap_or_default());
                server.write_all(&asked).await?;
                asked = rest;
            }
        }
    }
}

/// Length of the piece of a message with which `bytes` begin; `None` if it is not complete.
fn piece(bytes: &[u8]) -> io::Result<Option<usize>> {
    let Some((header, _)) = bytes.split_first_chunk::<HEADER>() else { return Ok(None) };
    let [a, b, c, _, length @ ..] = *header;
    let length = u32::from_le_bytes(length) as usize;
    if ![*b"HEL", *b"OPN", *b"MSG", *b"CLO"].contains(&[a, b, c])
        || !(HEADER..=LARGEST).contains(&length)
    {
        return Err(ErrorKind::InvalidData.into());
    }
    Ok((bytes.len() >= length).then_some(length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_is_taken_once_it_is_complete() {
        let hello = b"HELF\x0C\0\0\0four";
        assert_eq!(piece(b"").expect("nothing wrong"), None);
        assert_eq!(piece(&hello[..7]).expect("nothing wrong"), None);
        assert_eq!(piece(&hello[..11]).expect("nothing wrong"), None);
        assert_eq!(piece(hello).expect("complete"), Some(12));
        assert_eq!(piece(&[&hello[..], b"MSG"].concat()).expect("complete"), Some(12));
        for bad in [&b"GET / HT"[..], b"MSGF\x07\0\0\0", b"MSGF\x01\0\x01\0", b"ACKF\x0C\0\0\0"] {
            assert!(piece(bad).is_err(), "{bad:?}");
        }
        assert_eq!(piece(b"MSGF\0\0\x01\0").expect("the largest"), None);
    }
}
