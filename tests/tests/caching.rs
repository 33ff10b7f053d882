//! What a frame reuses, and that reuse never shows: a warm frame equals a cold one, bit for bit.

use std::collections::BTreeSet;

use glam::{DVec3, Vec3, Vec4};
use murano_animation::{Layer, Pose};
use murano_caustics::{Caustics, Method as CausticsMethod};
use murano_gpu::Gpu;
use murano_refraction::{Interfaces, Method, Refraction, TirPolicy};
use murano_render::{
    Floor, Frame, FrameRequest, PlacedLight, Renderer, Settings, Skipping, Stage, ToneMap, View, World,
};
use murano_scene::{
    Channel, Clip, Interpolation, Light, LightKind, Local, Material, Mesh, Node, Path, Primitive, Sampler, Scene, Shot,
    Transform, look_along,
};
use murano_tests::bench::{asset, gpu, renderer, still, vectors};

const SIZE: [u32; 2] = [96, 96];
const CAUSTICS: Caustics =
    Caustics { method: CausticsMethod::Footprint, photons: 24, map_size: 64, interfaces: Interfaces::All };

/// The dancer on her floor under her light, small.
fn dancer() -> (World, FrameRequest) {
    let (world, stage) = Stage::open(Shot::for_model(&asset("dancer.glb"))).expect("the dancer");
    let request = stage.request(0.25, &Settings { aov: true, caustics: Some(CAUSTICS), ..Settings::default() });
    (world, FrameRequest { size: SIZE, ..request })
}

fn render(renderer: &mut Renderer, request: &FrameRequest) -> Frame {
    renderer.render(request).unwrap_or_else(|error| panic!("{error}"))
}

/// Names of the passes that ran, without their instances.
fn ran(frame: &Frame) -> BTreeSet<&str> {
    let ran = frame.passes.iter().filter(|pass| pass.decision == "ran");
    ran.map(|pass| pass.name.split(':').next().expect("split gives one part")).collect()
}

/// Asserts that every pass of these names was reused, and that each name has one.
fn assert_reused(frame: &Frame, names: &[&str], when: &str) {
    for name in names {
        let mut found = frame.passes.iter().filter(|pass| pass.name.split(':').next() == Some(name)).peekable();
        assert!(found.peek().is_some(), "{when}: there is no pass {name}");
        for pass in found {
            assert_eq!(pass.decision, "reused", "{when}: {} ({})", pass.name, pass.reason);
        }
    }
}

/// Asserts that two frames show the same, bit for bit.
fn assert_equal(a: &Frame, b: &Frame, when: &str) {
    assert_eq!(a.size, b.size, "{when}");
    assert!(a.rgba == b.rgba, "{when}: the pictures differ");
    let (Some(a), Some(b)) = (&a.aov, &b.aov) else { return assert_eq!(a.aov.is_some(), b.aov.is_some(), "{when}") };
    for (a, b) in a.layers.iter().zip(&b.layers) {
        let bits = |planes: &[Vec<f32>]| -> Vec<u32> { planes.iter().flatten().map(|value| value.to_bits()).collect() };
        assert!(bits(&a.planes) == bits(&b.planes), "{when}: layer {} differs", a.name);
    }
}

/// Turns the camera about the vertical axis through the world's middle.
fn orbited(request: &FrameRequest, radians: f64) -> FrameRequest {
    let turn = glam::DMat4::from_rotation_y(radians);
    let view = View { world_from_view: turn * request.view.world_from_view, ..request.view };
    FrameRequest { view, ..request.clone() }
}

/// Moves the first light sideways, metres.
fn lit_from_beside(request: &FrameRequest, shift: f64) -> FrameRequest {
    let mut moved = request.clone();
    moved.lights[0].world_from_light.w_axis.x += shift;
    moved
}

