use super::*;
use nalgebra::Vector3;
use std::vec::Vec;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Colour {
    Red,
    Blue = 7,
}

choice! { Colour { Red, Blue } }

#[derive(Clone, Debug, PartialEq)]
struct Leaf {
    number: f64,
    pattern: u64,
    colours: Option<(Colour, [u8; 3])>,
}

whole! {
    Leaf { number, colours }
    bits { pattern }
    sound |it| it.number != 13.0
}

#[derive(Clone, Debug, PartialEq)]
struct Tree<const N: usize> {
    table: Vec<f64>,
    ring: [i64; N],
    next: usize,
    leaves: Vec<Leaf>,
    twigs: Vec<[u32; 2]>,
    bud: Option<Leaf>,
}

state! {
    Tree<N> [const N: usize] { ring, next, leaves }
    parts { twigs, bud }
    but { table }
    sound |it| it.next < N
}

fn leaf(number: f64) -> Leaf {
    Leaf { number, pattern: u64::MAX, colours: Some((Colour::Blue, [1, 2, 255])) }
}

fn tree() -> Tree<3> {
    Tree {
        table: vec![1.0],
        ring: [i64::MIN, -1, i64::MAX],
        next: 2,
        leaves: vec![leaf(-0.0), Leaf { colours: None, ..leaf(f64::NEG_INFINITY) }],
        twigs: vec![[0, u32::MAX]],
        bud: Some(leaf(1e-310)),
    }
}

/// Another tree of the same design.
fn sapling() -> Tree<3> {
    let (leaves, twigs, bud) = (Vec::new(), vec![[5; 2]], Some(leaf(0.0)));
    Tree { table: vec![1.0], ring: [0; 3], next: 0, leaves, twigs, bud }
}

fn saved(value: &impl Stateful) -> Vec<u8> {
    let mut writer = StateWriter::default();
    value.save(&mut writer);
    writer.finish()
}

fn resumed<T: Stateful>(mut value: T, bytes: &[u8]) -> Result<T, StateError> {
    let mut reader = StateReader::new(bytes);
    value.resume(&mut reader)?;
    reader.finish().map(|()| value)
}

#[test]
fn what_is_taken_up_is_what_was_saved_and_the_design_stays() {
    let planted = Tree { table: vec![2.0, 3.0], ..sapling() };
    let grown = resumed(planted, &saved(&tree())).expect("it is of the same design");
    assert_eq!(grown, Tree { table: vec![2.0, 3.0], ..tree() });
    assert_eq!(saved(&grown), saved(&tree()));
}

#[test]
fn numbers_are_the_same_bit_by_bit() {
    let quiet = f64::from_bits(0x7FF8_0000_DEAD_BEEF);
    for number in [0.0, -0.0, f64::MIN_POSITIVE / 3.0, f64::MAX, f64::INFINITY, f64::NAN, -quiet] {
        let read = resumed(1.0, &saved(&number)).map(f64::to_bits);
        assert_eq!(read, Ok(number.to_bits()));
    }
    let vector = Vector3::new(quiet, -0.0, 1.0);
    let read = resumed(Vector3::zeros(), &saved(&vector)).expect("it is a vector");
    assert_eq!(read.map(f64::to_bits), vector.map(f64::to_bits));
}

#[test]
fn what_is_too_short_too_long_or_impossible_is_refused() {
    let bytes = saved(&tree());
    for length in 0..bytes.len() {
        assert_eq!(resumed(sapling(), &bytes[..length]), Err(StateError::Short), "{length}");
    }
    assert_eq!(resumed(sapling(), &[&bytes[..], &[0]].concat()), Err(StateError::Long));
    let refused = |changed: Tree<3>, what| {
        assert_eq!(resumed(sapling(), &saved(&changed)), Err(StateError::Unsound { what }));
    };
    refused(Tree { next: 3, ..tree() }, "Tree<N>");
    refused(Tree { next: MOST_COUNTED as usize, ..tree() }, "usize");
    refused(Tree { leaves: vec![leaf(13.0)], ..tree() }, "Leaf");
    let other = Tree { twigs: Vec::new(), ..sapling() };
    assert!(matches!(resumed(other, &bytes), Err(StateError::Parts { .. })));
    let bare = Tree { bud: None, ..sapling() };
    assert!(matches!(resumed(bare, &bytes), Err(StateError::Parts { .. })));
}

#[test]
fn whatever_the_bytes_are_reading_ends() {
    let bytes = saved(&tree());
    for place in 0..bytes.len() {
        for value in [0, 1, 2, 0x7F, 0x80, 0xFF] {
            let mut changed = bytes.clone();
            changed[place] = value;
            if let Ok(read) = resumed(sapling(), &changed) {
                assert_eq!(saved(&read), changed, "{place}");
            }
        }
    }
}

/// Types that differ in one thing from `A { x: u32, y: f64 }`.
mod others {
    use super::*;

    macro_rules! declare {
        ($($module:ident: $kind:ident { $($field:ident: $type:ty),* } as $($order:ident),*;)*) => {$(
            pub mod $module {
                use super::*;

                pub struct $kind { $($field: $type),* }

                state! { $kind { $($order),* } }
            }
        )*};
    }

    declare! {
        same: A { x: u32, y: f64 } as x, y;
        again: A { x: u32, y: f64 } as x, y;
        turned: A { x: u32, y: f64 } as y, x;
        named: A { x: u32, z: f64 } as x, z;
        called: B { x: u32, y: f64 } as x, y;
        typed: A { x: u32, y: Option<f64> } as x, y;
        longer: A { x: u32, y: [f64; 1] } as x, y;
        grown: A { x: u32, y: f64, z: u8 } as x, y, z;
    }
}

#[test]
fn a_shape_tells_names_types_and_order() {
    use others::*;
    let shape = same::A::SHAPE;
    assert_eq!(shape, again::A::SHAPE);
    let others = [turned::A::SHAPE, named::A::SHAPE, called::B::SHAPE];
    let more = [typed::A::SHAPE, longer::A::SHAPE, grown::A::SHAPE];
    assert!(others.into_iter().chain(more).all(|other| other != shape));
}
