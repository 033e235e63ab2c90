//! Evidence that rod and oil have parted in the direction of a fault, weighed over windows of every width.
//!
//! With h the directions of a block, r what is left, G = Σ h r and W = Σ h hᵀ over a window of n blocks, and m the
//! column of W of the direction that is tried: C = n Ω + W Λ Wᵀ, θ̂ = mᵀC⁻¹G / mᵀC⁻¹m, and the evidence is
//! (|θ̂| − ε)² mᵀC⁻¹m / 2. Λ holds what else may have changed without being a fault. Both transducers have to say the
//! same: what only one of them says is its own.

use super::super::evidence::{RESTART, in_turn};
use super::super::parameters::{DIRECTIONS, ProcessParameters};
use super::directions::{CANDIDATES, Direction, FAULTS, HALF, upper};
use super::{FlowBlock, FlowDesign};
use crate::sequential::statistic::Peak;
use crate::sequential::windows::Sums;
use crate::state::state;
use nalgebra::{SMatrix, SVector};

type Matrix = SMatrix<f64, DIRECTIONS, DIRECTIONS>;
type Vector = SVector<f64, DIRECTIONS>;

const P: &ProcessParameters = &ProcessParameters::DEFAULT;

/// Blocks that are held.
const MOST_BLOCKS: usize = 512;

/// Blocks between two turns.
const TURN: usize = 2;

/// Widths of the windows, blocks: from 1 s to a minute, at [`ProcessParameters::flow_block`].
const BLOCKS: [usize; 10] = [5, 8, 12, 20, 32, 50, 80, 120, 200, 300];

/// Values of a block that are summed: G of C1 and of C2, and the upper half of W.
const SUMMED: usize = 2 * DIRECTIONS + HALF;

/// By what evidence is weighed.
#[derive(Clone, Debug)]
pub struct FlowWeighing {
    /// Ω of C1 and of C2, and the upper half of its inverse, row by row, what is beside the diagonal twice: by these alone
    /// a square is half as long a sum.
    scatter: [Matrix; 2],
    inverse: [[f64; HALF]; 2],
}

impl FlowWeighing {
    /// For the scatter of `design`; `None` if that is no covariance.
    pub fn new(design: &FlowDesign) -> Option<Self> {
        let scatter = design.scatter.map(|rows| Matrix::from_fn(|i, j| rows[i][j]));
        let [one, two] = scatter.map(|it| it.cholesky().map(|it| half(&it.inverse())));
        Some(Self { scatter, inverse: [one?, two?] })
    }

    /// Whether any direction can have that much evidence: with Λ there is less than Gᵀ(nΩ)⁻¹G / 2, by Cauchy-Schwarz.
    fn may_reach(&self, sums: &[f64; SUMMED], width: usize, nats: f64) -> bool {
        self.inverse.iter().zip([0, DIRECTIONS]).all(|(inverse, from)| {
            let products = &sums[from..from + DIRECTIONS];
            let (mut square, mut row) = (0.0, &inverse[..]);
            for i in 0..DIRECTIONS {
                let (here, next) = row.split_at(DIRECTIONS - i);
                let along = here.iter().zip(&products[i..]).fold(0.0, |sum, (a, b)| sum + a * b);
                square += along * products[i];
                row = next;
            }
            square > 2.0 * nats * width as f64
        })
    }

    /// C with all of Λ for one transducer, factored, and C⁻¹G.
    fn factor(&self, window: &Window, transducer: usize) -> Option<Factor> {
        let Window { count, products, squares } = window;
        let mut covariance = self.scatter[transducer] * *count;
        for (i, j) in upper() {
            let doubt = (0..DIRECTIONS)
                .fold(0.0, |sum, k| sum + squares[(i, k)] * TOLERANCES[k] * squares[(k, j)]);
            covariance[(i, j)] += doubt;
            covariance[(j, i)] = covariance[(i, j)];
        }
        let lower = covariance.cholesky()?;
        let solution = lower.solve(&products[transducer]);
        Some(Factor { lower: lower.unpack(), solution })
    }
}

