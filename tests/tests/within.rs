//! Bodies of glass within one another, and bodies that overlap: what the eye's rays and the lamps' light do there, against f64.

use glam::{DMat4, DVec3, Vec3};
use murano_animation::Pose;
use murano_caustics::Caustics;
use murano_metrics::irradiance::{IrradianceMap, energy_ratio, relative_l1};
use murano_optics::{Ior, SpectralSample, dispersed_ior, visible_spectrum};
use murano_reference::{Camera, PhotonTracing, Status, Window, all_interfaces, caustic_map};
use murano_refraction::{Interfaces, Method, Refraction};
use murano_render::{Floor, FrameRequest, Moment, PlacedLight, Skipping, View, World};
use murano_scene::{Light, LightKind, Local, Material, Node, Projection, Transform, look_along};
use murano_tests::bench::{
    Distribution, asset, degrees_between, glass_body, gpu, pixel_ray, renderer, scalars, settings, still, vectors,
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

/// Energy over the truth's and relative L1 of the caustic of some balls over a floor, red, green, blue.
fn caustic_error(balls: &[Ball], method: Method, dispersion: f32) -> [(f64, f64); 3] {
    const TEXELS: u32 = 64;
    const FINER: u32 = 12;
    const WAVELENGTHS: u32 = 4;
    let floor = Floor { height: -1.2, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    let lamp = spot(DVec3::new(0.8, 7.0, 0.5));
    let centre = DVec3::new(0.0, floor.height, 0.0);
    let window = Window { centre, half_u: 2.0 * DVec3::X, half_v: 2.0 * DVec3::NEG_Z, size: [TEXELS; 2] };
    let mut world = World { floor: Some(floor), ..world(balls) };
    world.scene.materials.iter_mut().for_each(|material| material.dispersion = dispersion);
    let mut traced = murano_reference::World::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a world");
    let bands: Vec<(DVec3, Option<f64>)> = if dispersion > 0.0 {
        let band = |band: SpectralSample| (DVec3::from(band.weight), Some(band.wavelength));
        visible_spectrum(WAVELENGTHS as usize).into_iter().map(band).collect()
    } else {
        vec![(DVec3::ONE, None)]
    };
    let mut truth = vec![DVec3::ZERO; window.texels()];
    for (weight, wavelength) in &bands {
        for (body, ball) in traced.bodies.iter_mut().zip(balls) {
            let n_d = Ior::new(ball.ior).expect("an index");
            body.ior = wavelength.map_or(ball.ior, |wave| dispersed_ior(n_d, f64::from(dispersion), wave).get());
        }
        let tracing = PhotonTracing { photons: 600_000 / bands.len() as u64, ..PhotonTracing::default() };
        let map = caustic_map(&traced, &lamp, window, &tracing, &|_, _| {}).expect("a caustic");
        truth.iter_mut().zip(map.total()).for_each(|(sum, irradiance)| *sum += *weight * irradiance);
    }
    let place = [DVec3::X, DVec3::NEG_Z, DVec3::Y].map(|axis| axis.extend(0.0));
    let view = View {
        world_from_view: DMat4::from_cols(place[0], place[1], place[2], (centre + 8.0 * DVec3::Y).extend(1.0)),
        projection: Projection::Orthographic { half_height: 2.0 },
        near: 1e-3,
    };
    let refraction = Refraction { reflection: true, wavelengths: WAVELENGTHS, ..settings(method, 5) };
    let request = FrameRequest {
        lights: vec![lamp],
        caustics: Some(Caustics { photons: 192, ..Caustics::default() }),
        ..still(view, [FINER * TEXELS; 2], refraction)
    };
    let aov = renderer(gpu(), world).render(&request).expect("a frame").aov.expect("asked for");
    let drawn = vectors(&aov, "caustic");
    std::array::from_fn(|channel| {
        let values = drawn.iter().map(|rgb| rgb[channel].max(0.0)).collect();
        let area = window.texel_area() / f64::from(FINER * FINER);
        let fine = IrradianceMap::new([FINER * TEXELS; 2], area, values).expect("a map");
        let drawn = fine.downsampled(FINER).expect("a whole number of pixels a texel");
        let values = truth.iter().map(|rgb| rgb[channel]).collect();
        let truth = IrradianceMap::new(window.size, window.texel_area(), values).expect("a map");
        (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap())
    })
}

#[test]
fn light_falls_through_bodies_within_bodies() {
    let cases = [
        ("within", WITHIN, Method::Layers, 0.0, 0.0435),
        ("within, exact", WITHIN, Method::Exact, 0.0, 0.0435),
        ("overlapping", OVERLAPPING, Method::Layers, 0.0, 0.0335),
        ("dispersed", WITHIN, Method::Layers, 4.0, 0.087),
    ];
    for (name, balls, method, dispersion, most) in cases {
        for (channel, (energy, l1)) in caustic_error(&balls, method, dispersion).into_iter().enumerate() {
            eprintln!("{name}, channel {channel}: energy {energy:.4}, relative L1 {l1:.4}");
            // Of four wavelengths each leaves a little aside.
            let least = if dispersion > 0.0 { 0.01 } else { 0.005 };
            assert!((energy - 1.0).abs() < least && l1 < most, "{name}, channel {channel}: energy {energy}, {l1}");
        }
    }
}

/// Slabs of other glass that lie on one another bend light no more than one of them does: it goes on as it came.
#[test]
fn faces_that_touch_are_both_met() {
    const SIZE: [u32; 2] = [64; 2];
    let mut world = glass_body(&asset("slab.glb"), Ior::GLASS);
    let scene = &mut world.scene;
    let slab = scene.nodes.pop().expect("a slab");
    let mesh = scene.meshes[slab.mesh.expect("a slab")].clone();
    let heights: Vec<f32> = mesh.primitives[0].positions.iter().map(|position| position.y).collect();
    let thickness = heights.iter().fold(f32::MIN, |a, &b| a.max(b)) - heights.iter().fold(f32::MAX, |a, &b| a.min(b));
    scene.roots.clear();
    for (level, ior) in [1.5, 1.2, 1.7].into_iter().enumerate() {
        let mut mesh = mesh.clone();
        mesh.primitives[0].material = Some(scene.materials.len());
        scene.materials.push(Material { ior, ..scene.materials[0].clone() });
        scene.meshes.push(mesh);
        let translation = DVec3::Y * (level as f64 * f64::from(thickness));
        scene.roots.push(scene.nodes.len());
        scene.nodes.push(Node {
            local: Local::Trs(Transform { translation, ..Transform::IDENTITY }),
            mesh: Some(scene.meshes.len() - 1),
            ..slab.clone()
        });
    }
    let view = View::look_at(DVec3::new(0.3, 6.0, 0.4), DVec3::ZERO, 0.05);
    let mut slabs = renderer(gpu(), world);
    for method in [Method::Layers, Method::Exact] {
        let refraction = Refraction { interfaces: Interfaces::All, ..settings(method, 5) };
        let aov = slabs.render(&still(view, SIZE, refraction)).expect("a frame").aov.expect("asked for");
        // Near the border of the picture `layers` does not know where light goes on to.
        let shown: Vec<usize> =
            (0..64 * 64).filter(|i| [i % 64, i / 64].iter().all(|at| (8..56).contains(at))).collect();
        let (status, exits, lengths) =
            (scalars(&aov, "status"), vectors(&aov, "exit_direction"), scalars(&aov, "path_length"));
        let off = shown.iter().map(|&index| degrees_between(pixel_ray(&view, SIZE, index).1, exits[index])).collect();
        let (off, lengths) =
            (Distribution::of(off), Distribution::of(shown.iter().map(|&index| lengths[index]).collect()));
        eprintln!("{method}: {off}, within glass {lengths}");
        assert!(shown.iter().all(|&index| status[index] == 1.0), "{method}: not all light leaves");
        assert!(off.max < 1e-3, "{method}: {off}");
        assert!((lengths.mean / (3.0 * f64::from(thickness)) - 1.0).abs() < 0.01, "{method}: {lengths}");
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
        // With what moved since: another pose's geometry is no other body's.
        let before = Some(Moment { playing: Vec::new(), view: request.view });
        renderer.render(&FrameRequest { before, ..aside.clone() }).expect("a frame");
        let verified = FrameRequest { skipping: Skipping::Verify, ..aside };
        renderer.render(&verified).expect("what is reused is what would be computed");
    }
}
