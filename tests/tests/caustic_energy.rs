//! Caustics of balls against closed forms: not a watt lost on the way from the lamp through a ball of glass to the floor, and every
//! watt where it belongs. Against an independent photon tracer where its data are at hand.
//!
//! Fluxes are those of a lamp of intensity 1. "Below the ball" is a floor just under its foot, with room for a camera in
//! between, which so looks at the caustic itself, not at its image in the ball.

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec3};
use murano_caustics::{Caustics, Method};
use murano_metrics::irradiance::{IrradianceMap, RidgeSettings, encircled_energy_radius, ridge_position};
use murano_optics::{Ior, analytic::BallLens, fresnel_dielectric};
use murano_refraction::Interfaces;
use murano_render::{FrameRequest, PlacedLight, Renderer, View, World};
use murano_scene::{Environment, LightKind, Projection, Scene};
use murano_tests::{
    bench::{ExrLayers, asset, body, glass_body, gpu, renderer, scalars, shared, vectors},
    caustics::{ENERGY, MAP_SIZE, account, floor, from_above, light, off, picture, request, streaks, with_method},
};

const PHOTONS: [u32; 4] = [64, 128, 256, 512];
/// Distances from the ball's centre to the floor, metres: just under its foot, and where rays near the axis meet.
const BELOW: f64 = 1.05;
const FOCUS: f64 = 1.5;

fn sunlight() -> PlacedLight {
    light(LightKind::Directional, DVec3::Y * 5.0, DVec3::NEG_Y)
}

/// Height of the spot above the ball's centre, metres.
const SPOT_HEIGHT: f64 = 6.0;

/// From above; half-angles in radians.
fn spot(inner: f32, outer: f32) -> PlacedLight {
    light(LightKind::Spot { inner, outer }, DVec3::Y * SPOT_HEIGHT, DVec3::NEG_Y)
}

/// A ball of radius 1 about the origin above a floor at this distance from its centre.
fn ball_above(distance: f64) -> World {
    World { floor: Some(floor(-distance)), ..glass_body(&asset("sphere.glb"), Ior::GLASS) }
}

/// Fraction of unpolarised light of a height that passes both interfaces when each of them takes it as unpolarised, as the
/// renderer does and ray tracers do. (The first interface polarises what the second meets: [`BallLens::transmittance`],
/// 0.6 % more of the sun in a ball of index 1.5.)
fn transmittance(ball: &BallLens, height: f64) -> f64 {
    let cos_i = (1.0 - height * height).max(0.0).sqrt();
    let [s, p] = fresnel_dielectric(cos_i, ball.sphere.ior.eta_entering()).into();
    (1.0 - 0.5 * (s + p)).powi(2)
}

/// Flux of parallel light of 1 lux that the ball refracts twice, watts: the integral of T over its disc.
fn refracted_sunlight(ball: &BallLens) -> f64 {
    const RINGS: u32 = 20_000;
    let step = 1.0 / f64::from(RINGS);
    (0..RINGS)
        .map(|ring| (f64::from(ring) + 0.5) * step)
        .map(|height| transmittance(ball, height) * TAU * height * step)
        .sum()
}

