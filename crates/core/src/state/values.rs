//! How numbers, lists and the like are saved.

use super::{
    Bits, Parts, StateError, StateReader, StateWriter, Stateful, Whole, shape_of_both,
    shape_of_name,
};
use alloc::boxed::Box;
use alloc::vec::Vec;
use nalgebra::SMatrix;

/// The least count that is refused: at a million frames a second it takes two thousand years.
pub const MOST_COUNTED: u64 = 1 << 56;

/// Numbers of which every pattern of bits is one.
macro_rules! numbers {
    ($($number:ident),*) => {$(
        impl Stateful for $number {
            const SHAPE: u64 = shape_of_name(stringify!($number));

            #[inline]
            fn save(&self, into: &mut StateWriter) {
                into.put(self.to_le_bytes());
            }

            #[inline]
            fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
                *self = Self::read(from)?;
                Ok(())
            }
        }

        impl Whole for $number {
            #[inline]
            fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
                from.take().map(Self::from_le_bytes)
            }
        }
    )*};
}

numbers!(u8, u16, u32, i32, i64, f64);

/// What is saved as another value: by the first function, and read by the second.
macro_rules! as_another {
    ($type:ty as $other:ty, $to:expr, $from:expr) => {
        impl Stateful for $type {
            const SHAPE: u64 = shape_of_both(shape_of_name(stringify!($type)), <$other>::SHAPE);

            fn save(&self, into: &mut StateWriter) {
                let to: fn(&Self) -> $other = $to;
                to(self).save(into);
            }

            fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
                *self = Self::read(from)?;
                Ok(())
            }
        }

        impl Whole for $type {
            fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
                let of: fn($other) -> Option<Self> = $from;
                let what = stringify!($type);
                of(<$other>::read(from)?).ok_or(StateError::Unsound { what })
            }
        }
    };
}

as_another!(bool as u8, |it| u8::from(*it), |it| (it < 2).then_some(it == 1));
as_another!(u64 as i64, |it| *it as i64, |it| count(it));
as_another!(usize as i64, |it| *it as i64, |it| count(it).and_then(|it| it.try_into().ok()));

fn count(number: i64) -> Option<u64> {
    u64::try_from(number).ok().filter(|count| *count < MOST_COUNTED)
}

impl Bits for u64 {
    const SHAPE: u64 = shape_of_name("bits");

    fn save_bits(&self, into: &mut StateWriter) {
        into.put(self.to_le_bytes());
    }

    fn read_bits(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        from.take().map(Self::from_le_bytes)
    }
}

impl<T: Bits> Bits for Option<T> {
    const SHAPE: u64 = shape_of_both(shape_of_name("Option"), T::SHAPE);

    fn save_bits(&self, into: &mut StateWriter) {
        self.is_some().save(into);
        if let Some(bits) = self {
            bits.save_bits(into);
        }
    }

    fn read_bits(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        if bool::read(from)? { T::read_bits(from).map(Some) } else { Ok(None) }
    }
}

impl<T: Whole> Stateful for Option<T> {
    const SHAPE: u64 = shape_of_both(shape_of_name("Option"), T::SHAPE);

    fn save(&self, into: &mut StateWriter) {
        self.is_some().save(into);
        if let Some(value) = self {
            value.save(into);
        }
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl<T: Whole> Whole for Option<T> {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        if bool::read(from)? { T::read(from).map(Some) } else { Ok(None) }
    }
}

impl<T: Stateful, const N: usize> Stateful for [T; N] {
    const SHAPE: u64 = shape_of_both(N as u64, T::SHAPE);

    #[inline]
    fn save(&self, into: &mut StateWriter) {
        self.iter().for_each(|value| value.save(into));
    }

    #[inline]
    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        self.iter_mut().try_for_each(|value| value.resume(from))
    }
}

impl<T: Whole, const N: usize> Whole for [T; N] {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let mut read = [const { None }; N];
        for place in &mut read {
            *place = Some(T::read(from)?);
        }
        Ok(read.map(|value| value.expect("each was read")))
    }
}

impl<T: Stateful> Stateful for Box<T> {
    const SHAPE: u64 = T::SHAPE;

    fn save(&self, into: &mut StateWriter) {
        (**self).save(into);
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        (**self).resume(from)
    }
}

