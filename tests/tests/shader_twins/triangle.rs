//! `lib::triangle` against a ray's crossing of a plane in f64.

use glam::{DVec2, DVec3, Vec2, Vec3, Vec4};

use crate::{
    SLACK, U,
    harness::{Random, assert_close, assert_finite, assert_near, run, xyz},
};

/// What f64 says about a triangle and a ray, and what f32 may not be able to tell.
struct Crossing {
    /// Sure to be hit.
    inside: bool,
    /// Sure to be missed.
    outside: bool,
    counter_clockwise: bool,
    depth: f64,
    barycentric: DVec3,
    /// Error of a barycentric coordinate.
    error: f64,
}

/// Where a ray crosses the plane of a triangle, and the ratios of areas there.
fn cross_in_f64(corners: [DVec3; 3], plane: DVec2, perspective: bool) -> Crossing {
    let [a, b, c] = corners;
    let (origin, direction) =
        if perspective { (DVec3::ZERO, plane.extend(-1.0)) } else { (plane.extend(0.0), DVec3::NEG_Z) };
    let normal = (b - a).cross(c - a);
    // Areas in the picture, each twice the triangle of the ray and an edge.
    let area = |p: DVec3, q: DVec3| -(p - origin).cross(q - origin).dot(direction);
    let areas = DVec3::new(area(b, c), area(c, a), area(a, b));
    let total = -normal.dot(direction);
    let spread = corners.map(|p| {
        let shift = plane.length() * if perspective { p.z.abs() } else { 1.0 };
        let sheared = (p - origin + direction * p.z).truncate().length();
        (p.truncate().length() + shift, sheared)
    });
    let largest = spread.iter().fold(0.0, |largest, (size, _)| f64::max(largest, *size));
    let sheared = spread.iter().fold(0.0, |largest, (_, size)| f64::max(largest, *size));
    let error = SLACK * U * (6.0 * largest * sheared + 4.0 * U * largest * largest);
    Crossing {
        inside: areas.min_element() > error || areas.max_element() < -error,
        outside: areas.min_element() < -error && areas.max_element() > error,
        counter_clockwise: total > 0.0,
        depth: normal.dot(a - origin) / normal.dot(direction),
        barycentric: areas / total,
        error: 4.0 * error / total.abs().max(1e-300),
    }
}

fn rows([a, b, c]: [Vec3; 3], plane: Vec2, perspective: bool) -> [Vec4; 3] {
    [a.extend(plane.x), b.extend(plane.y), c.extend(f32::from(u8::from(perspective)))]
}

/// Where a point lies in the picture.
fn plane_of(point: Vec3, perspective: bool) -> Vec2 {
    if perspective { point.truncate() / -point.z } else { point.truncate() }
}

/// A triangle of any size and shape: ordinary, needle, without area, reaching behind the viewpoint.
fn triangle(random: &mut Random) -> [Vec3; 3] {
    let scale = random.any(&[1e-6, 1e-3, 1.0, 1.0, 1.0, 1e3, 1e6]);
    let width = random.any(&[1.0, 1.0, 0.1, 1e-3, 1e-6]);
    let ahead = Vec3::new(0.0, 0.0, -random.any(&[0.0, 0.5, 2.0, 2.0, 100.0]));
    let a = ahead + random.in_cube();
    let b = a + random.in_cube();
    let c = match random.any(&[0, 1, 1, 1, 2, 3]) {
        0 => a + random.between(0.0, 1.0) * (b - a),
        1 => a + random.between(0.0, 1.0) * (b - a) + width * random.in_cube(),
        2 => a,
        _ => ahead + random.in_cube(),
    };
    [a, b, c].map(|corner| corner * scale)
}

