//! Bodies of glass within one another, and bodies that overlap: what the eye's rays and the lamps' light do there, against f64.

use glam::{DMat4, DVec3, Vec3};
use murano_animation::Pose;
use murano_caustics::Caustics;
use murano_metrics::irradiance::{IrradianceMap, energy_ratio, relative_l1};
use murano_optics::Ior;
use murano_reference::{Camera, PhotonTracing, Status, Window, all_interfaces, caustic_map};
use murano_refraction::{Interfaces, Method, Refraction};
use murano_render::{Floor, FrameRequest, PlacedLight, Skipping, View, World};
use murano_scene::{Light, LightKind, Local, Material, Node, Projection, Transform, look_along};
use murano_tests::bench::{
    Distribution, asset, degrees_between, glass_body, gpu, renderer, scalars, settings, still, vectors,
};

/// A ball of glass.
#[derive(Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
    ior: f64,
    /// What a metre of it leaves.
    colour: Vec3,
}

const fn ball(x: f64, y: f64, z: f64, radius: f64, ior: f64, colour: [f32; 3]) -> Ball {
    Ball { centre: DVec3::new(x, y, z), radius, ior, colour: Vec3::from_array(colour) }
}

/// One within another, aside from its middle, and in that a third one.
const WITHIN: [Ball; 3] = [
    ball(0.0, 0.0, 0.0, 1.0, 1.5, [0.9, 0.6, 0.5]),
    ball(0.2, 0.1, 0.1, 0.55, 1.2, [0.5, 0.9, 0.6]),
    ball(0.3, 0.15, 0.0, 0.25, 1.7, [1.0, 1.0, 1.0]),
];
/// Each a part of the way into the next, the last two of one glass.
const OVERLAPPING: [Ball; 3] = [
    ball(-0.7, 0.0, 0.0, 0.7, 1.5, [0.9, 0.6, 0.5]),
    ball(0.2, 0.2, 0.1, 0.55, 1.3, [0.5, 0.7, 0.9]),
    ball(0.8, 0.0, -0.2, 0.6, 1.3, [0.5, 0.7, 0.9]),
];

fn world(balls: &[Ball]) -> World {
    let mut world = glass_body(&asset("sphere.glb"), Ior::GLASS);
    let scene = &mut world.scene;
    let ball = scene.nodes.pop().expect("a ball");
    let mesh = scene.meshes[ball.mesh.expect("a ball")].clone();
    scene.roots.clear();
    for Ball { centre, radius, ior, colour } in balls {
        let mut mesh = mesh.clone();
        mesh.primitives[0].material = Some(scene.materials.len());
        let glass = scene.materials[0].clone();
        scene.materials.push(Material { ior: *ior, attenuation_color: *colour, attenuation_distance: 1.0, ..glass });
        scene.meshes.push(mesh);
        let place = Transform { translation: *centre, scale: DVec3::splat(*radius), ..Transform::IDENTITY };
        scene.roots.push(scene.nodes.len());
        scene.nodes.push(Node { local: Local::Trs(place), mesh: Some(scene.meshes.len() - 1), ..ball.clone() });
    }
    world
}

#[test]
fn the_eye_looks_through_bodies_within_bodies() {
    const SIZE: [u32; 2] = [256; 2];
    let view = View::look_at(DVec3::new(0.5, 1.0, 4.0), DVec3::ZERO, 0.65);
    let camera = Camera { world_from_view: view.world_from_view, projection: view.projection, size: SIZE };
    for (name, balls) in [("within", WITHIN), ("overlapping", OVERLAPPING)] {
        let scene = world(&balls).scene;
        let traced = murano_reference::World::of_scene(&scene, &Pose::rest(&scene)).expect("a world");
        let truth = all_interfaces(&traced, &camera, 8);
        let alone = murano_reference::World { bodies: traced.bodies.into_iter().take(1).collect(), opaque: None };
        let alone = all_interfaces(&alone, &camera, 8);
        for method in [Method::Layers, Method::Exact] {
            let refraction = Refraction { interfaces: Interfaces::All, ..settings(method, 5) };
            let request = still(view, SIZE, refraction);
            let mut renderer = renderer(gpu(), world(&balls));
            let aov = renderer.render(&request).expect("a frame").aov.expect("asked for");
            let (status, exits) = (scalars(&aov, "status"), vectors(&aov, "exit_direction"));
            let covered = truth.iter().filter(|path| path.status != Status::NoGlass).count();
            let left = |index: usize| truth[index].status == Status::Left && status[index] == 1.0;
            let angles = (0..status.len()).filter(|&i| left(i)).map(|i| degrees_between(truth[i].exit, exits[i]));
            let angles = Distribution::of(angles.collect());
            let shown = status
                .iter()
                .zip(&truth)
                .filter(|(status, path)| (**status == 0.0) != (path.status == Status::NoGlass));
            let lost = status.iter().filter(|&&status| status == 3.0).count();
            let (shown, lost) = (shown.count() as f64 / covered as f64, lost as f64 / covered as f64);
            let differs = |index: &usize| left(*index) && degrees_between(truth[*index].exit, alone[*index].exit) > 1.0;
            let differs = (0..status.len()).filter(differs).count() as f64 / covered as f64;
            eprintln!(
                "{name}, {method}: {angles}, outline {shown:.4}, lost {lost:.4}; without the others {differs:.2} over 1 degree"
            );
            assert!(differs > 0.2, "the other bodies would not be missed: {differs}");
            assert!(angles.p50 < 0.0001 && angles.p95 < 0.001 && angles.mean < 0.04, "{name}, {method}: {angles}");
            assert!(shown < 0.001 && lost < 0.0136, "{name}, {method}: outline {shown}, lost {lost}");
        }
    }
}

