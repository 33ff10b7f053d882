//! Closed meshes leave no hole in interface maps.
//!
//! A surface that is star-shaped around its centre holds the ball that touches its nearest triangle's plane. A ray that
//! meets that ball enters and leaves the surface: both layers must show something.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3, Vec4};
use murano_animation::{DeformedGeometry, Geometry, GeometryLeaves, Pose, shown_primitives};
use murano_gpu::{Leaf, Work};
use murano_refraction::{Hierarchy, Layers, Viewpoint, interface_map};
use murano_scene::{import, look_along};
use murano_scheduler::{History, Plan, Skipping};
use murano_tests::bench::asset;

use crate::harness::{GPU, Random, rows_of};

const SIZE: [u32; 2] = [72, 60];

/// Triangles of a closed surface.
struct Surface {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// A ball of radius 1 cut along the given longitudes and between the poles at the given latitudes, radians.
    fn globe(longitudes: &[f64], latitudes: &[f64]) -> Self {
        let columns = longitudes.len() as u32;
        let ring = |latitude: &f64| {
            let (y, radius) = latitude.sin_cos();
            longitudes.iter().map(move |longitude| DVec3::new(radius * longitude.cos(), y, radius * longitude.sin()))
        };
        let mut points: Vec<DVec3> = latitudes.iter().flat_map(ring).collect();
        let (south, north) = (points.len() as u32, points.len() as u32 + 1);
        points.extend([DVec3::NEG_Y, DVec3::Y]);
        let top = columns * (latitudes.len() as u32 - 1);
        let mut triangles = Vec::new();
        for column in 0..columns {
            let next = (column + 1) % columns;
            triangles.extend([[south, column, next], [north, top + next, top + column]]);
            for row in (0..top).step_by(columns as usize) {
                triangles.push([row + column, row + columns + column, row + next]);
                triangles.push([row + next, row + columns + column, row + columns + next]);
            }
        }
        Self { points, triangles }
    }

    /// Even steps; with many columns and few rows, needles.
    fn even(columns: u32, rows: u32) -> Self {
        let latitudes: Vec<f64> = (1..=rows).map(|row| PI * (f64::from(row) / f64::from(rows + 1) - 0.5)).collect();
        let longitudes: Vec<f64> = (0..columns).map(|column| TAU * f64::from(column) / f64::from(columns)).collect();
        Self::globe(&longitudes, &latitudes)
    }

    /// Steps of all sizes, down to what f32 rounds to none: slivers and triangles without area.
    fn uneven() -> Self {
        let mut random = Random(61);
        let mut longitudes: Vec<f64> = (0..40).map(|column| TAU * f64::from(column) / 40.0).collect();
        longitudes.extend((0..60).map(|_| f64::from(random.between(0.0, 6.2))));
        let near: Vec<f64> =
            longitudes.iter().map(|longitude| longitude + f64::from(random.magnitude(1e-9, 1e-3))).collect();
        longitudes.extend(near.into_iter().filter(|longitude| *longitude < TAU));
        longitudes.sort_by(f64::total_cmp);
        let mut latitudes: Vec<f64> = (1..16).map(|row| PI * (f64::from(row) / 16.0 - 0.5)).collect();
        latitudes.extend((0..10).map(|_| f64::from(random.between(-1.5, 1.5))));
        latitudes.extend([0.1, 0.1 + 1e-8, 0.1 + 2e-6]);
        latitudes.sort_by(f64::total_cmp);
        Self::globe(&longitudes, &latitudes)
    }

    /// Radius of the ball within, around the origin. Slivers, whose planes rounding turns, do not reach into it.
    fn inner_radius(&self) -> f64 {
        let distance = |&[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|index| self.points[index as usize]);
            let normal = (b - a).cross(c - a);
            (normal.length() > 1e-7).then(|| normal.normalize().dot(a).abs())
        };
        self.triangles.iter().filter_map(distance).fold(f64::INFINITY, f64::min)
    }

    fn deformed(&self, plan: &mut Plan<Work>, scale: f64) -> DeformedGeometry {
        let rows = |w: f32, scale: f64| self.points.iter().map(move |point| (point * scale).as_vec3().extend(w));
        let mut leaf = |name, (stamp, leaf)| plan.leaf(name, stamp, Work::Leaf(leaf));
        DeformedGeometry {
            positions: leaf("positions", Leaf::of(&rows(1.0, scale).collect::<Vec<Vec4>>())),
            normals: leaf("normals", Leaf::of(&rows(0.0, 1.0).collect::<Vec<Vec4>>())),
            tangents: None,
            triangles: leaf("triangles", Leaf::of(&self.triangles)),
            // Open everywhere: rasterising asks for none.
            neighbours: leaf("neighbours", Leaf::of(&vec![[0u32; 3]; self.triangles.len()])),
            vertex_count: self.points.len(),
            triangle_count: self.triangles.len(),
        }
    }
}

