//! A slab with parallel faces.

use glam::DVec3;

use crate::{Ior, Refracted, analytic::Passage, fresnel_dielectric, pair_transmittance};

/// Glass between the planes y = 0 and y = -thickness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Metres, at least 0.
    pub thickness: f64,
    /// Of the glass.
    pub ior: Ior,
}

impl Slab {
    /// The way of a ray from above (origin.y >= 0); `None` if it does not come down. T2 = I.
    pub fn passage(&self, origin: DVec3, direction: DVec3) -> Option<Passage> {
        if origin.y < 0.0 || direction.y.is_nan() || direction.y >= 0.0 {
            return None;
        }
        let entry = (origin + direction * (origin.y / -direction.y)).with_y(0.0);
        let cos_i = (-direction.y).min(1.0);
        let theta_t = self.ior.refraction_angle(cos_i.acos());
        let along = direction.with_y(0.0).normalize_or_zero();
        let inside = along * theta_t.sin() + DVec3::NEG_Y * theta_t.cos();
        let exit = entry + inside * (self.thickness / theta_t.cos());
        Some(Passage {
            entry,
            entry_normal: DVec3::Y,
            inside,
            exit,
            exit_normal: DVec3::NEG_Y,
            leaving: Refracted { direction, tir: false, cos_t: cos_i },
        })
    }

    /// Distance between the lines of the incident and the leaving ray: D sin(theta_i - theta_t) / cos(theta_t), metres.
    pub fn lateral_shift(&self, theta_i: f64) -> f64 {
        let theta_t = self.ior.refraction_angle(theta_i);
        self.thickness * (theta_i - theta_t).sin() / theta_t.cos()
    }

    /// Fraction of unpolarised light that passes both faces without being reflected at either.
    pub fn transmittance(&self, theta_i: f64) -> f64 {
        // From inside, at the angle of refraction, the interface reflects what it reflects from outside.
        let reflectance = fresnel_dielectric(theta_i.cos(), self.ior.eta_entering());
        pair_transmittance(reflectance, reflectance)
    }
}