/// The upper half of a symmetric matrix, row by row, with what is beside the diagonal twice.
fn half(matrix: &Matrix) -> [f64; HALF] {
    let mut half = [0.0; HALF];
    for (value, (i, j)) in half.iter_mut().zip(upper()) {
        *value = if i == j { matrix[(i, j)] } else { 2.0 * matrix[(i, j)] };
    }
    half
}

/// What the hydraulics have, by the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowKind {
    pub direction: Direction,
    /// In the unit of the direction.
    pub size: f64,
}

/// The newest blocks.
#[derive(Clone, Debug, Default)]
pub struct FlowWindows {
    sums: Sums<MOST_BLOCKS, SUMMED, RESTART>,
}

state! { FlowWindows { sums } }

/// Sums over a window.
struct Window {
    count: f64,
    /// G of C1 and of C2.
    products: [Vector; 2],
    /// W.
    squares: Matrix,
}

/// L of C = L Lᵀ for one transducer, and C⁻¹G.
struct Factor {
    lower: Matrix,
    solution: Vector,
}

/// mᵀC⁻¹m and mᵀC⁻¹G for one direction.
struct Solved {
    weight: f64,
    product: f64,
}

/// Λ.
const TOLERANCES: [f64; DIRECTIONS] = {
    let mut squares = P.flow_tolerances;
    let mut i = 0;
    while i < DIRECTIONS {
        squares[i] *= squares[i];
        i += 1;
    }
    squares
};

impl FlowWindows {
    pub const fn clear(&mut self) {
        self.sums.clear();
    }

    /// Number of blocks that are held.
    pub fn held(&self) -> usize {
        self.sums.held()
    }

    /// Takes a block; nothing that is not finite, which no sum would ever forget.
    pub fn push(&mut self, block: &FlowBlock) {
        let FlowBlock { left, directions, .. } = block;
        // Of one that is not finite no sum is.
        if !left.iter().chain(directions).sum::<f64>().is_finite() {
            return;
        }
        let mut values = [0.0; SUMMED];
        for (i, direction) in directions.iter().enumerate() {
            values[i] = direction * left[0];
            values[DIRECTIONS + i] = direction * left[1];
        }
        for (value, (i, j)) in values[2 * DIRECTIONS..].iter_mut().zip(upper()) {
            *value = directions[i] * directions[j];
        }
        self.sums.push(values);
    }

    /// The window with the most evidence of a fault, if it is more than `least`, nats; its width is in blocks.
    pub fn peak(&self, by: &FlowWeighing, least: f64) -> Peak {
        self.among(by, least, &BLOCKS)
    }

    /// The same of the widths whose turn it is, at every second block: as
    /// [`super::super::EvidenceWindows::peaks_in_turn`].
    pub fn peak_in_turn(&self, by: &FlowWeighing, least: f64) -> Peak {
        let count = self.sums.count();
        if !count.is_multiple_of(TURN) {
            return Peak::default();
        }
        self.among(by, least, &BLOCKS[..in_turn(count / TURN).min(BLOCKS.len())])
    }

    fn among(&self, by: &FlowWeighing, least: f64, widths: &[usize]) -> Peak {
        let mut peak = Peak { nats: least, width: 0 };
        for &width in widths {
            let Some(sums) = self.sums.over(width) else { break };
            if !by.may_reach(&sums, width, peak.nats) {
                continue;
            }
            let window = Window::new(&sums, width);
            let factors = [0, 1].map(|i| by.factor(&window, i));
            let [Some(one), Some(two)] = factors else { continue };
            for direction in FAULTS {
                let nats = evidence([&one, &two], &window, direction);
                if nats > peak.nats {
                    peak = Peak { nats, width };
                }
            }
        }
        if peak.width == 0 { Peak::default() } else { peak }
    }

