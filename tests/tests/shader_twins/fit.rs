//! A picture drawn in around vertices holds all of them, and no more than half a texel beside them.

use glam::{DVec2, DVec3, Vec4};
use murano_animation::DeformedGeometry;
use murano_gpu::{Leaf, Work};
use murano_refraction::Viewpoint;
use murano_scene::look_along;
use murano_scheduler::{History, Plan, Skipping};

use crate::harness::{GPU, Random, rows_of};

const SIZE: [u32; 2] = [96, 64];

/// Half extent and centre of the picture that the GPU draws in around points.
fn fitted(viewpoint: Viewpoint, points: &[DVec3]) -> [DVec2; 2] {
    let mut plan = Plan::new();
    let rows: Vec<Vec4> = points.iter().map(|point| point.as_vec3().extend(1.0)).collect();
    let (stamp, leaf) = Leaf::of(&rows);
    let positions = plan.leaf("positions", stamp, Work::Leaf(leaf));
    let geometry = DeformedGeometry {
        positions,
        normals: positions,
        tangents: None,
        triangles: positions,
        neighbours: positions,
        vertex_count: points.len(),
        triangle_count: 0,
    };
    let drawn_in = viewpoint.in_frame(DVec3::ZERO).fitted(&GPU, &mut plan, 0, &geometry).expect("a sound shader");
    let targets = [drawn_in.drawn_in.expect("it was fitted")];
    let executed = GPU.execute(&plan, &targets, &mut History::new(), Skipping::Off).expect("a picture drawn in");
    // Behind the matrix.
    let row = rows_of(&executed.targets[0])[4].as_dvec4();
    [DVec2::new(row.x, row.y), DVec2::new(row.z, row.w)]
}

#[test]
fn a_picture_is_drawn_in_around_vertices() {
    let mut random = Random(7);
    let scales = [(1.0_f32, 5.0_f32), (1e-6, 5e-6), (1e6, 5e6), (1.0, 1e3)];
    for (perspective, (size, distance)) in [true, false].into_iter().flat_map(|p| scales.map(|s| (p, s))) {
        // One more than a workgroup, and many.
        for count in [1, 257, 70_000] {
            let points: Vec<DVec3> = (0..count).map(|_| (size * random.in_cube()).as_dvec3()).collect();
            let (size, distance) = (f64::from(size), f64::from(distance));
            let eye = DVec3::new(0.3, 0.5, 0.8).normalize() * distance;
            let wide = if perspective { 2.0 * size / distance } else { 4.0 * size };
            let viewpoint = Viewpoint {
                world_from_view: look_along(eye, -eye),
                perspective,
                half_extent: DVec2::splat(wide),
                center: DVec2::ZERO,
                size: SIZE,
                near: 1e-3 * distance,
            };
            let view_from_world = viewpoint.world_from_view.inverse();
            let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            for point in &points {
                let p = view_from_world.transform_point3(*point);
                let plane = if perspective { p.truncate() / -p.z } else { p.truncate() };
                (low, high) = (low.min(plane), high.max(plane));
            }
            let [half, center] = fitted(viewpoint, &points);
            // Rounding of coordinates as large as the distance.
            let rounding = 1e-6 * if perspective { 1.0 } else { distance };
            let texel = 2.0 * half / DVec2::new(f64::from(SIZE[0]), f64::from(SIZE[1]));
            let what = format!("{count} points of {size} m at {distance} m, perspective {perspective}");
            let beside = [low - (center - half), (center + half) - high];
            for gap in beside {
                assert!(gap.cmpge(DVec2::splat(-rounding)).all(), "{what}: {gap} beside");
                assert!(gap.cmple(0.5 * texel + rounding + 2e-6 * wide).all(), "{what}: {gap} of {texel} beside");
            }
        }
    }
}

#[test]
fn a_picture_is_never_widened() {
    let viewpoint = Viewpoint {
        world_from_view: look_along(DVec3::Z * 5.0, DVec3::NEG_Z),
        perspective: true,
        half_extent: DVec2::new(0.1, 0.05),
        center: DVec2::new(0.2, 0.0),
        size: SIZE,
        near: 0.01,
    };
    let inside = |[half, center]: [DVec2; 2]| {
        let room = viewpoint.half_extent - (center - viewpoint.center).abs() - half;
        half.min_element() > 0.0 && room.min_element() > -1e-7
    };
    let across = [DVec3::new(-3.0, -3.0, 0.0), DVec3::new(3.0, 3.0, 0.0)];
    assert!(inside(fitted(viewpoint, &across)));
    let aside = [DVec3::new(-3.0, -3.0, 0.0), DVec3::new(-2.0, -3.0, 0.0)];
    assert!(inside(fitted(viewpoint, &aside)));
    // As near as the eye and behind it.
    let behind = [DVec3::new(0.0, 0.0, 5.0), DVec3::new(1.0, 0.0, 9.0)];
    assert!(inside(fitted(viewpoint, &behind)));
}
