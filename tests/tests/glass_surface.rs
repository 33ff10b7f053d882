//! The surface of glass: its colours and their textures, roughness, maps of normals, thin walls.

use glam::{DVec3, Vec2, Vec3, Vec4};
use murano_animation::{Layer, Pose};
use murano_optics::snell;
use murano_reference::{Camera, PathScene, PathSettings, Ray, World as TracedWorld, path_picture, trace_two};
use murano_refraction::{Interfaces, Method, Refraction, TirPolicy};
use murano_render::{Frame, Renderer, Settings, Stage, View, World};
use murano_scene::{
    Clip, Environment, FloorLevel, GlassBodies, Image, Interpolation, Local, Material, MaterialProperty, Mesh, Node,
    Primitive, Property, PropertyChannel, Sampler, Scene, Shot, ShotGlass, TextureRef, Transform, Wrap,
};
use murano_tests::bench::{asset, degrees_between, gpu, pixel_ray, still, under_waves, vectors};

const SIDE: u32 = 64;

/// A pane that does not bend light, front and back, from (-1, -1) to (1, 1), in white surroundings; its front may be cut into a left
/// and a right half of two materials.
fn pane(materials: Vec<Material>, images: Vec<Image>, colors: Option<[Vec4; 4]>) -> World {
    let quad = |left: f32, right: f32, z: f32, colors: Option<[Vec4; 4]>, material: usize| {
        let corner = |x: f32, y: f32| Vec3::new(x, y, z);
        Primitive {
            positions: vec![corner(left, -1.0), corner(right, -1.0), corner(right, 1.0), corner(left, 1.0)],
            normals: Some(vec![Vec3::new(0.0, 0.0, z.signum()); 4]),
            // v runs down the image.
            texcoords: vec![vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO]],
            colors: colors.map(|colors| colors.to_vec()),
            triangles: if z > 0.0 { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] },
            material: Some(material),
            ..Primitive::default()
        }
    };
    let mut primitives = vec![quad(-1.0, 1.0, -0.1, None, 0)];
    if materials.len() == 1 {
        primitives.push(quad(-1.0, 1.0, 0.1, colors, 0));
    } else {
        primitives.extend([quad(-1.0, 0.0, 0.1, None, 0), quad(0.0, 1.0, 0.1, None, 1)]);
    }
    let node = Node {
        name: "pane".into(),
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
        meshes: vec![Mesh { name: String::new(), primitives }],
        materials,
        images,
        ..Scene::default()
    };
    World { scene, environment: Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] }), floor: None }
}

fn clear() -> Material {
    Material { base_color: Vec4::ONE, ..Material::glass(1.0) }
}

fn texture(image: usize) -> TextureRef {
    let [offset, scale] = [Vec2::ZERO, Vec2::ONE];
    TextureRef { image, texcoord: 0, wrap: [Wrap::Clamp; 2], offset, rotation: 0.0, scale }
}

/// Four texels: upper left, upper right, lower left, lower right.
fn image(texels: [[u8; 3]; 4]) -> Image {
    Image { name: "pane".into(), width: 2, height: 2, rgba: texels.map(|[r, g, b]| [r, g, b, 255]).to_vec() }
}

/// Radiance in the middle of each quarter of the pane, in the order of an image's texels.
fn quarters(world: World, method: Method) -> [DVec3; 4] {
    let view = View::look_at(DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO, 2.0 * 0.1_f64.atan());
    let refraction = Refraction { method, reflection: false, ..Refraction::default() };
    let mut renderer = Renderer::new(gpu(), world).expect("a pane");
    let frame: Frame = renderer.render(&still(view, [SIDE; 2], refraction)).unwrap_or_else(|error| panic!("{error}"));
    let shown = vectors(frame.aov.as_ref().expect("asked for"), "radiance");
    let at = |x: u32, y: u32| shown[(y * SIDE + x) as usize];
    let [near, far] = [SIDE / 4, 3 * SIDE / 4];
    [at(near, near), at(far, near), at(near, far), at(far, far)]
}

