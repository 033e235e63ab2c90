//! Which multiplexor values select each signal.

use std::collections::HashMap;

use can_dbc::{MultiplexIndicator, SignalExtendedValueType};

use super::MAX_MULTIPLEX_DEPTH;
use super::draft::{Draft, DraftSignal};
use super::finding::{Concern, Finding, Severity};

/// A signal's own multiplexor (its place among the message's signals) and the values that select
/// the signal: inclusive ranges, ascending and disjoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Route {
    pub multiplexor: usize,
    pub ranges: Box<[(u64, u64)]>,
}

/// The route of each signal, `None` where it is always present; or what is wrong.
pub(super) struct Routes {
    pub routes: Vec<Option<Route>>,
    pub findings: Vec<Finding>,
}

impl Routes {
    /// Resolves `m`, `M` and SG_MUL_VAL_. After a finding of severity error the routes must not be
    /// used.
    pub fn resolve(draft: &Draft) -> Self {
        let multiplexors: Vec<usize> =
            (0..draft.signals.len()).filter(|&i| is_multiplexor(&draft.signals[i])).collect();
        let by_name =
            draft.signals.iter().enumerate().map(|(i, s)| (s.parsed.name.as_str(), i)).collect();
        let resolver = Resolver { draft, multiplexors, by_name };
        let mut resolved = Self { routes: Vec::new(), findings: Vec::new() };
        for signal in &draft.signals {
            let route = resolver.route(signal, &mut resolved.findings).unwrap_or_else(|finding| {
                resolved.findings.push(finding);
                None
            });
            resolved.routes.push(route);
        }
        resolved.check_depth(draft);
        resolved
    }

    /// The routes of signal `at`, its own first, the outermost last.
    pub fn way(&self, at: usize) -> impl Iterator<Item = &Route> {
        let mut next = self.routes[at].as_ref();
        std::iter::from_fn(move || {
            let route = next?;
            next = self.routes[route.multiplexor].as_ref();
            Some(route)
        })
    }

    fn check_depth(&mut self, draft: &Draft) {
        for (at, signal) in draft.signals.iter().enumerate() {
            // One step more than allowed tells a cycle, too.
            if self.way(at).take(MAX_MULTIPLEX_DEPTH + 1).count() > MAX_MULTIPLEX_DEPTH {
                self.findings.push(draft.finding(
                    Severity::Error,
                    Concern::Multiplexing,
                    Some(signal),
                    format!(
                        "its multiplexors select each other in a circle, or more than \
                         {MAX_MULTIPLEX_DEPTH} deep"
                    ),
                    "correct the SG_MUL_VAL_ statements",
                ));
            }
        }
    }
}

struct Resolver<'a> {
    draft: &'a Draft,
    multiplexors: Vec<usize>,
    by_name: HashMap<&'a str, usize>,
}

