//! The blocks of pcapng.

/// Begin of a pcapng section, the same in both byte orders.
pub(super) const SECTION: u32 = 0x0A0D_0D0A;
pub(super) const INTERFACE: u32 = 1;
pub(super) const ENHANCED_PACKET: u32 = 6;
/// What a section says of its byte order.
pub(super) const ORDER: u32 = 0x1A2B_3C4D;
/// Bytes of the smallest block: its type, and its length twice.
pub(super) const LEAST_BLOCK: usize = 12;
/// Most interfaces of a section.
pub(super) const MOST_INTERFACES: usize = 1024;
