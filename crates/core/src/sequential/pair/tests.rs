use super::super::drive::FEATURES;
use super::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

const TS: f64 = 0.02;
const SIGMA: f64 = 7e-5;

/// The rod goes as fast as the command of this cycle says.
fn ideal() -> Drive {
    let mut coefficients = [0.0; FEATURES];
    coefficients[0] = 1.0;
    Drive(coefficients)
}

fn design() -> PairDesign {
    let (deviation, parameters) = (SIGMA * 2.0_f64.sqrt(), &SequentialParameters::DEFAULT);
    PairDesign::new(ideal(), TS, deviation, Prediction::UNKNOWN, parameters)
        .expect("there is a gain")
}

/// A rod that follows its command, read with noise and `fault`s from cycle 200 to 210.
fn follow(seed: u64, fault: impl Fn(usize, f64) -> [f64; 2]) -> Pair {
    followed(seed, 210, fault)
}

/// The same until cycle `end`.
fn followed(seed: u64, end: usize, fault: impl Fn(usize, f64) -> [f64; 2]) -> Pair {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let mut pair = Pair::new(design());
    let mut length = 0.0;
    for k in 0..=end {
        let u = 0.3 * (k as f64 * 0.02).sin();
        let wild = normal();
        let faults = if k < 200 { [0.0; 2] } else { fault(k - 200, wild) };
        pair.step(Some(faults.map(|fault| length + fault + SIGMA * normal())), Some(u));
        length += TS * u;
    }
    pair
}

#[test]
fn the_transducer_that_steps_is_told() {
    for seed in 0..20 {
        for size in [5e-4, -5e-4] {
            let one =
                follow(seed, |_, _| [size, 0.0]).compare(Form::Step, 10, 13).expect("it follows");
            assert!(one > 5.0, "{seed}: {one:?}");
            let two =
                follow(seed, |_, _| [0.0, size]).compare(Form::Step, 10, 13).expect("it follows");
            assert!(two < -5.0, "{seed}: {two:?}");
        }
    }
}

/// A rod whose valve swings about what the command says, for several cycles each time; C2 steps by
/// 0.5 mm in the end.
fn swinging(seed: u64, design: PairDesign, cycles: usize, mut see: impl FnMut(&Pair)) -> Pair {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
    let (mut pair, mut length) = (Pair::new(design), 0.0);
    let mut swings = [0.0; 2];
    for k in 0..=cycles + 10 {
        let fault = if k < cycles { 0.0 } else { 5e-4 };
        let lengths = [length + SIGMA * normal(), length + fault + SIGMA * normal()];
        pair.step(Some(lengths), Some(0.0));
        if k < cycles {
            see(&pair);
        }
        swings = [1.3 * swings[0] - 0.75 * swings[1] + 6e-5 * normal(), swings[0]];
        length += swings[0];
    }
    pair
}

#[test]
fn errors_of_the_command_that_go_on_are_counted_once() {
    let mut sums = Vec::new();
    swinging(1, design(), 20_000, |pair| {
        sums.extend(pair.newest().map(|[n1, n2]| n1 + n2));
    });
    let product = |apart: usize| -> f64 {
        sums.iter().zip(&sums[apart..]).map(|(one, other)| one * other).sum()
    };
    let deviation = libm::sqrt(product(0) / sums.len() as f64 / 2.0);
    let whitening = Whitening::of(&core::array::from_fn(|k| product(k + 1) / product(0)))
        .expect("there are such errors");
    let told = |whitening: Option<Whitening>| {
        let prediction = Prediction { deviation, whitening };
        let design = PairDesign::new(
            ideal(),
            TS,
            SIGMA * 2.0_f64.sqrt(),
            prediction,
            &SequentialParameters::DEFAULT,
        )
        .expect("there is a gain");
        let nats = |seed: u64| {
            let pair = swinging(seed, design.clone(), 200, |_| ());
            pair.compare(Form::Step, 10, 13).expect("it follows") / pair.decided()
        };
        let all: Vec<f64> = (100..300).map(nats).collect();
        [all.iter().filter(|it| **it < -1.0).count(), all.iter().filter(|it| **it > 1.0).count()]
    };
    let [[right, wrong], [by_white, wrong_by_white]] = [Some(whitening), None].map(told);
    assert!(
        right >= 175 && wrong <= 2 && by_white < 150,
        "{right} right, {wrong} wrong of 200; {by_white} and {wrong_by_white} where each counts"
    );
}

