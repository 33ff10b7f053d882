//! A world where single things move by themselves: ten balls of glass over a floor, and a plate between them and it.

use glam::{DVec3, Vec3, Vec4};
use murano_animation::Layer;
use murano_render::{Floor, FrameRequest, Settings, ToneMap, View, World};
use murano_scene::{
    Channel, Clip, Interpolation, Light, LightKind, Local, Material, Mesh, Node, Path, PlacedLight, Primitive, Sampler,
    Scene, Transform, look_along,
};

use crate::bench::stability::bodies::Body;

/// Clip in which the plate slides to and fro.
pub const RECEIVER: usize = 0;
/// Clip in which one ball rises and falls.
pub const CASTER: usize = 1;

const BALLS: usize = 10;

/// Ten balls in two rows, a plate, a floor and a spot above them.
pub fn balls_over_plate() -> World {
    let ball = Body::ball(0.45, 24, 48).primitive();
    let plate = Body::plate(DVec3::new(1.2, 0.05, 0.6), 1).primitive();
    let opaque = Material { base_color: Vec4::new(0.6, 0.5, 0.4, 1.0), ..Material::default() };
    let at = |translation: DVec3, mesh: usize| Node {
        local: Local::Trs(Transform { translation, ..Transform::IDENTITY }),
        mesh: Some(mesh),
        ..Node::default()
    };
    let place = |index: usize| DVec3::new((index % 5) as f64 - 2.0, 0.0, (index / 5) as f64 - 0.5);
    let mut nodes: Vec<Node> = (0..BALLS).map(|index| at(place(index), 0)).collect();
    nodes.push(at(DVec3::new(0.0, -1.0, 0.0), 1));
    let slide = |node: usize, from: Vec3, to: Vec3, name: &str| Clip {
        name: name.into(),
        channels: vec![Channel {
            node,
            path: Path::Translation,
            sampler: Sampler {
                interpolation: Interpolation::Linear,
                // The way back takes other times than the way there, so that no moment is seen twice.
                times: vec![0.0, 0.62, 1.0],
                width: 3,
                values: [from, to, from].iter().flat_map(Vec3::to_array).collect(),
            },
        }],
        duration: 1.0,
        ..Clip::default()
    };
    let first = place(0).as_vec3();
    let scene = Scene {
        roots: (0..nodes.len()).collect(),
        nodes,
        meshes: vec![
            Mesh { name: "ball".into(), primitives: vec![ball] },
            Mesh { name: "plate".into(), primitives: vec![Primitive { material: Some(1), ..plate }] },
        ],
        materials: vec![Material::glass(1.5), opaque],
        clips: vec![
            slide(BALLS, Vec3::new(-0.8, -1.0, 0.0), Vec3::new(0.8, -1.0, 0.0), "receiver"),
            slide(0, first, first + 0.4 * Vec3::Y, "caster"),
        ],
        ..Scene::default()
    };
    World {
        scene,
        environment: None,
        floor: Some(Floor { height: -1.5, center: [0.0, 0.0], half_extent: 30.0, albedo: [0.5; 3] }),
    }
}

/// How they are looked at.
pub fn request(settings: &Settings, size: [u32; 2]) -> FrameRequest {
    let position = DVec3::new(1.0, 6.0, 1.5);
    let lamp = PlacedLight {
        world_from_light: look_along(position, -position),
        light: Light {
            name: "spot".into(),
            kind: LightKind::Spot { inner: 0.5, outer: 0.6 },
            color: Vec3::ONE,
            intensity: 200.0,
            range: f32::INFINITY,
        },
    };
    FrameRequest {
        playing: Layer::alone(Some(RECEIVER), 0.0),
        size,
        view: View::look_at(DVec3::new(0.0, 3.0, 6.0), DVec3::new(0.0, -0.6, 0.0), 0.7),
        lights: vec![lamp],
        refraction: settings.refraction,
        caustics: settings.caustics,
        samples: 1,
        exposure: 1.0,
        tone_map: ToneMap::default(),
        aov: false,
        before: None,
        skipping: settings.skipping,
    }
}