#[test]
fn an_orbit_over_a_still_pose_runs_nothing_of_the_light() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    render(&mut renderer, &request);
    for k in 1..8 {
        let frame = render(&mut renderer, &orbited(&request, 0.2 * f64::from(k)));
        assert_reused(&frame, &["deform", "light_map", "receivers", "emit", "deposit"], &format!("orbit {k}"));
        assert!(ran(&frame).contains("refract"), "orbit {k}: the eye saw nothing new");
    }
}

/// What opaque things hide from the lamp is kept as well as what it sees.
#[test]
fn caustics_in_opaque_shadows_are_kept() {
    let world = || {
        let mut world = two_bodies();
        let plate = |height: f32, half: f32| Primitive {
            positions: [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
                .map(|[x, z]: [f32; 2]| Vec3::new(half * x + 0.9, height, half * z))
                .to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(world.scene.materials.len()),
            ..Primitive::default()
        };
        let primitives = vec![plate(2.5, 0.8), plate(-2.0, 8.0)];
        world.scene.materials.push(Material { metallic: 0.0, ..Material::default() });
        world.scene.roots.push(world.scene.nodes.len());
        world.scene.nodes.push(Node { mesh: Some(world.scene.meshes.len()), ..Node::default() });
        world.scene.meshes.push(Mesh { name: "plates".into(), primitives });
        world.floor = None;
        world
    };
    let view = View::look_at(DVec3::new(2.0, 4.0, 7.0), DVec3::ZERO, 0.8);
    let request = FrameRequest {
        playing: Layer::alone(Some(0), 0.0),
        lights: vec![sun()],
        caustics: Some(Caustics { map_size: 256, ..CAUSTICS }),
        ..still(view, SIZE, Refraction::default())
    };
    let mut warm = renderer(gpu(), world());
    render(&mut warm, &request);
    let orbit = render(&mut warm, &orbited(&request, 0.3));
    assert_reused(&orbit, &["hidden", "deposit", "deposit_hidden"], "an orbit");
    assert!(ran(&orbit).contains("receive_hidden"), "an orbit: the eye saw nothing new");
    let later = at_time(&request, 0.05);
    let moved = render(&mut warm, &later);
    let decision = |name: &str| moved.passes.iter().find(|pass| pass.name == name).expect("a pass").decision;
    assert_eq!([decision("deposit_hidden:0"), decision("deposit_hidden:1")], ["ran", "reused"]);
    assert_equal(&moved, &render(&mut renderer(gpu(), world()), &later), "one of two turned");
    let Frame { passes, .. } = render(&mut warm, &FrameRequest { skipping: Skipping::Verify, ..later });
    assert!(passes.iter().any(|pass| pass.name == "deposit_hidden:0"));
}

#[test]
fn a_moving_light_leaves_the_body_and_the_eye_alone() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    for k in 1..5 {
        let frame = render(&mut renderer, &lit_from_beside(&request, 0.1 * f64::from(k)));
        assert_reused(&frame, &["deform", "eye_map", "opaque"], &format!("light {k}"));
        assert!(ran(&frame).is_superset(&BTreeSet::from(["light_map", "emit", "deposit", "illuminate"])));
    }
    let back = render(&mut renderer, &request);
    assert_eq!(ran(&back), BTreeSet::new(), "a light that came back");
    assert_equal(&back, &first, "a light that came back");
}

#[test]
fn a_repeated_frame_runs_nothing_and_time_scrubbed_back_is_still_there() {
    let (world, request) = dancer();
    let at = |time: f64| at_time(&request, time);
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &at(0.5));
    let again = render(&mut renderer, &at(0.5));
    assert_eq!(ran(&again), BTreeSet::new());
    assert_equal(&again, &first, "again");
    let later = render(&mut renderer, &at(0.75));
    assert!(ran(&later).contains("deform"), "the dancer did not move");
    assert!(later.rgba != first.rgba, "the dancer did not move");
    let back = render(&mut renderer, &at(0.5));
    assert_eq!(ran(&back), BTreeSet::new(), "scrubbed back");
    assert_equal(&back, &first, "scrubbed back");
}

