//! Punctual lights, in the units of KHR_lights_punctual.

use glam::{DMat4, Vec3};

/// The shape of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light; intensity in lux.
    Directional,
    /// All directions; intensity in candela.
    Point,
    /// A cone around -Z; intensity in candela; half-angles in radians.
    Spot {
        /// Half-angle at which the falloff begins.
        inner: f32,
        /// Half-angle beyond which there is no light.
        outer: f32,
    },
}

impl LightKind {
    /// Radiant intensity at an angle of this cosine to the light's -Z, as a part of that on it: the cone of
    /// KHR_lights_punctual, quadratic between its two half-angles; 1 without a cone.
    pub fn falloff(self, cosine: f64) -> f64 {
        let Self::Spot { inner, outer } = self else { return 1.0 };
        let [inner, outer] = [inner.min(outer), outer].map(|angle| f64::from(angle).cos());
        ((cosine - outer) / (inner - outer).max(1e-7)).clamp(0.0, 1.0).powi(2)
    }
}

/// A light; its node's transform places it and turns its -Z.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the file, or empty.
    pub name: String,
    /// Shape.
    pub kind: LightKind,
    /// Linear RGB.
    pub color: Vec3,
    /// Lux (directional) or candela (point, spot).
    pub intensity: f32,
    /// Metres beyond which the light is ignored; infinite when the file gives none.
    pub range: f32,
}

/// A light placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedLight {
    /// Rigid; the light looks along the -Z of its own space.
    pub world_from_light: DMat4,
    /// Shape, colour and intensity.
    pub light: Light,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spot_fades_between_its_half_angles() {
        let spot = LightKind::Spot { inner: 0.3, outer: 0.5 };
        let [inner, outer] = [0.3_f32, 0.5].map(|angle| f64::from(angle).cos());
        assert_eq!([1.0, inner, outer, -1.0].map(|cosine| spot.falloff(cosine)), [1.0, 1.0, 0.0, 0.0]);
        assert!((spot.falloff(0.5 * (inner + outer)) - 0.25).abs() < 1e-12);
        assert_eq!(LightKind::Point.falloff(-1.0), 1.0);
        let sharp = LightKind::Spot { inner: 0.5, outer: 0.5 };
        assert_eq!([outer + 1e-3, outer - 1e-3].map(|cosine| sharp.falloff(cosine)), [1.0, 0.0]);
    }
}
