//! Hostile scales, places, joints and lamps.

use glam::DVec3;
use murano_scene::{Channel, Clip, Interpolation, LightKind, Path, PlacedLight, Sampler, Scene};

use super::super::{
    bodies::{Body, at, scaled, turned},
    case::{Case, Group, MethodLimits, Truth, looking},
};
use super::{GLASS, YFOV, around, ball_cases, lamp, three_lamps};

/// A ball of a micrometre to one of a thousand kilometres.
pub fn scales() -> Group {
    let mut cases = Vec::new();
    for exponent in -6..=6 {
        let scale = 10_f64.powi(exponent);
        let (name, eye) = around()[1];
        let view = looking(eye * scale, DVec3::ZERO, YFOV);
        let by_node = Body::unit_ball().placed(GLASS, scaled(DVec3::splat(scale)));
        let in_mesh = Body::unit_ball().moved(|p| p * scale).alone(GLASS);
        for (how, scene) in [("node", by_node), ("mesh", in_mesh)] {
            let label = format!("{how} at scale 1e{exponent}, {name}");
            let case = Case::new(label, scene, view, Truth::Closed);
            cases.push(case.lit(three_lamps(DVec3::ZERO, scale)));
        }
    }
    // As at scale 1.
    let limits = MethodLimits::new([1.0, 2e-3, 1e-3], [0.01, 1e-3, 1e-3]);
    Group { name: "scales from 1e-6 to 1e6", limits, cases }
}

/// A ball far from the world's origin.
pub fn places() -> Group {
    let mut cases = Vec::new();
    let far = [DVec3::new(1e6, 0.0, 0.0), DVec3::new(-1e6, 1e6, 1e6), DVec3::new(123_456.7, -1e6, 765_432.1)];
    for (place, (name, eye)) in far.into_iter().zip(around()) {
        let view = looking(place + eye, place, YFOV);
        let scene = Body::unit_ball().placed(GLASS, at(place));
        let case = Case::new(format!("node at {place}, {name}"), scene, view, Truth::Closed);
        cases.push(case.lit(three_lamps(place, 1.0)));
        // The file's own f32 positions are half a millimetre of these thousand metres apart.
        let view = looking(place + 1e3 * eye, place, YFOV);
        let scene = Body::unit_ball().moved(|p| 1e3 * p + place).alone(GLASS);
        let case = Case::new(format!("vertices about {place}, {name}"), scene, view, Truth::Closed);
        cases.push(case.lit(three_lamps(place, 1e3)));
    }
    // As at the origin.
    let limits = MethodLimits::new([1.1, 5e-3, 1e-3], [0.012, 1e-3, 1e-3]);
    Group { name: "1e6 m from the origin", limits, cases }
}

/// Skins whose joints or weights mean nothing.
pub fn joints() -> Group {
    let ball = Body::unit_ball();
    let upper = |p: DVec3| {
        let share = (0.5 + 0.5 * p.y.clamp(-1.0, 1.0)) as f32;
        [share, 1.0 - share, 0.0, 0.0]
    };
    let rest = turned(DVec3::X, 20.0);
    let mut cases = Vec::new();
    let mut add = |name: &str, scene: &Scene, truth: Truth| {
        let mut more = ball_cases(|view| format!("{name}, {view}"), scene, truth);
        more[2].lamps = three_lamps(DVec3::ZERO, 1.0);
        cases.extend(more);
    };
    for (name, scale, truth) in [
        ("a joint mirrored in x", DVec3::new(-1.0, 1.0, 1.0), Truth::Closed),
        ("a joint mirrored in all", DVec3::splat(-1.0), Truth::Closed),
    ] {
        add(name, &ball.skinned(GLASS, &[scaled(scale), scaled(scale)], upper), truth);
    }
    for (name, scale) in [
        ("one of two joints at scale 0", DVec3::ZERO),
        ("one of two joints at 1e-30", DVec3::splat(1e-30)),
        ("one of two joints flattened", DVec3::new(1.0, 0.0, 1.0)),
        ("one of two joints mirrored", DVec3::new(-1.0, 1.0, 1.0)),
    ] {
        add(name, &ball.skinned(GLASS, &[rest, scaled(scale)], upper), Truth::Unknown);
    }
    for (name, scale) in [
        ("all joints at scale 0", DVec3::ZERO),
        ("all joints flattened", DVec3::new(1.0, 0.0, 1.0)),
        ("all joints to a line", DVec3::new(0.0, 1.0, 0.0)),
        ("all joints at 1e-30", DVec3::splat(1e-30)),
    ] {
        add(name, &ball.skinned(GLASS, &[scaled(scale), scaled(scale)], upper), Truth::Unknown);
    }
    for (name, weights) in [
        ("weights that sum to 0", [0.0; 4]),
        ("weights that cancel", [1.0, -1.0, 0.0, 0.0]),
        ("weights of 1e-38", [1e-38, 1e-38, 0.0, 0.0]),
        ("weights of 1e38", [1e38, 1e38, 0.0, 0.0]),
    ] {
        add(name, &ball.skinned(GLASS, &[rest, rest], |_| weights), Truth::Closed);
    }
    let limits = MethodLimits::new([1.1, 5e-3, 1e-3], [0.012, 1e-3, 1e-3]);
    Group { name: "joints of scale 0 or below, weights that sum to 0", limits, cases }
}