fn assert_near(found: [DVec3; 4], expected: [[f64; 3]; 4], slack: f64, what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!(found.abs_diff_eq(expected.into(), slack), "{what}: {found}, not {expected:?}");
    }
}

const METHODS: [Method; 4] = [Method::Sir, Method::Newton, Method::Layers, Method::Exact];

#[test]
fn a_base_colour_texture_tints_what_it_covers() {
    let [red, green, blue, white] = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];
    for method in METHODS {
        let glass =
            Material { base_color_texture: Some(texture(0)), base_color: Vec4::new(0.5, 1.0, 1.0, 1.0), ..clear() };
        let found = quarters(pane(vec![glass], vec![image([red, green, blue, white])], None), method);
        let expected = [[0.5, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.5, 1.0, 1.0]];
        // The middle of a quarter is next to the middle of a texel: the others weigh a hundredth.
        assert_near(found, expected, 0.05, method.name());
    }
}

#[test]
fn a_transmission_texture_darkens_by_its_red() {
    for method in METHODS {
        let glass = Material { transmission: 0.8, transmission_texture: Some(texture(0)), ..clear() };
        let image = image([[255, 0, 0], [0, 255, 0], [51, 0, 0], [102, 9, 9]]);
        let found = quarters(pane(vec![glass], vec![image], None), method);
        assert_near(found, [[0.8; 3], [0.0; 3], [0.16; 3], [0.32; 3]], 0.05, method.name());
    }
}

#[test]
fn vertex_colours_tint() {
    for method in METHODS {
        // Red to the right, from 0 to 1; green upwards.
        let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|at| Vec4::new(at.x, at.y, 1.0, 1.0));
        let found = quarters(pane(vec![clear()], Vec::new(), Some(corners)), method);
        let expected = [[0.25, 0.75, 1.0], [0.75, 0.75, 1.0], [0.25, 0.25, 1.0], [0.75, 0.25, 1.0]];
        assert_near(found, expected, 0.02, method.name());
    }
}

#[test]
fn a_body_of_two_materials_is_one_body() {
    for method in METHODS {
        let blue = Material { base_color: Vec4::new(0.0, 0.0, 1.0, 1.0), ..clear() };
        let found = quarters(pane(vec![clear(), blue], Vec::new(), None), method);
        let [left, right] = [[1.0; 3], [0.0, 0.0, 1.0]];
        assert_near(found, [left, right, left, right], 1e-3, method.name());
    }
}

#[test]
fn the_tracer_knows_the_same_bodies() {
    let blue = Material { base_color: Vec4::new(0.0, 0.0, 1.0, 1.0), ..clear() };
    let World { scene, .. } = pane(vec![clear(), blue], Vec::new(), None);
    let traced = TracedWorld::of_scene(&scene, &Pose::rest(&scene)).expect("a pane");
    let [body] = &traced.bodies[..] else { panic!("{} bodies", traced.bodies.len()) };
    // Of the back and of one half of the front, which are clear, and of the other half.
    assert!(body.tint.abs_diff_eq(DVec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0), 1e-6), "{}", body.tint);
}

