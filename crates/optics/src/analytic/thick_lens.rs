//! A thick lens, paraxially.

use crate::Ior;

/// Two spherical surfaces on one axis. A radius is positive where the centre of curvature lies behind the surface, as
/// the light goes; a plane has an infinite one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThickLens {
    /// Radius R1 of the first surface, metres.
    pub front_radius: f64,
    /// Radius R2 of the second surface, metres.
    pub back_radius: f64,
    /// Distance D between the surfaces on the axis, metres.
    pub thickness: f64,
    /// Of the glass.
    pub ior: Ior,
}

impl ThickLens {
    /// 1/f = (n-1) [1/R1 - 1/R2 + (n-1) D / (n R1 R2)], per metre (the lensmaker's equation).
    pub fn power(&self) -> f64 {
        let n = self.ior.get();
        let (front, back) = (1.0 / self.front_radius, 1.0 / self.back_radius);
        (n - 1.0) * (front - back + (n - 1.0) * self.thickness * front * back / n)
    }

    /// Focal length from the second principal plane, metres; infinite if the lens has no power.
    pub fn focal_length(&self) -> f64 {
        1.0 / self.power()
    }

    /// Distance from the back vertex to the focus of parallel light, f (1 - (n-1) D / (n R1)), metres; negative for a
    /// virtual focus.
    pub fn back_focal_distance(&self) -> f64 {
        let n = self.ior.get();
        self.focal_length() * (1.0 - (n - 1.0) * self.thickness / (n * self.front_radius))
    }
}
