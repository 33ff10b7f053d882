//! Absorption inside a body.

use glam::DVec3;

/// Absorbs everything within any visible length, and is still finite in f32, so that nothing times it is NaN.
const OPAQUE: f64 = 1e30;

/// Absorption per metre of a medium in which white light takes `color` (linear, each in [0, 1]) after `distance` metres
/// (KHR_materials_volume: attenuationColor and attenuationDistance).
///
/// An infinite distance absorbs nothing. A channel that is 0, or any but white at a distance of 0, is opaque.
pub fn absorption_coefficient(color: DVec3, distance: f64) -> DVec3 {
    let channel = |color: f64| {
        let optical_depth = -color.clamp(0.0, 1.0).ln();
        if optical_depth == 0.0 || distance == f64::INFINITY {
            0.0
        } else {
            (optical_depth / distance.max(0.0)).min(OPAQUE)
        }
    };
    DVec3::new(channel(color.x), channel(color.y), channel(color.z))
}

/// What is left of light after `length` metres in a medium that absorbs `sigma` per metre (Beer-Lambert).
pub fn beer_lambert(sigma: DVec3, length: f64) -> DVec3 {
    (-sigma * length.max(0.0)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AMBER: DVec3 = DVec3::new(0.9, 0.5, 0.1);

    #[test]
    fn the_colour_is_reached_at_the_distance_and_its_square_at_twice_that() {
        let sigma = absorption_coefficient(AMBER, 0.25);
        assert!(beer_lambert(sigma, 0.25).abs_diff_eq(AMBER, 1e-15));
        assert!(beer_lambert(sigma, 0.5).abs_diff_eq(AMBER * AMBER, 1e-15));
    }

    #[test]
    fn a_path_in_two_parts_absorbs_like_the_whole() {
        let sigma = absorption_coefficient(AMBER, 0.7);
        let parts = beer_lambert(sigma, 0.3) * beer_lambert(sigma, 1.1);
        assert!(parts.abs_diff_eq(beer_lambert(sigma, 1.4), 1e-15));
    }

    #[test]
    fn limits_are_clear_or_opaque_and_never_nan() {
        assert_eq!(absorption_coefficient(AMBER, f64::INFINITY), DVec3::ZERO);
        assert_eq!(absorption_coefficient(DVec3::ONE, 0.0), DVec3::ZERO);
        assert_eq!(absorption_coefficient(DVec3::ZERO, f64::INFINITY), DVec3::ZERO);
        let black = absorption_coefficient(DVec3::ZERO, 1.0);
        assert_eq!(beer_lambert(black, 0.0), DVec3::ONE);
        assert_eq!(beer_lambert(black, 1e-6), DVec3::ZERO);
        assert_eq!(beer_lambert(absorption_coefficient(AMBER, 0.0), 1e-6), DVec3::ZERO);
        assert_eq!(beer_lambert(DVec3::ONE, -3.0), DVec3::ONE);
    }
}
