//! The renderer against the reference tracer, frame after frame: every caster, every lamp, every pose, on a device that
//! remembers the frames before. What is dropped, or left over from another frame, shows as an error against the truth.

use glam::{DMat4, DVec3, Vec3};
use murano_animation::{Layer, Pose};
use murano_caustics::{Caustics, Method as CausticsMethod};
use murano_metrics::irradiance::{IrradianceMap, energy_ratio, relative_l1};
use murano_optics::{Ior, dispersed_ior, visible_spectrum};
use murano_reference::{Camera, PhotonClass, PhotonTracing, Status, Window, caustic_map, two_interfaces};
use murano_refraction::{Interfaces, Method, Refraction};
use murano_render::{Floor, FrameRequest, PlacedLight, Renderer, Stage, View, World};
use murano_scene::{
    EnvironmentChoice, FloorLevel, GlassBodies, Light, LightKind, Local, Mesh, Node, Primitive, Projection, Scene,
    Shot, Transform, look_along,
};
use murano_tests::bench::{
    Distribution, asset, degrees_between, glass_body, gpu, renderer, scalars, settings, still, under_waves, vectors,
};

/// Texels a side of the compared maps.
const TEXELS: u32 = 64;
/// Pixels a side of each of them: a picture samples points, and a focus is narrower than a texel.
const FINER: u32 = 12;

/// The floor's square that is compared.
fn window(floor: &Floor, half: f64) -> Window {
    let centre = DVec3::new(floor.center[0], floor.height, floor.center[1]);
    Window { centre, half_u: half * DVec3::X, half_v: half * DVec3::NEG_Z, size: [TEXELS, TEXELS] }
}

/// Looks straight down on a window from a height above it.
fn view_down(window: &Window, height: f64) -> View {
    let axis = |v: DVec3| v.normalize().extend(0.0);
    let eye = (window.centre + height * DVec3::Y).extend(1.0);
    View {
        world_from_view: DMat4::from_cols(axis(window.half_u), axis(window.half_v), DVec3::Y.extend(0.0), eye),
        projection: Projection::Orthographic { half_height: window.half_v.length() },
        near: 1e-3,
    }
}

/// What two refractions of every lamp's light through all glass add to a window, W/m^2 of white light.
fn traced(scene: &Scene, pose: &Pose, lamps: &[PlacedLight], window: Window) -> IrradianceMap {
    traced_with(scene, pose, lamps, window, 400_000)
}

/// The same by a number of photons from each lamp.
fn traced_with(scene: &Scene, pose: &Pose, lamps: &[PlacedLight], window: Window, photons: u64) -> IrradianceMap {
    let world = murano_reference::World::of_scene(scene, pose).expect("a world");
    let mut sum = vec![0.0; window.texels()];
    for lamp in lamps {
        let tracing = PhotonTracing { photons, ..PhotonTracing::default() };
        let map = caustic_map(&world, lamp, window, &tracing, &|_, _| {}).expect("a caustic");
        let green = map.class(PhotonClass::TwoRefractions).iter().map(|irradiance| irradiance.y);
        sum.iter_mut().zip(green).for_each(|(sum, irradiance)| *sum += irradiance);
    }
    IrradianceMap::new(window.size, window.texel_area(), sum).expect("a map")
}

/// The same, as it is drawn: red, green, blue.
fn rendered(renderer: &mut Renderer, request: &FrameRequest, window: &Window, height: f64) -> [IrradianceMap; 3] {
    let request =
        FrameRequest { view: view_down(window, height), size: [FINER * TEXELS; 2], aov: true, ..request.clone() };
    let aov = renderer.render(&request).expect("a frame").aov.expect("asked for");
    let irradiance = vectors(&aov, "caustic");
    let area = window.texel_area() / f64::from(FINER * FINER);
    std::array::from_fn(|channel| {
        let values = irradiance.iter().map(|rgb| rgb[channel].max(0.0)).collect();
        let fine = IrradianceMap::new([FINER * TEXELS; 2], area, values).expect("a map");
        fine.downsampled(FINER).expect("a whole number of pixels a texel")
    })
}

fn spot(position: DVec3, intensity: f32) -> PlacedLight {
    let kind = LightKind::Spot { inner: 0.6, outer: 0.7 };
    PlacedLight {
        world_from_light: look_along(position, -position),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity, range: f32::INFINITY },
    }
}