    /// What explains the newest `width` blocks best; `None` if there are not so many.
    pub fn kind(&self, by: &FlowWeighing, width: usize) -> Option<FlowKind> {
        let window = Window::new(&self.sums.over(width)?, width);
        let factors = [by.factor(&window, 0)?, by.factor(&window, 1)?];
        let explained = |direction: Direction| {
            let [one, two] = [0, 1].map(|i| factors[i].along(&window, direction));
            let [one, two] = [one?, two?].map(|it| it.product * it.product / it.weight);
            let size = size(&factors, &window, direction)?;
            let can_be = size > 0.0 || !direction.is_leakage();
            can_be.then_some((one + two, FlowKind { direction, size }))
        };
        let best = CANDIDATES.into_iter().filter_map(explained);
        best.max_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, kind)| kind)
    }

    /// Size of a fault in `direction` by the newest `width` blocks alone; `None` if there are not so many.
    pub fn size(&self, by: &FlowWeighing, width: usize, direction: Direction) -> Option<f64> {
        let window = Window::new(&self.sums.over(width)?, width);
        let factors = [by.factor(&window, 0)?, by.factor(&window, 1)?];
        size(&factors, &window, direction)
    }
}

impl Window {
    fn new(sums: &[f64; SUMMED], width: usize) -> Self {
        let mut squares = Matrix::zeros();
        for (value, (i, j)) in sums[2 * DIRECTIONS..].iter().zip(upper()) {
            squares[(i, j)] = *value;
            squares[(j, i)] = *value;
        }
        let products = [0, DIRECTIONS].map(|from| Vector::from_fn(|i, _| sums[from + i]));
        Self { count: width as f64, products, squares }
    }

    /// Whether the spool was near its middle for as much as so many blocks: a few of them may say anything.
    fn has_edges(&self) -> bool {
        let square = |direction: Direction| self.squares[(direction as usize, direction as usize)];
        self.count * square(Direction::ValveLeakage) >= P.edges_least * square(Direction::Leakage)
    }
}

impl Factor {
    /// mᵀC⁻¹m and mᵀC⁻¹G with all of Λ; `None` for a direction that did not occur.
    fn along(&self, window: &Window, direction: Direction) -> Option<Solved> {
        if direction == Direction::ValveLeakage && !window.has_edges() {
            return None;
        }
        let along: Vector = window.squares.column(direction as usize).into_owned();
        let product = along.dot(&self.solution);
        let weight = self.lower.solve_lower_triangular(&along)?.norm_squared();
        (weight > f64::MIN_POSITIVE && product.is_finite()).then_some(Solved { weight, product })
    }
}

impl Solved {
    /// The same without the direction's own part of Λ, which is C − λ m mᵀ: by Sherman and Morrison, both grow alike.
    fn alone(&self, direction: Direction) -> Self {
        let left = 1.0 - TOLERANCES[direction as usize] * self.weight;
        let by = 1.0 / left.max(f64::EPSILON);
        Self { weight: self.weight * by, product: self.product * by }
    }
}

/// Size of a fault in `direction` by both transducers.
fn size(factors: &[Factor; 2], window: &Window, direction: Direction) -> Option<f64> {
    let [one, two] = factors.each_ref().map(|it| it.along(window, direction));
    let (one, two) = (one?.alone(direction), two?.alone(direction));
    Some((one.product + two.product) / (one.weight + two.weight))
}

