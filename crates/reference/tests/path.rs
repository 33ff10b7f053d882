//! Whole pictures against closed forms and against the laws of energy and chance.

use std::f64::consts::PI;

use glam::{DMat4, DVec3, Vec3, Vec4};
use murano_animation::Pose;
use murano_optics::{beer_lambert, fresnel_unpolarised};
use murano_reference::{
    Camera, Convex, Ellipsoid, Fade, GlassBody, PathPicture, PathScene, PathSettings, PhotonMap, PhotonTracing, Plane,
    Receiver, Shape, TriangleMesh, World, path_picture, trace_photons,
};
use murano_scene::{
    Environment, Light, LightKind, Local, Material, Mesh, Node, PlacedLight, Primitive, Projection, Scene, Transform,
    look_along,
};
use proptest::prelude::*;

/// Light that is bright above and dim below, of three colours.
fn uneven_sky() -> Environment {
    let pixels = (0..64 * 32u32).map(|i| {
        let (x, y) = (i % 64, i / 64);
        let lamp = if (20..24).contains(&x) && (6..9).contains(&y) { 30.0 } else { 0.0 };
        [0.2 + lamp + x as f32 / 64.0, 0.5 + lamp, 1.5 - y as f32 / 32.0]
    });
    Environment { width: 64, height: 32, pixels: pixels.collect() }
}

fn even_sky() -> Environment {
    Environment { width: 1, height: 1, pixels: vec![[1.0; 3]] }
}

fn ball(ior: f64) -> GlassBody {
    GlassBody::clear(Shape::Ellipsoid(Ellipsoid { centre: DVec3::Y, radii: DVec3::splat(0.8) }), ior)
}

/// An octahedron whose interpolated normals are those of a ball: shading and geometry disagree by up to 55 degrees.
fn smooth_octahedron(ior: f64) -> GlassBody {
    let corners = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let faces = [[0, 2, 4], [4, 2, 1], [1, 2, 5], [5, 2, 0], [4, 3, 0], [1, 3, 4], [5, 3, 1], [0, 3, 5]];
    let positions = corners.map(|corner| DVec3::Y + 0.9 * corner);
    GlassBody::clear(Shape::Mesh(TriangleMesh::new(&positions, &corners, &faces).unwrap()), ior)
}

fn cube(ior: f64) -> GlassBody {
    let normals = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let faces = normals.map(|normal| Plane { normal, offset: 0.6 + normal.y });
    GlassBody::clear(Shape::Convex(Convex { faces: faces.to_vec() }), ior)
}

/// A square floor of half-side 10 at y = 0.
fn floor(material: Material) -> Scene {
    let corners = [[-10.0, -10.0], [-10.0, 10.0], [10.0, 10.0], [10.0, -10.0]];
    let primitive = Primitive {
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec(),
        normals: Some(vec![Vec3::Y; 4]),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(0),
        ..Primitive::default()
    };
    let node = Node {
        name: String::new(),
        parent: None,
        children: Vec::new(),
        local: Local::Trs(Transform::IDENTITY),
        mesh: Some(0),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    };
    Scene {
        nodes: vec![node],
        roots: vec![0],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        materials: vec![material],
        ..Scene::default()
    }
}

fn matte(albedo: f32) -> Material {
    Material {
        base_color: Vec4::new(albedo, albedo, albedo, 1.0),
        metallic: 0.0,
        roughness: 1.0,
        ..Material::default()
    }
}

fn world(scene: &Scene, bodies: Vec<GlassBody>) -> World {
    World { bodies, ..World::of_scene(scene, &Pose::rest(scene)).unwrap() }
}

fn lamp(kind: LightKind, from: DVec3, intensity: f32) -> PlacedLight {
    let light = Light { name: String::new(), kind, color: Vec3::ONE, intensity, range: f32::INFINITY };
    PlacedLight { world_from_light: look_along(from, -from), light }
}

fn above(size: u32) -> Camera {
    Camera::look_at(DVec3::new(0.3, 4.0, 5.0), DVec3::new(0.0, 0.5, 0.0), 0.6, [size, size])
}

