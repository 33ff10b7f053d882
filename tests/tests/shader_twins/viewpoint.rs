//! `lib::viewpoint` against a pinhole and a parallel projection in f64.

use glam::{DVec2, DVec3, Vec4};

use crate::{
    SLACK, U,
    harness::{Random, assert_close, assert_finite, assert_near, run, xyz},
};

/// A viewpoint, a texel of its picture, a depth there, and any point.
struct Case {
    half_extent: DVec2,
    center: DVec2,
    size: DVec2,
    perspective: bool,
    texel: DVec2,
    depth: f64,
    point: DVec3,
}

impl Case {
    fn read(rows: &[Vec4]) -> Self {
        let [first, second] = [rows[0], rows[1]].map(Vec4::as_dvec4);
        Self {
            half_extent: DVec2::new(first.x, first.y),
            center: DVec2::new(first.z, first.w),
            size: DVec2::new(second.x, second.y),
            perspective: second.z == 1.0,
            texel: xyz(rows[2]).truncate(),
            depth: f64::from(rows[2].z),
            point: xyz(rows[3]),
        }
    }

    fn plane(&self) -> DVec2 {
        self.center + self.half_extent * DVec2::new(2.0, -2.0) * (self.texel / self.size - 0.5)
    }

    fn ray(&self) -> (DVec3, DVec3) {
        let plane = self.plane();
        if self.perspective { (DVec3::ZERO, plane.extend(-1.0)) } else { (plane.extend(0.0), DVec3::NEG_Z) }
    }
}

fn cases() -> Vec<[Vec4; 4]> {
    let mut random = Random(11);
    let mut cases = Vec::new();
    for _ in 0..10_000 {
        let scale = random.any(&[1e-6, 1e-3, 1.0, 1.0, 1.0, 1e3, 1e6]);
        let perspective = random.any(&[0.0, 1.0]);
        let unit = if perspective == 1.0 { 1.0 } else { scale };
        let size = [random.any(&[1.0, 2.0, 17.0, 512.0, 4096.0]), random.any(&[1.0, 3.0, 64.0, 512.0, 16384.0])];
        let half = [0, 1].map(|_| unit * random.magnitude(1e-3, 10.0));
        let center = [0, 1].map(|_| unit * random.any(&[0.0, 0.5, -3.0]));
        // Within the picture, on its rim, and beyond.
        let texel = size.map(|extent| {
            let within = random.between(0.0, 1.0);
            extent * random.any(&[within, within, within, 0.0, 1.0, 1.5 * within, -0.5 * within])
        });
        let mut point = scale * random.in_cube();
        // Beside, in, and a little before the viewpoint's own plane too.
        point.z *= random.any(&[1.0, 1.0, 1.0, -0.0, 1e-3]);
        cases.push([
            Vec4::new(half[0], half[1], center[0], center[1]),
            Vec4::new(size[0], size[1], perspective, 1e-3),
            Vec4::new(texel[0], texel[1], scale * random.magnitude(1e-3, 1e3), 0.0),
            point.extend(0.0),
        ]);
    }
    cases
}

#[test]
fn texels_and_rays_are_those_of_f64() {
    let cases = cases();
    let outputs = run("tests::viewpoint", "main", cases.as_flattened(), cases.len(), 5);
    let mut behind = 0;
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, input, output);
        let case = Case::read(input);
        let what = || format!("case {index}, {input:?}");
        let plane = case.plane();
        let span = case.center.abs() + case.half_extent * (1.0 + 2.0 * (case.texel / case.size - 0.5).abs());
        let plane_error = SLACK * 4.0 * U * span.length();
        let found = xyz(output[0]).truncate();
        assert_close(found.extend(0.0), plane.extend(0.0), plane_error, what);

        let inside = case.texel.cmpge(DVec2::ZERO).all() && case.texel.cmplt(case.size).all();
        assert_eq!(output[0].z == 1.0, inside, "{}", what());

        let (origin, direction) = case.ray();
        assert_close(xyz(output[1]), origin, plane_error, what);
        assert_close(xyz(output[2]), direction, plane_error, what);
        let reach = plane_error * (1.0 + case.depth) + SLACK * 2.0 * U * case.depth * direction.length();
        assert_close(xyz(output[3]), origin + case.depth * direction, reach, what);

        let [x, y] = [output[4].x, output[4].y].map(f64::from);
        if case.perspective && case.point.z >= 0.0 {
            behind += 1;
            assert!(x < 0.0 && y < 0.0, "{}: ({x}, {y})", what());
        } else {
            let scale = if case.perspective { -case.point.z } else { 1.0 };
            let on_plane = case.point.truncate() / scale;
            let wanted = (DVec2::new(0.5, -0.5) * (on_plane - case.center) / case.half_extent + 0.5) * case.size;
            let error = U * ((on_plane.abs() + case.center.abs()) / case.half_extent + 1.0) * case.size;
            assert_near(x, wanted.x, SLACK * 4.0 * error.x, what);
            assert_near(y, wanted.y, SLACK * 4.0 * error.y, what);
        }

        let extent = 2.0 * case.half_extent / case.size * if case.perspective { case.depth } else { 1.0 };
        assert_near(f64::from(output[4].z), extent.x, SLACK * 4.0 * U * extent.x, what);
        assert_near(f64::from(output[4].w), extent.y, SLACK * 4.0 * U * extent.y, what);
    }
    assert!(behind > 1_000, "only {behind} points behind the viewpoint");
}
