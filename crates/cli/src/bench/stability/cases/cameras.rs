//! Hostile cameras and pictures.

use glam::DVec3;

use super::super::{
    bodies::Body,
    case::{Case, Group, MethodLimits, Truth, looking, looking_past, parallel},
};
use super::{GLASS, YFOV, around, three_lamps};

/// Plates lit along their faces, and the rim of a ball.
pub fn grazing() -> Group {
    let mut cases = Vec::new();
    let plate = Body::plate(DVec3::new(1.0, 0.2, 1.0), 1).alone(GLASS);
    for degrees in [0.0, 45.0, 80.0, 85.0, 88.0, 89.0, 89.9, 89.99, 90.0] {
        let angle: f64 = f64::to_radians(degrees);
        let from = DVec3::new(0.6 * angle.sin(), angle.cos(), 0.8 * angle.sin());
        let target = DVec3::Y * 0.2;
        let view = parallel(target + 4.0 * from, target, 0.7 * angle.cos().max(0.1));
        cases.push(Case::new(format!("plate at {degrees} degrees"), plate.clone(), view, Truth::Closed));
    }
    let ball = Body::ball(1.0, 64, 128).alone(GLASS);
    for inset in [1e-1, 1e-2, 1e-3, 1e-4] {
        let rim = DVec3::new(1.0 - inset, 0.0, 0.0);
        let view = parallel(rim + 4.0 * DVec3::Z, rim, inset);
        cases.push(Case::new(format!("ball's rim within {inset} radii"), ball.clone(), view, Truth::Closed));
    }
    // Most of these pictures show less than the way through the body: where it ends is not in the map.
    let limits = MethodLimits::new([1e-3, 1e-3, 1.0], [1e-3, 1e-3, 1.0]);
    Group { name: "grazing incidence", limits, cases }
}

/// The eye in the glass, on its surface, and in its hollows.
pub fn eye_inside() -> Group {
    let ball = Body::unit_ball();
    let shell = Body::unit_ball().and(&Body::ball(0.6, 32, 64).inside_out());
    let torus = Body::torus(1.0, 0.4, 96, 48);
    let mut cases = Vec::new();
    for (n, radius) in
        [GLASS, 1.0 / GLASS, 2.4].into_iter().flat_map(|n| [0.0, 0.5, 0.9, 0.99, 1.0, 1.01].map(|r| (n, r)))
    {
        let eye = DVec3::new(0.3, 0.1, 0.9).normalize() * radius;
        let view = looking_past(eye, eye + DVec3::new(0.4, -0.2, -1.0), 70.0, 1e-3);
        let case = Case::new(format!("ball, n = {n:.2}, eye at radius {radius}"), ball.alone(n), view, Truth::Closed);
        cases.push(case.lit(if radius == 0.5 { three_lamps(DVec3::ZERO, 1.0) } else { Vec::new() }));
    }
    for radius in [0.0, 0.5, 0.7, 0.8, 0.95] {
        let eye = DVec3::Z * radius;
        for (name, target) in [("in", DVec3::new(0.1, 0.05, -1.0)), ("across", DVec3::new(3.0, 0.3, 0.0))] {
            let view = looking_past(eye, target, 70.0, 1e-3);
            let label = format!("hollow ball, eye at radius {radius} looking {name}");
            cases.push(Case::new(label, shell.alone(GLASS), view, Truth::Closed));
        }
    }
    for (name, eye) in [("in the tube", DVec3::Z), ("in the hole", DVec3::new(0.1, 0.0, 0.1))] {
        let view = looking_past(eye, DVec3::new(1.0, 0.1, 0.2), 80.0, 1e-3);
        cases.push(Case::new(format!("torus, eye {name}"), torus.alone(GLASS), view, Truth::Closed));
    }
    // From inside, one interface is left, and exact. From the hollow of the hollow ball, the second is partly out of sight.
    let limits = MethodLimits::new([1.8, 0.01, 0.3], [0.15, 1e-3, 0.3]);
    Group { name: "eye inside the body", limits, cases }
}

