//! Rules for texts in the configuration.

mod weak;

pub use weak::{WEAK_TOKENS, weak_token};

use std::net::SocketAddr;
use tertius_core::frame::BusNumber;

/// Placeholder of the cylinder's number in the signal names of `[signals.cylinder]`.
pub const PLACEHOLDER: &str = "{n}";

/// Value of `http.listen`, `modbus.listen` and `opcua.listen` for no server, and of `mqtt.broker` for no broker.
pub const LISTEN_OFF: &str = "off";

/// Value of `mqtt.authority` for whom the computer trusts.
pub const SYSTEM: &str = "system";

/// The longest name that a DBC file may hold.
pub(super) const LONGEST_NAME: usize = 128;
/// Longest interface name: IFNAMSIZ of Linux without the closing zero.
const LONGEST_INTERFACE: usize = 15;
pub(super) const LONGEST_TEXT: usize = 200;
/// Longest name of a cylinder or transducer, characters: it stands in columns and headings.
pub const LONGEST_TAG: usize = 32;
/// Longest path: PATH_MAX of Linux.
pub(super) const LONGEST_PATH: usize = 4096;
/// Most commas of lists that are checked; a longer list is refused for its length.
const MOST_LISTED: usize = 64;

/// The rule for a text.
#[derive(Clone, Copy)]
pub(super) enum TextRule {
    /// Something for people to read.
    Name,
    /// The name of a cylinder or transducer.
    Tag,
    /// A network interface.
    Interface,
    /// A path, relative to the folder of the file.
    Path,
    /// A path of certificates, or "system".
    Authority,
    /// `MESSAGE` of the DBC, or `second:MESSAGE` on another bus than the first.
    Message,
    /// `MESSAGE.SIGNAL` of the DBC, or `second:MESSAGE.SIGNAL`.
    Signal,
    /// `MESSAGE.SIGNAL`, where `{n}` stands for the cylinder's number and `{A,B,C}` for the names of its place, or
    /// `object 0x6020:01`.
    CylinderSignal,
    /// An address and a port, or "off".
    Listen,
    /// A host and a port, or "off".
    Broker,
    /// Levels of MQTT topics.
    Topic,
    /// A group and an edge node of Sparkplug B.
    EdgeNode,
    /// A SHA-256 in hexadecimal digits.
    Digest,
    /// A day of the calendar.
    Day,
}

/// What a text has to be, and why or how.
pub(super) struct TextFault {
    pub must: String,
    pub help: &'static str,
}

const SIGNAL_HELP: &str = "names are those of the DBC, for example Plc_State.PlatformState; on another bus than the \
                           first with its name before them, second:Plc_State.PlatformState";
const CYLINDER_HELP: &str = "names are those of the DBC, for example Cyl{n}_C1.Position; {n} is \
                             replaced by the cylinder's number, {Port,Starboard} by the name in its place; on \
                             another bus than the first with its name before it, second:Cyl{n}_C1.Position";
const OBJECT_HELP: &str = "index and sub-index are hexadecimal, for example object 0x6020:01; the \
                           device is a [[canopen.device]]";
const MESSAGE_HELP: &str = "a cycle is opened by a message, whatever it carries: its name in the \
                            DBC without a signal, for example Sync";
const LISTEN_HELP: &str = "an IP address and a port, for example 127.0.0.1:9481 or [::1]:9481; or \
                           off, for no server";
const BROKER_HELP: &str =
    "a name or an address and a port, for example mqtt.ship.lan:8883; or off, for none";
const TOPIC_HELP: &str = "levels separated by slashes, for example ship/gangway, with none of + # $ and no slash \
                          at an end";
const EDGE_HELP: &str = "the names of a group and of this gateway in it, for example ship/gangway, with none of + # $ / in either";
const DIGEST_HELP: &str =
    "the SHA-256 of the token and not the token itself; `tertius token` makes both";
const DAY_HELP: &str = "for example 2026-03-14, in UTC";
const TAG_HELP: &str = "it is shown beside the number, for example FwdPort or LT-101A";
const INTERFACE_HELP: &str =
    "as `ip link` lists it, for example can0; or virtual, the embedded bus";