#[test]
fn samples_share_everything_but_what_the_eye_sees() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    let several = FrameRequest { samples: 3, ..request.clone() };
    let first = render(&mut renderer, &several);
    let again = render(&mut renderer, &several);
    assert_eq!(ran(&again), BTreeSet::new(), "again");
    assert_equal(&again, &first, "again");
    let brighter = render(&mut renderer, &FrameRequest { exposure: 2.0 * request.exposure, ..several.clone() });
    assert_eq!(ran(&brighter), BTreeSet::from(["composite"]));
    let orbit = orbited(&several, 0.2);
    let frame = render(&mut renderer, &orbit);
    assert_reused(&frame, &["deform", "light_map", "receivers", "emit", "deposit"], "orbit");
    assert!(ran(&frame).is_superset(&BTreeSet::from(["opaque", "refract", "accumulate", "composite"])));
    for skipping in [Skipping::Off, Skipping::Verify] {
        assert_equal(&frame, &render(&mut renderer, &FrameRequest { skipping, ..orbit.clone() }), "orbit, not skipped");
    }
    // The layers beside the picture are those of the first, whose rays go through the middle of the pixels.
    let one = render(&mut renderer, &request);
    let layer = |frame: &Frame, name: &str| vectors(frame.aov.as_ref().expect("asked for"), name);
    for name in ["p1", "exit_direction"] {
        assert!(layer(&one, name) == layer(&first, name), "{name} is of another ray");
    }
    assert!(layer(&one, "radiance") != layer(&first, "radiance"), "more samples see no more");
    for samples in [0, 1025] {
        let refused = renderer.render(&FrameRequest { samples, ..request.clone() });
        let message = refused.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(message.contains("samples of a pixel"), "{samples}: {message}");
    }
}

#[test]
fn skipping_changes_no_bit() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    for (k, edited) in
        [request.clone(), orbited(&request, 0.3), lit_from_beside(&request, 0.2), request].iter().enumerate()
    {
        let warm = render(&mut renderer, edited);
        for skipping in [Skipping::Off, Skipping::Verify] {
            let other = render(&mut renderer, &FrameRequest { skipping, ..edited.clone() });
            assert_equal(&warm, &other, &format!("edit {k}, {skipping:?}"));
        }
    }
}

#[test]
fn a_mirror_s_caustic_is_as_well_kept_as_one_of_glass() {
    let (world, stage) = Stage::open(Shot::for_model(&asset("ring.glb"))).expect("the ring");
    let request = stage.request(0.0, &Settings { aov: true, caustics: Some(CAUSTICS), ..Settings::default() });
    let request = FrameRequest { size: SIZE, ..request };
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    assert!(ran(&first).is_superset(&BTreeSet::from(["light_map", "emit", "deposit", "receive"])));
    let caustic = vectors(first.aov.as_ref().expect("asked for"), "caustic");
    assert!(caustic.iter().any(|light| light.max_element() > 0.0), "the ring throws no light");
    let orbit = render(&mut renderer, &orbited(&request, 0.2));
    assert_reused(&orbit, &["deform", "light_map", "receivers", "emit", "deposit"], "orbit");
    let moved = lit_from_beside(&request, 0.1);
    let warm = render(&mut renderer, &moved);
    assert_equal(&warm, &render(&mut renderer, &FrameRequest { skipping: Skipping::Verify, ..moved }), "verified");
    let dark = render(&mut renderer, &FrameRequest { caustics: None, ..request });
    assert!(!ran(&dark).contains("emit"), "photons without caustics");
    assert!(dark.passes.iter().any(|pass| pass.name == "deform:1" && pass.decision == "culled"));
}

