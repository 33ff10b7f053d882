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
