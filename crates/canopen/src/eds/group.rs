//! Sections that belong together: those of an object, and those of the device.

use std::collections::BTreeMap;

use super::finding::{Address, Concern, Finding, Findings, Severity};
use super::ini::Section;
use super::number;
use super::parse_error::excerpt;

/// The first index of an object; lower ones define data types.
pub(super) const FIRST_OBJECT: u16 = 0x1000;

/// The sections of one object.
#[derive(Default)]
pub(super) struct Group<'a> {
    /// `[1018]`
    pub head: Option<&'a Section<'a>>,
    /// `[1018sub1]` and others, by sub-index.
    pub subs: BTreeMap<u8, &'a Section<'a>>,
    /// `[1003Name]`: names of the sub-objects of `CompactSubObj`.
    pub names: Option<&'a Section<'a>>,
    /// `[1003Value]`: their values in a DCF.
    pub values: Option<&'a Section<'a>>,
    /// `[1003Denotation]`: their denotations in a DCF.
    pub denotations: Option<&'a Section<'a>>,
}

/// All sections by what they are about.
#[derive(Default)]
pub(super) struct Groups<'a> {
    pub objects: BTreeMap<u16, Group<'a>>,
    /// Other sections by their names in small letters.
    pub others: BTreeMap<String, &'a Section<'a>>,
    /// Objects and sub-objects that have two sections.
    pub twins: Vec<Finding>,
}

/// Part of an object that a section describes.
enum Part {
    Head,
    Sub(u8),
    Names,
    Values,
    Denotations,
}

impl<'a> Groups<'a> {
    pub fn new(sections: &'a [Section<'a>], findings: &mut Findings) -> Self {
        let mut groups = Self::default();
        for section in sections {
            match address(section.name) {
                Ok(Some((index, part))) => groups.add(index, part, section),
                Ok(None) => {
                    let name = section.name.to_ascii_lowercase();
                    if let Some(first) = groups.others.get(&name) {
                        let what = format!(
                            "[{}] stands in line {}, too",
                            excerpt(section.name),
                            first.line
                        );
                        let remedy = "the first one counts";
                        findings.warn(Concern::Duplicate, section.line, what, remedy);
                    } else {
                        groups.others.insert(name, section);
                    }
                }
                Err(()) => {
                    let what = format!("found [{}]", excerpt(section.name));
                    let remedy = "a sub-index has one or two hexadecimal digits, as in [1018sub1]";
                    findings.warn(Concern::Section, section.line, what, remedy);
                }
            }
        }
        groups
    }

    fn add(&mut self, index: u16, part: Part, section: &'a Section<'a>) {
        let group = self.objects.entry(index).or_default();
        let sub_index = if let Part::Sub(sub_index) = part { Some(sub_index) } else { None };
        let first = match part {
            Part::Sub(sub_index) => group.subs.insert(sub_index, section),
            Part::Head => group.head.replace(section),
            Part::Names => group.names.replace(section),
            Part::Values => group.values.replace(section),
            Part::Denotations => group.denotations.replace(section),
        };
        if let Some(first) = first {
            self.twins.push(Finding {
                severity: Severity::Error,
                concern: Concern::Duplicate,
                line: section.line,
                object: Some(Address { index, sub_index }),
                what: format!("[{}] stands in line {}, too", section.name, first.line),
                remedy: "leave the one that is meant",
            });
        }
    }

    /// The section of that name.
    pub fn other(&self, name: &str) -> Option<&'a Section<'a>> {
        self.others.get(&name.to_ascii_lowercase()).copied()
    }

    /// The static type that a type definition of the maker's stands for, as CANFestival's editor has them:
    /// the default value of its sub-object 1.
    pub fn defined_type(&self, number: u16) -> Option<u16> {
        let definition = self.objects.get(&number).filter(|_| number < FIRST_OBJECT)?;
        number::within(definition.subs.get(&1)?.filled("DefaultValue")?.value)
    }
}

/// The index and the part of the object that a section of that name describes; `None` if it is about
/// none.
///
/// # Errors
/// The sub-index is none.
fn address(name: &str) -> Result<Option<(u16, Part)>, ()> {
    const DIGITS: usize = 4;
    // With fewer digits only definitions of types are written.
    let digits = name.bytes().take(DIGITS).take_while(u8::is_ascii_hexdigit).count();
    let Ok(index) = u16::from_str_radix(&name[..digits], 16) else { return Ok(None) };
    let rest = &name[digits..];
    let part = match rest.to_ascii_lowercase().as_str() {
        "" => Part::Head,
        "name" => Part::Names,
        "value" => Part::Values,
        "denotation" => Part::Denotations,
        other => match other.strip_prefix("sub") {
            // Not all that is parsed are digits: there may be a sign.
            Some(digits) if digits.bytes().all(|byte| byte.is_ascii_hexdigit()) => {
                Part::Sub(u8::from_str_radix(digits, 16).map_err(|_| ())?)
            }
            Some(_) => return Err(()),
            None => return Ok(None),
        },
    };
    Ok(Some((index, part)))
}