#[test]
fn a_light_s_colour_reaches_the_picture_without_its_photons() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    let mut dimmed = request.clone();
    dimmed.lights[0].light.intensity *= 0.5;
    let mut red = request.clone();
    red.lights[0].light.color = Vec3::new(1.0, 0.2, 0.1);
    for (edited, what) in [(dimmed, "intensity"), (red, "colour")] {
        let frame = render(&mut renderer, &edited);
        assert_eq!(ran(&frame), BTreeSet::from(["composite", "illuminate", "refract"]), "{what}");
        assert!(frame.rgba != first.rgba, "{what} shows nowhere");
    }
}

/// The world again, with glass that absorbs.
fn stained(mut world: World) -> World {
    for material in &mut world.scene.materials {
        if material.is_glass() {
            material.attenuation_color = Vec3::new(0.2, 0.5, 0.9);
            material.attenuation_distance = 0.3;
        }
    }
    world
}

#[test]
fn what_glass_absorbs_moves_no_photon() {
    let (world, request) = dancer();
    let mut clear = renderer(gpu(), world);
    render(&mut clear, &request);
    let mut changed = renderer(clear.into_gpu(), stained(dancer().0));
    let frame = render(&mut changed, &request);
    assert_reused(&frame, &["deform", "eye_map", "light_map", "receivers", "emit"], "attenuation");
    assert!(ran(&frame).is_superset(&BTreeSet::from(["deposit", "refract"])), "{:?}", ran(&frame));
    let cold = render(&mut renderer(gpu(), stained(dancer().0)), &request);
    assert_equal(&frame, &cold, "attenuation");
}

/// Marsaglia's xorshift: the same edits on every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: u64) -> u64 {
        (self.roll() >> 11) % n
    }

    /// In [0, 1), one of few, so that states come back.
    fn share(&mut self) -> f64 {
        self.below(6) as f64 / 6.0
    }
}

/// The same with the clip at another time.
fn at_time(request: &FrameRequest, time: f64) -> FrameRequest {
    let mut request = request.clone();
    request.playing.iter_mut().for_each(|layer| layer.time = time);
    request
}

/// One random change of a request.
fn edit(request: &mut FrameRequest, original: &FrameRequest, dice: &mut Dice) {
    match dice.below(13) {
        0 | 1 => *request = at_time(request, dice.share()),
        2 => *request = FrameRequest { view: orbited(original, dice.share()).view, ..request.clone() },
        3 => request.view.world_from_view.w_axis.y = original.view.world_from_view.w_axis.y + dice.share(),
        4 => request.lights = lit_from_beside(original, dice.share()).lights,
        5 => request.lights[0].light.intensity = original.lights[0].light.intensity * dice.share() as f32,
        6 => {
            request.lights[0].light.kind = match dice.below(3) {
                0 => LightKind::Directional,
                1 => LightKind::Point,
                _ => original.lights[0].light.kind,
            }
        }
        7 => request.refraction.method = Method::ALL[dice.below(Method::ALL.len() as u64) as usize],
        8 => {
            request.refraction = Refraction {
                steps: 1 + dice.below(6) as u32,
                tir: TirPolicy::ALL[dice.below(TirPolicy::ALL.len() as u64) as usize],
                reflection: dice.below(2) == 0,
                ..request.refraction
            }
        }
        9 => {
            request.caustics = match dice.below(4) {
                0 => None,
                k => Some(Caustics { photons: 8 * k as u32, map_size: 32 << dice.below(2), ..CAUSTICS }),
            }
        }
        10 => request.size = [[64, 48], [48, 48], [40, 56]][dice.below(3) as usize],
        11 => request.exposure = 0.5 + dice.share() as f32,
        _ => request.tone_map = [ToneMap::Linear, ToneMap::Neutral, ToneMap::Agx][dice.below(3) as usize],
    }
}

/// Two tests of half the edits run at once.
#[test]
fn random_edits_never_show_an_old_frame() {
    random_edits(0x9e37_79b9_7f4a_7c15);
}

#[test]
fn other_random_edits_never_show_an_old_frame() {
    random_edits(0xd1b5_4a32_d192_ed03);
}