/// A map of normals bends the first interface: the exit direction is that of two refractions in f64, by the normal that the
/// texel stands for and by the pane's flat back.
#[test]
fn a_map_of_normals_bends_what_is_seen() {
    let texel = [171_u8, 90, 240];
    let [x, y, z] = texel.map(|byte| 2.0 * f64::from(byte) / 255.0 - 1.0);
    let bent = DVec3::new(x, y, z).normalize();
    // On the frame of the texture's gradient, then on tangents: the same frame, one turned by a quarter, one mirrored.
    let frames = [
        (None, bent),
        (Some(Vec4::new(1.0, 0.0, 0.0, 1.0)), bent),
        (Some(Vec4::new(0.0, 1.0, 0.0, 1.0)), DVec3::new(-bent.y, bent.x, bent.z)),
        (Some(Vec4::new(1.0, 0.0, 0.0, -1.0)), DVec3::new(bent.x, -bent.y, bent.z)),
    ];
    let view = View::look_at(DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO, 2.0 * 0.1_f64.atan());
    let size = [SIDE; 2];
    for (tangent, bent) in frames {
        let material = Material { normal_texture: Some(texture(0)), ..Material::glass(1.5) };
        // The right half of the front; the back is flat.
        let mut world = pane(vec![Material::glass(1.5), material], vec![image([texel; 4])], None);
        for primitive in &mut world.scene.meshes[0].primitives {
            primitive.tangents = tangent.map(|tangent| vec![tangent; 4]);
        }
        let mut renderer = Renderer::new(gpu(), world).expect("a pane");
        let request = still(view, size, Refraction::default());
        let frame = renderer.render(&request).unwrap_or_else(|error| panic!("{error}"));
        let exits = vectors(frame.aov.as_ref().expect("asked for"), "exit_direction");
        // Away from the pane's rim, past which the bent rays leave it.
        for (row, column) in [(32, 40), (20, 44), (40, 36)] {
            let pixel = row * SIDE as usize + column;
            let (_, incident) = pixel_ray(&view, size, pixel);
            let inside = snell(incident, bent, 1.0 / 1.5).direction;
            let truth = snell(inside, DVec3::Z, 1.5).direction;
            let off = degrees_between(exits[pixel], truth);
            assert!(
                off < 0.02 && degrees_between(truth, incident) > 10.0,
                "{tangent:?}, {row}, {column}: {off} degrees"
            );
        }
    }
}

/// And the second: behind the right half of its front, which is flat, the pane's back is bent. The tracer says so too.
#[test]
fn a_map_of_normals_bends_where_light_leaves() {
    let texel = [171_u8, 90, 240];
    let [x, y, z] = texel.map(|byte| 2.0 * f64::from(byte) / 255.0 - 1.0);
    let bent = DVec3::new(x, y, -z).normalize();
    // On the frame of the texture's gradient, then on tangents, one mirrored: the back faces away from the eye.
    let frames = [
        (None, bent),
        (Some(Vec4::new(1.0, 0.0, 0.0, -1.0)), bent),
        (Some(Vec4::new(1.0, 0.0, 0.0, 1.0)), DVec3::new(bent.x, -bent.y, bent.z)),
    ];
    let view = View::look_at(DVec3::new(0.0, 0.0, 10.0), DVec3::ZERO, 2.0 * 0.1_f64.atan());
    let size = [SIDE; 2];
    for method in [Method::Walk, Method::Layers, Method::Exact] {
        for (tangent, bent) in frames {
            let materials =
                vec![Material { normal_texture: Some(texture(0)), ..Material::glass(1.5) }, Material::glass(1.5)];
            let mut world = pane(materials, vec![image([texel; 4])], None);
            for primitive in &mut world.scene.meshes[0].primitives {
                primitive.tangents = tangent.map(|tangent| vec![tangent; 4]);
            }
            let traced = TracedWorld::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a pane");
            let mut renderer = Renderer::new(gpu(), world).expect("a pane");
            let request = still(view, size, Refraction { method, ..Refraction::default() });
            let frame = renderer.render(&request).unwrap_or_else(|error| panic!("{error}"));
            let exits = vectors(frame.aov.as_ref().expect("asked for"), "exit_direction");
            for (row, column) in [(32, 40), (20, 44), (40, 52)] {
                let pixel = row * SIDE as usize + column;
                let (origin, incident) = pixel_ray(&view, size, pixel);
                let inside = snell(incident, DVec3::Z, 1.0 / 1.5).direction;
                let truth = snell(inside, -bent, 1.5).direction;
                let theirs = trace_two(&traced, &Ray { origin, direction: incident }).exit;
                let off = [exits[pixel], theirs].map(|found| degrees_between(found, truth));
                assert!(
                    off[0] < 0.02 && off[1] < 1e-4 && degrees_between(truth, incident) > 10.0,
                    "{}, {tangent:?}, {row}, {column}: {off:?} degrees",
                    method.name()
                );
            }
        }
    }
}

/// A ball whose normals waves run over, from a map: in the picture through all interfaces. Bounded by what was measured, plus a tenth.
#[test]
fn glass_under_a_map_of_normals_is_near_that_of_the_path_tracer() {
    let settings = PathSettings { passes: 4, noise: 0.0, ..PathSettings::default() };
    let found = off_the_path_tracer("sphere.glb", ShotGlass::default(), settings, |scene| under_waves(scene, 0.25));
    eprintln!("waves: {found:.4}");
    assert!(found < 0.0949, "{found}");
}

