//! The discrete model (4-1) of one cylinder, and its properties.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{
    Complex, Matrix2, Matrix2x3, Matrix3, RowVector3, SMatrix, SVD, Schur, Vector2, Vector3,
};

/// Output matrix C of an observer that reads position and velocity.
pub const POSITION_AND_VELOCITY: Matrix2x3<f64> = Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0);

/// Output matrix C of an observer that reads the position alone.
pub const POSITION: RowVector3<f64> = RowVector3::new(1.0, 0.0, 0.0);

/// Most rounds of the eigenvalue iteration; three are enough for these small matrices.
const EIGEN_ROUNDS: usize = 300;

/// Largest entry of A and C that is accepted. Table 4-1's is 11; squares beyond 1e308 would send
/// the balancing into an endless loop.
pub(super) const LARGEST: f64 = 1e12;

/// The model x(k+1) = A x(k) + B u(k) of equation (4-1), with the state x = (l, l̇, P_L) in m, m/s
/// and bar, and the control speed u as the input, in m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// State matrix A, 3×3.
    pub a: Matrix3<f64>,
    /// Input matrix B, 3×1.
    pub b: Vector3<f64>,
}

impl Model {
    /// The model for the sample time, s, and the parameters θ1..θ5 and γ1, γ2 as in Table 4-1.
    pub fn new(sample_time: f64, theta: [f64; 5], gamma: [f64; 2]) -> Self {
        let [t1, t2, t3, t4, t5] = theta;
        let a = Matrix3::new(1.0, sample_time, 0.0, t1, 1.0 + t2, t3, 0.0, t4, 1.0 + t5);
        Self { a, b: Vector3::new(0.0, gamma[0], gamma[1]) }
    }

    /// The eigenvalues of A, the largest modulus first; `None` if A holds an entry that is not
    /// finite or beyond 1e12.
    ///
    /// If all of them are inside the unit circle, the model is stable without an observer.
    pub fn poles(&self) -> Option<[Complex<f64>; 3]> {
        eigenvalues(&self.a)
    }

    /// Speed to which a constant command of 1 m/s settles; 1 in a well identified model.
    ///
    /// It follows from the velocity and pressure equations alone, because θ1 l is a slow pull back
    /// to the middle, with which every speed ends at zero, long after the command has changed.
    /// `None` where the two equations have no unique equilibrium.
    pub fn velocity_gain(&self) -> Option<f64> {
        let dynamics = self.a.fixed_view::<2, 2>(1, 1);
        let rest = Matrix2::identity() - dynamics;
        let gain = rest.lu().solve(&Vector2::new(self.b[1], self.b[2]))?[0];
        gain.is_finite().then_some(gain)
    }

    /// Whether the state is observable from the outputs y = `c` x.
    ///
    /// Without θ3 the load pressure affects nothing that is measured, and it is not.
    pub fn is_observable<const M: usize>(&self, c: &SMatrix<f64, M, 3>) -> bool {
        let pair = Balanced::new(&self.a, c);
        self.poles().is_some_and(|poles| poles.iter().all(|pole| pair.sees(*pole)))
    }
}

/// Whether all entries are finite and at most [`LARGEST`].
pub(super) fn is_usable<const M: usize>(m: &SMatrix<f64, M, 3>) -> bool {
    m.iter().all(|entry| entry.abs() <= LARGEST)
}

/// The eigenvalues of `a`, the largest modulus first; `None` if `a` is not usable (or if the
/// iteration does not end, which has not been seen).
pub(super) fn eigenvalues(a: &Matrix3<f64>) -> Option<[Complex<f64>; 3]> {
    if !is_usable(a) {
        return None;
    }
    // Bar beside metres makes entries of 1e-5 and 10; balanced, they lose no digits.
    let mut balanced = *a;
    balance_parlett_reinsch(&mut balanced);
    let (_, t) = Schur::try_new(balanced, f64::EPSILON, EIGEN_ROUNDS)?.unpack();
    // The triangle holds a 2×2 block where two eigenvalues are a conjugate pair, or so nearly equal
    // that rounding decides; nalgebra's own complex_eigenvalues answers NaN to the latter.
    let mut poles = match (t[(1, 0)] != 0.0, t[(2, 1)] != 0.0) {
        (false, false) => [t[(0, 0)].into(), t[(1, 1)].into(), t[(2, 2)].into()],
        (true, false) => with_pair(t[(2, 2)], t.fixed_view::<2, 2>(0, 0).into()),
        (false, true) => with_pair(t[(0, 0)], t.fixed_view::<2, 2>(1, 1).into()),
        (true, true) => return None,
    };
    poles.sort_by(|one, other| modulus(*other).total_cmp(&modulus(*one)));
    poles.iter().all(|pole| modulus(*pole).is_finite()).then_some(poles)
}

/// |z|
pub(super) fn modulus(z: Complex<f64>) -> f64 {
    libm::hypot(z.re, z.im)
}

/// A real eigenvalue, and the two of a 2×2 block.
fn with_pair(single: f64, block: Matrix2<f64>) -> [Complex<f64>; 3] {
    let half_difference = (block[(0, 0)] - block[(1, 1)]) / 2.0;
    let discriminant = half_difference * half_difference + block[(0, 1)] * block[(1, 0)];
    let size = libm::sqrt(discriminant.abs());
    let root = if discriminant < 0.0 { Complex::new(0.0, size) } else { size.into() };
    let mean = Complex::from(block.trace() / 2.0);
    [single.into(), mean + root, mean - root]
}

