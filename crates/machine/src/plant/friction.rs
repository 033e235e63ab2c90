//! Friction of piston and rod: the Stribeck curve, and sticking.

use super::ailment::Wear;
use serde::Deserialize;

/// Friction (3-13): μ_v v + sign(v) (F_c0 + F_s0 exp(−|v| / c_s)); at rest (3-10).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Viscous friction μ_v, N s/m.
    pub viscous: f64,
    /// Coulomb friction F_c0, N.
    pub coulomb: f64,
    /// Static friction F_s0 beyond Coulomb's, N.
    pub stiction: f64,
    /// Stribeck speed c_s, m/s.
    pub stribeck_speed: f64,
}

/// Number of Stribeck speeds beyond which less than a ten millionth of the stiction is left.
const FAST: f64 = 16.0;

impl Friction {
    /// The friction of a cylinder with this wear.
    pub(super) fn worn(&self, wear: &Wear) -> Self {
        let dry = 1.0 + wear.friction;
        Self {
            viscous: self.viscous * (dry + wear.viscosity),
            coulomb: self.coulomb * dry,
            stiction: self.stiction * dry,
            ..*self
        }
    }

    /// The force, N, against a motion at `speed` ≥ 0, m/s, without its viscous part.
    pub fn dry(&self, speed: f64) -> f64 {
        let relative = speed / self.stribeck_speed;
        if relative > FAST {
            return self.coulomb;
        }
        self.coulomb + self.stiction * (-relative).exp()
    }

    /// The force, N, on a piston that moves at `speed`, m/s; its sign is the speed's. 0 at rest,
    /// where [`Friction::holds`] decides.
    pub fn force(&self, speed: f64) -> f64 {
        if speed == 0.0 {
            return 0.0;
        }
        self.viscous * speed + self.dry(speed.abs()).copysign(speed)
    }

    /// Whether a piston at rest stays there under the `force` of everything else, N. Static
    /// friction then balances it: in (3-10) the minimum belongs around |F_ext|, with the sign of
    /// F_ext.
    pub fn holds(&self, force: f64) -> bool {
        force.abs() <= self.coulomb + self.stiction
    }
}
