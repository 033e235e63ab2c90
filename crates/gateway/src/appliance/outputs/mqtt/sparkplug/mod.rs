//! Sparkplug B: the gateway as an edge node, and each cylinder as a device of it.

mod births;
mod payload;
mod session;

pub(super) use session::SparkplugSession;
use std::fmt::{self, Display, Formatter};

/// Namespace of the topics.
const NAMESPACE: &str = "spBv1.0";

/// Name of an edge node of Sparkplug: its group, and its own in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EdgeNode {
    pub group: String,
    pub node: String,
}

impl EdgeNode {
    /// Topic of messages of the kind `kind` of the node, or of its device `device`.
    fn topic(&self, kind: &str, device: Option<&str>) -> String {
        let Self { group, node } = self;
        match device {
            None => format!("{NAMESPACE}/{group}/{kind}/{node}"),
            Some(device) => format!("{NAMESPACE}/{group}/{kind}/{node}/{device}"),
        }
    }
}

impl Display for EdgeNode {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.group, self.node)
    }
}