fn lit<'a>(world: &'a World, scene: &'a Scene, environment: Option<&'a Environment>) -> PathScene<'a> {
    PathScene { world, scene, environment, lights: &[], photons: None, fade: None }
}

fn picture(scene: &PathScene<'_>, camera: &Camera, settings: &PathSettings) -> PathPicture {
    path_picture(scene, camera, settings, &|_, _| ())
}

#[test]
fn in_a_white_furnace_clear_glass_is_not_seen() {
    let (sky, nothing) = (even_sky(), Scene::default());
    for ior in [0.7, 1.2, 1.5, 2.4] {
        for (body, escapes) in [(ball(ior), 1e-4), (smooth_octahedron(ior), 0.1), (cube(ior), 1.0)] {
            let world = World::of_body(body);
            let seen = picture(&lit(&world, &nothing, Some(&sky)), &above(32), &PathSettings::default());
            for (radiance, pruned) in seen.radiance.iter().zip(&seen.pruned) {
                // What is missing is what was cut off: light that total reflection keeps in a cube for ever.
                assert!((radiance[0] + pruned - 1.0).abs() < 2e-6, "n = {ior}: {} + {pruned}", radiance[0]);
            }
            let cut = seen.pruned.iter().sum::<f32>() / seen.pruned.len() as f32;
            assert!(f64::from(cut) <= escapes, "n = {ior}: {cut}");
            assert!(seen.alpha.contains(&1.0) && seen.alpha.contains(&0.0));
        }
    }
}

#[test]
fn glass_like_air_is_invisible() {
    let sky = uneven_sky();
    let scene = floor(matte(0.7));
    let settings = PathSettings { scatterings: 0, samples: 2, ..PathSettings::default() };
    // Without light on the floor, which draws random numbers that the glass would shift.
    let nothing = Scene::default();
    let empty = picture(&lit(&World::default(), &nothing, Some(&sky)), &above(32), &settings);
    for body in [ball(1.0), smooth_octahedron(1.0), cube(1.0)] {
        let world = World::of_body(body);
        let seen = picture(&lit(&world, &nothing, Some(&sky)), &above(32), &settings);
        let differ = |a: &[f32; 3], b: &[f32; 3]| (0..3).any(|c| (a[c] - b[c]).abs() > 1e-5 * b[c]);
        assert!(!seen.radiance.iter().zip(&empty.radiance).any(|(a, b)| differ(a, b)));
    }
    // A floor behind it is lit as before by what reaches it on straight lines through the body.
    let settings = PathSettings { samples: 12, ..PathSettings::default() };
    let bare = world(&scene, Vec::new());
    let covered = world(&scene, vec![ball(1.0)]);
    let [bare, covered] =
        [&bare, &covered].map(|world| picture(&lit(world, &scene, Some(&sky)), &above(16), &settings));
    let sum = |picture: &PathPicture| picture.radiance.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>();
    let squares = |picture: &PathPicture| picture.standard_error.iter().map(|e| f64::from(e[0]).powi(2)).sum::<f64>();
    let error = (squares(&bare) + squares(&covered)).sqrt();
    assert!((sum(&bare) - sum(&covered)).abs() < 4.0 * error, "{} {} +- {error}", sum(&bare), sum(&covered));
}

