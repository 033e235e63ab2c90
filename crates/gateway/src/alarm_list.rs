//! The alarm list after ISA-18.2 and IEC 62682: which incidents a person has to deal with, and what people did.
//!
//! An incident is an alarm from the time at which it opens. People acknowledge it, or shelve it for a stated
//! time. None of that reaches the monitor: detection, the frames on the bus and the incident itself stay as
//! they are. The states follow from one table, [`TRANSITIONS`]; time is passed in.

use tertius_core::alarm::Level;
use tertius_core::time::{Span, Timestamp};
use thiserror::Error;

/// Longest time for which an alarm can be shelved.
pub const LONGEST_SHELVING: Span = Span::from_nanos(7 * 86_400 * 1_000_000_000);

/// Whether the incident goes on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AlarmCondition {
    /// It is open.
    #[default]
    Active,
    /// The monitor closed it.
    Returned,
    /// The program or the monitor ended while it was open. Nothing shows that it is over.
    Interrupted,
}

/// What a person does with an alarm. A name and a reason go with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActKind {
    Acknowledge,
    /// Takes it out of sight until that time.
    Shelve(Timestamp),
    Unshelve,
}

/// What can happen to an alarm, apart from shelving.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// The incident reached a higher level, or opened again.
    Worse,
    Acknowledged,
    Returned,
    Interrupted,
}

/// State of an alarm, apart from shelving.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Standing {
    pub condition: AlarmCondition,
    /// Whether somebody acknowledged it since it opened, became worse or was interrupted.
    pub acknowledged: bool,
}

const fn standing(condition: AlarmCondition, acknowledged: bool) -> Standing {
    Standing { condition, acknowledged }
}

/// What follows from each happening: a state, what happens, the state after it. What is not here cannot happen, and
/// changes nothing. An interruption takes the acknowledgement away, as does a higher level: both are news.
pub const TRANSITIONS: [(Standing, Happening, Standing); 13] = {
    use AlarmCondition::{Active, Interrupted, Returned};
    use Happening as On;
    [
        (standing(Active, false), On::Acknowledged, standing(Active, true)),
        (standing(Active, false), On::Worse, standing(Active, false)),
        (standing(Active, false), On::Returned, standing(Returned, false)),
        (standing(Active, false), On::Interrupted, standing(Interrupted, false)),
        (standing(Active, true), On::Worse, standing(Active, false)),
        (standing(Active, true), On::Returned, standing(Returned, true)),
        (standing(Active, true), On::Interrupted, standing(Interrupted, false)),
        (standing(Returned, false), On::Acknowledged, standing(Returned, true)),
        (standing(Interrupted, false), On::Acknowledged, standing(Interrupted, true)),
        // A monitor that takes up the state of an earlier one goes on with its incidents.
        (standing(Interrupted, false), On::Worse, standing(Active, false)),
        (standing(Interrupted, true), On::Worse, standing(Active, false)),
        (standing(Interrupted, false), On::Returned, standing(Returned, false)),
        (standing(Interrupted, true), On::Returned, standing(Returned, true)),
    ]
};

/// An incident as an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Alarm {
    pub standing: Standing,
    /// Highest level that it has reached.
    pub level: Level,
    /// Time until which it is shelved; may be over.
    pub shelved_until: Option<Timestamp>,
}

/// State of an alarm as a list shows it. The letters are those of the standards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlarmState {
    /// A: returned and acknowledged; the list does not show it.
    Normal,
    /// B
    Unacknowledged,
    /// C
    Acknowledged,
    /// D
    ReturnedUnacknowledged,
    /// As D, but nothing shows that it is over.
    InterruptedUnacknowledged,
    /// G: shelved by a person until a stated time.
    Shelved,
    /// H: the machine is in a state in which the monitor does not judge by design; the alarm was found before.
    Suppressed,
}

/// Why an act is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ActRefusal {
    #[error("it is acknowledged already")]
    Acknowledged,
    #[error("it is over and acknowledged: there is nothing to shelve")]
    Normal,
    #[error("it is not shelved")]
    NotShelved,
    #[error("the time until which it is to be shelved is past")]
    Past,
    #[error("it can be shelved for seven days at most")]
    TooLong,
}

impl Alarm {
    /// The alarm of an incident that opens at `level`.
    pub const fn opened(level: Level) -> Self {
        let standing = standing(AlarmCondition::Active, false);
        Self { standing, level, shelved_until: None }
    }

