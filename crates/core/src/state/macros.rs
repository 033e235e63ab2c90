//! The declarations of state, see [`super`].

/// The fields of a type: those that are state; `parts`, which are there, or are as many, as the design says; `bits`,
/// which are patterns and not counts; and all others, which are no state. `sound` is what holds for every value.
macro_rules! state {
    (
        $type:ty $([$($generic:tt)*])? { $($field:ident),* $(,)? }
        $(parts { $($part:ident),* $(,)? })?
        $(bits { $($bits:ident),* $(,)? })?
        $(but { $($but:ident),* $(,)? })?
        $(sound |$it:ident| $sound:expr)?
    ) => {
        impl$(<$($generic)*>)? $crate::state::Stateful for $type {
            const SHAPE: u64 = {
                use $crate::state::*;
                let shape = shape_of_name(stringify!($type));
                $(
                    let shape = shape_of_both(shape, shape_of_name(stringify!($field)));
                    let shape = shape_of_both(shape, shape_of_field(|it: &Self| &it.$field));
                )*
                $($(
                    let shape = shape_of_both(shape, shape_of_name(stringify!($part)));
                    let shape = shape_of_both(shape, shape_of_parts(|it: &Self| &it.$part));
                )*)?
                $($(
                    let shape = shape_of_both(shape, shape_of_name(stringify!($bits)));
                    let shape = shape_of_both(shape, shape_of_bits(|it: &Self| &it.$bits));
                )*)?
                shape
            };

            fn save(&self, into: &mut $crate::state::StateWriter) {
                let Self { $($field,)* $($($part,)*)? $($($bits,)*)? $($($but: _,)*)? } = self;
                $($crate::state::Stateful::save($field, into);)*
                $($($crate::state::Parts::save_parts($part, into);)*)?
                $($($crate::state::Bits::save_bits($bits, into);)*)?
            }

            fn resume(
                &mut self,
                from: &mut $crate::state::StateReader<'_>,
            ) -> Result<(), $crate::state::StateError> {
                let Self { $($field,)* $($($part,)*)? $($($bits,)*)? $($($but: _,)*)? } = self;
                $($crate::state::Stateful::resume($field, from)?;)*
                $($($crate::state::Parts::resume_parts($part, from)?;)*)?
                $($(*$bits = $crate::state::Bits::read_bits(from)?;)*)?
                $(
                    let $it = &*self;
                    if !$sound {
                        return Err($crate::state::StateError::Unsound { what: stringify!($type) });
                    }
                )?
                Ok(())
            }
        }
    };
}

/// A type of which all is state: its fields, and those that are `bits`. `sound` is what holds for every value.
macro_rules! whole {
    (
        $type:ty { $($field:ident),* $(,)? }
        $(bits { $($bits:ident),* $(,)? })?
        $(sound |$it:ident| $sound:expr)?
    ) => {
        $crate::state::state! {
            $type { $($field),* }
            $(bits { $($bits),* })?
            $(sound |$it| $sound)?
        }

        impl $crate::state::Whole for $type {
            fn read(
                from: &mut $crate::state::StateReader<'_>,
            ) -> Result<Self, $crate::state::StateError> {
                let read = Self {
                    $($field: $crate::state::Whole::read(from)?,)*
                    $($($bits: $crate::state::Bits::read_bits(from)?,)*)?
                };
                $(
                    let $it = &read;
                    if !$sound {
                        return Err($crate::state::StateError::Unsound { what: stringify!($type) });
                    }
                )?
                Ok(read)
            }
        }
    };
}

/// A type that is one of these, without data.
macro_rules! choice {
    ($type:ty { $($variant:ident),* $(,)? }) => {
        impl $crate::state::Stateful for $type {
            const SHAPE: u64 = {
                use $crate::state::*;
                let shape = shape_of_name(stringify!($type));
                $(let shape = shape_of_both(shape, shape_of_name(stringify!($variant)));)*
                shape
            };

            fn save(&self, into: &mut $crate::state::StateWriter) {
                let number = match self {
                    $(Self::$variant => Self::$variant as u8,)*
                };
                into.put([number]);
            }

            fn resume(
                &mut self,
                from: &mut $crate::state::StateReader<'_>,
            ) -> Result<(), $crate::state::StateError> {
                *self = $crate::state::Whole::read(from)?;
                Ok(())
            }
        }

        impl $crate::state::Whole for $type {
            fn read(
                from: &mut $crate::state::StateReader<'_>,
            ) -> Result<Self, $crate::state::StateError> {
                let [number] = from.take()?;
                let all = [$(Self::$variant),*];
                let found = all.into_iter().find(|one| match one {
                    $(Self::$variant => number == Self::$variant as u8,)*
                });
                found.ok_or($crate::state::StateError::Unsound { what: stringify!($type) })
            }
        }
    };
}

pub(crate) use {choice, state, whole};
