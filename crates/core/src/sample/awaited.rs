//! For which fields of a cylinder a cycle is held open.
//!
//! A supply pressure that comes five times a second would hold four of five cycles open to their deadline, and each verdict
//! would come that much later. A field that no cycle needs is awaited only while it comes in three of four cycles.

use crate::state::state;

/// Fields of a cylinder, by [`crate::sample::Field::bit`].
#[derive(Clone, Debug)]
pub struct Awaited {
    required: u16,
    /// Those that never make a cycle incomplete.
    optional: u16,
    /// Those that came in the open cycle.
    came: u16,
    /// Those that the open cycle has from the one before, and that did not come in it. One that comes now before the evaluation
    /// and now after it is counted too seldom: it is then a cycle old at most.
    kept: u16,
    /// The same of the newest cycles.
    newest: [u16; 4],
    /// Those for which the open cycle is held open.
    fields: u16,
}

state! {
    Awaited { came, kept, newest, fields }
    but { required, optional }
}

impl Awaited {
    /// `all` are awaited at first; those beside the `required` ones may turn out to come too seldom for it.
    pub const fn new(required: u16, all: u16) -> Self {
        Self {
            required,
            optional: all & !required,
            came: 0,
            kept: 0,
            newest: [all; 4],
            fields: all,
        }
    }

    /// Whether nothing more is awaited once the fields in `got` have come.
    #[inline]
    pub const fn is_done(&self, got: u16) -> bool {
        got & self.fields == self.fields
    }

    /// Takes the fields with which the open cycle is evaluated.
    #[inline]
    pub const fn take(&mut self, got: u16) {
        self.came |= got & !self.kept;
    }

    /// Ends a cycle in which `late` have come after the evaluation. Returns those that the next cycle keeps: the newest value
    /// of a slow signal is as good there.
    #[inline]
    pub const fn turn(&mut self, late: u16) -> u16 {
        // Nearly always nothing is optional.
        if self.optional == 0 { 0 } else { self.follow(late) }
    }

    const fn follow(&mut self, late: u16) -> u16 {
        let d = self.came | late;
        // A cycle in which nothing came shows nothing about the fields.
        if d == 0 {
            self.kept = 0;
            return 0;
        }
        let [_, a, b, c] = self.newest;
        (self.newest, self.came) = ([a, b, c, d], 0);
        let in_three_of_four = (a & b & (c | d)) | (c & d & (a | b));
        self.fields = self.required | (self.optional & in_three_of_four);
        self.kept = late & self.optional & !self.fields;
        self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const READING: u16 = 0b01;
    const PRESSURE: u16 = 0b10;

    /// Whether the pressure is awaited in each cycle; it comes where `comes` is true, in time only where it is awaited.
    fn awaited(comes: impl IntoIterator<Item = bool>) -> Vec<bool> {
        let mut awaited = Awaited::new(READING, READING | PRESSURE);
        let mut kept = 0;
        let one = |comes| {
            let is_awaited = !awaited.is_done(READING | kept);
            let [in_time, late] =
                [is_awaited, !is_awaited].map(|it| if comes && it { PRESSURE } else { 0 });
            awaited.take(READING | kept | in_time);
            kept = awaited.turn(late);
            assert!(awaited.is_done(READING | PRESSURE) && !awaited.is_done(PRESSURE));
            assert!(kept == 0 || kept == PRESSURE && comes && awaited.is_done(READING));
            is_awaited
        };
        comes.into_iter().map(one).collect()
    }

    #[test]
    fn what_comes_in_each_cycle_is_awaited_and_a_lost_frame_ends_nothing() {
        assert!(awaited((0..40).map(|k| k % 7 != 0)).into_iter().all(|it| it));
    }

    #[test]
    fn what_comes_more_seldom_is_awaited_only_at_first() {
        for every in [2, 3, 5, 50] {
            let seen = awaited((0..100).map(|k| k % every == 0));
            assert!(seen[..2].iter().all(|it| *it), "one in {every}");
            assert!(seen[4..].iter().all(|it| !it), "one in {every}: {seen:?}");
        }
    }

    #[test]
    fn what_comes_in_each_cycle_again_is_awaited_again() {
        let seen = awaited((0..20).map(|k| k >= 10));
        assert!(!seen[12] && seen[13..].iter().all(|it| *it), "{seen:?}");
    }
}