/// Mean relative difference over blocks of 4x4 pixels of the renderer's picture and the path tracer's, of an asset in the studio
/// without a floor, through all interfaces.
fn off_the_path_tracer(
    asset_name: &str,
    glass: ShotGlass,
    settings: PathSettings,
    change: impl FnOnce(&mut Scene),
) -> f64 {
    const BLOCK: usize = 4;
    let mut shot = Shot::for_model(&asset(asset_name));
    shot.glass = ShotGlass { bodies: GlassBodies::All, ior: Some(1.5), ..glass };
    shot.floor.level = FloorLevel::Absent;
    let (mut world, stage) = Stage::open(shot).expect("a body in the studio");
    change(&mut world.scene);
    let view = stage.request(0.0, &Settings::default()).view;
    let side = SIDE as usize;
    let all = Refraction { tir: TirPolicy::Trace, interfaces: Interfaces::All, ..Refraction::default() };
    let traced = TracedWorld::of_scene(&world.scene, &Pose::rest(&world.scene)).expect("a body");
    let scene = PathScene {
        world: &traced,
        scene: &world.scene,
        environment: world.environment.as_ref(),
        lights: &[],
        photons: None,
        fade: None,
    };
    let camera = Camera { world_from_view: view.world_from_view, projection: view.projection, size: [SIDE; 2] };
    let truth = path_picture(&scene, &camera, &settings, &|_, _| {}).radiance;
    let mut renderer = Renderer::new(gpu(), world).expect("a body");
    let frame = renderer.render(&still(view, [SIDE; 2], all)).unwrap_or_else(|error| panic!("{error}"));
    let shown = vectors(frame.aov.as_ref().expect("asked for"), "radiance");
    let blocks = (0..side / BLOCK).flat_map(|row| (0..side / BLOCK).map(move |column| (row, column)));
    let differences = blocks.map(|(row, column)| {
        let pixels = (0..BLOCK * BLOCK).map(|i| (BLOCK * row + i / BLOCK) * side + BLOCK * column + i % BLOCK);
        let (ours, theirs) = pixels.fold((DVec3::ZERO, DVec3::ZERO), |(ours, theirs), pixel| {
            (ours + shown[pixel], theirs + DVec3::from(truth[pixel].map(f64::from)))
        });
        ((ours - theirs).abs() / (ours + theirs)).element_sum() / 3.0
    });
    let differences: Vec<f64> = differences.filter(|d| d.is_finite()).collect();
    2.0 * differences.iter().sum::<f64>() / differences.len() as f64
}

/// Bounded by what was measured, plus a tenth.
#[test]
fn rough_glass_is_near_that_of_the_path_tracer() {
    let settings = PathSettings { passes: 6, noise: 0.0, ..PathSettings::default() };
    for (name, roughness, most) in [
        ("sphere.glb", 0.1, 0.0433),
        ("sphere.glb", 0.2, 0.0695),
        ("sphere.glb", 0.4, 0.0921),
        ("bumpy.glb", 0.2, 0.0923),
        ("bumpy.glb", 0.4, 0.139),
    ] {
        let glass = ShotGlass { roughness: Some(roughness), ..ShotGlass::default() };
        let found = off_the_path_tracer(name, glass, settings, |_| {});
        eprintln!("{name}, roughness {roughness}: {found:.4}");
        assert!(found < most, "{name}, roughness {roughness}: {found}, at most {most}");
    }
}

