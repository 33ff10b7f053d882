//! `lib::environment` against [`Environment::sample`].

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec4};
use half::f16;
use murano_gpu::{Leaf, TextureData};
use murano_scene::Environment;

use crate::harness::{Random, assert_finite, assert_near, run_with};

const SIZE: [u32; 2] = [64, 32];

/// Random texels that half floats hold exactly.
fn noise() -> Environment {
    let mut random = Random(31);
    let texels = SIZE[0] * SIZE[1];
    let pixels = (0..texels).map(|_| [0, 1, 2].map(|_| (random.between(0.0, 256.0)).floor() / 64.0)).collect();
    Environment { width: SIZE[0], height: SIZE[1], pixels }
}

fn leaf(environment: &Environment) -> Leaf {
    let halves = |&[r, g, b]: &[f32; 3]| [r, g, b, 1.0].map(|value| f16::from_f32(value).to_bits());
    let level = environment.pixels.iter().flat_map(halves).collect();
    Leaf::Texture(Arc::new(TextureData { size: SIZE, levels: vec![level] }))
}

/// How much a channel varies over the texels around a direction.
fn contrast(environment: &Environment, direction: DVec3, channel: usize) -> f64 {
    let [width, height] = SIZE.map(f64::from);
    let x = (0.5 + direction.z.atan2(direction.x) / std::f64::consts::TAU) * width;
    let y = direction.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI * height;
    let around = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (dx, dy))).map(|(dx, dy)| {
        let column = (x.floor() as i64 + dx).rem_euclid(i64::from(SIZE[0]));
        let row = (y.floor() as i64 + dy).clamp(0, i64::from(SIZE[1]) - 1);
        f64::from(environment.pixels[(row * i64::from(SIZE[0]) + column) as usize][channel])
    });
    let (low, high) = around.fold((f64::INFINITY, 0.0), |(low, high), v| (f64::min(low, v), f64::max(high, v)));
    high - low
}

#[test]
fn radiance_is_that_of_f64() {
    let environment = noise();
    let mut random = Random(32);
    let mut directions: Vec<Vec3> = (0..10_000).map(|_| random.direction()).collect();
    // The seam, and the horizon around it.
    for z in [-1e-3_f32, -1e-7, -0.0, 0.0, 1e-7, 1e-3] {
        directions.extend([-1e-3, 0.0, 0.5].map(|y| Vec3::new(-1.0, y, z).normalize()));
    }
    directions.extend([Vec3::X, Vec3::Z, Vec3::NEG_Z]);
    let ordinary = directions.len();
    // Near the poles, at them, and no direction at all: any column may be meant, but radiance it must be.
    directions.extend((0..100).map(|_| (Vec3::Y + 1e-4 * random.in_cube()).normalize()));
    directions.extend([Vec3::Y, Vec3::NEG_Y, Vec3::ZERO, Vec3::new(0.0, 2.0, 0.0)]);
    let inputs: Vec<Vec4> = directions.iter().map(|d| d.extend(random.between(0.0, 1.0))).collect();
    let outputs = run_with("tests::environment", "main", &inputs, inputs.len(), 1, Some(leaf(&environment)));
    for (index, (direction, output)) in directions.iter().zip(&outputs).enumerate() {
        assert_finite(index, &[inputs[index]], output);
        let direction = direction.as_dvec3();
        let truth = environment.sample(direction);
        for channel in 0..3 {
            let found = f64::from(output[0][channel]);
            assert!((0.0..=4.0).contains(&found), "case {index}, {direction}: {found}");
            if index < ordinary {
                // Texture units weigh in steps of 1/256; arc functions may be 3e-4 radians off, 1/300 of a texel here.
                let tolerance = 2.0 * (1.0 / 256.0 + 1.0 / 300.0) * contrast(&environment, direction, channel) + 4e-3;
                assert_near(found, truth[channel], tolerance, || format!("case {index}, {direction}"));
            }
        }
        let roughness = f64::from(inputs[index].w);
        let lobe = 2.0 * roughness * roughness * f64::from(SIZE[0]) / std::f64::consts::TAU;
        let level = lobe.max(1e-6).log2().max(0.0);
        // WGSL's log2 may be 2^-21 off.
        assert_near(f64::from(output[0].w), level, 4e-6, || format!("case {index}, roughness {roughness}"));
    }
}