    /// Takes what has happened. A state in which it cannot happen stays.
    #[must_use]
    pub fn after(self, happening: Happening) -> Self {
        let row = |(from, what, _): &&(Standing, Happening, Standing)| {
            *from == self.standing && *what == happening
        };
        let next = TRANSITIONS.iter().find(row).map(|(_, _, to)| *to);
        // What is news ends a shelving.
        let news = matches!(happening, Happening::Worse | Happening::Interrupted);
        let shelved_until = self.shelved_until.filter(|_| !news);
        Self { standing: next.unwrap_or(self.standing), shelved_until, ..self }
    }

    /// Takes the level of the incident; a higher one is news.
    #[must_use]
    pub fn at_level(self, level: Level) -> Self {
        if level <= self.level {
            return self;
        }
        Self { level, ..self.after(Happening::Worse) }
    }

    /// Takes what a person does at `now`.
    ///
    /// # Errors
    /// The act means nothing in this state.
    pub fn act(self, act: ActKind, now: Timestamp) -> Result<Self, ActRefusal> {
        match act {
            ActKind::Acknowledge if self.standing.acknowledged => Err(ActRefusal::Acknowledged),
            ActKind::Acknowledge => Ok(self.after(Happening::Acknowledged)),
            ActKind::Shelve(_) if self.is_normal() => Err(ActRefusal::Normal),
            ActKind::Shelve(until) if until <= now => Err(ActRefusal::Past),
            ActKind::Shelve(until) if until.since(now) > LONGEST_SHELVING => {
                Err(ActRefusal::TooLong)
            }
            ActKind::Shelve(until) => Ok(Self { shelved_until: Some(until), ..self }),
            ActKind::Unshelve if !self.is_shelved(now) => Err(ActRefusal::NotShelved),
            ActKind::Unshelve => Ok(Self { shelved_until: None, ..self }),
        }
    }

    /// State at `now`; `gated`: the monitor does not judge by design, since the machine is in no monitored state.
    pub fn state(&self, now: Timestamp, gated: bool) -> AlarmState {
        use AlarmCondition::{Active, Interrupted, Returned};
        if self.is_normal() {
            return AlarmState::Normal;
        }
        if self.is_shelved(now) {
            return AlarmState::Shelved;
        }
        match (self.standing.condition, self.standing.acknowledged) {
            (Active, _) if gated => AlarmState::Suppressed,
            (Active, false) => AlarmState::Unacknowledged,
            (Active, true) => AlarmState::Acknowledged,
            (Returned, _) => AlarmState::ReturnedUnacknowledged,
            (Interrupted, _) => AlarmState::InterruptedUnacknowledged,
        }
    }

    /// Whether the list shows it no longer.
    pub fn is_normal(&self) -> bool {
        self.standing.condition != AlarmCondition::Active && self.standing.acknowledged
    }

    /// A shelving that would last longer than it may is one that a clock that was set back has
    /// prolonged, and is over.
    fn is_shelved(&self, now: Timestamp) -> bool {
        self.shelved_until.is_some_and(|until| now < until && until.since(now) <= LONGEST_SHELVING)
    }
}

impl AlarmCondition {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Active => "active",
            Self::Returned => "returned",
            Self::Interrupted => "interrupted",
        }
    }
}

impl ActKind {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Acknowledge => "acknowledge",
            Self::Shelve(_) => "shelve",
            Self::Unshelve => "unshelve",
        }
    }
}

impl AlarmState {
    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Unacknowledged => "unacknowledged",
            Self::Acknowledged => "acknowledged",
            Self::ReturnedUnacknowledged => "returned_unacknowledged",
            Self::InterruptedUnacknowledged => "interrupted_unacknowledged",
            Self::Shelved => "shelved",
            Self::Suppressed => "suppressed",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use AlarmCondition::{Active, Interrupted, Returned};

    const NOW: Timestamp = Timestamp::from_nanos(1_000_000_000_000);

    fn later(seconds: f64) -> Timestamp {
        NOW.after(Span::from_seconds(seconds))
    }

    fn alarm(condition: AlarmCondition, acknowledged: bool) -> Alarm {
        Alarm { standing: standing(condition, acknowledged), ..Alarm::opened(Level::Yellow) }
    }

