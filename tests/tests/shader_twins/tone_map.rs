//! `render::tone_map` against the published curves in f64.

use glam::{DMat3, DVec3, Vec3, Vec4};

use crate::harness::{Random, assert_close, assert_finite, run, xyz};

/// A quarter of a 10-bit step: nobody sees it.
const INVISIBLE: f64 = 2.5e-4;

/// Khronos PBR Neutral: highlights are compressed above 0.76 and fade to white.
fn neutral(radiance: DVec3) -> DVec3 {
    let smallest = radiance.min_element();
    let toe = if smallest < 0.08 { smallest - 6.25 * smallest * smallest } else { 0.04 };
    let color = radiance - toe;
    let peak = color.max_element();
    let start = 0.8 - 0.04;
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let compressed = 1.0 - room * room / (peak + room - start);
    let white = 1.0 - 1.0 / (0.15 * (peak - compressed) + 1.0);
    (color * compressed / peak).lerp(DVec3::splat(compressed), white)
}

/// AgX in the form of Wrensch's fit: log2 between -12.47393 and 4.026069 stops, a contrast curve, decoded with 2.2.
fn agx(radiance: DVec3) -> DVec3 {
    let inset = DMat3::from_cols(
        DVec3::new(0.842479062253094, 0.0423282422610123, 0.0423756549057051),
        DVec3::new(0.0784335999999992, 0.878468636469772, 0.0784336),
        DVec3::new(0.0792237451477643, 0.0791661274605434, 0.879142973793104),
    );
    let outset = DMat3::from_cols(
        DVec3::new(1.19687900512017, -0.0528968517574562, -0.0529716355144438),
        DVec3::new(-0.0980208811401368, 1.15190312990417, -0.0980434501171241),
        DVec3::new(-0.0990297440797205, -0.0989611768448433, 1.15107367264116),
    );
    let stops = |x: f64| (x.log2().clamp(-12.47393, 4.026069) + 12.47393) / (4.026069 + 12.47393);
    let contrast = |x: f64| {
        [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5].iter().rev().fold(0.0, |sum, term| sum * x + term)
    };
    let each = |v: DVec3, f: &dyn Fn(f64) -> f64| DVec3::new(f(v.x), f(v.y), f(v.z));
    let logarithmic = each(inset * radiance.max(DVec3::splat(1e-10)), &stops);
    each(outset * each(logarithmic, &contrast), &|x| x.max(0.0).powf(2.2))
}

/// IEC 61966-2-1.
fn srgb(linear: DVec3) -> DVec3 {
    let encode = |x: f64| if x <= 0.0031308 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    DVec3::new(encode(linear.x), encode(linear.y), encode(linear.z))
}

#[test]
fn curves_are_those_of_f64() {
    let mut random = Random(51);
    let levels = [0.0, 1e-30, 1e-6, 0.003_130_8, 0.079, 0.08, 0.18, 0.76, 0.8, 1.0, 16.3, 1e3, 6.55e4, 1e6];
    let mut colors = Vec::new();
    for r in levels {
        for g in levels {
            colors.extend(levels.map(|b| Vec3::new(r, g, b)));
        }
    }
    colors.extend((0..10_000).map(|_| Vec3::from_array(std::array::from_fn(|_| random.magnitude(1e-4, 1e2)))));
    let cases: Vec<Vec4> = colors.iter().map(|color| color.extend(random.any(&[0.0, 1.0, 2.0]))).collect();
    let outputs = run("tests::tone_map", "main", &cases, cases.len(), 4);
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, &[*input], output);
        let what = || format!("case {index}, {input}");
        let radiance = xyz(*input);
        assert_close(xyz(output[0]), neutral(radiance), INVISIBLE, what);
        assert_close(xyz(output[1]), agx(radiance), INVISIBLE, what);
        let chosen = match input.w as u32 {
            0 => radiance,
            1 => neutral(radiance),
            _ => agx(radiance),
        };
        let display = xyz(output[2]);
        assert_close(display, chosen.clamp(DVec3::ZERO, DVec3::ONE), INVISIBLE, what);
        assert!(display.min_element() >= 0.0 && display.max_element() <= 1.0, "{}: {display}", what());
        assert_close(xyz(output[3]), srgb(display), INVISIBLE, what);
    }
}