#[test]
fn crossings_are_those_of_f64() {
    let mut random = Random(21);
    let cases: Vec<_> = (0..20_000)
        .map(|_| {
            let corners = triangle(&mut random);
            let perspective = random.any(&[true, false]);
            let (u, v) = (random.between(-0.1, 1.0), random.between(-0.1, 1.0));
            let [a, b, c] = corners;
            let plane = plane_of(a + u * (b - a) + v * (1.0 - u) * (c - a), perspective);
            (corners, if plane.is_finite() { plane } else { Vec2::ZERO }, perspective)
        })
        .collect();
    let inputs: Vec<_> =
        cases.iter().map(|(corners, plane, perspective)| rows(*corners, *plane, *perspective)).collect();
    let outputs = run("tests::triangle", "main", inputs.as_flattened(), inputs.len(), 2);
    let (mut hits, mut misses) = (0, 0);
    for (index, ((corners, plane, perspective), output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, &inputs[index], output);
        let corners = corners.map(Vec3::as_dvec3);
        let truth = cross_in_f64(corners, plane.as_dvec2(), *perspective);
        let what = || format!("case {index}, {corners:?} at {plane}, perspective {perspective}");
        let hit = output[0].x == 1.0;
        assert!(hit || !truth.inside, "{}: a hole", what());
        assert!(!hit || !truth.outside, "{}: hit outside", what());
        hits += u32::from(truth.inside);
        misses += u32::from(truth.outside);
        if !hit {
            continue;
        }
        let depths = corners.map(|corner| -corner.z);
        let (nearest, farthest) = (
            depths.iter().copied().fold(f64::INFINITY, f64::min),
            depths.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        );
        let depth = f64::from(output[0].z);
        assert!((nearest..=farthest).contains(&depth), "{}: depth {depth}", what());
        let weights = xyz(output[1]);
        assert!(weights.min_element() >= 0.0 && weights.max_element() <= 1.0 + 1e-6, "{}: {weights}", what());
        assert_near(weights.element_sum(), 1.0, SLACK * 4.0 * U, what);
        if truth.inside {
            assert_eq!(output[0].y == 1.0, truth.counter_clockwise, "{}", what());
            assert_close(weights, truth.barycentric, truth.error + SLACK * 4.0 * U, what);
            let tolerance =
                3.0 * truth.error * (farthest - nearest) + SLACK * 4.0 * U * farthest.abs().max(nearest.abs());
            assert_near(depth, truth.depth, tolerance, what);
        }
    }
    assert!(hits > 5_000 && misses > 1_000, "{hits} sure hits, {misses} sure misses");
}

/// Two triangles with a common edge leave no gap along it, wherever rounding puts the ray.
#[test]
fn neighbours_leave_no_gap() {
    let mut random = Random(22);
    let mut inputs = Vec::new();
    while inputs.len() < 20_000 {
        let scale = random.any(&[1e-6, 1.0, 1e6]);
        let perspective = random.any(&[true, false]);
        let ahead = Vec3::new(0.0, 0.0, -random.any(&[1.5, 3.0, 100.0]));
        let [a, b, c, d] = std::array::from_fn(|_| scale * (ahead + random.in_cube()));
        let plane = plane_of(a + random.between(0.05, 0.95) * (b - a), perspective);
        let sure = |corners: [Vec3; 3]| {
            let Crossing { barycentric, error, .. } =
                cross_in_f64(corners.map(Vec3::as_dvec3), plane.as_dvec2(), perspective);
            barycentric.x > error && barycentric.y > error
        };
        let sides = [c, d].map(|p| {
            let [a, b, p] = [a, b, p].map(|corner| plane_of(corner, perspective));
            (b - a).perp_dot(p - a) > 0.0
        });
        if sides[0] != sides[1] && sure([a, b, c]) && sure([b, a, d]) {
            inputs.push(rows([a, b, c], plane, perspective));
            inputs.push(rows([b, a, d], plane, perspective));
        }
    }
    let outputs = run("tests::triangle", "main", inputs.as_flattened(), inputs.len(), 2);
    let mut shares = [0, 0];
    for (case, pair) in outputs.chunks_exact(2).enumerate() {
        let hits = [&pair[0], &pair[1]].map(|output| output[0].x == 1.0);
        assert!(hits[0] || hits[1], "between {:?} and {:?}", inputs[2 * case], inputs[2 * case + 1]);
        for (share, hit) in shares.iter_mut().zip(hits) {
            *share += u32::from(hit);
        }
    }
    // The rays fall on both sides: the edge itself was met.
    assert!(shares.iter().all(|share| *share > 2_000), "{shares:?}");
}