#[test]
fn the_transducer_that_is_noisy_is_told() {
    for seed in 0..20 {
        let one = followed(seed, 225, |_, wild| [4e-4 * wild, 0.0]).energy(26);
        assert!(one.is_some_and(|nats| nats > 6.0), "{seed}: {one:?}");
        let two = followed(seed, 225, |_, wild| [0.0, 4e-4 * wild]).energy(26);
        assert!(two.is_some_and(|nats| nats < -6.0), "{seed}: {two:?}");
    }
}

/// Two that are noisy alike, as coarser ones in the place of both: it is neither alone.
#[test]
fn two_noisy_transducers_are_nobodys_noise() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let others: Vec<f64> = StandardNormal.sample_iter(&mut rng).take(400).collect();
    let decided = |cycles: usize| {
        let both = (0..200).filter(|seed| {
            let other = |age: usize| others[age + *seed as usize];
            let noises = |age, wild| [4e-4 * wild, 4e-4 * other(age)];
            let nats = followed(*seed, 199 + cycles, noises).energy(cycles);
            nats.expect("it follows").abs() > 6.0
        });
        both.count()
    };
    let decided = [11, 26, 50].map(decided);
    assert!(decided.iter().all(|decided| *decided < 8), "{decided:?} of 200");
}

/// Of a difference that is no more than healthy nobody is the cause, whatever the rod does.
#[test]
fn healthy_innovations_are_nobodys_noise() {
    for seed in 0..50 {
        for moved in [0.0, 2e-3] {
            let pair = follow(seed, |age, _| [moved * (age as f64).cos(); 2]);
            let nats = pair.energy(40).expect("it follows");
            assert!(nats.abs() < 4.0, "{seed} {moved}: {nats}");
        }
    }
}

#[test]
fn a_rod_that_moves_by_itself_blames_neither() {
    let evidence = follow(3, |_, _| [2e-3, 2e-3]).compare(Form::Step, 10, 13).expect("it follows");
    assert!(evidence.abs() < 5.0, "{evidence:?}");
}

#[test]
fn after_a_gap_nothing_is_compared() {
    let mut pair = follow(1, |_, _| [1e-3, 0.0]);
    pair.step(None, Some(0.0));
    assert_eq!(pair.compare(Form::Step, 10, 13), None);
    assert_eq!((pair.newest(), pair.energy(11)), (None, None));
}

/// Errors that nobody has measured count as if they were independent of each other, and prove too much.
#[test]
fn where_the_errors_are_not_known_it_takes_more_to_decide() {
    let prediction = Prediction { whitening: Some(Whitening::NONE), ..Prediction::UNKNOWN };
    let decided = |prediction: Prediction| {
        let deviation = SIGMA * 2.0_f64.sqrt();
        let parameters = &SequentialParameters::DEFAULT;
        let design = PairDesign::new(ideal(), TS, deviation, prediction, parameters);
        Pair::new(design.expect("there is a gain")).decided()
    };
    assert!(decided(Prediction::UNKNOWN) > decided(prediction));
}

/// After a gap there is nothing to compare until enough has been read again.
#[test]
fn what_was_read_before_a_reset_is_not_compared() {
    let mut pair = follow(1, |_, _| [5e-4, 0.0]);
    assert!(pair.compare(Form::Step, 10, 13).is_some());
    pair.reset();
    assert_eq!(pair.compare(Form::Step, 10, 13), None);
}