impl Resolver<'_> {
    fn route(
        &self,
        signal: &DraftSignal,
        findings: &mut Vec<Finding>,
    ) -> Result<Option<Route>, Finding> {
        let error = |what: String, remedy| {
            let mut finding = self.draft.finding(
                Severity::Error,
                Concern::Multiplexing,
                Some(signal),
                what,
                remedy,
            );
            // Where there is a SG_MUL_VAL_, all that can be wrong is wrong with that.
            finding.line = signal.multiplex.as_ref().map_or(signal.line, |extended| extended.line);
            finding
        };
        if signal.bare_indicator {
            return Err(error(
                "multiplex indicator m without a number".to_owned(),
                "write m0, m1, … or leave it out",
            ));
        }
        let number = match (number(signal), &signal.multiplex) {
            (None, None) => return Ok(None),
            (None, Some(_)) => {
                return Err(error(
                    "SG_MUL_VAL_ is about a signal that is not multiplexed".to_owned(),
                    "mark the signal m0, m1, … or remove the SG_MUL_VAL_",
                ));
            }
            (Some(number), _) => number,
        };
        let Some(extended) = &signal.multiplex else {
            return match self.multiplexors[..] {
                [only] if !std::ptr::eq(&raw const self.draft.signals[only], signal) => {
                    self.checked(signal, only, vec![(number, number)], findings).map(Some)
                }
                [] | [_] => Err(error(
                    format!("multiplexed (m{number}), but the message has no multiplexor"),
                    "mark the multiplexor M",
                )),
                _ => Err(error(
                    "the message has several multiplexors and this signal no SG_MUL_VAL_"
                        .to_owned(),
                    "add the SG_MUL_VAL_ that names the signal's multiplexor",
                )),
            };
        };
        let Some(&multiplexor) = self.by_name.get(extended.multiplexor.as_str()) else {
            return Err(error(
                format!(
                    "SG_MUL_VAL_ names a multiplexor {} that is not there",
                    extended.multiplexor
                ),
                "correct the name",
            ));
        };
        if !is_multiplexor(&self.draft.signals[multiplexor]) {
            return Err(error(
                format!("SG_MUL_VAL_ names {}, which is not a multiplexor", extended.multiplexor),
                "mark it M (or m0M, …), or correct the name",
            ));
        }
        if let Some((low, high)) = extended.ranges.iter().find(|(low, high)| low > high) {
            return Err(error(
                format!("SG_MUL_VAL_ has the range {low}-{high}"),
                "write the smaller number first",
            ));
        }
        if !extended.ranges.iter().any(|&(low, high)| (low..=high).contains(&number)) {
            findings.push(self.draft.finding(
                Severity::Warning,
                Concern::Multiplexing,
                Some(signal),
                format!("marked m{number}, which is not among its SG_MUL_VAL_ ranges"),
                "the ranges count; correct the mark",
            ));
        }
        self.checked(signal, multiplexor, extended.ranges.clone(), findings).map(Some)
    }

    /// The route, if the multiplexor is suitable.
    fn checked(
        &self,
        signal: &DraftSignal,
        multiplexor: usize,
        ranges: Vec<(u64, u64)>,
        findings: &mut Vec<Finding>,
    ) -> Result<Route, Finding> {
        let by = &self.draft.signals[multiplexor];
        if is_float(by) {
            return Err(self.draft.finding(
                Severity::Error,
                Concern::Multiplexing,
                Some(by),
                "a multiplexor that is a float".to_owned(),
                "a multiplexor must be an integer: remove its SIG_VALTYPE_",
            ));
        }
        let ranges = merged(ranges);
        let usable_bits = by.parsed.size.saturating_sub(u64::from(is_signed(by)));
        let highest = if usable_bits >= 64 { u64::MAX } else { (1 << usable_bits) - 1 };
        if ranges[0].0 > highest {
            findings.push(self.draft.finding(
                Severity::Warning,
                Concern::Multiplexing,
                Some(signal),
                format!("selected by {} only beyond its highest value {highest}", by.name()),
                "no frame ever carries the signal; correct the number or the multiplexor's length",
            ));
        }
        Ok(Route { multiplexor, ranges })
    }
}

/// `ranges`, ascending, with overlapping and adjoining ranges merged; `ranges` is not empty.
fn merged(mut ranges: Vec<(u64, u64)>) -> Box<[(u64, u64)]> {
    ranges.sort_unstable();
    let mut merged: Vec<(u64, u64)> = Vec::with_capacity(ranges.len());
    for (low, high) in ranges {
        match merged.last_mut() {
            Some(last) if low <= last.1.saturating_add(1) => last.1 = last.1.max(high),
            _ => merged.push((low, high)),
        }
    }
    merged.into()
}

/// Whether two lists of ascending ranges have no number in common.
pub(super) fn disjoint(a: &[(u64, u64)], b: &[(u64, u64)]) -> bool {
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        if a[i].1 < b[j].0 {
            i += 1;
        } else if b[j].1 < a[i].0 {
            j += 1;
        } else {
            return false;
        }
    }
    true
}

/// Whether the signal selects others.
pub(super) fn is_multiplexor(signal: &DraftSignal) -> bool {
    matches!(
        signal.parsed.multiplexer_indicator,
        MultiplexIndicator::Multiplexor | MultiplexIndicator::MultiplexorAndMultiplexedSignal(_)
    )
}

/// The number after `m`.
fn number(signal: &DraftSignal) -> Option<u64> {
    match signal.parsed.multiplexer_indicator {
        MultiplexIndicator::MultiplexedSignal(number)
        | MultiplexIndicator::MultiplexorAndMultiplexedSignal(number) => Some(number),
        MultiplexIndicator::Multiplexor | MultiplexIndicator::Plain => None,
    }
}

pub(super) fn is_signed(signal: &DraftSignal) -> bool {
    signal.parsed.value_type == can_dbc::ValueType::Signed
}

pub(super) fn is_float(signal: &DraftSignal) -> bool {
    !matches!(signal.value_type, None | Some(SignalExtendedValueType::SignedOrUnsignedInteger))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_merged_and_compared() {
        assert_eq!(*merged(vec![(5, 7), (0, 2), (3, 4), (9, 9), (6, 8)]), [(0, 9)]);
        assert_eq!(*merged(vec![(5, u64::MAX), (0, 2), (9, 9)]), [(0, 2), (5, u64::MAX)]);
        assert!(disjoint(&[(0, 2), (5, 6)], &[(3, 4), (7, 9)]));
        assert!(!disjoint(&[(0, 2), (5, 6)], &[(3, 3), (6, 9)]));
    }
}
