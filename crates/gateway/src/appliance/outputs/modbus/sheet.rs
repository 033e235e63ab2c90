//! Registers of a device: their content and their description, laid out by the same calls.

/// How a value is held by its registers, the more significant one first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegisterKind {
    /// Whole number in one register.
    U16,
    /// Whole number in two registers.
    U32,
    /// IEEE 754 number in two registers; not-a-number where there is none.
    F32,
}

impl RegisterKind {
    /// Name in the description.
    pub const fn name(self) -> &'static str {
        match self {
            Self::U16 => "u16",
            Self::U32 => "u32",
            Self::F32 => "f32",
        }
    }
}

/// Description of a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RegisterEntry {
    /// Address of its first register, from 0.
    pub address: u16,
    pub kind: RegisterKind,
    pub name: String,
    /// Unit; empty for a number.
    pub unit: &'static str,
    pub meaning: String,
}

/// The registers of a device in the order of their addresses. Between the blocks there are none.
#[derive(Clone, Debug, Default)]
pub struct RegisterSheet {
    /// First address and registers of each block.
    blocks: Vec<(u16, Vec<u16>)>,
    /// Descriptions, if they are asked for.
    entries: Option<Vec<RegisterEntry>>,
}

/// What a value is: its name, its unit, its meaning.
pub type Label<'a> = (&'a str, &'static str, &'a str);

impl RegisterSheet {
    /// A sheet that keeps descriptions, too.
    pub fn described() -> Self {
        Self { entries: Some(Vec::new()), ..Self::default() }
    }

    /// Begins a block at `address`, which is beyond all before it.
    pub fn block(&mut self, address: u16) {
        self.blocks.push((address, Vec::new()));
    }

    pub fn u16(&mut self, label: Label<'_>, value: u16) {
        self.put(RegisterKind::U16, label, &[value]);
    }

    pub fn u32(&mut self, label: Label<'_>, value: u32) {
        self.put(RegisterKind::U32, label, &words(value));
    }

    pub fn f32(&mut self, label: Label<'_>, value: Option<f64>) {
        let value = value.map_or(f32::NAN, |value| value as f32);
        self.put(RegisterKind::F32, label, &words(value.to_bits()));
    }

    fn put(&mut self, kind: RegisterKind, (name, unit, meaning): Label<'_>, words: &[u16]) {
        let Some((first, block)) = self.blocks.last_mut() else { return };
        if let Some(entries) = &mut self.entries {
            let address = *first + block.len() as u16;
            let (name, meaning) = (name.to_owned(), meaning.to_owned());
            entries.push(RegisterEntry { address, kind, name, unit, meaning });
        }
        block.extend(words);
    }

    /// So many registers from `address` on; `None` if any of them is not there.
    pub fn read(&self, address: u16, count: u16) -> Option<&[u16]> {
        self.blocks.iter().find_map(|(first, block)| {
            let begin = usize::from(address.checked_sub(*first)?);
            block.get(begin..begin + usize::from(count))
        })
    }

    pub fn entries(&self) -> &[RegisterEntry] {
        self.entries.as_deref().unwrap_or_default()
    }
}

const fn words(value: u32) -> [u16; 2] {
    [(value >> 16) as u16, value as u16]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_not_read() {
        let mut sheet = RegisterSheet::default();
        sheet.block(0);
        sheet.u16(("a", "", ""), 7);
        sheet.u32(("b", "", ""), 0x0001_0002);
        sheet.block(100);
        sheet.f32(("c", "m", ""), Some(1.0));
        sheet.f32(("d", "m", ""), None);
        assert_eq!(sheet.read(0, 3), Some(&[7, 1, 2][..]));
        assert_eq!(sheet.read(2, 1), Some(&[2][..]));
        assert_eq!(sheet.read(100, 4), Some(&[0x3F80, 0, 0x7FC0, 0][..]));
        for (address, count) in [(0, 4), (3, 1), (99, 1), (99, 2), (100, 5), (104, 1), (65_535, 2)]
        {
            assert_eq!(sheet.read(address, count), None, "{address} {count}");
        }
    }
}