#[test]
fn a_slab_reflects_and_transmits_what_the_series_says() {
    // White above, black below, with the horizon's blend kept to three degrees.
    let pixels = (0..64).map(|row| [if row < 32 { 1.0 } else { 0.0 }; 3]).collect();
    let sky = Environment { width: 1, height: 64, pixels };
    let nothing = Scene::default();
    for ior in [1.2, 1.5, 2.4] {
        for (angle, density) in [(0.1f64, 0.0), (0.8, 0.0), (1.2, 0.0), (0.8, 2.0)] {
            let mut body = GlassBody::clear(Shape::Convex(Convex::slab(0.3)), ior);
            body.absorption = DVec3::splat(density);
            let world = World::of_body(body);
            let direction = DVec3::new(angle.sin(), -angle.cos(), 0.0);
            let camera = Camera {
                world_from_view: look_along(-2.0 * direction, direction),
                projection: Projection::Orthographic { half_height: 0.1 },
                size: [4, 4],
            };
            let settings = PathSettings { smallest_weight: 1e-7, ..PathSettings::default() };
            let seen = picture(&lit(&world, &nothing, Some(&sky)), &camera, &settings);
            let reflectance = fresnel_unpolarised(angle.cos(), 1.0 / ior);
            let cos_inside = (1.0 - (angle.sin() / ior).powi(2)).sqrt();
            let kept = beer_lambert(DVec3::splat(density), 0.3 / cos_inside).x;
            // R + (1-R)^2 R a^2 (1 + R^2 a^2 + ...): every branch that comes back up.
            let series = (1.0 - reflectance).powi(2) * reflectance * kept * kept / (1.0 - (reflectance * kept).powi(2));
            let truth = reflectance + series;
            for rgb in &seen.radiance {
                assert!((f64::from(rgb[0]) - truth).abs() < 1e-6, "n = {ior}, {angle}, {density}: {rgb:?} {truth}");
            }
        }
    }
}

/// Branches that live by chance weigh for those that do not: the mean stays, however many are left to chance.
#[test]
fn roulette_does_not_change_the_mean() {
    let sky = even_sky();
    let nothing = Scene::default();
    let mut body = GlassBody::clear(Shape::Convex(Convex::slab(0.3)), 1.5);
    body.absorption = DVec3::splat(4.0);
    let world = World::of_body(body);
    let camera = Camera {
        world_from_view: look_along(2.0 * DVec3::Y, DVec3::NEG_Y),
        projection: Projection::Orthographic { half_height: 0.1 },
        size: [16, 16],
    };
    let with = |smallest_weight| {
        let settings = PathSettings { smallest_weight, samples: 6, ..PathSettings::default() };
        let seen = picture(&lit(&world, &nothing, Some(&sky)), &camera, &settings);
        let mean = seen.radiance.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 256.0;
        let error = seen.standard_error.iter().map(|e| f64::from(e[0]).powi(2)).sum::<f64>().sqrt() / 256.0;
        (mean, error)
    };
    let (truth, _) = with(1e-9);
    let (mean, error) = with(0.9);
    assert!(error < 0.01 && (mean - truth).abs() < 4.0 * error, "{mean} +- {error}, {truth}");
}

#[test]
fn a_lamp_over_a_matte_floor() {
    let scene = floor(matte(0.5));
    let world = world(&scene, Vec::new());
    let camera = Camera {
        world_from_view: look_along(3.0 * DVec3::Y, DVec3::NEG_Y),
        projection: Projection::Orthographic { half_height: 1e-3 },
        size: [2, 2],
    };
    let lamps = [lamp(LightKind::Point, 2.0 * DVec3::Y, 8.0), lamp(LightKind::Directional, DVec3::Y, 3.0)];
    let settings = PathSettings { scatterings: 0, ..PathSettings::default() };
    let seen = picture(&PathScene { lights: &lamps, ..lit(&world, &scene, None) }, &camera, &settings);
    // All directions are the normal: F = 0.04, D = 1 / pi, V = 1 / 4. The lamps give 8 / 2^2 and 3 lux.
    let truth = 5.0 * (0.96 * 0.5 + 0.04 * 0.25) / PI;
    assert!(seen.radiance.iter().all(|rgb| (f64::from(rgb[1]) - truth).abs() < 1e-5), "{:?} {truth}", seen.radiance);
    let below = lamp(LightKind::Point, -2.0 * DVec3::Y, 8.0);
    let dark = picture(&PathScene { lights: &[below], ..lit(&world, &scene, None) }, &camera, &settings);
    assert!(dark.radiance.iter().all(|rgb| *rgb == [0.0; 3]));
}

