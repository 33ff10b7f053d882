//! Rays and where they meet a surface.

use glam::DVec3;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World, metres.
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
}

impl Ray {
    /// The point `t` metres along.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// The side of a surface that a ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Facing {
    /// From outside: the ray enters.
    Front,
    /// From inside: the ray leaves.
    Back,
}

/// Where a ray starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Departure {
    /// From somewhere in space.
    #[default]
    Free,
    /// From a surface: this element (triangle, face, 0 for a quadric) does not count as met again at the start.
    Element(u32),
}

/// A ray met a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, metres, positive.
    pub t: f64,
    /// World, metres.
    pub position: DVec3,
    /// Unit, outward, of the surface itself.
    pub geometric: DVec3,
    /// Unit, outward, interpolated from the vertices and normalised; equal to `geometric` on shapes with a closed form.
    pub normal: DVec3,
    /// Triangle or face.
    pub element: u32,
    /// Weights of a triangle's corners; zero on other shapes.
    pub barycentric: DVec3,
}

impl Hit {
    /// The side that a ray of this direction meets.
    pub fn facing(&self, direction: DVec3) -> Facing {
        if self.geometric.dot(direction) < 0.0 { Facing::Front } else { Facing::Back }
    }

    /// The shading normal turned against a direction; the geometric one where the interpolated normal faces the other
    /// way (Snell's law has no answer there).
    pub fn normal_against(&self, direction: DVec3) -> DVec3 {
        let sign = match self.facing(direction) {
            Facing::Front => 1.0,
            Facing::Back => -1.0,
        };
        let shading = sign * self.normal;
        if shading.dot(direction) < 0.0 { shading } else { sign * self.geometric }
    }
}
