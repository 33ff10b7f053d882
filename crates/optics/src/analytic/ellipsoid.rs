//! An ellipsoid, by its quadratic form.

use glam::DVec3;

use crate::{Ior, analytic::Passage, snell};

/// An ellipsoid of glass about the origin, its axes along the coordinate axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Half-lengths of the axes, metres, each above 0.
    pub semi_axes: DVec3,
    /// Of the glass.
    pub ior: Ior,
}

impl Ellipsoid {
    /// A body of revolution about z with eccentricity 1/n: it focuses light that enters along its axis to a point, its
    /// own far focus, and does so exactly (Descartes). `None` for n = 1, where the axis would be infinite.
    pub fn stigmatic(semi_major: f64, ior: Ior) -> Option<Self> {
        let minor = semi_major * (1.0 - 1.0 / (ior.get() * ior.get())).sqrt();
        (minor > 0.0).then_some(Self { semi_axes: DVec3::new(minor, minor, semi_major), ior })
    }

    /// The way of a ray from outside; `None` if it misses the body or starts inside.
    pub fn passage(&self, origin: DVec3, direction: DVec3) -> Option<Passage> {
        // Scaled by the axes the surface is the unit sphere.
        let (o, d) = (origin / self.semi_axes, direction / self.semi_axes);
        let discriminant = d.length_squared() - o.cross(d).length_squared();
        if discriminant.is_nan() || discriminant < 0.0 {
            return None;
        }
        let distance = (-o.dot(d) - discriminant.sqrt()) / d.length_squared();
        if distance.is_nan() || distance < 0.0 {
            return None;
        }
        let entry = origin + direction * distance;
        let entry_normal = self.normal(entry);
        let inside = snell(direction, entry_normal, self.ior.eta_entering()).direction;
        let (p, t) = (entry / self.semi_axes, inside / self.semi_axes);
        let chord = (-2.0 * p.dot(t) / t.length_squared()).max(0.0);
        let exit = entry + inside * chord;
        let exit_normal = self.normal(exit);
        let leaving = snell(inside, -exit_normal, self.ior.eta_leaving());
        Some(Passage { entry, entry_normal, inside, exit, exit_normal, leaving })
    }

    /// Outward unit normal at a point of the surface.
    fn normal(&self, point: DVec3) -> DVec3 {
        (point / (self.semi_axes * self.semi_axes)).normalize_or(DVec3::Z)
    }
}