impl<T: Whole> Stateful for Vec<T> {
    const SHAPE: u64 = shape_of_both(shape_of_name("Vec"), T::SHAPE);

    fn save(&self, into: &mut StateWriter) {
        self.len().save(into);
        self.iter().for_each(|value| value.save(into));
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        *self = Self::read(from)?;
        Ok(())
    }
}

impl<T: Whole> Whole for Vec<T> {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let count = usize::read(from)?;
        // Nothing is reserved for them: a count that is wrong ends with the bytes.
        let mut values = Self::new();
        for _ in 0..count {
            values.push(T::read(from)?);
        }
        Ok(values)
    }
}

impl<const R: usize, const C: usize> Stateful for SMatrix<f64, R, C> {
    const SHAPE: u64 = shape_of_both(R as u64, shape_of_both(C as u64, f64::SHAPE));

    fn save(&self, into: &mut StateWriter) {
        self.iter().for_each(|value| value.save(into));
    }

    fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        self.iter_mut().try_for_each(|value| value.resume(from))
    }
}

impl<const R: usize, const C: usize> Whole for SMatrix<f64, R, C> {
    fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
        let mut matrix = Self::zeros();
        matrix.resume(from)?;
        Ok(matrix)
    }
}

/// Values side by side.
macro_rules! tuples {
    ($(($($name:ident)*))*) => {$(
        impl<$($name: Whole),*> Stateful for ($($name,)*) {
            const SHAPE: u64 = {
                let shape = shape_of_name("tuple");
                $(let shape = shape_of_both(shape, $name::SHAPE);)*
                shape
            };

            #[expect(non_snake_case, reason = "the types' names are those of the values")]
            fn save(&self, into: &mut StateWriter) {
                let ($($name,)*) = self;
                $($name.save(into);)*
            }

            fn resume(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
                *self = Self::read(from)?;
                Ok(())
            }
        }

        impl<$($name: Whole),*> Whole for ($($name,)*) {
            fn read(from: &mut StateReader<'_>) -> Result<Self, StateError> {
                Ok(($($name::read(from)?,)*))
            }
        }
    )*};
}

tuples! { (A B) (A B C D) }

impl<T: Stateful> Parts for Option<T> {
    const SHAPE: u64 = shape_of_both(shape_of_name("part"), T::SHAPE);

    fn save_parts(&self, into: &mut StateWriter) {
        save_each(self.iter(), into);
    }

    fn resume_parts(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        resume_each(self.iter_mut(), from)
    }
}

impl<T: Stateful> Parts for Vec<T> {
    const SHAPE: u64 = shape_of_both(shape_of_name("parts"), T::SHAPE);

    fn save_parts(&self, into: &mut StateWriter) {
        save_each(self.iter(), into);
    }

    fn resume_parts(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        resume_each(self.iter_mut(), from)
    }
}

impl<T: Stateful> Parts for Box<[T]> {
    const SHAPE: u64 = shape_of_both(shape_of_name("parts"), T::SHAPE);

    fn save_parts(&self, into: &mut StateWriter) {
        save_each(self.iter(), into);
    }

    fn resume_parts(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        resume_each(self.iter_mut(), from)
    }
}

impl<T: Parts, const N: usize> Parts for [T; N] {
    const SHAPE: u64 = shape_of_both(N as u64, T::SHAPE);

    fn save_parts(&self, into: &mut StateWriter) {
        self.iter().for_each(|parts| parts.save_parts(into));
    }

    fn resume_parts(&mut self, from: &mut StateReader<'_>) -> Result<(), StateError> {
        self.iter_mut().try_for_each(|parts| parts.resume_parts(from))
    }
}

fn save_each<'a, T: Stateful + 'a>(
    parts: impl ExactSizeIterator<Item = &'a T>,
    into: &mut StateWriter,
) {
    parts.len().save(into);
    parts.for_each(|part| part.save(into));
}

fn resume_each<'a, T: Stateful + 'a>(
    mut parts: impl ExactSizeIterator<Item = &'a mut T>,
    from: &mut StateReader<'_>,
) -> Result<(), StateError> {
    if usize::read(from)? != parts.len() {
        return Err(StateError::Parts { what: core::any::type_name::<T>() });
    }
    parts.try_for_each(|part| part.resume(from))
}