    /// Each row of the table by what a list then shows, and everything that is not in it.
    #[test]
    fn each_transition_is_the_standard_s() {
        use AlarmState as S;
        use Happening as On;
        let states = [
            (alarm(Active, false), S::Unacknowledged),
            (alarm(Active, true), S::Acknowledged),
            (alarm(Returned, false), S::ReturnedUnacknowledged),
            (alarm(Returned, true), S::Normal),
            (alarm(Interrupted, false), S::InterruptedUnacknowledged),
            (alarm(Interrupted, true), S::Normal),
        ];
        let happenings = [On::Worse, On::Acknowledged, On::Returned, On::Interrupted];
        let interrupted = S::InterruptedUnacknowledged;
        let expected = [
            [S::Unacknowledged, S::Acknowledged, S::ReturnedUnacknowledged, interrupted],
            [S::Unacknowledged, S::Acknowledged, S::Normal, interrupted],
            [
                S::ReturnedUnacknowledged,
                S::Normal,
                S::ReturnedUnacknowledged,
                S::ReturnedUnacknowledged,
            ],
            [S::Normal; 4],
            [S::Unacknowledged, S::Normal, S::ReturnedUnacknowledged, interrupted],
            [S::Unacknowledged, S::Normal, S::Normal, S::Normal],
        ];
        for ((before, shown), row) in states.into_iter().zip(expected) {
            assert_eq!(before.state(NOW, false), shown);
            for (happening, after) in happenings.into_iter().zip(row) {
                let state = before.after(happening).state(NOW, false);
                assert_eq!(state, after, "{before:?} {happening:?}");
            }
        }
    }

    #[test]
    fn a_higher_level_is_news_and_a_lower_one_is_not() {
        let alarm = alarm(Active, true).act(ActKind::Shelve(later(60.0)), NOW).expect("active");
        assert_eq!(alarm.at_level(Level::Yellow), alarm);
        let worse = alarm.at_level(Level::Red);
        assert_eq!(worse.state(NOW, false), AlarmState::Unacknowledged);
        assert_eq!(worse.at_level(Level::Orange), worse);
    }

    #[test]
    fn a_shelving_ends_by_itself_and_whatever_the_clock_does() {
        let alarm = alarm(Active, false);
        let shelved = alarm.act(ActKind::Shelve(later(60.0)), NOW).expect("it is active");
        assert_eq!(shelved.state(later(59.0), false), AlarmState::Shelved);
        assert_eq!(shelved.state(later(60.0), false), AlarmState::Unacknowledged);
        assert_eq!(shelved.state(later(-8.0 * 86_400.0), false), AlarmState::Unacknowledged);
        let open = shelved.act(ActKind::Unshelve, NOW).expect("it is shelved");
        assert_eq!(open, alarm);
        assert_eq!(open.act(ActKind::Unshelve, NOW), Err(ActRefusal::NotShelved));
        for (seconds, why) in [(0.0, ActRefusal::Past), (8.0 * 86_400.0, ActRefusal::TooLong)] {
            assert_eq!(alarm.act(ActKind::Shelve(later(seconds)), NOW), Err(why));
        }
        // It goes on below it.
        let returned = shelved.after(Happening::Returned);
        assert_eq!(returned.state(later(60.0), false), AlarmState::ReturnedUnacknowledged);
    }

    #[test]
    fn an_act_that_means_nothing_is_refused() {
        let normal = alarm(Returned, true);
        assert_eq!(normal.act(ActKind::Acknowledge, NOW), Err(ActRefusal::Acknowledged));
        assert_eq!(normal.act(ActKind::Shelve(later(1.0)), NOW), Err(ActRefusal::Normal));
        let acknowledged = alarm(Active, false).act(ActKind::Acknowledge, NOW).expect("new");
        assert_eq!(acknowledged.act(ActKind::Acknowledge, NOW), Err(ActRefusal::Acknowledged));
    }

    #[test]
    fn what_stands_while_nothing_is_judged_is_said_to_be_suppressed() {
        assert_eq!(alarm(Active, false).state(NOW, true), AlarmState::Suppressed);
        assert_eq!(alarm(Returned, false).state(NOW, true), AlarmState::ReturnedUnacknowledged);
        assert_eq!(alarm(Returned, true).state(NOW, true), AlarmState::Normal);
    }
}
