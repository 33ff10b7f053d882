//! How much of what a viewpoint sees of two bodies is seen of both.

use glam::{DVec2, DVec3};
use murano_animation::Bounds;
use murano_refraction::Viewpoint;

/// Points of an outline are taken from so many of the whole.
const POINTS: u32 = 96;

/// Area that two bodies share on the image plane, as a share of the smaller one's, if each fills its box as an ellipsoid does; 0 where part
/// of one lies behind the viewpoint.
pub(crate) fn shared_part(view: &Viewpoint, a: &Bounds, b: &Bounds) -> f64 {
    let [Some(a), Some(b)] = [a, b].map(|bounds| outline(view, bounds)) else { return 0.0 };
    let smaller = area(&a).min(area(&b));
    if smaller > 0.0 { area(&clipped(a, &b)) / smaller } else { 0.0 }
}

/// The outline of the ellipsoid in a box on the image plane, counter-clockwise.
fn outline(view: &Viewpoint, bounds: &Bounds) -> Option<Vec<DVec2>> {
    let view_from_world = view.world_from_view.inverse();
    let half = 0.5 * (bounds.max - bounds.min);
    let mut points = Vec::with_capacity(POINTS as usize);
    for i in 0..POINTS {
        // Fibonacci's lattice.
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(POINTS);
        let (sine, cosine) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let level = (1.0 - z * z).sqrt();
        let p = view_from_world.transform_point3(bounds.center() + half * DVec3::new(level * cosine, level * sine, z));
        if view.perspective && p.z >= 0.0 {
            return None;
        }
        points.push(if view.perspective { p.truncate() / -p.z } else { p.truncate() });
    }
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    // Andrew's monotone chains.
    let mut hull: Vec<DVec2> = Vec::with_capacity(9);
    let mut chain = |points: &mut dyn Iterator<Item = &DVec2>| {
        let start = hull.len();
        for &point in points {
            while hull.len() >= start + 2 && turns(hull[hull.len() - 2], hull[hull.len() - 1], point) <= 0.0 {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
    };
    chain(&mut points.iter());
    chain(&mut points.iter().rev());
    Some(hull)
}

/// Twice the area of a triangle, positive where it runs counter-clockwise.
fn turns(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn area(polygon: &[DVec2]) -> f64 {
    let Some(&first) = polygon.first() else { return 0.0 };
    0.5 * polygon.windows(2).map(|edge| turns(first, edge[0], edge[1])).sum::<f64>()
}

/// What of a polygon lies within a convex one (Sutherland and Hodgman).
fn clipped(mut polygon: Vec<DVec2>, by: &[DVec2]) -> Vec<DVec2> {
    for (i, &from) in by.iter().enumerate() {
        let to = by[(i + 1) % by.len()];
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, &point) in polygon.iter().enumerate() {
            let before = polygon[(k + polygon.len() - 1) % polygon.len()];
            let [side_before, side] = [before, point].map(|point| turns(from, to, point));
            if (side_before < 0.0) != (side < 0.0) {
                kept.push(before.lerp(point, side_before / (side_before - side)));
            }
            if side >= 0.0 {
                kept.push(point);
            }
        }
        polygon = kept;
    }
    polygon
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec3};

    use super::*;

    /// Around a ball.
    fn cube(center: DVec3, half: f64) -> Bounds {
        Bounds { min: center - half, max: center + half }
    }

    fn view(perspective: bool) -> Viewpoint {
        Viewpoint {
            world_from_view: DMat4::from_translation(10.0 * DVec3::Z),
            perspective,
            half_extent: DVec2::ONE,
            center: DVec2::ZERO,
            size: [1; 2],
            near: 1e-3,
        }
    }

    #[test]
    fn balls_share_what_they_cover_both() {
        let a = cube(DVec3::ZERO, 1.0);
        // Of circles of radius 1, so far apart: 2 acos(d / 2) - d / 2 sqrt(4 - d^2).
        for offset in [0.0, 0.5, 1.0, 1.5, 1.9, 2.5_f64] {
            let near = offset.min(2.0);
            let expected = (2.0 * (0.5 * near).acos() - 0.5 * near * (4.0 - near * near).sqrt()) / std::f64::consts::PI;
            let part = shared_part(&view(false), &a, &cube(DVec3::new(offset, 0.0, -5.0), 1.0));
            assert!((part - expected).abs() < 0.05, "{offset}: {part} for {expected}");
        }
        let part = shared_part(&view(true), &a, &cube(DVec3::new(0.0, 0.0, 4.0), 1.0));
        assert!((part - 1.0).abs() < 0.01, "one hides the other: {part}");
        assert_eq!(shared_part(&view(true), &a, &cube(12.0 * DVec3::Z, 1.0)), 0.0, "behind the viewpoint");
        assert_eq!(shared_part(&view(false), &a, &cube(DVec3::ZERO, 0.0)), 0.0, "a point");
    }

    #[test]
    fn an_outline_is_that_of_the_ellipsoid() {
        let turned =
            Viewpoint { world_from_view: murano_scene::look_along(DVec3::splat(10.0), DVec3::NEG_ONE), ..view(false) };
        let bounds = Bounds { min: -DVec3::new(1.0, 2.0, 3.0), max: DVec3::new(1.0, 2.0, 3.0) };
        // pi sqrt((b c n_x)^2 + (a c n_y)^2 + (a b n_z)^2) along n.
        let expected = std::f64::consts::PI * ((36.0 + 9.0 + 4.0) / 3.0_f64).sqrt();
        let found = area(&outline(&turned, &bounds).unwrap());
        assert!(found < expected && found > 0.93 * expected, "{found} for {expected}");
    }
}