/// Bodies cut open.
pub fn cut_by_the_near_plane() -> Group {
    let ball = Body::unit_ball();
    let torus = Body::torus(1.0, 0.4, 96, 48);
    let mut cases = Vec::new();
    for near in [1.9, 2.0, 2.3, 3.0, 3.7, 4.0, 4.1] {
        let eye = DVec3::new(0.0, 0.0, 3.0);
        let view = looking_past(eye, DVec3::ZERO, YFOV, near);
        cases.push(Case::new(format!("ball, near plane at {near}"), ball.alone(GLASS), view, Truth::Closed));
        let eye = DVec3::new(0.0, 2.0, 2.2);
        let view = looking_past(eye, DVec3::ZERO, YFOV, near);
        cases.push(Case::new(format!("torus, near plane at {near}"), torus.alone(GLASS), view, Truth::Closed));
    }
    let mut view = parallel(DVec3::new(0.0, 1.0, 3.0), DVec3::ZERO, 1.2);
    view.near = 3.0;
    cases.push(Case::new("ball, parallel rays", ball.alone(GLASS), view, Truth::Closed));
    let limits = MethodLimits::new([1.1, 0.01, 1e-3], [0.03, 1e-3, 1e-3]);
    Group { name: "near plane through the body", limits, cases }
}

/// Angles from almost nothing to almost 180 degrees, and parallel rays.
pub fn fields_of_view() -> Group {
    let ball = Body::unit_ball().alone(GLASS);
    let mut cases = Vec::new();
    for yfov in [1e-4, 1e-2, 1.0, 10.0, 100.0, 150.0, 170.0, 179.0, 179.9, 179.999] {
        for (name, eye) in around() {
            // So near that even the widest shows something of the ball.
            let eye = if yfov > 90.0 { 1.02 * eye.normalize() } else { eye };
            let target = DVec3::new(0.2, 0.1, 0.0);
            let case =
                Case::new(format!("{yfov} degrees, {name}"), ball.clone(), looking(eye, target, yfov), Truth::Closed);
            cases.push(if name == "front" { case.lit(three_lamps(DVec3::ZERO, 1.0)) } else { case });
        }
    }
    for half_height in [1e-6, 1e-3, 1.1, 1e3, 1e6] {
        let view = parallel(DVec3::new(0.5, 2.0, 3.0), DVec3::new(0.2, 0.1, 0.0), half_height);
        let case = Case::new(format!("parallel, {half_height} m"), ball.clone(), view, Truth::Closed);
        cases.push(case.lit(three_lamps(DVec3::ZERO, 1.0)));
    }
    // Narrow views do not show where light leaves; wide ones show the body in few texels.
    let limits = MethodLimits::new([14.0, 0.18, 1.0], [1.0, 0.04, 1.0]);
    Group { name: "fields of view to 180 degrees, parallel", limits, cases }
}

/// Pictures of one pixel, and strips.
pub fn sizes() -> Group {
    let ball = Body::unit_ball().alone(GLASS);
    let mut cases = Vec::new();
    for size in [[1, 1], [2, 1], [1, 3], [7, 13], [9, 8], [8192, 1], [1, 8192], [4096, 2]] {
        let (name, eye) = around()[0];
        // A pixel is as high as wide: a wide strip has a small angle.
        let yfov = (YFOV * f64::from(size[1]) / f64::from(size[0])).min(YFOV);
        let label = format!("{}x{}, {name}", size[0], size[1]);
        let target = DVec3::new(0.1, 0.05, 0.0);
        let case = Case::new(label, ball.clone(), looking(eye, target, yfov), Truth::Closed).sized(size);
        cases.push(case.lit(three_lamps(DVec3::ZERO, 1.0)));
    }
    // The map has as few texels as the picture, and says so; strips do not show where light leaves.
    let limits = MethodLimits::new([5.0, 0.02, 1.0], [0.25, 0.02, 1.0]);
    Group { name: "pictures from 1x1 to 8192x1", limits, cases }
}
