//! Server-sent events, as they come in pieces.

/// Most bytes of an event; one of the gateway's has some kilobytes.
const LARGEST_EVENT: usize = 1_000_000;

/// Takes pieces of a stream, and gives its events.
#[derive(Debug, Default)]
pub struct EventLines {
    pending: Vec<u8>,
}

impl EventLines {
    /// Takes a piece.
    ///
    /// # Errors
    /// An event is too long.
    pub fn push(&mut self, piece: &[u8]) -> Result<(), String> {
        self.pending.extend_from_slice(piece);
        if self.pending.len() > LARGEST_EVENT {
            return Err(format!("an event has more than {LARGEST_EVENT} bytes"));
        }
        Ok(())
    }

    /// Name and data of the next event that is complete.
    pub fn next(&mut self) -> Option<(String, String)> {
        let end = self.pending.windows(2).position(|pair| pair == b"\n\n")?;
        let event: Vec<u8> = self.pending.drain(..end + 2).collect();
        let event = String::from_utf8_lossy(&event);
        let field = |name: &str| {
            let values =
                event.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
            values
                .map(|value| value.strip_prefix(' ').unwrap_or(value))
                .collect::<Vec<_>>()
                .join("\n")
        };
        Some((field("event"), field("data")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_come_whole_however_they_are_cut() {
        let text = "event: overview\ndata: {\"a\":1}\n\n: a comment\nevent:bins\ndata:[1,\ndata: 2]\n\nevent: x\nda";
        for size in 1..text.len() {
            let mut events = EventLines::default();
            let mut told = Vec::new();
            for piece in text.as_bytes().chunks(size) {
                events.push(piece).expect("it is short");
                told.extend(std::iter::from_fn(|| events.next()));
            }
            let event = |name: &str, data: &str| (name.to_owned(), data.to_owned());
            assert_eq!(told, [event("overview", "{\"a\":1}"), event("bins", "[1,\n2]")], "{size}");
        }
    }

    #[test]
    fn an_event_without_an_end_is_refused() {
        let mut events = EventLines::default();
        let piece = [b'a'; 65_536];
        let taken = (0..100).take_while(|_| events.push(&piece).is_ok()).count();
        assert_eq!(taken, LARGEST_EVENT / piece.len());
    }
}
