//! Orientation, energy and irradiance of environments.

mod common;

use std::fs;

use exr::prelude::write_rgba_file;
use glam::DVec3;
use murano_scene::{Environment, EnvironmentError};

/// `width` by `height` texels, coloured by column and row.
fn environment(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Environment {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    Environment { width, height, pixels }
}

fn mean(environment: (u32, u32, &[[f32; 3]])) -> f64 {
    let (width, height, pixels) = environment;
    let rows = pixels.chunks_exact(width as usize).enumerate().map(|(y, row)| {
        let edge = |v: f64| (std::f64::consts::PI * v / f64::from(height)).cos();
        let share = (edge(y as f64) - edge(y as f64 + 1.0)) / 2.0 / f64::from(width);
        row.iter().map(|texel| f64::from(texel[0]) * share).sum::<f64>()
    });
    rows.sum()
}

#[test]
fn directions_meet_their_texels() {
    let map = environment(8, 4, |x, y| [x as f32, y as f32, 1.0]);
    // u = 0.5 + atan2(z, x) / 2 pi: +X in the middle, +Z at three quarters, -Z at one quarter.
    for (direction, u) in [(DVec3::X, 0.5), (DVec3::Z, 0.75), (DVec3::NEG_Z, 0.25)] {
        let [x, y, one] = map.sample(direction);
        assert!((x - (u * 8.0 - 0.5)).abs() < 1e-12 && (y - 1.5).abs() < 1e-12 && (one - 1.0).abs() < 1e-12);
    }
    assert_eq!(map.sample(DVec3::Y)[1], 0.0);
    assert_eq!(map.sample(DVec3::NEG_Y)[1], 3.0);
    // At -X the last column meets the first.
    assert!((map.sample(DVec3::NEG_X)[0] - 3.5).abs() < 1e-12);
}

#[test]
fn texel_centres_return_their_texels() {
    let map = environment(16, 8, |x, y| [x as f32, y as f32, 0.0]);
    for y in 0..8 {
        for x in 0..16 {
            let phi = 2.0 * std::f64::consts::PI * ((f64::from(x) + 0.5) / 16.0 - 0.5);
            let theta = std::f64::consts::PI * (f64::from(y) + 0.5) / 8.0;
            let direction = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            let [column, row, _] = map.sample(direction);
            assert!((column - f64::from(x)).abs() < 1e-9 && (row - f64::from(y)).abs() < 1e-9, "{x} {y}");
        }
    }
}

#[test]
fn a_constant_environment_lights_every_normal_alike() {
    let coefficients = environment(64, 32, |_, _| [1.0, 2.0, 0.5]).irradiance_sh();
    for normal in [DVec3::X, DVec3::Y, DVec3::NEG_Z, DVec3::new(1.0, -2.0, 3.0).normalize()] {
        let [r, g, b] = Environment::evaluate_sh(&coefficients, normal);
        // The texels' mean directions are not quite their centres.
        assert!((r - 1.0).abs() < 2e-3 && (g - 2.0).abs() < 4e-3 && (b - 0.5).abs() < 1e-3, "{normal}: {r} {g} {b}");
    }
}

#[test]
fn irradiance_agrees_with_the_integral_for_smooth_light() {
    // Radiance 1 + y: degree 1, so nine coefficients hold it exactly; E / pi = 1 + 2/3 n.y.
    let map = environment(256, 128, |_, y| [1.0 + (std::f32::consts::PI * (y as f32 + 0.5) / 128.0).cos(); 3]);
    let coefficients = map.irradiance_sh();
    for normal in [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::new(0.6, 0.8, 0.0)] {
        let [value, ..] = Environment::evaluate_sh(&coefficients, normal);
        assert!((value - (1.0 + 2.0 / 3.0 * normal.y)).abs() < 1e-3, "{normal}: {value}");
    }
    // Each axis lights the side that faces it.
    for (u, axis) in [(0.5, DVec3::X), (0.75, DVec3::Z)] {
        let column = (u * 256.0) as u32;
        let lamp =
            environment(
                256,
                128,
                |x, y| {
                    if x.abs_diff(column) < 4 && y.abs_diff(64) < 4 { [100.0; 3] } else { [0.0; 3] }
                },
            );
        let coefficients = lamp.irradiance_sh();
        let facing = Environment::evaluate_sh(&coefficients, axis)[0];
        assert!(facing > 2.0 * Environment::evaluate_sh(&coefficients, axis.any_orthonormal_vector())[0].abs());
    }
}

#[test]
fn every_mip_level_holds_the_same_energy() {
    for (width, height) in [(64, 32), (37, 19), (1, 5), (5, 1), (1, 1)] {
        let map = environment(width, height, |x, y| [((x * 7 + y * 13) % 11) as f32; 3]);
        let levels = map.mip_chain();
        let expected = mean((width, height, &map.pixels));
        for (width, height, pixels) in &levels {
            assert_eq!(pixels.len(), (width * height) as usize);
            assert!((mean((*width, *height, pixels)) - expected).abs() < 1e-5 * expected.max(1.0));
        }
        assert_eq!(levels[0].2, map.pixels);
        assert_eq!(levels.last().map(|(width, height, _)| (*width, *height)), Some((1, 1)));
        assert!(levels.is_sorted_by(|a, b| a.0 * a.1 > b.0 * b.1));
    }
}

#[test]
fn exr_and_hdr_are_told_apart_by_content() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("sky.hdr");
    write_rgba_file(&path, 4, 2, |x, y| (x as f32, y as f32, 0.25_f32, 1.0_f32)).expect("an exr");
    let map = Environment::load(&path).expect("an exr, whatever its name");
    assert_eq!((map.width, map.height), (4, 2));
    assert_eq!(map.pixels[6], [2.0, 1.0, 0.25]);

    write_rgba_file(&path, 4, 2, |x, _| (if x == 3 { f32::NAN } else { -1.0 }, 0.0_f32, 0.0_f32, 1.0_f32))
        .expect("an exr");
    assert!(matches!(Environment::load(&path), Err(EnvironmentError::NonFinite { x: 3, y: 0, .. })));

    fs::write(&path, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000 +X 1000000\n").expect("a file");
    assert!(matches!(Environment::load(&path), Err(EnvironmentError::Undecodable { .. })));
    fs::write(&path, "no image").expect("a file");
    assert!(matches!(Environment::load(&path), Err(EnvironmentError::Undecodable { .. })));
    assert!(matches!(Environment::load(&folder.path().join("none.hdr")), Err(EnvironmentError::Missing { .. })));
}

#[test]
fn real_skies_are_brighter_above() {
    let Some(folder) = common::data("env") else { return };
    let sky = Environment::load(&folder.join("qwantani_afternoon_puresky_1k.hdr")).expect("a sky");
    assert_eq!((sky.width, sky.height), (1024, 512));
    let coefficients = sky.irradiance_sh();
    let (up, down) = (
        Environment::evaluate_sh(&coefficients, DVec3::Y)[1],
        Environment::evaluate_sh(&coefficients, DVec3::NEG_Y)[1],
    );
    assert!(up > 1.5 * down, "{up} {down}");
}