/// Sky and lobe are both sampled: what each finds must be weighed so that nothing counts twice.
#[test]
fn a_matte_floor_in_a_furnace_shows_its_albedo() {
    let (scene, sky) = (floor(matte(0.5)), even_sky());
    let world = world(&scene, Vec::new());
    for angle in [0.3f64, 1.0, 1.4] {
        let direction = DVec3::new(angle.sin(), -angle.cos(), 0.0);
        let camera = Camera {
            world_from_view: look_along(-direction, direction),
            projection: Projection::Orthographic { half_height: 0.1 },
            size: [16, 16],
        };
        let settings = PathSettings { samples: 12, ..PathSettings::default() };
        let seen = picture(&lit(&world, &scene, Some(&sky)), &camera, &settings);
        let mean = seen.radiance.iter().map(|rgb| f64::from(rgb[2])).sum::<f64>() / 256.0;
        let error = seen.standard_error.iter().map(|e| f64::from(e[2]).powi(2)).sum::<f64>().sqrt() / 256.0;
        let truth = rough_albedo(-direction, 0.5);
        assert!(error < 2e-3 && (mean - truth).abs() < 4.0 * error, "{angle}: {mean} +- {error}, {truth}");
    }
}

/// What a dielectric of roughness 1 reflects towards `view` of light that is even over the hemisphere about +y: the BRDF of
/// glTF 2.0 (appendix B.3) with alpha = 1, so that D = 1 / pi and V = 1 / (2 (n.l + n.v)), by a rule of midpoints.
fn rough_albedo(view: DVec3, albedo: f64) -> f64 {
    let steps = 500;
    let mut sum = 0.0;
    for i in 0..steps {
        for j in 0..2 * steps {
            let cosine = (i as f64 + 0.5) / steps as f64;
            let (sin, cos) = (PI * (j as f64 + 0.5) / steps as f64).sin_cos();
            let level = (1.0 - cosine * cosine).sqrt();
            let light = DVec3::new(level * cos, cosine, level * sin);
            let fresnel = 0.04 + 0.96 * (1.0 - view.dot((view + light).normalize())).powi(5);
            let value = (1.0 - fresnel) * albedo / PI + fresnel / PI * 0.5 / (cosine + view.y);
            sum += value * cosine * PI / (steps * steps) as f64;
        }
    }
    sum
}

#[test]
fn light_through_glass_arrives_as_photons() {
    let scene = floor(matte(0.5));
    let bare = world(&scene, Vec::new());
    let covered = world(&scene, vec![ball(1.0)]);
    let lamps = [lamp(LightKind::Directional, DVec3::new(1.0, 3.0, 0.5), 3.0)];
    let mut landings = Vec::new();
    let tracing = PhotonTracing { photons: 200_000, ..PhotonTracing::default() };
    trace_photons(&covered, &lamps[0], &Receiver::Opaque, &tracing, &|_, _| (), &mut |landing| landings.push(*landing))
        .unwrap();
    let photons = PhotonMap::new(landings, 0.05);
    // Looks at the middle of the shadow, which is 0.8 wide.
    let camera = Camera::look_at(DVec3::new(-0.4, 3.0, -0.1), DVec3::new(-0.3, 0.0, -0.17), 0.1, [16, 16]);
    let settings = PathSettings { scatterings: 0, samples: 2, ..PathSettings::default() };
    let lit_by = |world, photons| {
        let seen = picture(&PathScene { lights: &lamps, photons, ..lit(world, &scene, None) }, &camera, &settings);
        seen.radiance.iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / seen.radiance.len() as f64
    };
    let truth = lit_by(&bare, None);
    assert_eq!(lit_by(&covered, None), 0.0);
    // Jittered photons, a thousand in reach of each point.
    let through = lit_by(&covered, Some(&photons));
    assert!((through / truth - 1.0).abs() < 0.01, "{through} {truth}");
}