/// Index and sub-index of `object 0x6020:01`; without a sub-index it is 0.
pub fn object_of(text: &str) -> Option<(u16, u8)> {
    let address = text.strip_prefix("object ")?.trim();
    let digits = address.strip_prefix("0x").or(address.strip_prefix("0X"))?;
    let (index, sub_index) = digits.split_once(':').unwrap_or((digits, "0"));
    let plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_hexdigit());
    if !plain(index) || !plain(sub_index) {
        return None;
    }
    Some((u16::from_str_radix(index, 16).ok()?, u8::from_str_radix(sub_index, 16).ok()?))
}

impl TextRule {
    pub fn check(self, text: &str) -> Result<(), TextFault> {
        match self {
            Self::Name => bounded(text, LONGEST_TEXT, "it is shown to people"),
            Self::Tag => tag(text),
            Self::Path | Self::Authority => {
                bounded(text, LONGEST_PATH, "a path relative to this file")
            }
            Self::Interface => interface(text),
            Self::Message if bus_of(text).is_some_and(|(_, name)| is_name(name)) => Ok(()),
            Self::Message => fault("the bare name of a message", MESSAGE_HELP),
            Self::Signal if is_signal(text) => Ok(()),
            Self::Signal if text.contains(PLACEHOLDER) => {
                fault("one signal for the whole machine, without {n}", SIGNAL_HELP)
            }
            Self::Signal => fault("of the form MESSAGE.SIGNAL", SIGNAL_HELP),
            Self::CylinderSignal if are_signals(text) => Ok(()),
            Self::CylinderSignal if object_of(text).is_some() => Ok(()),
            Self::CylinderSignal if text.starts_with("object") => {
                fault("of the form object 0xINDEX:SUB", OBJECT_HELP)
            }
            Self::CylinderSignal => fault("of the form MESSAGE.SIGNAL", CYLINDER_HELP),
            Self::Listen if text == LISTEN_OFF || text.parse::<SocketAddr>().is_ok() => Ok(()),
            Self::Broker if text == LISTEN_OFF || broker_of(text).is_some() => Ok(()),
            Self::Broker => fault("HOST:PORT or off", BROKER_HELP),
            Self::Topic if is_topic(text) => Ok(()),
            Self::Topic => fault("the first levels of a topic", TOPIC_HELP),
            Self::EdgeNode if is_topic(text) && text.split('/').count() == 2 => Ok(()),
            Self::EdgeNode => fault("of the form GROUP/NODE", EDGE_HELP),
            Self::Digest if is_digest(text) => match weak_token(text) {
                None => Ok(()),
                Some(token) => {
                    let must = format!(
                        "the digest of a token that nobody guesses, and this is that of {token:?}"
                    );
                    fault(must, "`tertius token` makes a token of 128 random bits, and its digest")
                }
            },
            Self::Digest => fault("64 hexadecimal digits", DIGEST_HELP),
            Self::Listen => fault("ADDRESS:PORT or off", LISTEN_HELP),
            Self::Day if is_day(text) => Ok(()),
            Self::Day => fault("a day as YYYY-MM-DD", DAY_HELP),
        }
    }
}

fn fault(must: impl Into<String>, help: &'static str) -> Result<(), TextFault> {
    Err(TextFault { must: must.into(), help })
}

fn bounded(text: &str, longest: usize, help: &'static str) -> Result<(), TextFault> {
    if text.trim().is_empty() {
        fault("not empty", help)
    } else if text.len() > longest {
        fault(format!("at most {longest} bytes long"), help)
    } else if text.contains(char::is_control) {
        fault("without control characters", help)
    } else {
        Ok(())
    }
}

fn tag(text: &str) -> Result<(), TextFault> {
    if text.chars().count() > LONGEST_TAG {
        return fault(format!("at most {LONGEST_TAG} characters long"), TAG_HELP);
    }
    bounded(text, text.len(), TAG_HELP)?;
    if text.contains(is_invisible) {
        return fault("without invisible characters", TAG_HELP);
    }
    if text.trim() != text {
        return fault("without spaces at its ends", TAG_HELP);
    }
    // "cylinder 3 (2)" and "C1 (C2)" would be read as the other one.
    let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
    if is_number || ["c1", "c2"].contains(&text.to_ascii_lowercase().as_str()) {
        return fault("a name, and not a number, C1 or C2", TAG_HELP);
    }
    Ok(())
}

