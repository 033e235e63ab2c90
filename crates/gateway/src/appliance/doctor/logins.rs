//! Check of the failed logins of the gateway that is running.

use super::facts::Logins;
use super::finding::Finding;
use tertius_core::text::counted;

const SUBJECT: &str = "logins";

/// The finding on `logins`; none where no gateway is running, or it has no page.
pub(super) fn judge(logins: Option<&Result<Logins, String>>) -> Option<Finding> {
    Some(match logins? {
        Ok(Logins { failures, lockouts: 0 }) => {
            let tokens = counted(*failures, "wrong token");
            Finding::ok(SUBJECT, format!("{tokens} since the gateway started, and no lockout"))
        }
        Ok(Logins { failures, lockouts }) => {
            let (tokens, lockouts) =
                (counted(*failures, "wrong token"), counted(*lockouts, "lockout"));
            Finding::warn(
                SUBJECT,
                format!("{tokens} since the gateway started, and {lockouts}"),
                "`journalctl -u tertius -g 'wrong token'` names the addresses: if you do not know one, keep it from \
                 the page",
            )
        }
        Err(reason) => Finding::warn(
            SUBJECT,
            format!("the running gateway was not asked for wrong tokens: {reason}"),
            "its log says whether it serves its page; after a new certificate or address, `systemctl reload tertius`",
        ),
    })
}

impl Logins {
    /// Those in the metrics `text`; `None` where it has none, as that of an older gateway.
    pub fn read(text: &str) -> Option<Self> {
        let total = |name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            line.strip_prefix("_total ")?.trim().parse().ok()
        };
        Some(Self {
            failures: total("tertius_login_failures")?,
            lockouts: total("tertius_login_lockouts")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_totals_are_found_among_others() {
        let text = "# HELP tertius_login_failures_total Wrong tokens.\ntertius_turns_total 5\n\
                    tertius_login_failures_total 12\ntertius_login_lockouts_total 2\n";
        assert_eq!(Logins::read(text), Some(Logins { failures: 12, lockouts: 2 }));
        let older = text.replace("lockouts", "others");
        assert_eq!(Logins::read(&older), None, "a total that is missing is not zero");
    }
}
