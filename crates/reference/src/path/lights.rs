//! Punctual lights, as KHR_lights_punctual defines them.

use glam::DVec3;
use murano_scene::{LightKind, PlacedLight};

/// Light that would arrive at a point if nothing stood in its way.
pub(super) struct Arriving {
    /// Towards the light, unit.
    pub towards: DVec3,
    /// Metres to the light; infinite for parallel light.
    pub distance: f64,
    /// On a surface that faces the light, linear RGB.
    pub irradiance: DVec3,
}

/// What a light sends to a point; `None` outside its cone or range.
pub(super) fn arriving(placed: &PlacedLight, point: DVec3) -> Option<Arriving> {
    let light = &placed.light;
    let place = &placed.world_from_light;
    let axis = place.transform_vector3(DVec3::NEG_Z).normalize_or(DVec3::NEG_Z);
    let full = light.color.as_dvec3() * f64::from(light.intensity);
    let to_light = place.w_axis.truncate() - point;
    let distance = to_light.length();
    let towards = to_light / distance;
    if light.kind == LightKind::Directional {
        let lit = full != DVec3::ZERO;
        return lit.then_some(Arriving { towards: -axis, distance: f64::INFINITY, irradiance: full });
    }
    let share = light.kind.falloff(-towards.dot(axis));
    let within = if light.range.is_finite() && light.range > 0.0 {
        (1.0 - (distance / f64::from(light.range)).powi(4)).clamp(0.0, 1.0)
    } else {
        1.0
    };
    let irradiance = full * (share * within / (distance * distance));
    (irradiance.is_finite() && irradiance != DVec3::ZERO).then_some(Arriving { towards, distance, irradiance })
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, Vec3};
    use murano_scene::Light;

    use super::*;

    fn above(kind: LightKind, range: f32) -> PlacedLight {
        let light = Light { name: String::new(), kind, color: Vec3::new(1.0, 0.5, 0.25), intensity: 8.0, range };
        let world_from_light =
            DMat4::from_translation(DVec3::new(0.0, 2.0, 0.0)) * DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
        PlacedLight { world_from_light, light }
    }

    #[test]
    fn light_falls_with_distance_cone_and_range() {
        let point = arriving(&above(LightKind::Point, f32::INFINITY), DVec3::ZERO).unwrap();
        assert!(point.irradiance.abs_diff_eq(DVec3::new(2.0, 1.0, 0.5), 1e-12) && point.towards == DVec3::Y);
        assert_eq!(point.distance, 2.0);
        let ranged = arriving(&above(LightKind::Point, 4.0), DVec3::ZERO).unwrap();
        assert!((ranged.irradiance.x - 2.0 * 15.0 / 16.0).abs() < 1e-12);
        assert!(arriving(&above(LightKind::Point, 1.5), DVec3::ZERO).is_none());

        let cone = LightKind::Spot { inner: 0.2, outer: 0.4 };
        let at = |angle: f64| DVec3::new(angle.sin(), 2.0 - angle.cos(), 0.0);
        let spot = |angle| arriving(&above(cone, f32::INFINITY), at(angle)).map(|light| light.irradiance.x);
        assert!((spot(0.1).unwrap() - 8.0).abs() < 1e-9 && spot(0.41).is_none());
        let half = (0.3f64.cos() - 0.4f64.cos()) / (0.2f64.cos() - 0.4f64.cos());
        assert!((spot(0.3).unwrap() - 8.0 * half * half).abs() < 1e-5);

        let sun = arriving(&above(LightKind::Directional, f32::INFINITY), DVec3::splat(9.0)).unwrap();
        assert!(sun.towards.abs_diff_eq(DVec3::Y, 1e-12) && sun.irradiance.x == 8.0 && sun.distance == f64::INFINITY);
    }
}