fn random_edits(seed: u64) {
    const STEPS: u32 = 100;
    let (world, mut request) = dancer();
    request.size = [64, 48];
    let original = request.clone();
    let mut warm = renderer(gpu(), world);
    // Of its own device, and without skipping: it computes every frame from nothing but the request.
    let mut cold = renderer(gpu(), dancer().0);
    let mut dice = Dice(seed);
    let (mut reused, mut needed) = (0, 0);
    for k in 0..STEPS {
        edit(&mut request, &original, &mut dice);
        let frame = render(&mut warm, &request);
        let expected = render(&mut cold, &FrameRequest { skipping: Skipping::Off, ..request.clone() });
        assert_equal(&frame, &expected, &format!("edit {k}, {request:?}"));
        reused += frame.passes.iter().filter(|pass| pass.decision == "reused").count();
        needed += frame.passes.iter().filter(|pass| pass.decision != "culled").count();
    }
    eprintln!("{STEPS} random edits: {reused} of {needed} passes were reused");
    // A test that never reuses would prove nothing.
    assert!(2 * reused > needed, "{reused} of {needed}");
}

fn exits(frame: &Frame) -> Vec<DVec3> {
    vectors(frame.aov.as_ref().expect("asked for"), "exit_direction")
}

/// Caustic light at every pixel, lux, red.
fn caustic_of(frame: &Frame) -> &[f32] {
    let aov = frame.aov.as_ref().expect("asked for");
    &aov.layers.iter().find(|layer| layer.name == "caustic").expect("a layer of AOV_LAYERS").planes[0]
}

#[test]
fn a_caster_that_leaves_the_light_s_view_takes_its_caustic_along() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    assert!(caustic_of(&first).iter().any(|value| *value > 0.0));
    let mut away = request.clone();
    let place = &mut away.lights[0].world_from_light;
    let position = place.w_axis.truncate();
    // Onto the floor on the far side of the lamp.
    *place = look_along(position, DVec3::new(position.x, -position.y, position.z));
    let dark = render(&mut renderer, &away);
    let light_map = dark.passes.iter().find(|pass| pass.name.starts_with("light_map")).expect("the pass is declared");
    assert_eq!(light_map.decision, "culled", "{}", light_map.reason);
    assert!(caustic_of(&dark).iter().all(|value| *value == 0.0), "a caustic without light");
    let back = render(&mut renderer, &request);
    assert_equal(&back, &first, "back in the light");
}

#[test]
fn a_light_switched_off_and_on() {
    let (world, request) = dancer();
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    let mut off = request.clone();
    off.lights[0].light.intensity = 0.0;
    let dark = render(&mut renderer, &off);
    assert!(caustic_of(&dark).iter().all(|value| *value == 0.0));
    let none = render(&mut renderer, &FrameRequest { lights: Vec::new(), ..request.clone() });
    assert_equal(&dark, &none, "a light that is out is no light");
    let on = render(&mut renderer, &request);
    assert_eq!(ran(&on), BTreeSet::new(), "switched on again");
    assert_equal(&on, &first, "switched on again");
}

#[test]
fn a_skeleton_that_moves_out_of_the_picture_still_moves_its_caustic() {
    let (world, mut request) = dancer();
    let floor = world.floor.expect("the dancer stands on one");
    let lamp = request.lights[0].world_from_light.w_axis.truncate();
    let head = DVec3::new(floor.center[0], floor.height + 1.2, floor.center[1]);
    // Where the upper body throws its shadow; the camera looks straight down at that from low above the floor.
    let shadow = lamp + (head - lamp) * ((floor.height - lamp.y) / (head.y - lamp.y));
    request.view = View::look_at(shadow + DVec3::Y * 0.4, shadow, 0.8);
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    let eye_map = first.passes.iter().find(|pass| pass.name.starts_with("eye_map")).expect("the pass is declared");
    assert_eq!(eye_map.decision, "culled", "the body is in the picture: {}", eye_map.reason);
    assert!(caustic_of(&first).iter().any(|value| *value > 0.0), "no caustic in the picture");
    let later_request = at_time(&request, request.time() + 0.5);
    let later = render(&mut renderer, &later_request);
    assert!(ran(&later).is_superset(&BTreeSet::from(["deform", "light_map", "emit", "deposit"])), "{:?}", ran(&later));
    assert!(caustic_of(&first) != caustic_of(&later), "the caustic stood still");
    let cold = render(&mut renderer, &FrameRequest { skipping: Skipping::Off, ..later_request });
    assert_equal(&later, &cold, "off-screen");
}