/// Whether a character shows nothing, or changes the direction of others, so that a name would look like another one.
fn is_invisible(c: char) -> bool {
    matches!(
        c,
        '\u{ad}'
            | '\u{61c}'
            | '\u{180e}'
            | '\u{200b}'..='\u{200f}'
            | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}'
            | '\u{fff9}'..='\u{fffb}'
            | '\u{e0000}'..='\u{e007f}'
    )
}

fn interface(text: &str) -> Result<(), TextFault> {
    bounded(text, LONGEST_INTERFACE, INTERFACE_HELP)?;
    if text.contains(|c: char| c.is_whitespace() || c == '/') {
        return fault("without spaces and slashes", INTERFACE_HELP);
    }
    Ok(())
}

/// Host, without brackets, and port of `HOST:PORT`.
pub(super) fn broker_of(text: &str) -> Option<(&str, u16)> {
    let (host, port) = text.rsplit_once(':')?;
    let port = port.parse().ok().filter(|port| *port > 0)?;
    if let Some(address) = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')) {
        return text.parse::<SocketAddr>().is_ok().then_some((address, port));
    }
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'_');
    let is_name = (1..=LONGEST_TEXT).contains(&host.len()) && host.bytes().all(plain);
    is_name.then_some((host, port))
}

fn is_topic(text: &str) -> bool {
    let is_level = |level: &str| {
        !level.is_empty() && !level.contains(['+', '#', '$']) && !level.contains(char::is_control)
    };
    text.len() <= LONGEST_NAME && text.split('/').all(is_level)
}

fn is_digest(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Whether `text` is a day; of which there may be 31 in each month.
fn is_day(text: &str) -> bool {
    let part = |range| text.get(range).and_then(|digits: &str| digits.parse::<u16>().ok());
    let digits = text.len() == 10
        && text.bytes().enumerate().all(|(at, byte)| match at {
            4 | 7 => byte == b'-',
            _ => byte.is_ascii_digit(),
        });
    digits
        && part(5..7).is_some_and(|month| (1..=12).contains(&month))
        && part(8..10).is_some_and(|day| (1..=31).contains(&day))
}

/// Whether `text` is a C identifier, as names in DBC files are.
fn is_name(text: &str) -> bool {
    text.len() <= LONGEST_NAME
        && text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The first list, `{A,B,C}`, of a text: what is before it, the list, and what is behind it.
fn list_of(text: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = text.split_once('{')?;
    let (list, after) = rest.split_once('}')?;
    list.contains(',').then_some((before, list, after))
}

/// The name of a signal for cylinder `n`; of a list that is too short, the last one.
pub(super) fn of_cylinder(signal: &str, n: u8) -> String {
    let mut name = signal.replace(PLACEHOLDER, &n.to_string());
    while let Some((before, list, after)) = list_of(&name) {
        let place = usize::from(n).saturating_sub(1);
        let chosen = list.split(',').nth(place).or(list.split(',').next_back());
        name = format!("{before}{}{after}", chosen.unwrap_or_default().trim());
    }
    name
}

/// Number of names in the first list of a signal's name that is as long as `wanted` is not; `None` if all are.
pub(super) fn other_count(signal: &str, wanted: usize) -> Option<usize> {
    let numbered = signal.replace(PLACEHOLDER, "1");
    let mut rest = numbered.as_str();
    while let Some((_, list, after)) = list_of(rest) {
        let count = list.split(',').count();
        if count != wanted {
            return Some(count);
        }
        rest = after;
    }
    None
}

/// The bus that the name of a message or signal begins with, `second:`, and the name in the DBC; without one it is the
/// first bus.
pub fn bus_of(name: &str) -> Option<(BusNumber, &str)> {
    let Some((bus, name)) = name.split_once(':') else { return Some((BusNumber::First, name)) };
    let number = BusNumber::NAMES.iter().position(|known| *known == bus)?;
    Some((BusNumber::ALL[number], name))
}

/// Whether the name of each cylinder is a signal's.
fn are_signals(text: &str) -> bool {
    let listed = text.matches(',').count().min(MOST_LISTED) as u8;
    (1..=listed + 1).all(|n| is_signal(&of_cylinder(text, n)))
}

fn is_signal(text: &str) -> bool {
    let parts = bus_of(text).and_then(|(_, text)| text.split_once('.'));
    parts.is_some_and(|(message, signal)| is_name(message) && is_name(signal))
}
