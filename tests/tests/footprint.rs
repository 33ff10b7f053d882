//! One ray a pixel, filtered over the pixel's footprint, against many rays a pixel.

use glam::DVec3;
use murano_optics::Ior;
use murano_refraction::{Interfaces, MOST_INTERFACES, Method, Refraction, TirPolicy};
use murano_render::{FrameRequest, Renderer, Stage, View};
use murano_scene::{Environment, FloorLevel, GlassBodies, Shot};
use murano_tests::bench::{asset, diameter, glass_body, gpu, renderer, still, vectors};

const SIDE: usize = 96;
/// Along each side of a pixel.
const RAYS: usize = 6;

/// Radiance of a glass body in the studio.
fn radiance(renderer: &mut Renderer, request: &FrameRequest, side: usize) -> Vec<DVec3> {
    let request = FrameRequest { size: [side as u32; 2], ..request.clone() };
    let frame = renderer.render(&request).unwrap_or_else(|error| panic!("{error}"));
    vectors(frame.aov.as_ref().expect("asked for"), "radiance")
}

/// Mean of the relative difference from what many rays see, over the picture, of so many samples of each pixel.
fn error(refraction: Refraction, samples: u32) -> f64 {
    let mut shot = Shot::for_model(&asset("bumpy.glb"));
    shot.glass.bodies = GlassBodies::All;
    shot.glass.ior = Some(1.5);
    shot.floor.level = FloorLevel::Absent;
    let (world, stage) = Stage::open(shot).expect("the body in the studio");
    let view = stage.request(0.0, &murano_render::Settings::default()).view;
    let request = still(view, [0; 2], refraction);
    let mut renderer = Renderer::new(gpu(), world).expect("a body");
    let one = radiance(&mut renderer, &FrameRequest { samples, ..request.clone() }, SIDE);
    let many = radiance(&mut renderer, &request, RAYS * SIDE);
    let mut sum = 0.0;
    for (pixel, one) in one.iter().enumerate() {
        let corner = RAYS * (pixel / SIDE) * RAYS * SIDE + RAYS * (pixel % SIDE);
        let rays = (0..RAYS * RAYS).map(|ray| many[corner + ray / RAYS * RAYS * SIDE + ray % RAYS]);
        let mean = rays.sum::<DVec3>() / (RAYS * RAYS) as f64;
        sum += ((*one - mean).abs() / (*one + mean + 0.05)).element_sum() / 3.0;
    }
    sum / one.len() as f64
}

/// Bounded by what was measured, plus a tenth. Without footprints the first two are .0199 and .0346; most of what is left is
/// outlines, and with two branches the fine images that the back of the glass mirrors.
#[test]
fn one_ray_sees_about_what_many_see() {
    let two = Refraction { method: Method::Layers, ..Refraction::default() };
    let all = Refraction { tir: TirPolicy::Trace, interfaces: Interfaces::All, branches: 1, ..two };
    let branches = Refraction { branches: 2, ..all };
    for (what, refraction, most) in
        [("two interfaces", two, 0.0163), ("all interfaces", all, 0.027), ("with two branches", branches, 0.0341)]
    {
        let found = error(refraction, 1);
        eprintln!("{what}: {found:.4}");
        assert!(found < most, "{what}: {found}, at most {most}");
    }
}

/// Samples go where those rays go, and each stands for its part of the pixel alone. Bounded by what was measured, plus a tenth.
#[test]
fn samples_come_to_what_many_see() {
    let two = Refraction { method: Method::Layers, ..Refraction::default() };
    let [one, few, many, most] = [1, 4, 16, 64].map(|samples| error(two, samples));
    eprintln!("1, 4, 16, 64 samples: {one:.4}, {few:.4}, {many:.4}, {most:.4}");
    assert!(one < 0.0163 && few < 0.0079 && many < 0.0051 && most < 0.00145, "{one}, {few}, {many}, {most}");
}

/// Before surroundings that are white all over nobody sees clear glass: no light is lost, nor any won.
#[test]
fn samples_of_glass_in_a_white_furnace_lose_no_light() {
    let mut world = glass_body(&asset("bumpy.glb"), Ior::GLASS);
    world.environment = Some(Environment { width: 2, height: 1, pixels: vec![[1.0; 3]; 2] });
    let view = View::look_at(DVec3::new(0.0, 0.0, 2.5 * diameter(&world)), DVec3::ZERO, 0.5);
    let refraction =
        Refraction { interfaces: Interfaces::All, most_interfaces: MOST_INTERFACES, ..Refraction::default() };
    let mut renderer = renderer(gpu(), world);
    for (branches, samples, most_lost) in [(2, 1, 0.006), (2, 4, 0.0005), (4, 4, 0.0005)] {
        let request = FrameRequest { samples, ..still(view, [64; 2], Refraction { branches, ..refraction }) };
        let seen = radiance(&mut renderer, &request, 64);
        let mean = seen.iter().sum::<DVec3>() / seen.len() as f64;
        eprintln!("{branches} branches, {samples} samples: {mean}");
        assert!((mean - 1.0).abs().max_element() < most_lost, "{branches} branches, {samples} samples: {mean}");
    }
}
