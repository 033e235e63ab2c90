//! A seeded generator of numbers and of DBCs.

/// splitmix64: the same numbers everywhere, for the same seed.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0..`end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.roll() % end
    }

    pub fn of<'a>(&mut self, choices: &[&'a str]) -> &'a str {
        choices[self.below(choices.len() as u64) as usize]
    }
}

const FACTORS: [&str; 10] =
    ["1", "1", "0.1", "3e-05", "-0.5", "0.000108506944444444", "2", "-3", "1E10", "0.001"];
const OFFSETS: [&str; 8] = ["0", "0", "0", "-1.5", "7", "-40", "1e-3", "123456.789"];

/// A message in the making: its text, and the statements that go to the end of the file.
pub struct Writer<'a> {
    pub dice: &'a mut Dice,
    dbc_id: u64,
    bits: u64,
    signals: u64,
    nested: bool,
    text: String,
    after: String,
}

/// A random DBC that is valid: any byte order, alignment, length, sign, float and multiplexing.
pub fn random_dbc(dice: &mut Dice, messages: u64) -> String {
    let mut text = "VERSION \"\"\n\nBU_: A\n\n".to_owned();
    let mut after = String::new();
    for number in 0..messages {
        let length =
            [1, 2, 3, 4, 5, 6, 7, 8, 8, 8, 12, 16, 24, 32, 48, 64][dice.below(16) as usize];
        let dbc_id = if dice.below(2) == 0 { number } else { 0x8000_0000 + number * 0x12345 };
        let nested = dice.below(2) == 0;
        let mut writer = Writer {
            dice,
            dbc_id,
            bits: 8 * length,
            signals: 0,
            nested,
            text: format!("BO_ {dbc_id} M{number}: {length} A\n"),
            after: String::new(),
        };
        writer.message();
        text += &writer.text;
        text += "\n";
        after += &writer.after;
    }
    text + &after
}

impl Writer<'_> {
    fn message(&mut self) {
        let mut occupied = vec![false; self.bits as usize];
        if self.dice.below(2) == 0 {
            self.group(&mut occupied, None, 0);
        } else {
            self.plain(&mut occupied, 6, "", None);
        }
    }

    /// A multiplexor below `parent` (name and range), signals that it selects, and perhaps
    /// multiplexors below it.
    fn group(&mut self, occupied: &mut [bool], parent: Option<(&str, (u64, u64))>, depth: u32) {
        let width = 1 + self.dice.below(6);
        let (mark, name) = match parent {
            None => (" M".to_owned(), format!("Root{}", self.signals)),
            Some((_, range)) => (format!(" m{}M", range.0), format!("Mux{}", self.signals)),
        };
        let Some(at) = self.place(occupied, width, false) else { return };
        self.write(&name, &mark, at, width, false, "+", "(1,0)");
        if let Some((above, (low, high))) = parent {
            self.after += &format!("SG_MUL_VAL_ {} {name} {above} {low}-{high};\n", self.dbc_id);
        }
        if depth == 0 {
            self.plain(occupied, 2, "", None);
        }
        let mut low = 0;
        while low < 1 << width {
            let high = if self.nested { low + self.dice.below(3) } else { low };
            let mut branch = occupied.to_vec();
            let range = (low, high.min((1 << width) - 1));
            self.plain(&mut branch, 3, &format!(" m{low}"), Some((&name, range)));
            if self.nested && depth < 3 && self.dice.below(3) == 0 {
                self.group(&mut branch, Some((&name, range)), depth + 1);
            }
            low = high + 1 + self.dice.below(4);
        }
    }

    /// Up to `most` signals that select nothing.
    fn plain(
        &mut self,
        occupied: &mut [bool],
        most: u64,
        mark: &str,
        parent: Option<(&str, (u64, u64))>,
    ) {
        for _ in 0..=self.dice.below(most) {
            let float = [None, None, None, Some(32), Some(64)][self.dice.below(5) as usize];
            let width = float.unwrap_or_else(|| 1 + self.dice.below(64));
            let motorola = self.dice.below(2) == 0;
            let Some(at) = self.place(occupied, width, motorola) else { continue };
            let name = format!("S{}", self.signals);
            let sign = self.dice.of(&["+", "-"]);
            let scale = format!("({},{})", self.dice.of(&FACTORS), self.dice.of(&OFFSETS));
            self.write(&name, mark, at, width, motorola, sign, &scale);
            if let Some(bits) = float {
                self.after += &format!("SIG_VALTYPE_ {} {name} : {};\n", self.dbc_id, bits / 32);
            }
            if let (true, Some((above, (low, high)))) = (self.nested, parent) {
                self.after +=
                    &format!("SG_MUL_VAL_ {} {name} {above} {low}-{high};\n", self.dbc_id);
            }
        }
    }

    /// A free place for so many bits, taken; the start bit as a DBC has it.
    fn place(&mut self, occupied: &mut [bool], width: u64, motorola: bool) -> Option<u64> {
        let flip = |bit: u64| if motorola { bit ^ 7 } else { bit };
        for _ in 0..20 {
            let first = self.dice.below(self.bits);
            let places = first..first + width;
            if places.end <= self.bits && places.clone().all(|bit| !occupied[flip(bit) as usize]) {
                places.for_each(|bit| occupied[flip(bit) as usize] = true);
                return Some(flip(first));
            }
        }
        None
    }

    #[allow(clippy::too_many_arguments, reason = "the columns of one line of text")]
    fn write(
        &mut self,
        name: &str,
        mark: &str,
        at: u64,
        width: u64,
        motorola: bool,
        sign: &str,
        scale: &str,
    ) {
        let order = u8::from(!motorola);
        self.text +=
            &format!(" SG_ {name}{mark} : {at}|{width}@{order}{sign} {scale} [0|0] \"\" A\n");
        self.signals += 1;
    }
}
