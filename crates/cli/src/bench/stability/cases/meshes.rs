//! Hostile meshes.

use glam::DVec3;

use super::super::{
    bodies::Body,
    case::{Case, Group, MethodLimits, Truth, looking},
};
use super::{GLASS, YFOV, ball_cases, three_lamps};

/// Long thin triangles, and triangles of no area.
pub fn needles_and_slivers() -> Group {
    let mut cases = Vec::new();
    let mut add = |name: &str, body: &Body, truth: Truth| {
        let mut more = ball_cases(|view| format!("{name}, {view}"), &body.alone(GLASS), truth);
        more[0].lamps = three_lamps(DVec3::ZERO, 1.0)[..1].to_vec();
        cases.extend(more);
    };
    add("gores of a ball, 1 to 500", &Body::ball(1.0, 3, 1000), Truth::Closed);
    add("rings of a ball, 1 to 100", &Body::ball(1.0, 300, 8), Truth::Closed);
    add("plate of 1000 strips", &Body::plate(DVec3::new(0.9, 0.3, 0.9), 1000), Truth::Closed);

    let mut slivers = Body::unit_ball();
    let count = slivers.positions.len() as u32;
    let middle = |a: u32, b: u32, body: &Body| 0.5 * (body.positions[a as usize] + body.positions[b as usize]);
    for [a, b, c] in slivers.triangles.clone().into_iter().step_by(3) {
        // A corner twice, three times, and three corners on one line.
        slivers.triangles.extend([[a, a, b], [c, c, c]]);
        let on_edge = slivers.positions.len() as u32;
        slivers.positions.push(middle(a, b, &slivers));
        slivers.normals.push(slivers.normals[a as usize]);
        slivers.triangles.push([a, on_edge, b]);
    }
    add("ball with triangles of no area", &slivers, Truth::Closed);

    let mut split = Body::unit_ball();
    for triangle in 0..split.triangles.len() {
        let [a, b, c] = split.triangles[triangle];
        let near_a = split.positions.len() as u32;
        let weight = 1e-4;
        let between = |list: &[DVec3]| list[a as usize].lerp(list[b as usize], weight);
        let (position, normal) = (between(&split.positions), between(&split.normals).normalize());
        split.positions.push(position);
        split.normals.push(normal);
        split.triangles[triangle] = [near_a, b, c];
        split.triangles.push([a, near_a, c]);
    }
    add("ball with a needle beside every triangle", &split, Truth::Closed);

    let mut unshaded = Body::unit_ball();
    unshaded.normals.iter_mut().take((count / 2) as usize).for_each(|normal| *normal = DVec3::ZERO);
    add("ball with normals of no length", &unshaded, Truth::Unknown);
    // The plate's edges, where a search may find the face beside.
    let limits = MethodLimits::new([1.1, 0.02, 2e-3], [0.13, 0.02, 2e-3]);
    Group { name: "needles and triangles of no area", limits, cases }
}

/// Faces that lie on each other.
pub fn coincident_faces() -> Group {
    let ball = Body::unit_ball();
    let sheet = |size: f64| Body::plate(DVec3::new(size, 0.0, size), 1).kept(|p| p.y == 0.0);
    let faces_only = sheet(0.9);
    let faces_only = Body {
        triangles: faces_only
            .triangles
            .iter()
            .copied()
            .filter(|t| faces_only.normals[t[0] as usize].y != 0.0)
            .collect(),
        ..faces_only
    };
    let mut cases = ball_cases(
        |view| format!("every triangle twice, {view}"),
        &ball.clone().and(&ball).alone(GLASS),
        Truth::Closed,
    );
    cases.extend(ball_cases(
        |view| format!("every triangle with its reverse, {view}"),
        &ball.clone().and(&ball.clone().inside_out()).alone(GLASS),
        Truth::Unknown,
    ));
    for eye in [DVec3::new(0.1, 3.0, 0.2), DVec3::new(2.0, 2.0, 0.5)] {
        let view = looking(eye, DVec3::ZERO, YFOV);
        cases.push(Case::new("sheet without thickness", faces_only.alone(GLASS), view, Truth::Sheet));
    }
    let touching = Body::plate(DVec3::splat(0.5), 1).moved(|p| p - 0.5 * DVec3::Y);
    let touching = touching.and(&Body::plate(DVec3::splat(0.5), 1).moved(|p| p + 0.5 * DVec3::Y));
    cases.extend(ball_cases(|view| format!("two cubes on one face, {view}"), &touching.alone(GLASS), Truth::Unknown));
    cases[0].lamps = three_lamps(DVec3::ZERO, 1.0);
    cases[3].lamps = three_lamps(DVec3::ZERO, 1.0);
    let limits = MethodLimits::new([1.1, 5e-3, 1e-3], [0.012, 1e-3, 1e-3]);
    Group { name: "coincident faces", limits, cases }
}

/// Meshes that surround nothing.
pub fn open_and_inside_out() -> Group {
    let ball = Body::unit_ball();
    let bowl = ball.clone().kept(|p| p.y < 0.5).alone(GLASS);
    let half = ball.clone().kept(|p| p.z < 0.01).alone(GLASS);
    let triangle = Body {
        positions: vec![DVec3::new(-1.0, -0.8, 0.2), DVec3::new(1.0, -0.7, 0.0), DVec3::new(0.0, 0.9, -0.3)],
        normals: vec![DVec3::Z; 3],
        triangles: vec![[0, 1, 2]],
    };
    let mut patchwork = ball.clone();
    patchwork.triangles.iter_mut().step_by(2).for_each(|triangle| triangle.swap(1, 2));
    let mut cases = Vec::new();
    for (name, scene, truth) in [
        ("ball without its top", &bowl, Truth::Open),
        ("half a ball", &half, Truth::Open),
        ("one triangle", &triangle.alone(GLASS), Truth::Open),
        ("its back", &triangle.clone().inside_out().alone(GLASS), Truth::Open),
        ("ball turned inside out", &ball.clone().inside_out().alone(GLASS), Truth::Open),
        ("ball with every other triangle turned", &patchwork.alone(GLASS), Truth::Unknown),
    ] {
        let mut more = ball_cases(|view| format!("{name}, {view}"), scene, truth);
        more[1].lamps = three_lamps(DVec3::ZERO, 1.0);
        cases.extend(more);
    }
    // A search beside the hole may find the rim for the wall that is not there.
    let limits = MethodLimits::new([1.4, 0.012, 0.01], [0.08, 0.025, 4e-3]);
    Group { name: "open and inside-out meshes", limits, cases }
}