fn spot(position: DVec3) -> PlacedLight {
    let kind = LightKind::Spot { inner: 0.6, outer: 0.7 };
    PlacedLight {
        world_from_light: look_along(position, -position),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity: 100.0, range: f32::INFINITY },
    }
}

#[test]
fn light_falls_through_bodies_within_bodies() {
    const TEXELS: u32 = 64;
    const FINER: u32 = 12;
    let floor = Floor { height: -1.2, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    let lamp = spot(DVec3::new(0.8, 7.0, 0.5));
    let centre = DVec3::new(0.0, floor.height, 0.0);
    let window = Window { centre, half_u: 2.0 * DVec3::X, half_v: 2.0 * DVec3::NEG_Z, size: [TEXELS; 2] };
    for (name, balls, most) in [("within", WITHIN, 0.033), ("overlapping", OVERLAPPING, 0.025)] {
        let world = World { floor: Some(floor), ..world(&balls) };
        let traced = murano_reference::World::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a world");
        let tracing = PhotonTracing { photons: 1_600_000, ..PhotonTracing::default() };
        let truth = caustic_map(&traced, &lamp, window, &tracing, &|_, _| {}).expect("a caustic").total();
        let view = View {
            world_from_view: DMat4::from_cols(
                DVec3::X.extend(0.0),
                DVec3::NEG_Z.extend(0.0),
                DVec3::Y.extend(0.0),
                (centre + 8.0 * DVec3::Y).extend(1.0),
            ),
            projection: Projection::Orthographic { half_height: 2.0 },
            near: 1e-3,
        };
        let request = FrameRequest {
            lights: vec![lamp.clone()],
            caustics: Some(Caustics { photons: 192, ..Caustics::default() }),
            ..still(view, [FINER * TEXELS; 2], Refraction { reflection: true, ..settings(Method::Layers, 5) })
        };
        let aov = renderer(gpu(), world).render(&request).expect("a frame").aov.expect("asked for");
        let drawn = vectors(&aov, "caustic");
        for channel in 0..3 {
            let values = drawn.iter().map(|rgb| rgb[channel].max(0.0)).collect();
            let area = window.texel_area() / f64::from(FINER * FINER);
            let fine = IrradianceMap::new([FINER * TEXELS; 2], area, values).expect("a map");
            let drawn = fine.downsampled(FINER).expect("a whole number of pixels a texel");
            let values = truth.iter().map(|rgb| rgb[channel]).collect();
            let truth = IrradianceMap::new(window.size, window.texel_area(), values).expect("a map");
            let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
            eprintln!("{name}, channel {channel}: energy {energy:.4}, relative L1 {l1:.4}");
            assert!((energy - 1.0).abs() < 0.005 && l1 < most, "{name}, channel {channel}: energy {energy}, {l1}");
        }
    }
}

/// Joined or apart, what is drawn is what a cold start draws, and what has not changed is not drawn again.
#[test]
fn bodies_join_and_part_as_they_move() {
    let refraction = Refraction { interfaces: Interfaces::All, ..settings(Method::Layers, 5) };
    let view = View::look_at(DVec3::new(0.5, 1.0, 5.0), DVec3::ZERO, 0.65);
    let mut balls = WITHIN;
    balls[2] = ball(1.7, 0.0, 0.0, 0.4, 1.7, [1.0; 3]);
    let floor = Floor { height: -1.2, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    let moved = |x: f64| {
        let mut world = World { floor: Some(floor), ..world(&balls) };
        let Local::Trs(place) = &mut world.scene.nodes[2].local else { unreachable!() };
        place.translation.x = x;
        world
    };
    let request = FrameRequest {
        lights: vec![spot(DVec3::new(0.8, 7.0, 0.5))],
        caustics: Some(Caustics { photons: 64, map_size: 128, ..Caustics::default() }),
        ..still(view, [128; 2], refraction)
    };
    // Apart from the others, then into the outer one.
    for x in [1.7, 1.2] {
        let mut renderer = renderer(gpu(), moved(x));
        let first = renderer.render(&request).expect("a frame");
        let instances = |name: &str| {
            first
                .passes
                .iter()
                .filter(|pass| pass.name.split(':').next() == Some(name) && pass.decision == "ran")
                .count()
        };
        let expected = if x > 1.4 { 2 } else { 1 };
        assert_eq!([instances("refract"), instances("emit")], [expected; 2], "bodies at {x}");
        let again = renderer.render(&request).expect("a frame");
        assert!(again.passes.iter().all(|pass| pass.decision != "ran"), "a repeated frame runs something");
        assert_eq!(first.rgba, again.rgba);
        let aside =
            FrameRequest { view: View::look_at(DVec3::new(1.5, 1.0, 5.0), DVec3::ZERO, 0.65), ..request.clone() };
        let verified = FrameRequest { skipping: Skipping::Verify, ..aside };
        renderer.render(&verified).expect("what is reused is what would be computed");
    }
}
