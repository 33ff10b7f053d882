//! Snell's law and reflection.

use glam::DVec3;

/// What becomes of a direction at an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refracted {
    /// Unit. Where the light goes: through the interface, or back where it is totally reflected.
    pub direction: DVec3,
    /// Whether there is no transmitted ray.
    pub tir: bool,
    /// Cosine of the angle of refraction; 0 under total internal reflection.
    pub cos_t: f64,
}

/// 1 - eta^2 (1 - c^2), the square of the cosine of the angle of refraction; negative under total internal reflection.
///
/// Written so that nothing cancels: exactly c^2 for eta = 1, however grazing.
pub(crate) fn cos_t_squared(cos_i: f64, eta: f64) -> f64 {
    (1.0 - eta) * (1.0 + eta) + (eta * cos_i) * (eta * cos_i)
}

/// The mirror direction. The sign of `n` does not matter.
pub fn reflected(i: DVec3, n: DVec3) -> DVec3 {
    i - 2.0 * i.dot(n) * n
}

/// Snell's law.
///
/// A direction that leaves the surface (an interpolated normal that faces away) counts as grazing it; if `i` or `n` is
/// zero, `i` passes unchanged.
pub fn snell(i: DVec3, n: DVec3, eta: f64) -> Refracted {
    if i == DVec3::ZERO || n == DVec3::ZERO {
        return Refracted { direction: i, tir: false, cos_t: 0.0 };
    }
    let d = i.dot(n);
    let k = cos_t_squared((-d).clamp(0.0, 1.0), eta);
    if k < 0.0 {
        return Refracted { direction: reflected(i, n), tir: true, cos_t: 0.0 };
    }
    let cos_t = k.sqrt().min(1.0);
    let direction = (eta * (i - d * n) - cos_t * n).normalize_or(i);
    Refracted { direction, tir: false, cos_t }
}

/// Snell's law with the angle of incidence held at the critical angle: where light would be totally reflected, it
/// leaves along the surface (Oliveira & Brauwers, section 5).
pub fn critical_clamp(i: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let refracted = snell(i, n, eta);
    if refracted.tir { (i - i.dot(n) * n).normalize_or(i) } else { refracted.direction }
}
