//! A sphere, by angles and chords.

use glam::DVec3;

use crate::{Ior, Refracted, analytic::Passage};

/// A ball of glass about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Metres, above 0.
    pub radius: f64,
    /// Of the glass.
    pub ior: Ior,
}

impl Sphere {
    /// The way of a ray from outside; `None` if it misses the ball or starts inside.
    ///
    /// In the plane through the centre the ray turns by theta_i - theta_t towards the centre at each interface, runs a
    /// chord of 2 R cos(theta_t) in between, and is never totally reflected.
    pub fn passage(&self, origin: DVec3, direction: DVec3) -> Option<Passage> {
        let closest = origin - origin.dot(direction) * direction;
        let offset = closest.length();
        let before = (self.radius - offset) * (self.radius + offset);
        let travelled = -origin.dot(direction) - before.max(0.0).sqrt();
        if before < 0.0 || travelled.is_nan() || travelled < 0.0 {
            return None;
        }
        let theta_i = (offset / self.radius).min(1.0).asin();
        let theta_t = self.ior.refraction_angle(theta_i);
        let turn = theta_i - theta_t;

        // Towards the centre, across the ray. For a ray through the centre there is no turn and any will do.
        let inwards = (-closest).normalize_or_zero();
        let turned = |angle: f64| direction * angle.cos() + inwards * angle.sin();
        let entry = closest - direction * before.sqrt();
        let inside = turned(turn);
        let exit = entry + inside * (2.0 * self.radius * theta_t.cos());
        Some(Passage {
            entry,
            entry_normal: entry / self.radius,
            inside,
            exit,
            exit_normal: exit / self.radius,
            leaving: Refracted { direction: turned(2.0 * turn), tir: false, cos_t: theta_i.cos() },
        })
    }

    /// Angle between the incident and the leaving direction for a ray whose line passes the centre at a distance in
    /// [0, radius].
    pub fn deviation(&self, offset: f64) -> f64 {
        let sin_i = (offset / self.radius).clamp(0.0, 1.0);
        2.0 * (sin_i.asin() - (sin_i / self.ior.get()).asin())
    }
}
