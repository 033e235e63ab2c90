//! The schema of a configuration, as data: tables, keys, types and the limits of single values; and how
//! [`super::settings`] declares a table once, for the loader, the messages, the types and the documentation.

use std::fmt;
use std::ops::{Bound, RangeBounds};

use super::text::TextRule;

/// A table of the file.
pub(super) struct Table {
    pub keys: &'static [Key],
}

/// A key of a [`Table`].
pub(super) struct Key {
    pub name: &'static str,
    /// Meaning of the key, with its unit.
    pub what: &'static str,
    /// Example value as written in the file; empty for tables.
    pub example: &'static str,
    /// The default as it is written in Rust; `None` for a required key.
    pub default: Option<&'static str>,
    pub kind: Kind,
}

/// Declares a table: its type with its defaults, its keys, and how it is read. A row is
///
/// ```text
/// key: Type = default => kind, "example in TOML", "purpose, with its unit";
/// ```
///
/// Without a default the key is required. `Type as Read` is read as another type, from which it follows.
/// Only a table whose keys all have defaults has one itself.
macro_rules! table {
    (
        $(#[$about:meta])*
        pub struct $name:ident = $table:ident {
            $(
                $(#[$more:meta])*
                $key:ident: $type:ty $(as $read:ty)? = $default:expr =>
                    $kind:expr, $example:literal, $what:literal;
            )*
        }
    ) => {
        table! { @declare [$(#[$about])*] $name $table $(
            [$(#[$more])*] $key [$type] [$($read)?] [$default] [$kind] $example $what
        )* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }
    };
    (
        $(#[$about:meta])*
        pub struct $name:ident = $table:ident {
            $(
                $(#[$more:meta])*
                $key:ident: $type:ty $(as $read:ty)? $(= $default:expr)? =>
                    $kind:expr, $example:literal, $what:literal;
            )*
        }
    ) => {
        table! { @declare [$(#[$about])*] $name $table $(
            [$(#[$more])*] $key [$type] [$($read)?] [$($default)?] [$kind] $example $what
        )* }
    };
    (
        @declare [$($about:tt)*] $name:ident $table:ident
        $(
            [$($more:tt)*] $key:ident [$type:ty] [$($read:ty)?] [$($default:expr)?] [$kind:expr]
            $example:literal $what:literal
        )*
    ) => {
        $($about)*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name {
            $(
                #[doc = $what]
                #[doc = ""]
                $($more)*
                pub $key: $type,
            )*
        }

        pub(crate) static $table: $crate::schema::Table = $crate::schema::Table {
            keys: &[$($crate::schema::Key {
                name: stringify!($key),
                what: $what,
                example: $example,
                default: table!(@text $($default)?),
                kind: $kind,
            }),*],
        };

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Fields;

                impl<'de> serde::de::Visitor<'de> for Fields {
                    type Value = $name;

                    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                        f.write_str("a table")
                    }

                    fn visit_map<A: serde::de::MapAccess<'de>>(
                        self,
                        mut map: A,
                    ) -> Result<$name, A::Error> {
                        $(let mut $key: Option<$type> = None;)*
                        while let Some(found) = map.next_key::<String>()? {
                            match found.as_str() {
                                $(stringify!($key) => {
                                    $key = Some(table!(@read map, $type, $($read)?));
                                })*
                                other => {
                                    let known = &[$(stringify!($key)),*];
                                    return Err(serde::de::Error::unknown_field(other, known));
                                }
                            }
                        }
                        Ok($name {
                            $($key: match $key {
                                Some(value) => value,
                                None => table!(@absent $key, $($default)?),
                            },)*
                        })
                    }
                }

                deserializer.deserialize_struct(
                    stringify!($name),
                    &[$(stringify!($key)),*],
                    Fields,
                )
            }
        }
    };
    (@text) => { None };
    (@text $default:expr) => { Some(stringify!($default)) };
    (@read $map:ident, $type:ty,) => { $map.next_value::<$type>()? };
    (@read $map:ident, $type:ty, $read:ty) => { <$type>::from($map.next_value::<$read>()?) };
    (@absent $key:ident,) => {
        return Err(serde::de::Error::missing_field(stringify!($key)))
    };
    (@absent $key:ident, $default:expr) => { $default };
}
pub(super) use table;

/// The shape of a key's value.
pub(super) enum Kind {
    Table(&'static Table),
    /// `[[name]]`, any number of times.
    Tables(&'static Table),
    One(Scalar),
    /// A list of `least` to `most` values.
    List {
        least: usize,
        most: usize,
        of: Scalar,
    },
}

/// A single value, and which values are valid.
pub(super) enum Scalar {
    Text(TextRule),
    Number(Limits),
    Whole(WholeLimits),
    Switch,
    Choice(&'static [&'static str]),
}

/// Limits of a number, which must also be finite.
pub(super) struct Limits {
    pub low: Bound<f64>,
    pub high: Bound<f64>,
    pub why: &'static str,
}

/// Inclusive limits of a whole number.
pub(super) struct WholeLimits {
    pub low: i128,
    pub high: i128,
    pub why: &'static str,
}

impl Table {
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.keys.iter().map(|key| key.name)
    }
}

impl Key {
    /// Whether a table without the key is refused.
    pub const fn is_required(&self) -> bool {
        self.default.is_none()
    }

    /// The key as a person writes it: `[table]`, `[[tables]]` or `key = example`.
    pub fn written(&self) -> String {
        match self.kind {
            Kind::Table(_) => format!("[{}]", self.name),
            Kind::Tables(_) => format!("[[{}]]", self.name),
            Kind::One(_) | Kind::List { .. } => format!("{} = {}", self.name, self.example),
        }
    }

    /// The key's purpose, and how a person writes it.
    pub fn meaning(&self) -> String {
        format!("{}; for example {}", self.what, self.written())
    }

    /// What the value has to be, in words.
    pub fn expected(&self) -> String {
        match &self.kind {
            Kind::Table(_) => "a table".into(),
            Kind::Tables(_) => format!("tables written as [[{}]]", self.name),
            Kind::One(scalar) => scalar.expected().into(),
            Kind::List { least, most, of } if least == most => {
                format!("a list of {least} values, each {}", of.expected())
            }
            Kind::List { of, .. } => format!("a list of values, each {}", of.expected()),
        }
    }
}

impl Scalar {
    pub fn expected(&self) -> &'static str {
        match self {
            Self::Text(_) | Self::Choice(_) => "a string",
            Self::Number(_) => "a number",
            Self::Whole(_) => "a whole number",
            Self::Switch => "true or false",
        }
    }
}

impl Limits {
    pub const fn finite(why: &'static str) -> Self {
        Self { low: Bound::Unbounded, high: Bound::Unbounded, why }
    }

    pub const fn above(low: f64, why: &'static str) -> Self {
        Self { low: Bound::Excluded(low), high: Bound::Unbounded, why }
    }

    pub const fn least(low: f64, why: &'static str) -> Self {
        Self { low: Bound::Included(low), high: Bound::Unbounded, why }
    }

    pub const fn most(self, high: f64) -> Self {
        Self { low: self.low, high: Bound::Included(high), why: self.why }
    }

    pub fn hold(&self, value: f64) -> bool {
        value.is_finite() && (self.low, self.high).contains(&value)
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.low, self.high) {
            (Bound::Unbounded, Bound::Unbounded) => return f.write_str("a finite number"),
            (Bound::Unbounded, _) => {}
            (Bound::Included(low), _) => write!(f, "at least {low}")?,
            (Bound::Excluded(low), _) => write!(f, "above {low}")?,
        }
        if !matches!(self.low, Bound::Unbounded) && !matches!(self.high, Bound::Unbounded) {
            f.write_str(" and ")?;
        }
        match self.high {
            Bound::Unbounded => f.write_str(" and finite"),
            Bound::Included(high) => write!(f, "at most {high}"),
            Bound::Excluded(high) => write!(f, "below {high}"),
        }
    }
}

impl WholeLimits {
    pub const fn new(low: i128, high: i128, why: &'static str) -> Self {
        Self { low, high, why }
    }
}

impl fmt::Display for WholeLimits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", self.low, self.high)
    }
}