/// Flux of a spot of 1 candela that the ball refracts twice, watts: the integral of I T over its solid angle.
fn refracted_spot(ball: &BallLens, inner: f64, outer: f64) -> f64 {
    const STEPS: u32 = 20_000;
    let widest = (1.0 / SPOT_HEIGHT).asin().min(outer);
    let step = widest / f64::from(STEPS);
    (0..STEPS)
        .map(|k| (f64::from(k) + 0.5) * step)
        .map(|angle| {
            // KHR_lights_punctual.
            let falloff = ((angle.cos() - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0).powi(2);
            falloff * transmittance(ball, SPOT_HEIGHT * angle.sin()) * TAU * angle.sin() * step
        })
        .sum()
}

#[test]
fn a_ball_sends_the_light_it_refracts_and_all_of_it_lands() {
    let ball = BallLens::new(1.0, Ior::GLASS, FOCUS);
    let lamps =
        [("sun", sunlight(), refracted_sunlight(&ball)), ("spot", spot(0.45, 0.5), refracted_spot(&ball, 0.45, 0.5))];
    let mut gpu = gpu();
    for distance in [BELOW, FOCUS] {
        let mut renderer = renderer(gpu, ball_above(distance));
        for (name, lamp, truth) in &lamps {
            for (method, photons) in Method::ALL.into_iter().flat_map(|method| PHOTONS.map(|photons| (method, photons)))
            {
                let asked = with_method(request(from_above(5.0, 2.0), 16, lamp.clone(), photons), method);
                let account = account(&mut renderer, &asked);
                let mapped: f64 = account.map.iter().map(|texel| f64::from(texel[0])).sum();
                eprintln!(
                    "{name}, floor {distance} below, {method}, {photons}^2 photons: truth {truth:.5} W, sent {:.5}, landed {:.5}, \
                     mapped {mapped:.5}",
                    account.sent, account.landed
                );
                assert!(off(account.sent, *truth) <= ENERGY, "sent {} of {truth}", account.sent);
                assert!(off(account.landed, account.sent) <= ENERGY, "landed {} of {}", account.landed, account.sent);
                assert!(off(mapped, account.landed) <= ENERGY, "mapped {mapped} of {}", account.landed);
                // All light in one texel would take a quarter of the range, and rounding a little more.
                let used = account.range_used();
                assert!(used > 0.0 && used < 0.26, "{used} of the fixed-point range");
            }
        }
        gpu = renderer.into_gpu();
    }
}

#[test]
fn a_spot_s_cone_cuts_what_the_ball_gets() {
    let ball = BallLens::new(1.0, Ior::GLASS, FOCUS);
    let truth = refracted_spot(&ball, 0.06, 0.12);
    let mut renderer = renderer(gpu(), ball_above(FOCUS));
    let account = account(&mut renderer, &request(from_above(5.0, 2.0), 16, spot(0.06, 0.12), 256));
    eprintln!("narrow spot: truth {truth:.6} W, sent {:.6}", account.sent);
    assert!(off(account.sent, truth) <= ENERGY, "sent {} of {truth}", account.sent);
}

#[test]
fn the_brightest_texel_at_the_focus_is_on_the_axis() {
    let mut renderer = renderer(gpu(), ball_above(FOCUS));
    for (name, lamp) in [("sun", sunlight()), ("spot", spot(0.45, 0.5))] {
        for photons in PHOTONS {
            let account = account(&mut renderer, &request(from_above(5.0, 2.0), 16, lamp.clone(), photons));
            let brightest =
                (0..account.detail.len()).max_by(|a, b| account.detail[*a][0].total_cmp(&account.detail[*b][0]));
            let brightest = brightest.expect("a map has texels") as u32;
            // The axis passes the middle of the lamp's view.
            let from_axis = |texel: u32, axis: usize| {
                let [offset, scale] = [account.detail_offset[axis], account.detail_scale[axis]].map(f64::from);
                (f64::from(texel) + 0.5 - scale * (f64::from(MAP_SIZE) / 2.0 - offset)).abs()
            };
            let (x, y) = (from_axis(brightest % MAP_SIZE, 0), from_axis(brightest / MAP_SIZE, 1));
            eprintln!("{name}, {photons}^2 photons: brightest texel {x}, {y} texels off the axis");
            assert!(x <= 1.0 && y <= 1.0, "{name}, {photons}^2: {x}, {y} texels off");
        }
    }
}

/// Flux of annuli about the origin, one `width` wide each, from a square picture of irradiance `half` metres around it:
/// the mean of the pixels in an annulus times its area.
fn annuli(irradiance: &[f64], size: u32, half: f64, width: f64) -> Vec<f64> {
    let count = (half / width) as usize;
    let mut sums = vec![(0.0, 0_u32); count];
    let place = |pixel: u32| (2.0 * (f64::from(pixel) + 0.5) / f64::from(size) - 1.0) * half;
    for (index, value) in (0..).zip(irradiance) {
        let ring = (place(index % size).hypot(place(index / size)) / width) as usize;
        if let Some((sum, pixels)) = sums.get_mut(ring) {
            *sum += value;
            *pixels += 1;
        }
    }
    let area = |ring: usize| PI * width * width * (2 * ring + 1) as f64;
    sums.iter().enumerate().map(|(ring, (sum, pixels))| sum / f64::from(*pixels) * area(ring)).collect()
}

#[test]
fn the_irradiance_under_a_ball_in_the_sun_is_that_of_the_closed_form() {
    const SIZE: u32 = 512;
    const WIDTH: f64 = 0.02;
    let mut gpu = gpu();
    // Relative L1 over the annuli, by photons: what was measured, plus a fifth.
    let bounds = |distance: f64, method: Method| match (distance == BELOW, method) {
        (true, Method::Splat) => [0.036, 0.0145, 0.012, 0.011],
        (true, Method::Shah) => [0.0341, 0.013, 0.0133, 0.0107],
        (true, Method::Beams) => [0.039, 0.015, 0.013, 0.0106],
        (true, Method::Footprint) => [0.0176, 0.0113, 0.0108, 0.0098],
        (false, Method::Splat) => [0.143, 0.096, 0.084, 0.083],
        (false, Method::Shah) => [0.132, 0.052, 0.0146, 0.0095],
        (false, Method::Beams) => [0.043, 0.018, 0.013, 0.013],
        (false, Method::Footprint) => [0.021, 0.014, 0.012, 0.013],
    };
    for distance in [BELOW, FOCUS] {
        let half = 1.0;
        let ball = BallLens::new(1.0, Ior::GLASS, distance);
        let mut renderer = renderer(gpu, ball_above(distance));
        let within = |rings: usize| ball.flux_within(rings as f64 * WIDTH, 200_000);
        for method in Method::ALL {
            for (photons, most) in PHOTONS.into_iter().zip(bounds(distance, method)) {
                // In the gap between the ball's foot and the floor.
                let view = from_above(-0.5 * (1.0 + distance), half);
                let frame = picture(&mut renderer, &with_method(request(view, SIZE, sunlight(), photons), method));
                let irradiance = scalars(&frame.aov.expect("asked for"), "caustic");
                let ours = annuli(&irradiance, SIZE, half, WIDTH);
                let exact: Vec<f64> = (0..ours.len()).map(|ring| within(ring + 1) - within(ring)).collect();
                let total: f64 = exact.iter().sum();
                let error = ours.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum::<f64>() / total;
                eprintln!(
                    "sun, floor {distance} below, {method}, {photons}^2 photons: relative L1 {error:.4} of {total:.4} W"
                );
                assert!(error <= most, "{method}, {photons}^2: {error} > {most}");
            }
        }
        gpu = renderer.into_gpu();
    }
}

#[test]
fn the_picture_of_the_caustic_holds_the_flux_that_landed() {
    const SIZE: u32 = 512;
    let mut gpu = gpu();
    for distance in [BELOW, FOCUS] {
        let mut renderer = renderer(gpu, ball_above(distance));
        for (name, mut lamp, half) in [("sun", sunlight(), 7.0), ("spot", spot(0.45, 0.5), 4.5)] {
            lamp.light.intensity = 3.0;
            let request = request(from_above(-0.5 * (1.0 + distance), half), SIZE, lamp, 256);
            let landed = 3.0 * account(&mut renderer, &request).landed;
            let pixel = (2.0 * half / f64::from(SIZE)).powi(2);
            let frame = picture(&mut renderer, &request);
            let seen = pixel * scalars(&frame.aov.expect("asked for"), "caustic").iter().sum::<f64>();
            eprintln!("{name}, floor {distance} below: landed {landed:.4} W, seen {seen:.4} W");
            // Pixels as large as the map's texels sample the spike at the focus only so well.
            assert!(off(seen, landed) <= 0.03, "{name}: seen {seen} of {landed}");
        }
        gpu = renderer.into_gpu();
    }
}

/// A lamp that creeps by a tenth of a map's texel a frame changes what the floor gets by about as much each time: nothing jumps
/// from texel to texel, and neither does the level that is fitted to the light.
#[test]
fn light_that_creeps_changes_the_caustic_smoothly() {
    const SIZE: u32 = 256;
    let mut renderer = renderer(gpu(), ball_above(BELOW));
    let at = |step: u32| {
        // Beside the axis, on which photons meet the mesh's own edges.
        let shift = 2e-4 * f64::from(step + 1);
        let lamp =
            light(LightKind::Spot { inner: 0.45, outer: 0.5 }, DVec3::new(shift, SPOT_HEIGHT, 0.0), DVec3::NEG_Y);
        let mut request = request(from_above(-0.5 * (1.0 + BELOW), 0.6), SIZE, lamp, 128);
        request.caustics = Some(Caustics { photons: 128, interfaces: Interfaces::Two, ..Caustics::default() });
        request
    };
    let seen: Vec<Vec<f64>> =
        (0..12).map(|step| scalars(&picture(&mut renderer, &at(step)).aov.expect("asked for"), "caustic")).collect();
    let total: f64 = seen[0].iter().sum();
    let change = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / total;
    let steps: Vec<f64> = seen.windows(2).map(|pair| change(&pair[0], &pair[1])).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let largest = steps.iter().copied().fold(0.0, f64::max);
    eprintln!("creeping light: mean change {mean:.5}, largest {largest:.5}");
    assert!(largest < 1.5 * mean, "one step changes {largest}, the mean {mean}");
    assert!(mean < 0.01, "{mean}");
}

#[test]
fn clear_glass_of_index_1_changes_nothing() {
    let studio = || Environment::load(&asset("studio.hdr")).expect("the studio");
    let mut with = glass_body(&asset("sphere.glb"), Ior::AIR);
    with.environment = Some(studio());
    with.floor = Some(floor(-1.0));
    let without = World { scene: Scene::default(), environment: Some(studio()), floor: Some(floor(-1.0)) };

    let view = View::look_at(DVec3::new(2.0, 1.5, 4.0), DVec3::ZERO, 0.8);
    let mut asked = request(view, 128, spot(0.4, 0.5), 64);
    asked.lights.push(sunlight());
    let mut first = renderer(gpu(), with);
    let seen = picture(&mut first, &asked);
    for pass in &seen.passes {
        let glass = ["light_map", "emit", "deposit", "receive", "eye_map", "refract"];
        let of_the_body = pass.name.split(':').next().is_some_and(|name| glass.contains(&name));
        assert!(!of_the_body || pass.decision == "culled", "{} {}: {}", pass.name, pass.decision, pass.reason);
    }
    let deform = seen.passes.iter().find(|pass| pass.name == "deform:1").expect("the body is in the plan");
    assert_eq!(deform.decision, "culled");

    let bare = picture(&mut renderer(gpu(), without), &asked);
    assert!(seen.rgba == bare.rgba, "the picture differs");
    let (seen, bare) = (seen.aov.expect("asked for"), bare.aov.expect("asked for"));
    for (a, b) in seen.layers.iter().zip(&bare.layers) {
        assert!(a.planes == b.planes, "layer {} differs", a.name);
    }
}

/// A caustic of the independent photon tracer, and the world and request that show it.
struct Reference {
    name: String,
    layers: ExrLayers,
    world: World,
    request: FrameRequest,
    half: f64,
    /// Watts that reached the plane after two refractions.
    arrived: f64,
}

fn references() -> Vec<Reference> {
    let Some(index) = shared("reference/index.json") else { return Vec::new() };
    let text = std::fs::read_to_string(index).expect("index.json is readable");
    let index: serde_json::Value = serde_json::from_str(&text).expect("index.json is JSON");
    index["caustics"].as_array().expect("a list of caustics").iter().map(reference).collect()
}

fn reference(entry: &serde_json::Value) -> Reference {
    let number = |name: &str| entry[name].as_f64().expect("a number");
    let text = |name: &str| entry[name].as_str().expect("a text");
    let point = |name: &str| DVec3::from_array(std::array::from_fn(|axis| entry[name][axis].as_f64().expect("three")));
    let mesh = text("mesh");
    let folder = if mesh.contains("20k") { "reference/meshes" } else { "data/paper" };
    let model = shared(&format!("{folder}/{mesh}")).expect("the body of a reference caustic");
    let height = number("plane_y");
    let half = number("half");
    let mut lamp = if text("light") == "point" {
        light(LightKind::Point, point("pos"), -point("pos"))
    } else {
        light(LightKind::Directional, point("dir") * -4.0, point("dir"))
    };
    let strength = if text("light") == "point" { number("intensity_cd") } else { number("irradiance_lux") };
    lamp.light.intensity = strength as f32;
    Reference {
        name: text("file").trim_start_matches("caustics/").trim_end_matches(".exr").into(),
        layers: ExrLayers::read(&shared(&format!("reference/{}", text("file"))).expect("what index.json lists")),
        world: World {
            floor: Some(floor(height)),
            ..glass_body(&model, Ior::new(number("ior")).expect("an index of refraction"))
        },
        // Under every body there is a gap above the plane; the camera is in it.
        request: request(from_above(height + 0.005, half), 256, lamp, 256),
        half,
        arrived: entry["account"]["budget_W"]["arrived_TT"].as_f64().expect("a flux"),
    }
}

/// How far the energy in the window may be off, and the most relative L1 at 128^2 and 256^2 photons: what was measured plus a fifth.
fn limits(name: &str, interfaces: Interfaces) -> (f64, [f64; 2]) {
    let all = interfaces == Interfaces::All;
    match (name, all) {
        ("sphere20k_point", false) => (0.005, [0.029, 0.020]),
        ("sphere20k_point", true) => (0.005, [0.030, 0.022]),
        ("sphere20k_directional", false) => (0.005, [0.0232, 0.015]),
        ("sphere20k_directional", true) => (0.005, [0.026, 0.018]),
        ("bumpy20k_point", false) => (0.005, [0.0575, 0.038]),
        ("bumpy20k_point", true) => (0.005, [0.0865, 0.0645]),
        ("bumpy20k_directional", false) => (0.005, [0.0705, 0.0435]),
        ("bumpy20k_directional", true) => (0.005, [0.102, 0.073]),
        ("bunny_69k_point", false) => (0.008, [0.163, 0.085]),
        ("bunny_69k_point", true) => (0.005, [0.193, 0.116]),
        ("bunny_69k_directional", false) => (0.005, [0.149, 0.081]),
        ("bunny_69k_directional", true) => (0.005, [0.190, 0.1145]),
        _ => panic!("no limits are known for {name}"),
    }
}

#[test]
fn caustics_agree_with_the_photon_tracer() {
    const SIZE: u32 = 256;
    const FINER: u32 = 4;
    let mut device = None;
    for reference in references() {
        let mut renderer = renderer(device.take().unwrap_or_else(gpu), reference.world);
        let strength = f64::from(reference.request.lights[0].light.intensity);
        let pixel = (2.0 * reference.half / f64::from(SIZE)).powi(2);
        let flux = |values: &[f64]| pixel * values.iter().sum::<f64>();
        let layer = |name: &str| -> Vec<f64> {
            reference.layers.channel(&format!("{name}.V")).iter().map(|value| f64::from(*value)).collect()
        };
        let (twice, all) = (layer("E_TT"), layer("E_caustic"));
        for interfaces in Interfaces::ALL {
            for (photons, grade) in [(128, 0), (256, 1)] {
                let mut request = reference.request.clone();
                request.caustics = Some(Caustics { photons, interfaces, ..Caustics::default() });
                let account = account(&mut renderer, &request);
                request.size = [SIZE * FINER; 2];
                let frame = picture(&mut renderer, &request);
                // A texel is the mean of its pixels, not its middle.
                let pixels = scalars(&frame.aov.expect("asked for"), "caustic");
                let fine = IrradianceMap::new(request.size, pixel / f64::from(FINER * FINER), pixels).expect("a map");
                let ours = fine.downsampled(FINER).expect("a whole number of pixels a texel").values().to_vec();
                let truth = if interfaces == Interfaces::Two { &twice } else { &all };
                let energy = flux(&ours) / flux(truth);
                let error = ours.iter().zip(truth).map(|(a, b)| (a - b).abs()).sum::<f64>() * pixel / flux(truth);
                let map = |values: &[f64]| IrradianceMap::new([SIZE; 2], pixel, values.to_vec()).expect("a map");
                let (exact, drawn) = (map(truth), map(&ours));
                let radius = |map| encircled_energy_radius(map, 0.5, exact.centroid()).expect("light");
                let radius = radius(&drawn) / radius(&exact);
                let ridge = ridge_position(&exact, &drawn, RidgeSettings::default());
                // Under a ball in the sun the truth has a point and no ridge.
                let (ridge, missed) = ridge.map_or((0.0, 0.0), |ridge| (ridge.mean, ridge.missed));
                let streaks = streaks(&ours, truth, SIZE as usize);
                eprintln!(
                    "{}, {interfaces}, {photons}^2: sent {:.4} W, landed {:.4} W; in the window {:.4} W, {energy:.4} of the \
                     reference; relative L1 {error:.4}; radius of half the light {radius:.4}, ridges off by {ridge:.3} texels, {missed:.4} \
                     missed, streaks {streaks:.5}",
                    reference.name,
                    strength * account.sent,
                    strength * account.landed,
                    flux(&ours),
                );
                assert!(off(radius, 1.0) <= 0.02, "{}: {radius} of the radius", reference.name);
                assert!(photons < 256 || streaks <= 0.005, "{}: {streaks} of the flux in streaks", reference.name);
                assert!(ridge <= 1.0, "{}: ridges off by {ridge} texels", reference.name);
                let (energy_off, most) = limits(&reference.name, interfaces);
                assert!(off(flux(&ours), flux(truth)) <= energy_off, "{}: {energy} of the energy", reference.name);
                assert!(error <= most[grade], "{}, {photons}^2: {error} > {}", reference.name, most[grade]);
                if interfaces == Interfaces::Two {
                    let sent = strength * account.sent;
                    let most = if reference.name.starts_with("sphere") { 0.005 } else { 0.01 };
                    assert!(off(sent, reference.arrived) <= most, "{}: {sent} W sent", reference.name);
                }
            }
        }
        device = Some(renderer.into_gpu());
    }
}

/// Caustic and shadow of a picture whose tiles of 8x8 pixels lie elsewhere than the picture's own: its eye stands so many pixels aside.
fn beside(renderer: &mut Renderer, request: &FrameRequest, pixels: [u32; 2]) -> Vec<DVec3> {
    let Projection::Orthographic { half_height } = request.view.projection else { panic!("a parallel view") };
    let step = 2.0 * half_height / f64::from(request.size[1]);
    let aside = DVec3::new(f64::from(pixels[0]), -f64::from(pixels[1]), 0.0) * step;
    let world_from_view = request.view.world_from_view * DMat4::from_translation(aside);
    let view = View { world_from_view, ..request.view };
    let aov = picture(renderer, &FrameRequest { view, ..request.clone() }).aov.expect("asked for");
    vectors(&aov, "caustic").into_iter().chain(vectors(&aov, "shadow")).collect()
}

#[test]
fn what_a_pixel_sees_of_a_caustic_does_not_depend_on_the_tile_that_it_lies_in() {
    const SIZE: [u32; 2] = [130, 70];
    const ASIDE: [u32; 2] = [3, 5];
    let lamps = [
        sunlight(),
        light(LightKind::Directional, DVec3::Y * 5.0, DVec3::new(0.5, -1.0, 0.2)),
        spot(0.25, 0.3),
        light(LightKind::Point, DVec3::new(1.5, 2.5, 0.5), DVec3::NEG_Y),
    ];
    let ring = World { floor: Some(floor(-0.18)), ..body(&asset("ring.glb")) };
    for (world, height) in [(ball_above(FOCUS), -1.02), (ring, 3.0)] {
        let mut renderer = renderer(gpu(), world);
        for (lamp, map_size) in lamps.iter().zip([96, 130, 512, 1000]) {
            for half in [0.02, 0.3, 4.0] {
                let asked = request(from_above(height, half), SIZE[1], lamp.clone(), 128);
                let caustics =
                    Caustics { method: Method::Footprint, map_size, interfaces: Interfaces::All, photons: 128 };
                let asked = FrameRequest { size: SIZE, caustics: Some(caustics), ..asked };
                let [here, there] = [[0; 2], ASIDE].map(|aside| beside(&mut renderer, &asked, aside));
                let pixels = (SIZE[0] * SIZE[1]) as usize;
                let brightest = here[..pixels].iter().map(|light| light.max_element()).fold(0.0, f64::max);
                for row in ASIDE[1]..SIZE[1] {
                    for column in ASIDE[0]..SIZE[0] {
                        let own = (row * SIZE[0] + column) as usize;
                        let other = ((row - ASIDE[1]) * SIZE[0] + column - ASIDE[0]) as usize;
                        let caustic = (here[own] - there[other]).abs().max_element() / brightest.max(1e-9);
                        let shadow = (here[pixels + own] - there[pixels + other]).abs().max_element();
                        let what = format!("{:?}, half {half}, [{column}, {row}]", lamp.light.kind);
                        assert!(
                            caustic < 2e-3 && shadow < 2e-3,
                            "{what}: caustic off by {caustic}, shadow by {shadow}"
                        );
                    }
                }
            }
        }
    }
}