#[test]
fn a_fading_floor_melts_into_the_sky() {
    let sky = uneven_sky();
    let scene = floor(matte(0.5));
    let world = world(&scene, Vec::new());
    let camera = Camera::look_at(DVec3::new(0.0, 1.0, 0.0), DVec3::new(0.0, 0.5, 1.0), 0.9, [8, 32]);
    let fade = Some(Fade { material: 0, centre: DVec3::ZERO, radius: 4.0 });
    let settings = PathSettings { samples: 8, ..PathSettings::default() };
    let seen = picture(&PathScene { fade, ..lit(&world, &scene, Some(&sky)) }, &camera, &settings);
    let open = picture(&lit(&World::default(), &scene, Some(&sky)), &camera, &settings);
    let whole = picture(&lit(&world, &scene, Some(&sky)), &camera, &settings);
    let close = |a: &PathPicture, b: &PathPicture, pixel: usize, times: f32| {
        (0..3).all(|c| {
            let error = a.standard_error[pixel][c].hypot(b.standard_error[pixel][c]);
            (a.radiance[pixel][c] - b.radiance[pixel][c]).abs() <= times * error + 1e-4
        })
    };
    for pixel in 0..8 * 32 {
        // Where the ray meets the floor, as a share of the radius.
        let ray = camera.pixel_ray(pixel);
        let share = ray.at(-ray.origin.y / ray.direction.y).length() / 4.0;
        if ray.direction.y < 0.0 && share < 0.4 {
            assert!(close(&seen, &whole, pixel, 5.0), "{pixel} {share}");
        }
        if ray.direction.y < -0.06 && share > 1.1 {
            assert!(close(&seen, &open, pixel, 1.0), "{pixel} {share}");
        }
    }
}

/// A lamp's light passes as far as what is between has faded.
#[test]
fn a_fading_roof_throws_a_fading_shadow() {
    let mut scene = floor(matte(0.5));
    scene.materials.push(matte(0.5));
    let mut roof = scene.meshes[0].clone();
    roof.primitives[0].material = Some(1);
    scene.meshes.push(roof);
    let raised = Transform { translation: DVec3::Y, ..Transform::IDENTITY };
    scene.nodes.push(Node { mesh: Some(1), local: Local::Trs(raised), ..scene.nodes[0].clone() });
    scene.roots.push(1);
    let covered = world(&scene, Vec::new());
    let bare_scene = floor(matte(0.5));
    let bare = world(&bare_scene, Vec::new());
    // Seen and lit below the roof's middle; the eye is under the roof, the lamp above it.
    let camera = Camera::look_at(DVec3::new(0.0, 0.5, 0.3), DVec3::ZERO, 1e-3, [2, 2]);
    let lamps = [lamp(LightKind::Point, 3.0 * DVec3::Y, 8.0)];
    let settings = PathSettings { scatterings: 0, ..PathSettings::default() };
    let seen = |world, scene, fade| {
        picture(&PathScene { lights: &lamps, fade, ..lit(world, scene, None) }, &camera, &settings).radiance[0][0]
    };
    let whole = seen(&bare, &bare_scene, None);
    assert_eq!(seen(&covered, &scene, None), 0.0);
    for (share, passing) in [(0.3, 0.0), (0.725, 0.5), (1.2, 1.0), (0.5875, 0.156_25)] {
        // 0.45 to 1 by a smooth step: half is gone in the middle, 5/32 at a quarter of the way.
        let fade = Fade { material: 1, centre: DVec3::new(4.0 * share, 1.0, 0.0), radius: 4.0 };
        let through = f64::from(seen(&covered, &scene, Some(fade)) / whole);
        assert!((through - passing).abs() < 0.02, "{share}: {through} for {passing}");
    }
}

