//! Glass that is not of one colour: base colour and transmission, their textures, vertex colours.

use glam::{DVec3, Vec2, Vec3, Vec4};
use murano_refraction::{Method, Refraction};
use murano_render::{Frame, Renderer, View, World};
use murano_scene::{Environment, Image, Local, Material, Mesh, Node, Primitive, Scene, TextureRef, Transform, Wrap};
use murano_tests::bench::{gpu, still, vectors};

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
    let traced = murano_reference::World::of_scene(&scene, &murano_animation::Pose::rest(&scene)).expect("a pane");
    let [body] = &traced.bodies[..] else { panic!("{} bodies", traced.bodies.len()) };
    // Of the back and of one half of the front, which are clear, and of the other half.
    assert!(body.tint.abs_diff_eq(DVec3::new(2.0 / 3.0, 2.0 / 3.0, 1.0), 1e-6), "{}", body.tint);
}
