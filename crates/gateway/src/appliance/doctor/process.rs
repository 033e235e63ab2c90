//! Data on a process from /proc.

use super::facts::Rights;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

// Numbers of linux/capability.h.
const NET_ADMIN: u32 = 12;
const IPC_LOCK: u32 = 14;
const SYS_NICE: u32 = 23;

impl Rights {
    /// Rights from the texts of /proc/…/status and /proc/…/limits; what is missing there is not
    /// granted.
    pub fn read(status: &str, limits: &str) -> Self {
        let capabilities = status
            .lines()
            .find_map(|line| line.strip_prefix("CapEff:"))
            .and_then(|digits| u64::from_str_radix(digits.trim(), 16).ok())
            .unwrap_or_default();
        let has = |capability: u32| capabilities >> capability & 1 == 1;
        Self {
            gateway: None,
            net_admin: has(NET_ADMIN),
            sys_nice: has(SYS_NICE),
            ipc_lock: has(IPC_LOCK),
            priority: limit(limits, "Max realtime priority"),
            locked_memory: limit(limits, "Max locked memory"),
        }
    }
}

/// Soft limit of that name; `None` if unlimited.
fn limit(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name));
    let soft = line.and_then(|rest| rest.split_whitespace().next()).unwrap_or("0");
    if soft == "unlimited" { None } else { Some(soft.parse().unwrap_or(0)) }
}

/// The configuration of a running gateway, from the text of its /proc/…/cmdline; `None` for another
/// program.
pub(super) fn gateway_config(cmdline: &[u8]) -> Option<&Path> {
    let mut words = cmdline.split(|&byte| byte == 0);
    let program = words.next()?;
    if program.rsplit(|&byte| byte == b'/').next() != Some(b"tertius") || words.next()? != b"run" {
        return None;
    }
    let path = loop {
        match words.next()? {
            b"--config" => break words.next()?,
            word => {
                if let Some(path) = word.strip_prefix(b"--config=") {
                    break path;
                }
            }
        }
    };
    Some(Path::new(OsStr::from_bytes(path)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_and_capabilities_are_read() {
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max locked memory         65536                unlimited            bytes     \n\
                      Max realtime priority     49                   49                   \n";
        let rights = Rights::read("Name:\ttertius\nCapEff:\t0000000000805000\n", limits);
        assert!(rights.net_admin && rights.ipc_lock && rights.sys_nice);
        assert_eq!((rights.priority, rights.locked_memory), (Some(49), Some(65536)));
        let none =
            Rights::read("CapEff:\t0000000000000000\n", &limits.replace("65536", "unlimited"));
        assert!(!(none.net_admin || none.ipc_lock || none.sys_nice));
        assert_eq!(none.locked_memory, None);
        // What cannot be read is not granted.
        assert_eq!(Rights::read("", "").priority, Some(0));
    }

    #[test]
    fn a_live_gateway_is_known_by_its_command_line() {
        let config = |cmdline: &'static [u8]| gateway_config(cmdline).and_then(Path::to_str);
        assert_eq!(config(b"/usr/local/bin/tertius\0run\0--config\0x.toml\0"), Some("x.toml"));
        assert_eq!(config(b"tertius\0run\0--log\0json\0--config=/x.toml\0"), Some("/x.toml"));
        assert_eq!(config(b"/usr/local/bin/tertius\0doctor\0--config\0x.toml\0"), None);
        assert_eq!(config(b"/usr/bin/cat\0run\0--config\0x.toml\0"), None);
        assert_eq!(config(b"tertius\0run\0"), None);
        assert_eq!(config(b""), None);
    }
}