/// Evidence of a fault in `direction`, nats: that of the transducer with less of it, if both say the same.
fn evidence(factors: [&Factor; 2], window: &Window, direction: Direction) -> f64 {
    let band = P.flow_bands[direction as usize];
    let [one, two] = factors.map(|factor| {
        let Solved { weight, product } = factor.along(window, direction)?.alone(direction);
        let beyond = (product / weight).abs() - band;
        let nats = if beyond > 0.0 { 0.5 * beyond * beyond * weight } else { 0.0 };
        Some((nats, product > 0.0))
    });
    match (one, two) {
        (Some((one, up)), Some((two, too))) if up == too => one.min(two),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::Curve;

    /// Standard deviation of a block's residual along each direction, and what a direction adds to a block.
    const SIGMA: f64 = 2e-5;
    const WAY: f64 = 0.2;

    fn weighing() -> FlowWeighing {
        let scatter = core::array::from_fn(|i| {
            core::array::from_fn(|j| if i == j { SIGMA * SIGMA } else { 0.0 })
        });
        let design = FlowDesign {
            limit: 50.0,
            curve: Curve::new(50.0, alloc::vec![-0.5, 0.5]),
            taught: alloc::vec![true],
            between: 0.5,
            leakage: 0.0,
            compression: 0.0,
            area_ratio: 0.5,
            supplies: [0.0, f64::INFINITY],
            scatter: [scatter; 2],
        };
        FlowWeighing::new(&design).expect("it is a covariance")
    }

    /// `count` blocks in which each transducer shows a fault of this size, and the other directions swing.
    fn windows(count: usize, direction: Direction, sizes: [f64; 2]) -> FlowWindows {
        let mut windows = FlowWindows::default();
        for k in 0..count {
            let directions = core::array::from_fn(|i| {
                let sign = if k / (i + 1) % 2 == 0 { 1.0 } else { -1.0 };
                WAY * if i == direction as usize { 1.0 } else { sign }
            });
            windows.push(&FlowBlock {
                left: sizes.map(|size| size * WAY),
                directions,
                parted: None,
            });
        }
        windows
    }

    #[test]
    fn the_nats_are_those_of_the_formula_where_nothing_else_moves() {
        let mut windows = FlowWindows::default();
        for _ in 0..50 {
            let directions = [WAY, 0.0, 0.0, 0.0, 0.0, 0.0];
            windows.push(&FlowBlock { left: [1e-3 * WAY, 1.2e-3 * WAY], directions, parted: None });
        }
        let peak = windows.peak(&weighing(), 1.0);
        // The one of 1 mm/s, 0.2 mm/s beyond what is no fault.
        let expected = (1e-3_f64 - 0.8e-3).powi(2) * 50.0 * WAY.powi(4) / (2.0 * SIGMA * SIGMA);
        assert_eq!(peak.width, 50);
        assert!((peak.nats / expected - 1.0).abs() < 1e-9, "{peak:?}, {expected}");
        assert_eq!(windows.peak(&weighing(), 1.1 * expected), Peak::default());
    }

    #[test]
    fn what_one_transducer_says_alone_is_no_fault_of_the_hydraulics() {
        for sizes in [[5e-3, 0.0], [0.0, 5e-3], [5e-3, -5e-3]] {
            let windows = windows(100, Direction::Leakage, sizes);
            assert_eq!(windows.peak(&weighing(), 1.0), Peak::default(), "{sizes:?}");
        }
        let both = windows(100, Direction::Leakage, [5e-3; 2]);
        assert!(both.peak(&weighing(), 1.0).nats > 20.0);
    }

    #[test]
    fn each_direction_is_told_from_the_others_with_its_size() {
        for direction in FAULTS {
            let signs: &[f64] = if direction.is_leakage() { &[1.0] } else { &[1.0, -1.0] };
            for size in signs.iter().map(|sign| 4e-3 * sign) {
                let windows = windows(120, direction, [size; 2]);
                let kind = windows.kind(&weighing(), 120).expect("there are so many");
                assert_eq!(kind.direction, direction);
                assert!((kind.size / size - 1.0).abs() < 0.1, "{kind:?}");
            }
        }
    }

    #[test]
    fn nothing_spoils_the_sums_for_good() {
        let mut spoilt = windows(10, Direction::Null, [0.0; 2]);
        spoilt.push(&FlowBlock {
            left: [f64::NAN, 0.0],
            directions: [WAY; DIRECTIONS],
            parted: None,
        });
        spoilt.push(&FlowBlock {
            left: [0.0; 2],
            directions: [f64::INFINITY; DIRECTIONS],
            parted: None,
        });
        assert_eq!(spoilt.held(), 10);
    }
}
