//! The index of refraction.

use std::fmt;

/// Index of refraction relative to air: finite and at least 1.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Ior(f64);

/// A number that is no index of refraction.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{0} is not an index of refraction; give a finite number of at least 1 (water 1.33, glass 1.5, diamond 2.42)")]
pub struct InvalidIor(pub f64);

impl Ior {
    /// The medium around every body.
    pub const AIR: Self = Self(1.0);
    /// The default of KHR_materials_ior.
    pub const GLASS: Self = Self(1.5);

    /// Checks a number.
    ///
    /// # Errors
    /// [`InvalidIor`] if it is not finite, or below 1.
    pub fn new(n: f64) -> Result<Self, InvalidIor> {
        if n.is_finite() && n >= 1.0 { Ok(Self(n)) } else { Err(InvalidIor(n)) }
    }

    /// The number.
    pub fn get(self) -> f64 {
        self.0
    }

    /// eta of light that enters the medium from air.
    pub fn eta_entering(self) -> f64 {
        1.0 / self.0
    }

    /// eta of light that leaves the medium for air.
    pub fn eta_leaving(self) -> f64 {
        self.0
    }

    /// Angle of incidence inside the medium beyond which light is totally reflected; pi/2 for n = 1.
    pub fn critical_angle(self) -> f64 {
        (1.0 / self.0).asin()
    }

    /// Angle of incidence in air at which light polarised along the plane of incidence is not reflected (Brewster).
    pub fn brewster_angle(self) -> f64 {
        self.0.atan()
    }

    /// Angle of refraction inside the medium for an angle of incidence in air, both in [0, pi/2].
    pub fn refraction_angle(self, theta_i: f64) -> f64 {
        (theta_i.sin() / self.0).asin()
    }
}

impl Default for Ior {
    fn default() -> Self {
        Self::GLASS
    }
}

impl TryFrom<f64> for Ior {
    type Error = InvalidIor;

    fn try_from(n: f64) -> Result<Self, InvalidIor> {
        Self::new(n)
    }
}

impl fmt::Display for Ior {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_finite_numbers_from_one_up() {
        for n in [1.0, 1.5, 2.5, 4.0] {
            assert_eq!(Ior::new(n).map(Ior::get), Ok(n));
        }
        for n in [0.0, 0.999, -1.5, f64::INFINITY] {
            assert_eq!(Ior::new(n), Err(InvalidIor(n)));
        }
        assert!(Ior::new(f64::NAN).is_err());
    }

    #[test]
    fn known_angles() {
        assert!((Ior::GLASS.critical_angle().to_degrees() - 41.810_314_9).abs() < 1e-6);
        assert!((Ior::GLASS.brewster_angle().to_degrees() - 56.309_932_5).abs() < 1e-6);
        assert_eq!(Ior::AIR.critical_angle(), std::f64::consts::FRAC_PI_2);
        assert!((Ior::GLASS.refraction_angle(0.5) - (0.5f64.sin() / 1.5).asin()).abs() < 1e-15);
    }
}
