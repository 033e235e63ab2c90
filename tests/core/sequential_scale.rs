//! A gain that is off is called a scale, and nothing else is: counts over machines, seas and signs.

use crate::sequential_support::{Heard, setup};
use tertius::alarm::State as Said;
use tertius::simulator::{EPOCH, Options};
use tertius::verdict::Suspect;

/// s, of the first fault and of its end.
const BEGIN: f64 = 12.0;
const END: f64 = 45.0;

/// Of each row, with six faults each.
const SEEDS: u64 = 12;

#[derive(Debug, Default)]
struct Counts {
    faults: u32,
    found: u32,
    /// Called a scale at some time.
    told: u32,
    /// Called so when the fault had been there for 10 s, and at the end of its time.
    after_10: u32,
    at_last: u32,
    /// Delays until then, s, and what the size is in parts of the true one.
    delays: Vec<f64>,
    sizes: Vec<f64>,
    right: u32,
    wrong: u32,
}

/// `fault` with `{sign}` in it, on all six cylinders, C1 or C2, in the loop or not.
fn count(fault: &str, size: f64) -> Counts {
    let mut counts = Counts::default();
    for seed in 0..SEEDS {
        let in_loop = seed % 2 == 1;
        let truth: Vec<(u8, Suspect, f64)> = (1..=6_u8)
            .map(|n| {
                let which = if (u64::from(n) + seed / 2).is_multiple_of(2) {
                    Suspect::C1
                } else {
                    Suspect::C2
                };
                let sign = if (u64::from(n) / 2 + seed).is_multiple_of(2) { 1.0 } else { -1.0 };
                (n, which, sign)
            })
            .collect();
        let faults: Vec<String> = truth
            .iter()
            .map(|(n, which, sign)| {
                let fault = fault.replace("{}", &(sign * size).to_string());
                format!(
                    "{fault},cylinder={n},sensor={},at={}",
                    which.name(),
                    BEGIN + 0.3 * f64::from(*n)
                )
            })
            .collect();
        let options = Options { in_loop, ..setup().options(100 + seed, &faults) };
        let heard = setup().play(END + 2.0, &options);
        truth.iter().for_each(|one| counts.take(&heard, *one, size));
    }
    counts
}

impl Counts {
    fn take(&mut self, heard: &Heard, (n, which, sign): (u8, Suspect, f64), size: f64) {
        let begin = BEGIN + 0.3 * f64::from(n);
        let own = || heard.warnings.iter().filter(|warning| warning.cylinder == n);
        let at = |warning: &tertius::alarm::Warning| warning.timestamp.since(EPOCH).as_seconds();
        self.faults += 1;
        self.found += u32::from(own().any(|warning| warning.state == Said::Raised));
        let until = |time: f64| own().take_while(|warning| at(warning) < time).last();
        let is_scale = |time: f64| until(time).is_some_and(|w| w.finding.gain().is_some());
        self.after_10 += u32::from(is_scale(begin + 10.0));
        self.at_last += u32::from(is_scale(END));
        if let Some(first) = own().find(|warning| warning.finding.gain().is_some()) {
            self.told += 1;
            self.delays.push(at(first) - begin);
        }
        let Some(last) = until(END) else { return };
        if let Some(gain) = last.finding.gain() {
            let side = if which == Suspect::C1 { sign } else { -sign };
            self.sizes.push(gain / (side * size));
        }
        self.right += u32::from(last.finding.suspect == which);
        self.wrong +=
            u32::from(last.finding.suspect != which && last.finding.suspect != Suspect::Undecided);
    }

    fn row(&mut self, what: &str) -> String {
        let of = |values: &mut Vec<f64>, part: f64| {
            values.sort_by(f64::total_cmp);
            let place = (part * (values.len() as f64 - 1.0)).max(0.0) as usize;
            values.get(place).map_or("–".to_owned(), |value| format!("{value:.2}"))
        };
        let delays = [0.5, 0.95].map(|part| of(&mut self.delays, part));
        let sizes = [0.05, 0.5, 0.95].map(|part| of(&mut self.sizes, part));
        format!(
            "{what:<22} {:>6} {:>5} {:>5} {:>9} {:>7}   {:<12} {:<18} {:>5} {:>5}",
            self.faults,
            self.found,
            self.told,
            self.after_10,
            self.at_last,
            delays.join(" "),
            sizes.join(" "),
            self.right,
            self.wrong
        )
    }
}

const HEADER: &str = "fault                  faults found  told after10s at last  delay 50 95 size 5 50 95       right wrong";

/// The error is nothing where the rod is at the middle of its stroke, and a small one is not there all
/// the time; the slower the evidence.
#[test]
fn a_gain_is_called_a_scale() {
    println!("{HEADER}");
    for (gain, median, nearly_all) in [(0.002, 10.0, 30.0), (0.005, 8.0, 20.0), (0.01, 6.0, 12.0)] {
        let mut counts = count("scale,gain={}", gain);
        let row = counts.row(&format!("scale {:.1} %", 100.0 * gain));
        println!("{row}");
        assert!(counts.found == counts.faults && 20 * counts.told >= 19 * counts.faults, "{row}");
        let of = |part: f64| counts.delays[(part * (counts.delays.len() - 1) as f64) as usize];
        assert!(of(0.5) < median && of(0.95) < nearly_all, "{row}");
        let near = |size: &&f64| (*size - 1.0).abs() < 0.05;
        assert!(10 * counts.sizes.iter().filter(near).count() >= 9 * counts.sizes.len(), "{row}");
        assert!(4 * counts.at_last >= 3 * counts.faults && counts.wrong == 0, "{row}");
    }
}

#[test]
fn nothing_else_is_called_a_scale() {
    println!("{HEADER}");
    for (fault, sizes) in [
        ("step,size={}", &[5e-4, 1e-3, 1e-2][..]),
        ("drift,rate={}", &[1e-5, 1e-4, 1e-3, 1e-2]),
        ("incipient,size={}", &[5e-3, 7e-2]),
        ("noise,size={}", &[4.34e-4, 8.68e-4, 5e-3]),
    ] {
        for size in sizes {
            let mut counts = count(fault, *size);
            let row = counts.row(&fault.replace("{}", &size.to_string()));
            println!("{row}");
            assert!(counts.found == counts.faults && counts.told == 0, "{row}");
        }
    }
}