/// Depth of the front and the back layer at each texel, 0 where there is nothing.
fn depths(plan: &mut Plan<Work>, geometry: &DeformedGeometry, viewpoint: &Viewpoint, layers: Layers) -> [Vec<f32>; 2] {
    let map =
        interface_map(&GPU, plan, ("watertight", 0), &(*geometry).into(), &viewpoint.in_frame(DVec3::ZERO), layers)
            .unwrap_or_else(|error| panic!("{error}"));
    let targets = [map.front, map.back.expect("two layers")];
    let executed =
        GPU.execute(plan, &targets, &mut History::new(), Skipping::Off).unwrap_or_else(|error| panic!("{error}"));
    [0, 1].map(|layer| {
        let rows = rows_of(&executed.targets[layer]);
        assert!(rows.iter().all(|row| row.is_finite()), "{viewpoint:?}: a normal or depth is not finite");
        let unit = |row: &&Vec4| row.w != 0.0 && (row.truncate().length() - 1.0).abs() > 1e-5;
        assert_eq!(rows.iter().find(unit), None, "{viewpoint:?}: a normal is not unit");
        rows.iter().map(|row| row.w).collect()
    })
}

fn viewpoint(world_from_view: DMat4, perspective: bool, half_extent: f64, near: f64) -> Viewpoint {
    let half_extent = half_extent * DVec2::new(f64::from(SIZE[0]) / f64::from(SIZE[1]), 1.0);
    Viewpoint { world_from_view, perspective, half_extent, center: DVec2::ZERO, size: SIZE, near }
}

/// A texel's ray in the world.
fn ray(viewpoint: &Viewpoint, texel: usize) -> (DVec3, DVec3) {
    let [x, y] = [texel as u32 % SIZE[0], texel as u32 / SIZE[0]].map(|index| f64::from(index) + 0.5);
    let size = viewpoint.size.map(f64::from);
    let ndc = DVec2::new(2.0, -2.0) * (DVec2::new(x / size[0], y / size[1]) - 0.5);
    let plane = viewpoint.center + ndc * viewpoint.half_extent;
    let (origin, direction) =
        if viewpoint.perspective { (DVec3::ZERO, plane.extend(-1.0)) } else { (plane.extend(0.0), DVec3::NEG_Z) };
    let world = viewpoint.world_from_view;
    (world.transform_point3(origin), world.transform_vector3(direction).normalize())
}

/// Looks at the ball from any side: close by, from afar, in parallel.
fn outside(random: &mut Random, scale: f64) -> Vec<Viewpoint> {
    let mut from = |distance: f64| {
        let side = random.direction().as_dvec3();
        look_along(scale * distance * side, 0.1 * random.direction().as_dvec3() - distance * side)
    };
    vec![
        viewpoint(from(1.05), true, 1.5, 1e-3 * scale),
        viewpoint(from(3.0), true, 0.45, 1e-3 * scale),
        viewpoint(from(100.0), true, 0.012, 0.1 * scale),
        viewpoint(from(4.0), false, 1.2 * scale, 1e-3 * scale),
    ]
}

/// Checks both layers against the rays that surely meet the ball, and those that surely miss it.
fn assert_no_hole([front, back]: &[Vec<f32>; 2], viewpoint: &Viewpoint, scale: f64, inner: f64) {
    let mut met = 0;
    for texel in 0..front.len() {
        let (origin, direction) = ray(viewpoint, texel);
        let what = || format!("scale {scale}, texel {texel} of {viewpoint:?}");
        let middle = -origin.dot(direction);
        let distance = (origin + middle * direction).length() / scale;
        if middle > 0.0 && distance < inner {
            met += 1;
            assert!(front[texel] > 0.0, "{}: a hole in front", what());
            assert!(back[texel] > front[texel], "{}: a hole behind", what());
        } else if distance > 1.0 + 1e-4 {
            assert_eq!((front[texel], back[texel]), (0.0, 0.0), "{}: nothing is there", what());
        }
    }
    assert!(met > 800, "the ball covers {met} texels of {viewpoint:?}");
}

#[test]
fn a_ball_has_no_hole() {
    let mut random = Random(62);
    for surface in [Surface::even(48, 23), Surface::even(900, 3), Surface::uneven()] {
        let inner = surface.inner_radius() * (1.0 - 1e-4);
        assert!(inner > 0.5, "{inner}");
        for (scale, layers) in
            [(1e-6, Layers::NearestBack), (1.0, Layers::FarthestBack { depth_range: true }), (1e6, Layers::NearestBack)]
        {
            for viewpoint in outside(&mut random, scale) {
                let mut plan = Plan::new();
                let geometry = surface.deformed(&mut plan, scale);
                assert_no_hole(&depths(&mut plan, &geometry, &viewpoint, layers), &viewpoint, scale, inner);
            }
        }
    }
}

/// From the middle of a ball there is no front and no end to the back: triangles reach behind the viewpoint.
#[test]
fn a_ball_surrounds_its_centre() {
    let mut random = Random(63);
    for surface in [Surface::even(48, 23), Surface::even(900, 3), Surface::even(3, 1)] {
        for scale in [1e-6, 1.0, 1e6] {
            let world_from_view = look_along(DVec3::ZERO, random.direction().as_dvec3());
            let viewpoint = viewpoint(world_from_view, true, 3.0, 1e-4 * scale);
            let mut plan = Plan::new();
            let geometry = surface.deformed(&mut plan, scale);
            let [front, back] = depths(&mut plan, &geometry, &viewpoint, Layers::NearestBack);
            assert!(front.iter().all(|depth| *depth == 0.0), "{viewpoint:?}");
            assert!(back.iter().all(|depth| *depth > 0.0), "{viewpoint:?}");
        }
    }
}