/// A tetrahedron of glass on four corners of a cube. It turns about +Y by a quarter in a second, onto the other four: its
/// bounding box at both ends is the cube.
fn turning_tetrahedron() -> World {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]].map(Vec3::from_array);
    let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    let primitive = Primitive {
        positions: faces.iter().flatten().map(|corner| corners[*corner]).collect(),
        triangles: (0..4).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
        material: Some(0),
        ..Primitive::default()
    };
    let quarter = std::f32::consts::FRAC_PI_4.sin_cos();
    let sampler = Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width: 4,
        values: vec![0.0, 0.0, 0.0, 1.0, 0.0, quarter.0, 0.0, quarter.1],
    };
    let node = Node {
        name: "tetrahedron".into(),
        parent: None,
        children: Vec::new(),
        local: Local::Trs(Transform::IDENTITY),
        mesh: Some(0),
        skin: None,
        camera: None,
        light: None,
        weights: Vec::new(),
    };
    let scene = Scene {
        nodes: vec![node],
        roots: vec![0],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        materials: vec![Material { base_color: Vec4::ONE, ..Material::glass(1.3) }],
        clips: vec![Clip {
            name: "turn".into(),
            channels: vec![Channel { node: 0, path: Path::Rotation, sampler }],
            duration: 1.0,
            ..Clip::default()
        }],
        ..Scene::default()
    };
    let floor = Floor { height: -1.5, center: [0.0, 0.0], half_extent: 20.0, albedo: [0.5; 3] };
    World { scene, environment: None, floor: Some(floor) }
}

fn sun() -> PlacedLight {
    PlacedLight {
        world_from_light: look_along(DVec3::Y * 5.0, DVec3::new(0.1, -1.0, 0.05)),
        light: Light {
            name: String::new(),
            kind: LightKind::Directional,
            color: Vec3::ONE,
            intensity: 2.0,
            range: f32::INFINITY,
        },
    }
}

#[test]
fn a_turn_that_keeps_the_bounding_box_is_seen() {
    let world = thin_tetrahedron();
    let scene = &world.scene;
    let bounds = |time: f64| {
        let geometry = murano_animation::Geometry::build(scene, &murano_animation::shown_primitives(scene));
        geometry.expect("four triangles").posed_bounds(&Pose::sample(scene, &Layer::alone(Some(0), time)))
    };
    let (start, end) = (bounds(0.0), bounds(1.0));
    assert!(start.min.distance(end.min) < 1e-6 && start.max.distance(end.max) < 1e-6, "{start:?} {end:?}");

    let view = View::look_at(DVec3::new(2.0, 4.0, 5.0), DVec3::ZERO, 0.8);
    let request = FrameRequest {
        playing: Layer::alone(Some(0), 0.0),
        lights: vec![sun()],
        caustics: Some(CAUSTICS),
        ..still(view, SIZE, Refraction::default())
    };
    let mut renderer = renderer(gpu(), world);
    let first = render(&mut renderer, &request);
    let turned = render(&mut renderer, &at_time(&request, 1.0));
    assert!(
        ran(&turned).is_superset(&BTreeSet::from(["deform", "light_map", "emit", "deposit", "eye_map", "refract"])),
        "{:?}",
        ran(&turned)
    );
    assert!(caustic_of(&first) != caustic_of(&turned), "the caustic stood still");
    assert!(first.rgba != turned.rgba, "the body stood still");
}