/// Balls of glass, centre and radius, over a floor.
fn balls(balls: &[(DVec3, f64)]) -> (World, Floor) {
    let mut world = glass_body(&asset("sphere.glb"), Ior::GLASS);
    let ball = world.scene.nodes.pop().expect("a ball");
    world.scene.roots.clear();
    for (translation, radius) in balls {
        let place = Transform { translation: *translation, scale: DVec3::splat(*radius), ..Transform::IDENTITY };
        world.scene.roots.push(world.scene.nodes.len());
        world.scene.nodes.push(Node { local: Local::Trs(place), ..ball.clone() });
    }
    let floor = Floor { height: -1.2, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    world.floor = Some(floor);
    (world, floor)
}

/// A lamp that stands among what it shines on: no picture holds all of that.
#[test]
fn a_point_light_throws_caustics_to_all_sides() {
    let around = [0.3_f64, 2.5, 4.4].map(|turn| (DVec3::new(3.4 * turn.cos(), -0.2, 3.4 * turn.sin()), 0.8));
    let (world, floor) = balls(&around);
    let mut lamp = spot(DVec3::new(0.0, 1.0, 0.0), 100.0);
    lamp.light.kind = LightKind::Point;
    let window = window(&floor, 9.0);
    // One in twenty of those that a lamp sends to all sides meets a ball.
    let truth = traced_with(&world.scene, &Pose::rest(&world.scene), std::slice::from_ref(&lamp), window, 6_000_000);
    let request = FrameRequest {
        lights: vec![lamp],
        caustics: Some(Caustics { photons: 192, interfaces: Interfaces::Two, ..Caustics::default() }),
        ..still(view_down(&window, 8.0), window.size, Refraction::default())
    };
    let [_, drawn, _] = rendered(&mut renderer(gpu(), world), &request, &window, 8.0);
    let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
    eprintln!("a lamp among three balls: energy {energy:.4}, relative L1 {l1:.3}");
    assert!((energy - 1.0).abs() < 0.005, "{energy}");
    assert!(l1 < 0.03, "{l1}");
}

/// The part of a ball that stands in an opaque thing's shadow throws no light.
#[test]
fn a_plate_before_a_ball_takes_its_part_of_the_caustic() {
    let (mut world, floor) = balls(&[(DVec3::ZERO, 1.15)]);
    let lamp = spot(DVec3::Y * 7.0, 100.0);
    let window = window(&floor, 3.0);
    let request = FrameRequest {
        lights: vec![lamp.clone()],
        caustics: Some(Caustics { photons: 192, interfaces: Interfaces::Two, ..Caustics::default() }),
        ..still(view_down(&window, 0.04), window.size, Refraction::default())
    };
    let open = traced(&world.scene, &Pose::rest(&world.scene), std::slice::from_ref(&lamp), window);
    // Over less than a half of the ball, whose light does not cross over into the plate's shadow.
    add_box(&mut world.scene, Vec3::new(0.15, 1.3, -3.0), Vec3::new(4.0, 1.3, 3.0));
    let truth = traced(&world.scene, &Pose::rest(&world.scene), std::slice::from_ref(&lamp), window);
    let kept = energy_ratio(&open, &truth).unwrap();
    assert!((0.2..0.8).contains(&kept), "the plate takes a part: {kept} is left");
    let mut renderer = renderer(gpu(), world);
    for method in CausticsMethod::ALL {
        let caustics = request.caustics.map(|caustics| Caustics { method, ..caustics });
        let request = FrameRequest { caustics, ..request.clone() };
        let [_, drawn, _] = rendered(&mut renderer, &request, &window, 0.04);
        let energy = energy_ratio(&truth, &drawn).unwrap();
        eprintln!("behind a plate, {method}: {kept:.3} of the light is left, energy {energy:.4}");
        assert!((energy - 1.0).abs() < 0.005, "{method}: {energy}");
    }
}

/// A body of unit size over a floor under a spot: its renderer and request, what is compared, and the truth of that.
fn over_floor(mut world: World) -> (Renderer, FrameRequest, Window, IrradianceMap) {
    let floor = Floor { height: -1.3, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    world.floor = Some(floor);
    let lamp = spot(DVec3::new(1.0, 6.0, 0.5), 100.0);
    let window = window(&floor, 1.6);
    let truth = traced_with(&world.scene, &Pose::rest(&world.scene), std::slice::from_ref(&lamp), window, 1_600_000);
    let request =
        FrameRequest { lights: vec![lamp], ..still(view_down(&window, 8.0), window.size, settings(Method::Layers, 5)) };
    (renderer(gpu(), world), request, window, truth)
}

/// Photons through a ball under a map of normals, which bends both interfaces and how footprints turn there. Bounded by what was measured,
/// plus a tenth.
#[test]
fn photons_see_a_map_of_normals() {
    let mut world = glass_body(&asset("sphere.glb"), Ior::GLASS);
    under_waves(&mut world.scene, 0.15);
    let (mut renderer, request, window, truth) = over_floor(world);
    for (method, most) in [(CausticsMethod::Beams, 0.0512), (CausticsMethod::Footprint, 0.042)] {
        let caustics = Some(Caustics { method, photons: 192, interfaces: Interfaces::Two, ..Caustics::default() });
        let [_, drawn, _] = rendered(&mut renderer, &FrameRequest { caustics, ..request.clone() }, &window, 8.0);
        let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
        eprintln!("under waves, {method}: energy {energy:.4}, relative L1 {l1:.4}");
        assert!((energy - 1.0).abs() < 0.005 && l1 < most, "{method}: energy {energy}, relative L1 {l1}");
    }
}

/// A ball of flat facets, whose light has steps that no footprint may smooth over. Bounded by what was measured, plus a twentieth: laid down as if
/// they were smooth they are .051 off.
#[test]
fn facets_throw_patches_with_edges() {
    const AROUND: u32 = 48;
    const UP: u32 = 24;
    let mut world = glass_body(&asset("sphere.glb"), Ior::GLASS);
    let place = |row: u32, column: u32| {
        let up = std::f32::consts::PI * row as f32 / UP as f32;
        let around = std::f32::consts::TAU * column as f32 / AROUND as f32;
        Vec3::new(up.sin() * around.sin(), up.cos(), up.sin() * around.cos())
    };
    let mut ball = Primitive { material: world.scene.meshes[0].primitives[0].material, ..Primitive::default() };
    ball.positions = (0..=UP).flat_map(|row| (0..=AROUND).map(move |column| place(row, column))).collect();
    for (row, column) in (0..UP).flat_map(|row| (0..AROUND).map(move |column| (row, column))) {
        let first = row * (AROUND + 1) + column;
        let below = first + AROUND + 1;
        ball.triangles.extend([[first, below, first + 1], [first + 1, below, below + 1]]);
    }
    world.scene.meshes[0].primitives = vec![ball];
    let (mut renderer, request, window, truth) = over_floor(world);
    let caustics = Some(Caustics { photons: 96, interfaces: Interfaces::Two, ..Caustics::default() });
    let [_, drawn, _] = rendered(&mut renderer, &FrameRequest { caustics, ..request }, &window, 8.0);
    let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
    eprintln!("facets: energy {energy:.4}, relative L1 {l1:.4}");
    assert!((energy - 1.0).abs() < 0.005 && l1 < 0.0492, "energy {energy}, relative L1 {l1}");
}

/// Adds an opaque box, or a plate where its height is none.
fn add_box(scene: &mut Scene, low: Vec3, high: Vec3) {
    let corner = |at: usize| {
        let bit = |axis: usize| if at >> axis & 1 == 1 { high[axis] } else { low[axis] };
        Vec3::new(bit(0), bit(1), bit(2))
    };
    // Counter-clockwise seen from outside: top, bottom, then around.
    let faces = [[2, 6, 7, 3], [0, 1, 5, 4], [4, 5, 7, 6], [0, 2, 3, 1], [1, 3, 7, 5], [0, 4, 6, 2]];
    let shown = if low.y == high.y { 1 } else { faces.len() };
    let mut solid = Primitive::default();
    for face in &faces[..shown] {
        let first = solid.positions.len() as u32;
        solid.positions.extend(face.map(corner));
        solid.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    scene.meshes.push(Mesh { name: "box".into(), primitives: vec![solid] });
    scene.roots.push(scene.nodes.len());
    scene.nodes.push(Node { mesh: Some(scene.meshes.len() - 1), ..Node::default() });
}

/// Light that a ball throws into the shadow of something opaque lies there; it goes past what is solid and not through it. Bounded by what
/// was measured, plus a tenth.
#[test]
fn light_reaches_what_opaque_things_hide_from_the_lamp() {
    // Behind its focus the ball's light has crossed over: what enters beside the plate lands under it.
    let plate = (Vec3::new(0.05, 1.2, -3.0), Vec3::new(4.0, 1.2, 3.0), DVec3::new(0.0, 7.0, 0.0));
    // Its light meets a wall's top, its side and the floor beyond, in the wall's shadow and out of it.
    let wall = (Vec3::new(0.15, -1.2, -0.6), Vec3::new(0.3, -0.6, 0.6), DVec3::new(-3.0, 6.0, 0.0));
    for (name, (low, high, place)) in [("plate", plate), ("wall", wall)] {
        let (mut world, floor) = balls(&[(DVec3::new(0.0, 0.4, 0.0), 0.5)]);
        add_box(&mut world.scene, low, high);
        let lamp = spot(place, 100.0);
        let window = window(&floor, 2.0);
        let truth =
            traced_with(&world.scene, &Pose::rest(&world.scene), std::slice::from_ref(&lamp), window, 1_600_000);
        let request =
            FrameRequest { lights: vec![lamp], ..still(view_down(&window, 0.04), window.size, Refraction::default()) };
        let mut renderer = renderer(gpu(), world);
        for method in [CausticsMethod::Splat, CausticsMethod::Beams, CausticsMethod::Footprint] {
            let caustics = Some(Caustics { photons: 192, method, interfaces: Interfaces::Two, ..Caustics::default() });
            let [_, drawn, _] = rendered(&mut renderer, &FrameRequest { caustics, ..request.clone() }, &window, 0.04);
            let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
            eprintln!("{name}, {method}: {:.3} W, energy {energy:.4}, relative L1 {l1:.4}", truth.flux());
            let most = match method {
                CausticsMethod::Splat => 0.0745,
                CausticsMethod::Beams => 0.063,
                _ => 0.0481,
            };
            assert!((energy - 1.0).abs() < 0.005 && l1 < most, "{name}, {method}: energy {energy}, relative L1 {l1}");
        }
    }
}

/// Of two balls, one of which stands in the other's light, wholly or with a part of it: each ray's light is counted once.
#[test]
fn casters_in_each_others_light_share_it() {
    // Followed through both; and where little of it meets both, each ray's light through one of them.
    for (aside, most) in [(0.35, [0.01, 0.07]), (0.95, [0.008, 0.1])] {
        let lamp = spot(DVec3::new(0.0, 7.0, 0.0), 100.0);
        let places = [DVec3::new(0.0, 1.0, 0.0), DVec3::new(aside, -0.4, 0.1)];
        let (world, floor) = balls(&places.map(|place| (place, 0.5)));
        let window = window(&floor, 3.0);
        let traced = murano_reference::World::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a world");
        let tracing = PhotonTracing { photons: 800_000, ..PhotonTracing::default() };
        let total = caustic_map(&traced, &lamp, window, &tracing, &|_, _| {}).expect("a caustic").total();
        let green = total.iter().map(|irradiance| irradiance.y).collect();
        let truth = IrradianceMap::new(window.size, window.texel_area(), green).expect("a map");
        let request = FrameRequest {
            lights: vec![lamp],
            caustics: Some(Caustics { photons: 192, ..Caustics::default() }),
            ..still(view_down(&window, 8.0), window.size, Refraction::default())
        };
        let [_, drawn, _] = rendered(&mut renderer(gpu(), world), &request, &window, 8.0);
        let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
        eprintln!("one ball in another's light, {aside} aside: energy {energy:.4}, relative L1 {l1:.3}");
        assert!((energy - 1.0).abs() < most[0] && l1 < most[1], "{aside} aside: energy {energy}, relative L1 {l1}");
    }
}

/// Three balls of different sizes and two lamps of different strength: to drop any of the six caustics, or to count one
/// twice, costs a tenth of the light and more. The balls stand so that none is in another's light.
#[test]
fn every_caster_and_every_lamp_throws_its_caustic() {
    let (world, floor) = balls(&[
        (DVec3::new(-3.6, 0.0, 0.3), 0.9),
        (DVec3::new(0.2, -0.1, -0.4), 0.8),
        (DVec3::new(3.6, -0.2, 0.4), 0.7),
    ]);
    let lamps = vec![spot(DVec3::new(1.0, 9.0, 0.5), 100.0), spot(DVec3::new(-1.0, 8.0, 3.0), 70.0)];
    let window = window(&floor, 6.0);
    let truth = traced(&world.scene, &Pose::rest(&world.scene), &lamps, window);
    let request = FrameRequest {
        lights: lamps.clone(),
        caustics: Some(Caustics {
            method: CausticsMethod::Footprint,
            photons: 192,
            map_size: 512,
            interfaces: Interfaces::Two,
        }),
        ..still(view_down(&window, 8.0), window.size, Refraction::default())
    };
    let mut renderer = renderer(gpu(), world);
    let [_, drawn, _] = rendered(&mut renderer, &request, &window, 8.0);
    let (energy, l1) = (energy_ratio(&truth, &drawn).unwrap(), relative_l1(&truth, &drawn).unwrap());
    eprintln!("three balls, two lamps: energy {energy:.4}, relative L1 {l1:.3}");
    assert!((energy - 1.0).abs() < 0.02, "{energy}");
    // A caustic in another place costs 2 of its share.
    assert!(l1 < 0.05, "{l1}");
    // And each by itself: without the other lamp, only its own caustic is there.
    let alone = FrameRequest { lights: vec![lamps[1].clone()], ..request };
    let [_, drawn, _] = rendered(&mut renderer, &alone, &window, 8.0);
    let truth = traced(&renderer_scene(&renderer), &Pose::rest(&renderer.world().scene), &lamps[1..], window);
    let energy = energy_ratio(&truth, &drawn).unwrap();
    assert!((energy - 1.0).abs() < 0.02, "the second lamp alone: {energy}");
}

/// A rainbow: each colour is where the photon tracer's light of its wavelengths is, and all of them together are white.
#[test]
fn a_dispersed_caustic_is_that_of_its_wavelengths() {
    const WAVELENGTHS: u32 = 4;
    const DISPERSION: f32 = 4.0;
    let mut world = glass_body(&asset("bumpy.glb"), Ior::GLASS);
    world.scene.materials.iter_mut().for_each(|material| material.dispersion = DISPERSION);
    let floor = Floor { height: -1.3, center: [0.0, 0.0], half_extent: 60.0, albedo: [0.5; 3] };
    world.floor = Some(floor);
    let lamp = spot(DVec3::new(1.0, 6.0, 0.5), 100.0);
    let window = window(&floor, 1.6);
    let mut traced_world = murano_reference::World::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a world");
    let mut truths = [vec![DVec3::ZERO; window.texels()], vec![DVec3::ZERO; window.texels()]];
    for sample in visible_spectrum(WAVELENGTHS as usize) {
        traced_world.bodies[0].ior = dispersed_ior(Ior::GLASS, f64::from(DISPERSION), sample.wavelength).get();
        let tracing = PhotonTracing { photons: 1_000_000, ..PhotonTracing::default() };
        let map = caustic_map(&traced_world, &lamp, window, &tracing, &|_, _| {}).expect("a caustic");
        let kinds = [map.class(PhotonClass::TwoRefractions).to_vec(), map.total()];
        for (truth, irradiance) in truths.iter_mut().zip(kinds) {
            for (sum, irradiance) in truth.iter_mut().zip(irradiance) {
                *sum += DVec3::from(sample.weight) * irradiance.y;
            }
        }
    }
    let request = FrameRequest {
        lights: vec![lamp],
        ..still(
            view_down(&window, 8.0),
            window.size,
            Refraction { wavelengths: WAVELENGTHS, reflection: true, ..settings(Method::Layers, 5) },
        )
    };
    let mut renderer = renderer(gpu(), world);
    for (interfaces, truth, most) in [(Interfaces::Two, &truths[0], 0.025), (Interfaces::All, &truths[1], 0.046)] {
        let caustics = Some(Caustics { photons: 192, interfaces, ..Caustics::default() });
        let drawn = rendered(&mut renderer, &FrameRequest { caustics, ..request.clone() }, &window, 8.0);
        let truth: [IrradianceMap; 3] = std::array::from_fn(|channel| {
            let values = truth.iter().map(|rgb| rgb[channel]).collect();
            IrradianceMap::new(window.size, window.texel_area(), values).expect("a map")
        });
        for (channel, (drawn, truth)) in drawn.iter().zip(&truth).enumerate() {
            let (energy, l1) = (energy_ratio(truth, drawn).unwrap(), relative_l1(truth, drawn).unwrap());
            eprintln!("dispersed, {interfaces}, channel {channel}: energy {energy:.4}, relative L1 {l1:.3}");
            assert!((energy - 1.0).abs() < 0.005, "{interfaces}, channel {channel}: energy {energy}");
            assert!(l1 < most, "{interfaces}, channel {channel}: {l1}");
        }
        // Without dispersion, or with its ends exchanged, this would not be so.
        let apart = relative_l1(&truth[0], &truth[2]).unwrap();
        assert!(apart > 0.15, "red and blue lie in the same places: {apart}");
    }
}

/// The scene without the floor that the renderer appends.
fn renderer_scene(renderer: &Renderer) -> Scene {
    let mut scene = renderer.world().scene.clone();
    scene.roots.pop();
    scene
}

fn dancer() -> (World, Stage) {
    let mut shot = Shot::for_model(&asset("dancer.glb"));
    shot.glass.bodies = GlassBodies::All;
    shot.glass.ior = Some(1.2);
    shot.glass.attenuation_distance = Some(f32::INFINITY);
    shot.environment = EnvironmentChoice::Absent;
    shot.floor.level = FloorLevel::Auto;
    Stage::open(shot).expect("a stage")
}

/// A clip played forward, held, and wound back on one device: at each moment eye and light see the body as it is then.
#[test]
fn a_played_clip_is_never_stale() {
    const SIZE: [u32; 2] = [320, 320];
    let (world, stage) = dancer();
    let floor = world.floor.expect("a floor");
    let mut renderer = renderer(gpu(), world);
    let scene = renderer_scene(&renderer);
    let usual = stage.request(0.0, &murano_render::Settings::default());
    let duration = scene.clips[0].duration;
    let window = window(&floor, 1.5 * stage.extent().radius);
    for share in [0.1, 0.35, 0.6, 0.6, 0.1] {
        let request = FrameRequest {
            playing: Layer::alone(Some(0), share * duration),
            size: SIZE,
            refraction: settings(Method::Newton, 5),
            caustics: Some(Caustics { photons: 192, interfaces: Interfaces::Two, ..Caustics::default() }),
            aov: true,
            ..usual.clone()
        };
        let pose = Pose::sample(&scene, &request.playing);
        let traced_world = murano_reference::World::of_scene(&scene, &pose).expect("a world");
        let camera =
            Camera { world_from_view: request.view.world_from_view, projection: request.view.projection, size: SIZE };
        let aov = renderer.render(&request).expect("a frame").aov.expect("asked for");
        let (status, exits) = (scalars(&aov, "status"), vectors(&aov, "exit_direction"));
        let truth = two_interfaces(&traced_world, &camera);
        let differ =
            truth.iter().zip(&status).filter(|(path, status)| (path.status == Status::NoGlass) != (**status == 0.0));
        let covered = truth.iter().filter(|path| path.status != Status::NoGlass).count();
        let differ = differ.count() as f64 / covered as f64;
        let both = truth.iter().zip(status.iter().zip(&exits));
        let angles = both.filter(|(path, (status, _))| path.status == Status::Left && **status == 1.0);
        let angles = Distribution::of(angles.map(|(path, (_, exit))| degrees_between(path.exit, *exit)).collect());
        let light = traced(&scene, &pose, &request.lights, window);
        // `newton` does not know what light goes on through another limb.
        let followed = FrameRequest { refraction: settings(Method::Layers, 5), ..request.clone() };
        let [_, drawn, _] = rendered(&mut renderer, &followed, &window, 6.0 * stage.extent().radius);
        let (energy, l1) = (energy_ratio(&light, &drawn).unwrap(), relative_l1(&light, &drawn).unwrap());
        eprintln!("at {share}: outline {differ:.5}, {angles}; caustic energy {energy:.3}, relative L1 {l1:.3}");
        // Between these moments the outline moves by tens of percents of the body.
        assert!(differ < 0.002, "outline at {share}: {differ}");
        assert!(angles.p50 < 0.1 && angles.mean < 0.5, "exit directions at {share}: {angles}");
        assert!((energy - 1.0).abs() < 0.02 && l1 < 0.15, "caustic at {share}: energy {energy}, relative L1 {l1}");
    }
}
