//! Sine and cosine from `+ - *` alone, so that the generated files have the same bits on every platform.
//!
//! The standard library's `sin` and `cos` go to the platform's C library, whose last digit differs between systems.

use std::f64::consts::{FRAC_2_PI, TAU};

/// High part of pi / 2: its product with a small integer is exact.
const HALF_PI_HIGH: f64 = 1.570_796_325_802_803;
/// pi / 2 minus [`HALF_PI_HIGH`].
const HALF_PI_LOW: f64 = 9.920_935_796_805_404e-10;

/// Sine and cosine of `angle` (radians), to about 1e-15 for angles of moderate size.
pub fn sin_cos(angle: f64) -> (f64, f64) {
    let quadrant = (angle * FRAC_2_PI).round();
    let r = (angle - quadrant * HALF_PI_HIGH) - quadrant * HALF_PI_LOW;
    let r2 = r * r;
    // Taylor series on [-pi/4, pi/4], by Horner's rule; the first dropped term is below 1e-16.
    let mut sine = 1.0;
    let mut cosine = 1.0;
    for n in (1..=8).rev() {
        let n = f64::from(n);
        sine = 1.0 - r2 / ((2.0 * n) * (2.0 * n + 1.0)) * sine;
        cosine = 1.0 - r2 / ((2.0 * n - 1.0) * (2.0 * n)) * cosine;
    }
    sine *= r;
    match (quadrant as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Sine of `angle` (radians).
pub fn sin(angle: f64) -> f64 {
    sin_cos(angle).0
}

/// Cosine of `angle` (radians).
pub fn cos(angle: f64) -> f64 {
    sin_cos(angle).1
}

/// Sine of a phase in turns: `wave(0.25) = 1`.
pub fn wave(turns: f64) -> f64 {
    sin(TAU * turns)
}