#[test]
fn what_is_baked_of_a_rigid_body_is_baked_once() {
    let view = View::look_at(DVec3::new(2.0, 4.0, 5.0), DVec3::ZERO, 0.8);
    let refraction = Refraction { method: Method::Isr, ..Refraction::default() };
    let request = FrameRequest { playing: Layer::alone(Some(0), 0.0), ..still(view, SIZE, refraction) };
    let mut warm = renderer(gpu(), turning_tetrahedron());
    let first = render(&mut warm, &request);
    assert!(ran(&first).is_superset(&BTreeSet::from(["deform", "refit_at_rest", "thickness", "eye_map", "refract"])));
    let later = at_time(&request, 0.3);
    let turned = render(&mut warm, &later);
    assert_reused(&turned, &["refit_at_rest", "thickness"], "a rigid body turned");
    assert!(ran(&turned).contains("deform") && exits(&turned) != exits(&first), "the body stood still");
    assert_equal(&turned, &render(&mut renderer(gpu(), turning_tetrahedron()), &later), "turned");
}

/// The tetrahedron of glass so thin optically that light leaves it at every face.
fn thin_tetrahedron() -> World {
    let mut world = turning_tetrahedron();
    world.scene.materials.iter_mut().for_each(|material| material.ior = 1.1);
    world
}

/// The tetrahedron and a smaller one beside it.
fn two_bodies() -> World {
    let mut world = thin_tetrahedron();
    let place = Transform { translation: DVec3::new(2.5, -0.8, 0.0), scale: DVec3::splat(0.5), ..Transform::IDENTITY };
    let second = Node { local: Local::Trs(place), ..world.scene.nodes[0].clone() };
    world.scene.nodes.push(second);
    world.scene.roots.push(1);
    world
}

#[test]
fn one_of_two_casters_that_moves_leaves_the_other_s_light_alone() {
    let view = View::look_at(DVec3::new(2.0, 4.0, 7.0), DVec3::ZERO, 0.8);
    let still = still(view, SIZE, Refraction::default());
    let request = FrameRequest {
        playing: Layer::alone(Some(0), 0.0),
        lights: vec![sun()],
        caustics: Some(Caustics { map_size: 256, ..CAUSTICS }),
        ..still
    };
    let mut both = renderer(gpu(), two_bodies());
    render(&mut both, &request);
    // By little: the sun's view follows what it sees of all casters in steps.
    let later = at_time(&request, 0.05);
    let moved = render(&mut both, &later);
    let decision = |name: &str| moved.passes.iter().find(|pass| pass.name == name).expect("a pass").decision;
    for name in ["light_map", "emit", "deposit", "receive"] {
        assert_eq!(decision(&format!("{name}:0")), "ran", "{name} of the one that turned");
        assert_eq!(decision(&format!("{name}:1")), "reused", "{name} of the one at rest");
    }
    assert_equal(&moved, &render(&mut renderer(gpu(), two_bodies()), &later), "one of two turned");
}

#[test]
fn a_body_taken_away_leaves_no_caustic_behind() {
    let view = View::look_at(DVec3::new(2.0, 4.0, 7.0), DVec3::ZERO, 0.8);
    let request =
        FrameRequest { lights: vec![sun()], caustics: Some(CAUSTICS), ..still(view, SIZE, Refraction::default()) };
    let mut both = renderer(gpu(), two_bodies());
    let with = render(&mut both, &request);
    // A world cannot lose a body; another world on the same device can lack it.
    let device: Gpu = both.into_gpu();
    let warm = render(&mut renderer(device, thin_tetrahedron()), &request);
    let cold = render(&mut renderer(gpu(), thin_tetrahedron()), &request);
    assert_equal(&warm, &cold, "one of two bodies taken away");
    assert!(caustic_of(&with) != caustic_of(&warm), "the second body had no caustic");
}