/// A clip of one second in which the body's height goes from 1 through 0 to -1.
pub fn joints_through_zero() -> Group {
    let mut scene = Body::unit_ball().alone(GLASS);
    let sampler = Sampler {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 1.0],
        width: 3,
        values: vec![1.0, 1.0, 1.0, 1.0, -1.0, 1.0],
    };
    scene.clips.push(Clip {
        name: "through zero".into(),
        channels: vec![Channel { node: 0, path: Path::Scale, sampler }],
        duration: 1.0,
        ..Clip::default()
    });
    let case = |time: f64| {
        let view = looking(around()[1].1, DVec3::ZERO, YFOV);
        let truth = if (time - 0.5).abs() < 0.01 { Truth::Unknown } else { Truth::Closed };
        Case::new(format!("at {time} s"), scene.clone(), view, truth).at_time(time).lit(three_lamps(DVec3::ZERO, 1.0))
    };
    let times = [0.0, 0.3, 0.45, 0.499, 0.499_999_9, 0.5, 0.500_000_1, 0.501, 0.55, 0.7, 0.999];
    let limits = MethodLimits::new([1.0, 6e-3, 1e-3], [0.04, 1e-3, 1e-3]);
    Group { name: "a body scaled through 0", limits, cases: times.map(case).into() }
}

/// Lamps where none should be.
pub fn lamps() -> Group {
    let ball = Body::unit_ball().alone(GLASS);
    let spot = |outer: f32| LightKind::Spot { inner: 0.7 * outer, outer };
    let mut cases = Vec::new();
    let mut add = |name: &str, placed: PlacedLight| {
        let view = looking(around()[1].1, DVec3::ZERO, YFOV);
        cases.push(Case::new(name, ball.clone(), view, Truth::Closed).lit(vec![placed]));
    };
    let above = DVec3::new(0.0, 3.0, 0.0);
    for (name, kind) in [("spot", spot(0.5)), ("point", LightKind::Point)] {
        add(&format!("{name} in the centre"), lamp(kind, DVec3::ZERO, DVec3::NEG_Y, 1.0));
        add(&format!("{name} on the surface"), lamp(kind, DVec3::Y, DVec3::NEG_Y, 1.0));
        add(&format!("{name} just above"), lamp(kind, 1.75 * DVec3::Y, DVec3::NEG_Y, 1.0));
        add(&format!("{name} in the floor"), lamp(kind, DVec3::new(4.0, -1.0, 0.0), DVec3::NEG_Y, 1.0));
        add(&format!("{name} 1e6 m away"), lamp(kind, 1e6 * DVec3::new(0.1, 1.0, 0.2), DVec3::ZERO, 1e6));
    }
    for outer in [1e-6, 1e-3, 1.5, std::f32::consts::FRAC_PI_2, std::f32::consts::PI] {
        add(&format!("spot of {outer} rad"), lamp(spot(outer), above, DVec3::ZERO, 1.0));
    }
    for direction in [DVec3::NEG_Y, DVec3::Y, DVec3::X, DVec3::new(1.0, -1e-6, 0.0), DVec3::new(1e-9, -1.0, 0.0)] {
        let placed = lamp(LightKind::Directional, -direction, DVec3::ZERO, 1.0);
        add(&format!("sun along {direction}"), placed);
    }
    let mut ranged = lamp(LightKind::Point, above, DVec3::ZERO, 1.0);
    ranged.light.range = 1e-6;
    add("point of range 1e-6 m", ranged);
    let mut bright = lamp(LightKind::Point, above, DVec3::ZERO, 1.0);
    bright.light.intensity = 1e12;
    add("point of 1e12 candela", bright);
    // Lamps bend no path.
    let limits = MethodLimits::new([1.0, 2e-3, 1e-3], [0.01, 1e-3, 1e-3]);
    Group { name: "lamps inside, on the surface, far, of any angle", limits, cases }
}
