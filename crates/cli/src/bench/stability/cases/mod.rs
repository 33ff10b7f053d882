//! The hostile cases, group by group.

mod cameras;
mod meshes;
mod placing;

use glam::{DVec3, Vec3};
use murano_scene::{Light, LightKind, PlacedLight, Scene, look_along};

use super::{
    bodies::Body,
    case::{Case, Group, MethodLimits, Truth, looking},
};

/// Index of refraction of most bodies.
const GLASS: f64 = 1.5;

/// From the front, from above and from the right: the unit ball fills most of each.
fn around() -> [(&'static str, DVec3); 3] {
    [("front", DVec3::new(0.0, 0.0, 3.0)), ("above", DVec3::new(-1.2, 2.4, 1.3)), ("right", DVec3::new(2.9, 0.3, -0.8))]
}

/// Full vertical angle that shows the unit ball from three metres away.
const YFOV: f64 = 46.0;

/// Every group; `quick` keeps a quarter of each, and lamps over one case each.
pub fn groups(quick: bool) -> Vec<Group> {
    let mut groups = all();
    if quick {
        for group in &mut groups {
            let mut kept = 0;
            group.cases.retain(|_| {
                kept += 1;
                kept % 4 == 1
            });
            group.cases.iter_mut().skip(1).for_each(|case| case.lamps.clear());
        }
    }
    groups
}

fn all() -> Vec<Group> {
    vec![
        denser(),
        thinner(),
        concave(),
        rough_and_thin(),
        cameras::grazing(),
        cameras::eye_inside(),
        cameras::cut_by_the_near_plane(),
        meshes::needles_and_slivers(),
        meshes::coincident_faces(),
        meshes::open_and_inside_out(),
        placing::scales(),
        placing::places(),
        cameras::fields_of_view(),
        cameras::sizes(),
        placing::joints(),
        placing::joints_through_zero(),
        placing::lamps(),
    ]
}

/// A spot, a point light and the sun, for a body of this radius about a point.
fn three_lamps(center: DVec3, radius: f64) -> Vec<PlacedLight> {
    let place = |direction: DVec3| center + direction * radius;
    let spot = LightKind::Spot { inner: 0.3, outer: 0.5 };
    vec![
        lamp(spot, place(DVec3::new(-2.0, 4.0, 1.0)), center, radius),
        lamp(LightKind::Point, place(DVec3::new(3.0, 3.0, 0.0)), center, radius),
        lamp(LightKind::Directional, place(DVec3::new(0.0, 5.0, -1.0)), center, radius),
    ]
}

/// A lamp whose light is of the order of 1 lux at the target, `radius` metres being the size of things.
fn lamp(kind: LightKind, position: DVec3, target: DVec3, radius: f64) -> PlacedLight {
    let intensity = if kind == LightKind::Directional { 1.0 } else { (16.0 * radius * radius) as f32 };
    PlacedLight {
        world_from_light: look_along(position, target - position),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity, range: f32::INFINITY },
    }
}

fn ball_cases(label: impl Fn(&str) -> String, scene: &Scene, truth: Truth) -> Vec<Case> {
    let case = |(name, eye)| Case::new(label(name), scene.clone(), looking(eye, DVec3::ZERO, YFOV), truth);
    around().into_iter().map(case).collect()
}

/// Lobes from a mirror's to the widest, and walls around nothing, of glass that hardly bends and of such that bends most.
fn rough_and_thin() -> Group {
    let ball = Body::unit_ball();
    let torus = Body::torus(1.0, 0.4, 96, 48);
    let mut cases = Vec::new();
    let surfaces = [1e-5_f32, 0.3, 1.0].map(|roughness| (roughness, 1.0)).into_iter().chain([(0.0, 0.0), (0.3, 0.0)]);
    for (k, (roughness, thickness)) in surfaces.enumerate() {
        for n in [1.0 / GLASS, 1.0 + 1e-7, GLASS, 4.0] {
            let body = if k % 2 == 0 { &ball } else { &torus };
            let mut scene = body.alone(n);
            for material in &mut scene.materials {
                (material.roughness, material.thickness) = (roughness, thickness);
            }
            let truth = if thickness == 0.0 { Truth::Sheet } else { Truth::Closed };
            let kind = if thickness == 0.0 { "thin" } else { "solid" };
            let mut few =
                ball_cases(|view| format!("{kind}, roughness {roughness}, n = {n:.2}, {view}"), &scene, truth);
            few[0].lamps = if n == GLASS { three_lamps(DVec3::ZERO, 1.4) } else { Vec::new() };
            cases.extend(few);
        }
    }
    let limits = MethodLimits::new([50.0, 0.4, 0.12], [0.7, 0.01, 0.25]);
    Group { name: "rough and thin glass", limits, cases }
}

/// `1, 1.05, ..., 4`.
fn indices() -> impl Iterator<Item = f64> {
    (0..=60).map(|k| 1.0 + 0.05 * f64::from(k))
}

fn denser() -> Group {
    let body = Body::unit_ball();
    let cases = indices().enumerate().map(|(k, n)| {
        let (name, eye) = around()[k % 3];
        let case =
            Case::new(format!("n = {n:.2}, {name}"), body.alone(n), looking(eye, DVec3::ZERO, YFOV), Truth::Closed);
        if k % 5 == 0 { case.lit(three_lamps(DVec3::ZERO, 1.0)) } else { case }
    });
    let limits = MethodLimits::new([5.0, 0.06, 1e-3], [0.03, 1e-3, 1e-3]);
    Group { name: "n from 1 to 4", limits, cases: cases.collect() }
}

fn thinner() -> Group {
    let body = Body::unit_ball();
    let cases = indices().enumerate().skip(1).map(|(k, n)| {
        let (name, eye) = around()[k % 3];
        let view = looking(eye, DVec3::ZERO, YFOV);
        let case = Case::new(format!("n = 1/{n:.2}, {name}"), body.alone(1.0 / n), view, Truth::Closed);
        if k % 5 == 0 { case.lit(three_lamps(DVec3::ZERO, 1.0)) } else { case }
    });
    // Light spreads inside: the search ends beside the body, and says so.
    let limits = MethodLimits::new([2.0, 1e-3, 0.06], [1.0, 1e-3, 0.06]);
    Group { name: "n from 1/4 to 1 (thinner than around)", limits, cases: cases.collect() }
}

fn concave() -> Group {
    let torus = Body::torus(1.0, 0.4, 96, 48);
    let shell = Body::unit_ball().and(&Body::ball(0.6, 32, 64).inside_out());
    let mut cases = Vec::new();
    for n in [1.0 / GLASS, 1.1, GLASS, 2.4] {
        cases.extend(ball_cases(|view| format!("torus, n = {n:.2}, {view}"), &torus.alone(n), Truth::Closed));
        cases.extend(ball_cases(|view| format!("shell, n = {n:.2}, {view}"), &shell.alone(n), Truth::Closed));
    }
    // `dir` searches the farthest back, which through a hollow is not the second interface. `newton` knows the nearest
    // back alone, and says where that is not what the ray meets.
    let limits = MethodLimits::new([50.0, 0.4, 0.12], [0.7, 0.01, 0.25]);
    Group { name: "torus and hollow ball", limits, cases }
}
