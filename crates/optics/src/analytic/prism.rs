//! A prism, in its principal section.

use crate::Ior;

/// Two plane faces that meet at the apex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prism {
    /// Angle between the faces, radians, above 0 and below pi.
    pub apex: f64,
    /// Of the glass.
    pub ior: Ior,
}

impl Prism {
    /// Angle by which the prism turns a ray away from its apex, for an angle of incidence in (-pi/2, pi/2), positive on
    /// the side of the normal that faces the base. `None` where the second face reflects totally: there the angle of
    /// incidence inside, A - theta_t, exceeds asin(1/n).
    pub fn deviation(&self, theta_i: f64) -> Option<f64> {
        let inside = self.apex - (theta_i.sin() / self.ior.get()).asin();
        let sin_out = self.ior.get() * inside.sin();
        (sin_out.abs() <= 1.0 && inside.abs() < std::f64::consts::FRAC_PI_2)
            .then(|| theta_i + sin_out.asin() - self.apex)
    }

    /// Smallest deviation there is, 2 asin(n sin(A/2)) - A, with light passing symmetrically. `None` if no symmetric
    /// ray gets through.
    pub fn minimum_deviation(&self) -> Option<f64> {
        let theta_i = self.symmetric_incidence()?;
        Some(2.0 * theta_i - self.apex)
    }

    /// Angle of incidence of the symmetric ray. `None` if there is none.
    pub fn symmetric_incidence(&self) -> Option<f64> {
        let sin_i = self.ior.get() * (self.apex / 2.0).sin();
        (sin_i <= 1.0).then(|| sin_i.asin())
    }
}