/// A pair (A, C) in units of the state in which A's rows and columns are alike and C's rows have
/// length 1, so that "is zero" has a meaning.
pub(super) struct Balanced<const M: usize> {
    a: Matrix3<f64>,
    c: SMatrix<f64, M, 3>,
}

impl<const M: usize> Balanced<M> {
    /// Balances a usable pair; another one stays as it is.
    pub(super) fn new(a: &Matrix3<f64>, c: &SMatrix<f64, M, 3>) -> Self {
        const { assert!(M <= 3, "three rows are kept for the outputs below") };
        let (mut a, mut c) = (*a, *c);
        if is_usable(&a) {
            let units = balance_parlett_reinsch(&mut a);
            for mut row in c.row_iter_mut() {
                row.component_mul_assign(&units.transpose());
                row.try_normalize_mut(0.0);
            }
        }
        Self { a, c }
    }

    /// Whether the outputs show the eigenvalue `pole` of A: [λI − A; C] has full rank (the test of
    /// Popov, Belevitch and Hautus).
    pub(super) fn sees(&self, pole: Complex<f64>) -> bool {
        let mut test = SMatrix::<Complex<f64>, 6, 3>::zeros();
        let shifted = Matrix3::from_diagonal_element(pole) - self.a.map(Complex::from);
        test.fixed_rows_mut::<3>(0).copy_from(&shifted);
        test.fixed_rows_mut::<M>(3).copy_from(&self.c.map(Complex::from));
        let size = 1.0 + shifted.norm();
        SVD::try_new(test, false, false, f64::EPSILON, EIGEN_ROUNDS)
            .is_some_and(|svd| svd.singular_values.min() > 1e-12 * size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 4-1 at 50 Hz.
    fn table() -> Model {
        let theta = [-0.0101, -0.1231, -1.6891e-5, -10.7104, -0.0023];
        Model::new(0.02, theta, [0.0926, 6.5427])
    }

    #[test]
    fn table_4_1_lies_where_equation_4_1_puts_it() {
        let model = table();
        let a = [[1.0, 0.02, 0.0], [-0.0101, 0.8769, -1.6891e-5], [0.0, -10.7104, 0.9977]];
        for (i, row) in a.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert!((model.a[(i, j)] - entry).abs() < 1e-15, "A[{i}][{j}]");
            }
        }
        assert_eq!(model.b, Vector3::new(0.0, 0.0926, 6.5427));
    }

    /// The trace and the determinant of A determine the sum and the product of the poles.
    #[test]
    fn the_poles_of_table_4_1_are_stable_and_add_up() {
        let poles = table().poles().unwrap();
        let sum: Complex<f64> = poles.iter().sum();
        let product: Complex<f64> = poles.iter().product();
        assert!((sum - table().a.trace()).norm() < 1e-14);
        assert!((product - table().a.determinant()).norm() < 1e-14);
        assert!(poles[0].norm() < 1.0 && poles[0].norm() >= poles[2].norm(), "{poles:?}");
    }

    #[test]
    fn a_command_settles_to_itself_in_table_4_1() {
        // By Cramer: (−θ5 γ1 + θ3 γ2) / (θ2 θ5 − θ3 θ4).
        let by_hand =
            (0.0023 * 0.0926 - 1.6891e-5 * 6.5427) / (-0.1231 * -0.0023 - -1.6891e-5 * -10.7104);
        let gain = table().velocity_gain().unwrap();
        assert!((gain - by_hand).abs() < 1e-10 && (gain - 1.0).abs() < 0.05, "{gain} {by_hand}");
        assert_eq!(Model::new(0.02, [0.0; 5], [0.1, 6.0]).velocity_gain(), None);
    }

    #[test]
    fn the_load_pressure_shows_only_through_theta_3() {
        let mut model = table();
        assert!(model.is_observable(&POSITION) && model.is_observable(&POSITION_AND_VELOCITY));
        model.a[(1, 2)] = 0.0;
        assert!(!model.is_observable(&POSITION) && !model.is_observable(&POSITION_AND_VELOCITY));
    }

    /// Rounding decides whether the double pole at 0 is two real ones or a conjugate pair.
    #[test]
    fn a_double_pole_is_found() {
        for step in 1..2000 {
            let d = f64::from(step) * 1e-3;
            let a = Matrix3::new(-d, -d * d / 0.64, 1.4, 0.64, d, -1.6, 0.0, 0.0, 5.0);
            let poles = eigenvalues(&a).expect("finite");
            assert!((poles[0] - 5.0).norm() < 1e-12, "{d}: {poles:?}");
            assert!(poles[1].norm() < 1e-6 && poles[2].norm() < 1e-6, "{d}: {poles:?}");
        }
    }

    #[test]
    fn a_model_that_is_not_finite_or_huge_has_no_poles() {
        assert_eq!(Model::new(1e300, [1e300; 5], [0.1, 6.0]).poles(), None);
        assert_eq!(Model::new(0.02, [f64::NAN; 5], [0.1, 6.0]).poles(), None);
        assert!(!Model::new(f64::INFINITY, [0.0; 5], [0.1, 6.0]).is_observable(&POSITION));
    }
}