/// From behind, a sheet is seen in the mean of its colours: the map does not say which triangle it is.
#[test]
fn a_sheet_is_seen_from_behind() {
    let thin =
        |r: f32, g: f32| Material { base_color: Vec4::new(r, g, 1.0, 1.0), thickness: 0.0, ..Material::glass(1.5) };
    let mut world = pane(vec![thin(1.0, 0.0), thin(0.0, 1.0)], Vec::new(), None);
    world.scene.meshes[0].primitives.remove(0);
    let view = View::look_at(DVec3::new(0.0, 0.0, -10.0), DVec3::ZERO, 2.0 * 0.1_f64.atan());
    let refraction = Refraction { reflection: false, ..Refraction::default() };
    let mut renderer = Renderer::new(gpu(), world).expect("a sheet");
    let frame = renderer.render(&still(view, [SIDE; 2], refraction)).unwrap_or_else(|error| panic!("{error}"));
    let shown = vectors(frame.aov.as_ref().expect("asked for"), "radiance")[(SIDE / 2 * SIDE + SIDE / 4) as usize];
    // At right angles a sheet of index 1.5 reflects 2 R / (1 + R) of R = .04.
    let passed = 1.0 - 0.08 / 1.04;
    assert!(shown.abs_diff_eq(passed * DVec3::new(0.5, 0.5, 1.0), 1e-3), "{shown}");
}

/// A bubble: straight through both walls, both of which mirror. What is left are mirror images of mirror images. Bounded by what was
/// measured, plus a tenth.
#[test]
fn thin_walls_are_those_of_the_path_tracer() {
    let settings =
        PathSettings { samples: 1, jitter: false, passes: 1, smallest_weight: 1e-4, ..PathSettings::default() };
    let glass = ShotGlass { thin: Some(true), ..ShotGlass::default() };
    let found = off_the_path_tracer("sphere.glb", glass, settings, |_| {});
    eprintln!("a bubble: {found:.5}");
    assert!(found < 0.0438, "{found}");
}

/// A model of glass with clips that drive its material from 0 to 1 s.
fn driven(base: &str, curves: &[(MaterialProperty, [f32; 2])]) -> World {
    let mut shot = Shot::for_model(&asset(base));
    shot.glass = ShotGlass { bodies: GlassBodies::All, ior: Some(1.2), ..ShotGlass::default() };
    let (mut world, _) = Stage::open(shot).unwrap_or_else(|error| panic!("{error}"));
    let channel = |&(property, values): &(MaterialProperty, [f32; 2])| PropertyChannel {
        property: Property::Material(0, property),
        sampler: Sampler {
            interpolation: Interpolation::Linear,
            times: vec![0.0, 1.0],
            width: 1,
            values: values.into(),
        },
    };
    let properties = curves.iter().map(channel).collect();
    world.scene.clips = vec![Clip { name: "change".into(), properties, duration: 1.0, ..Clip::default() }];
    world
}

/// Glass whose clip changes it is, at each moment, what it has become: in the picture and in its caustic. At the end, it is none.
#[test]
fn a_clip_changes_the_glass() {
    let curves = [
        (MaterialProperty::Ior, [1.25, 1.75]),
        (MaterialProperty::Roughness, [0.0, 0.5]),
        (MaterialProperty::Transmission, [1.0, 0.0]),
    ];
    let mut shot = Shot::for_model(&asset("bumpy.glb"));
    shot.output.size = [SIDE; 2];
    let (_, stage) = Stage::open(shot).unwrap_or_else(|error| panic!("{error}"));
    let request = stage.request(0.0, &Settings::default());
    let mut moving = Renderer::new(gpu(), driven("bumpy.glb", &curves)).expect("a body");
    let moments = [(0.0, 1.25, 0.0, 1.0), (0.5, 1.5, 0.25, 0.5), (1.0, 1.75, 0.5, 0.0), (0.0, 1.25, 0.0, 1.0)];
    for (time, ior, roughness, transmission) in moments {
        let mut world = driven("bumpy.glb", &[]);
        world.scene.clips.clear();
        world.scene.materials[0] = Material { ior, roughness, transmission, ..world.scene.materials[0].clone() };
        let still = murano_render::FrameRequest { playing: Vec::new(), ..request.clone() };
        let wanted = Renderer::new(gpu(), world).expect("a body").render(&still).expect("a frame");
        let played = murano_render::FrameRequest { playing: Layer::alone(Some(0), time), ..request.clone() };
        let found = moving.render(&played).expect("a frame");
        assert!(found.rgba == wanted.rgba, "at {time} s");
    }
}
