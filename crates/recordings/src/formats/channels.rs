//! Numbers for interfaces, for formats that have no names.

/// Most channels, by which Vector's tools number theirs.
const MOST: u16 = 255;
/// What such a format's own interfaces are called by its reader, before the number.
const OWN: &str = "channel";

/// The name of an interface that has only a number, made anew where the number is another one.
#[derive(Default)]
pub struct NumberedName {
    number: Option<u64>,
    name: Vec<u8>,
}

impl NumberedName {
    /// The name of a channel.
    pub fn channel(&mut self, number: u64) -> &[u8] {
        self.of(OWN, number)
    }

    /// The name that begins with `prefix`, the same one at each call.
    pub fn of(&mut self, prefix: &str, number: u64) -> &[u8] {
        if self.number.replace(number) != Some(number) {
            self.name = format!("{prefix}{number}").into_bytes();
        }
        &self.name
    }
}

/// The numbers of the interfaces so far, counted from 1.
#[derive(Default)]
pub struct Channels(Vec<(String, u16)>);

impl Channels {
    /// The number of an interface: that of its name if it is `channel2` or so and the number is free, otherwise the
    /// lowest one that is free. `None` where there is none left.
    pub fn number(&mut self, interface: &str) -> Option<u16> {
        if let Some((_, number)) = self.0.iter().find(|(name, _)| name == interface) {
            return Some(*number);
        }
        let is_free = |number: &u16| self.0.iter().all(|(_, taken)| taken != number);
        let own = interface.strip_prefix(OWN).and_then(|number| number.parse().ok());
        let own = own.filter(|number| (1..=MOST).contains(number) && is_free(number));
        let number = own.or_else(|| (1..=MOST).find(is_free))?;
        self.0.push((interface.to_owned(), number));
        Some(number)
    }

    /// Every interface with its number, in the order in which they came.
    pub fn all(&self) -> &[(String, u16)] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_follows_its_number() {
        let mut name = NumberedName::default();
        for number in [0, 0, 12, 12, 0] {
            assert_eq!(name.channel(number), format!("channel{number}").as_bytes());
        }
    }

    #[test]
    fn a_channel_keeps_its_number_and_others_get_what_is_free() {
        let mut channels = Channels::default();
        let names = ["channel2", "can0", "can1", "channel1", "can0", "channel2", "channel0"];
        let numbers = names.map(|name| channels.number(name));
        assert_eq!(numbers, [2, 1, 3, 4, 1, 2, 5].map(Some));
        assert_eq!(channels.all().len(), 5);
        let mut channels = Channels::default();
        let given = (0..300).filter_map(|n| channels.number(&format!("can{n}"))).count();
        assert_eq!(given, 255);
    }
}