/// Whatever enters a closed mesh leaves it: one layer is covered exactly where the other is.
#[test]
fn both_layers_of_a_closed_model_cover_the_same_texels() {
    let mut random = Random(64);
    for model in ["bumpy.glb", "torus.glb", "prism.glb"] {
        let scene = import(&asset(model)).unwrap_or_else(|error| panic!("{error}"));
        let geometry = Geometry::build(&scene, &shown_primitives(&scene)).unwrap_or_else(|error| panic!("{error}"));
        let pose = Pose::rest(&scene);
        let bounds = geometry.posed_bounds(&pose);
        let radius = 0.5 * bounds.diameter();
        let leaves = GeometryLeaves::new(&geometry);
        for mut viewpoint in outside(&mut random, radius).into_iter().skip(1) {
            viewpoint.size = [512, 512];
            let mut plan = Plan::new();
            let deformed = leaves
                .deform(&GPU, &mut plan, 0, &geometry, &pose, bounds.center())
                .unwrap_or_else(|error| panic!("{error}"));
            let [front, back] = depths(&mut plan, &deformed, &viewpoint, Layers::NearestBack);
            let differing = front.iter().zip(&back).filter(|(front, back)| (**front > 0.0) != (**back > 0.0)).count();
            let covered = front.iter().filter(|depth| **depth > 0.0).count();
            assert!(covered > 10_000, "{model}: {covered} texels of {viewpoint:?}");
            assert_eq!(differing, 0, "{model}: of {covered} texels of {viewpoint:?}");
        }
    }
}

/// Quads across the whole picture, one behind the other, each facing the viewer and away by turns.
fn stack(count: u32) -> Surface {
    let mut surface = Surface { points: Vec::new(), triangles: Vec::new() };
    for layer in 0..count {
        let first = surface.points.len() as u32;
        let corners = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)];
        surface.points.extend(corners.map(|(x, y)| DVec3::new(x, y, -1.0 - 0.1 * f64::from(layer))));
        let [a, b, c, d] = [0, 1, 2, 3].map(|corner| first + corner);
        let quad = [[a, b, c], [a, c, d]];
        surface.triangles.extend(if layer % 2 == 0 { quad } else { quad.map(|[a, b, c]| [a, c, b]) });
    }
    surface
}

/// The lists of layers hold the two layers that rasterising finds; so they do where there are more than there is room for.
#[test]
fn lists_of_layers_begin_with_the_rasterised_layers() {
    let mut random = Random(65);
    let mut scenes = vec![(stack(2), DMat4::IDENTITY), (stack(30), DMat4::IDENTITY)];
    for surface in [Surface::even(48, 23), Surface::uneven()] {
        let side = random.direction().as_dvec3();
        scenes.push((surface, look_along(3.0 * side, -side)));
    }
    for (surface, world_from_view) in scenes {
        let viewpoint = viewpoint(world_from_view, true, 0.45, 1e-3);
        let of = |layers| {
            let mut plan = Plan::new();
            let geometry = surface.deformed(&mut plan, 1.0);
            depths(&mut plan, &geometry, &viewpoint, layers)
        };
        let rasterised = of(Layers::NearestBack);
        for hierarchy in [Hierarchy::Cores, Hierarchy::CoresAndHulls] {
            let listed = of(Layers::All(hierarchy));
            for (ours, theirs) in listed.iter().flatten().zip(rasterised.iter().flatten()) {
                assert!((ours - theirs).abs() <= 2e-6 * theirs, "{ours} for {theirs}");
            }
        }
    }
}

/// A list says so where it does not hold every layer.
#[test]
fn short_lists_of_layers_are_marked() {
    for (count, short) in [(2, false), (30, true)] {
        let viewpoint = viewpoint(DMat4::IDENTITY, true, 0.45, 1e-3);
        let mut plan = Plan::new();
        let geometry = stack(count).deformed(&mut plan, 1.0);
        let layers = Layers::All(Hierarchy::Cores);
        let map =
            interface_map(&GPU, &mut plan, ("short", 0), &geometry.into(), &viewpoint.in_frame(DVec3::ZERO), layers)
                .unwrap_or_else(|error| panic!("{error}"));
        let lists = map.layer_lists.expect("asked for").lists;
        let executed =
            GPU.execute(&plan, &[lists], &mut History::new(), Skipping::Off).unwrap_or_else(|error| panic!("{error}"));
        for row in rows_of(&executed.targets[0]) {
            for count in [row.y, row.w].map(f32::to_bits) {
                // On the diagonal lie both triangles of a quad.
                assert!(count & 0xffff >= 2, "{count}");
                assert_eq!(count >= 1 << 16, short, "{count}");
            }
        }
    }
}
