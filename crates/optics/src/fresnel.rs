//! Fresnel's equations for dielectrics.

use glam::DVec2;

use crate::snell::cos_t_squared;

/// Reflectances (Rs, Rp) for light polarised across and along the plane of incidence; (1, 1) under total internal
/// reflection. Holds from either side of an interface; `cos_i` is clamped to [0, 1].
pub fn fresnel_dielectric(cos_i: f64, eta: f64) -> DVec2 {
    let c = cos_i.clamp(0.0, 1.0);
    let k = cos_t_squared(c, eta);
    if k < 0.0 {
        return DVec2::ONE;
    }
    let cos_t = k.sqrt();
    let amplitude_s = ratio_or_zero(eta * c - cos_t, eta * c + cos_t);
    let amplitude_p = ratio_or_zero(c - eta * cos_t, c + eta * cos_t);
    DVec2::new(amplitude_s * amplitude_s, amplitude_p * amplitude_p)
}

/// Both cosines vanish only between equal media, where nothing is reflected.
fn ratio_or_zero(numerator: f64, denominator: f64) -> f64 {
    if denominator == 0.0 { 0.0 } else { numerator / denominator }
}

/// Reflectance of unpolarised light.
pub fn fresnel_unpolarised(cos_i: f64, eta: f64) -> f64 {
    let reflectance = fresnel_dielectric(cos_i, eta);
    0.5 * (reflectance.x + reflectance.y)
}

/// Transmittance of unpolarised light through two interfaces that share their plane of incidence, from the (Rs, Rp) of
/// each: the first polarises what the second meets.
pub fn pair_transmittance(first: DVec2, second: DVec2) -> f64 {
    0.5 * (DVec2::ONE - first).dot(DVec2::ONE - second)
}