#[test]
fn the_stated_error_is_the_spread_over_seeds() {
    let sky = uneven_sky();
    let scene = floor(Material { roughness: 0.5, ..matte(0.8) });
    let world = world(&scene, Vec::new());
    let camera = Camera::look_at(DVec3::new(0.0, 2.0, 3.0), DVec3::ZERO, 0.2, [16, 16]);
    let scene = lit(&world, &scene, Some(&sky));
    let seeds = 24;
    let settings = |seed| PathSettings { seed, ..PathSettings::default() };
    let pictures: Vec<PathPicture> = (0..seeds).map(|seed| picture(&scene, &camera, &settings(seed))).collect();
    let (mut spread, mut stated) = (0.0, 0.0);
    for pixel in 0..camera.pixels() {
        let values = pictures.iter().map(|picture| f64::from(picture.radiance[pixel][1]));
        let mean = values.clone().sum::<f64>() / seeds as f64;
        spread += values.map(|value| (value - mean).powi(2)).sum::<f64>() / (seeds - 1) as f64;
        stated += pictures.iter().map(|p| f64::from(p.standard_error[pixel][1]).powi(2)).sum::<f64>() / seeds as f64;
    }
    // Both variances are means over 256 pixels and 24 seeds.
    assert!((spread / stated - 1.0).abs() < 0.15, "{}", spread / stated);

    let more = picture(&scene, &camera, &PathSettings { passes: 4, ..settings(0) });
    assert_ne!(more.radiance, pictures[0].radiance, "every pass draws anew");
    let gain = pictures[0].noise() / more.noise();
    assert!((gain - 2.0).abs() < 0.2, "four times the samples gain {gain}");
    let target = 1.1 * more.noise();
    let enough = picture(&scene, &camera, &PathSettings { passes: 64, noise: target, ..settings(0) });
    assert!(enough.noise() <= target && (2..=5).contains(&enough.passes), "{}", enough.passes);
}

#[test]
fn threads_change_nothing() {
    let sky = uneven_sky();
    let scene = floor(matte(0.5));
    let world = world(&scene, vec![smooth_octahedron(1.5)]);
    let scene = lit(&world, &scene, Some(&sky));
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| picture(&scene, &above(24), &PathSettings { samples: 2, ..PathSettings::default() }))
    };
    let alone = with(1);
    assert_eq!(alone, with(3));
    let other = PathSettings { samples: 2, seed: 1, ..PathSettings::default() };
    assert_ne!(alone, picture(&scene, &above(24), &other));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Under light of radiance at most 1 everywhere, nothing shines brighter.
    #[test]
    fn energy_is_never_created(
        ior in 0.5f64..4.0,
        which in 0usize..3,
        density in 0.0f64..5.0,
        albedo in 0.0f32..1.0,
        roughness in 0.0f32..1.0,
        metallic in 0.0f32..1.0,
        turn in 0.0f64..6.3,
    ) {
        let sky = even_sky();
        let mut body = [ball, smooth_octahedron, cube][which](ior);
        body.absorption = DVec3::new(density, 0.0, 1.0);
        let nothing = Scene::default();
        let eye = DMat4::from_rotation_y(turn).transform_point3(DVec3::new(0.0, 3.0, 4.0));
        let camera = Camera::look_at(eye, DVec3::new(0.0, 0.7, 0.0), 0.5, [12, 12]);
        let settings = PathSettings { samples: 2, ..PathSettings::default() };
        let alone = World::of_body(body);
        let seen = picture(&lit(&alone, &nothing, Some(&sky)), &camera, &settings);
        // What roulette adds to one branch it takes from others: one light branch more or less.
        prop_assert!(seen.radiance.iter().flatten().all(|&value| (0.0..=1.0 + 5e-3).contains(&value)));

        let scene = floor(Material { roughness, metallic, ..matte(albedo) });
        let standing = world(&scene, alone.bodies);
        let seen = picture(&lit(&standing, &scene, Some(&sky)), &camera, &settings);
        let mean = seen.radiance.iter().map(|rgb| f64::from(rgb[1])).sum::<f64>() / 144.0;
        let error = seen.standard_error.iter().map(|e| f64::from(e[1]).powi(2)).sum::<f64>().sqrt() / 144.0;
        prop_assert!(mean <= 1.0 + 4.0 * error + 1e-6, "{mean} +- {error}");
    }
}
