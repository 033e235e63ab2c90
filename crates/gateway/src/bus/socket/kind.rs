//! Whether an interface is a real bus.

use super::LinkError;
use neli::consts::nl::NlmF;
use neli::consts::rtnl::{Ifla, IflaInfo, RtAddrFamily, Rtm};
use neli::consts::socket::NlFamily;
use neli::nl::{NlPayload, NlmsghdrBuilder};
use neli::rtnl::{Ifinfomsg, IfinfomsgBuilder};
use neli::socket::synchronous::NlSocketHandle;
use neli::utils::Groups;
use std::error::Error;
use std::io;

/// Kinds of interfaces, as named by `ip -details link`, that do not leave this computer.
const VIRTUAL: [&str; 2] = ["vcan", "vxcan"];

/// Whether frames on `interface` cannot leave this computer: a vcan or vxcan. Asks the kernel;
/// needs no privilege. An interface whose kind the kernel does not name counts as real.
///
/// # Errors
/// There is no such interface, or netlink is not available.
pub fn is_virtual(interface: &str) -> Result<bool, LinkError> {
    let index = nix::net::if_::if_nametoindex(interface)
        .map_err(|_| LinkError::NoInterface { interface: interface.to_owned() })?;
    let kind = kind(index).map_err(|error| LinkError::Netlink {
        interface: interface.to_owned(),
        error: io::Error::other(error.to_string()),
    })?;
    Ok(kind.is_some_and(|kind| VIRTUAL.contains(&&*kind)))
}

/// Kind of the interface (IFLA_INFO_KIND); `None` where the driver has none.
fn kind(index: u32) -> Result<Option<String>, Box<dyn Error>> {
    let socket = NlSocketHandle::connect(NlFamily::Route, None, Groups::empty())?;
    let wanted = IfinfomsgBuilder::default()
        .ifi_family(RtAddrFamily::Unspecified)
        .ifi_index(libc::c_int::try_from(index)?)
        .build()?;
    let request = NlmsghdrBuilder::default()
        .nl_type(Rtm::Getlink)
        .nl_flags(NlmF::REQUEST)
        .nl_payload(NlPayload::Payload(wanted))
        .build()?;
    socket.send(&request)?;
    let (mut answers, _) = socket.recv::<Rtm, Ifinfomsg>()?;
    let Some(answer) = answers.next().transpose()? else { return Ok(None) };
    if let NlPayload::Err(error) = answer.nl_payload() {
        return Err(io::Error::from_raw_os_error(-*error.error()).into());
    }
    let Some(payload) = answer.get_payload() else { return Ok(None) };
    let attributes = payload.rtattrs().get_attr_handle();
    let Some(link) = attributes.get_attribute(Ifla::Linkinfo) else { return Ok(None) };
    let information = link.get_attr_handle::<IflaInfo>()?;
    Ok(information.get_attr_payload_as_with_len::<String>(IflaInfo::Kind).ok())
}
