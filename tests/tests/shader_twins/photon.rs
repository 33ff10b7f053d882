//! `caustics::photon` against its law in f64, and against the solid angle of the whole picture.

use glam::{Vec3, Vec4};

use crate::{
    SLACK, U,
    harness::{Random, assert_finite, assert_near, run, xyz},
};

/// KHR_lights_punctual: the square of a ramp between the cone's two half-angles.
fn cone_falloff(cos_angle: f64, cos_outer: f64, cos_inner: f64) -> f64 {
    if cos_outer <= -1.0 {
        return 1.0;
    }
    ((cos_angle - cos_outer) / (cos_inner - cos_outer).max(1e-4)).clamp(0.0, 1.0).powi(2)
}

#[test]
fn flux_is_that_of_f64() {
    let mut random = Random(41);
    let cones = [[-1.0, -1.0], [0.5, 0.5], [0.5, 0.7], [0.9, 0.900_01], [-0.2, 0.3], [0.999_9, 1.0]];
    let cases: Vec<[Vec4; 3]> = (0..10_000)
        .map(|_| {
            let [outer, inner] = random.any(&cones);
            let plane_scale = random.any(&[1e-6, 1.0, 1.0, 1e3]);
            let plane = plane_scale * random.in_cube();
            let half = [0, 1].map(|_| random.magnitude(1e-6, 1e6));
            let aside = random.direction();
            let axis = random.any(&[Vec3::NEG_Z, Vec3::NEG_Z, aside, Vec3::ZERO]);
            [
                Vec4::new(random.between(-1.0, 1.0), outer, inner, random.any(&[0.0, 1.0])),
                axis.extend(random.any(&[1.0, 64.0, 4096.0])),
                Vec4::new(half[0], half[1], plane.x, plane.y),
            ]
        })
        .collect();
    let outputs = run("tests::photon", "main", cases.as_flattened(), cases.len(), 1);
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, input, output);
        let what = || format!("case {index}, {input:?}");
        let [cos_angle, cos_outer, cos_inner, perspective] = input[0].to_array().map(f64::from);
        let ramp = if cos_outer <= -1.0 { f64::INFINITY } else { (cos_inner - cos_outer).max(1e-4) };
        let error = SLACK * U * (4.0 + 2.0 * 6.0 / ramp);
        assert_near(f64::from(output[0].x), cone_falloff(cos_angle, cos_outer, cos_inner), error, what);

        let area = 4.0 * f64::from(input[2].x) * f64::from(input[2].y) / f64::from(input[1].w).powi(2);
        let ray = glam::DVec3::new(input[2].z.into(), input[2].w.into(), -1.0);
        let cos_axis = ray.length().recip();
        let (share, error) = if perspective == 0.0 {
            (1.0, SLACK * 6.0 * U)
        } else {
            let angle = ray.dot(xyz(input[1])) * cos_axis;
            let solid = cos_axis.powi(3);
            (solid * cone_falloff(angle, cos_outer, cos_inner), solid * SLACK * U * (16.0 + 2.0 * 10.0 / ramp))
        };
        assert_near(f64::from(output[0].y), area * share, area * error + 1.2e-38, what);
    }
}

/// A lamp of one candela sends as many lumens through a picture as the picture has steradians.
#[test]
fn the_cells_of_a_picture_share_its_solid_angle() {
    const SIDE: u32 = 128;
    for half in [0.05_f64, 0.5, 3.0] {
        let cells = (0..SIDE * SIDE).map(|cell| {
            let at = |index: u32| (half * (2.0 * (f64::from(index) + 0.5) / f64::from(SIDE) - 1.0)) as f32;
            [
                Vec4::new(1.0, -1.0, -1.0, 1.0),
                Vec3::NEG_Z.extend(SIDE as f32),
                Vec4::new(half as f32, half as f32, at(cell % SIDE), at(cell / SIDE)),
            ]
        });
        let cells: Vec<[Vec4; 3]> = cells.collect();
        let outputs = run("tests::photon", "main", cells.as_flattened(), cells.len(), 1);
        let sum: f64 = outputs.iter().map(|output| f64::from(output[0].y)).sum();
        let solid_angle = 4.0 * (half * half / (1.0 + half * half)).asin();
        // The midpoint rule over a smooth function: its error falls with the square of the cell, 6e-4 for the widest.
        assert_near(sum / solid_angle, 1.0, 1e-3, || format!("half extent {half}"));
    }
}
