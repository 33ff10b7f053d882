//! Horie's table against Snell's law: error and time.
//!
//! `cargo run --release -p murano-optics --example refraction_table`
//!
//! A million directions in random order, half of the cosines of incidence near grazing; the best of nine runs on one core.
//! Errors are angles in degrees over the directions that both refract; "lost" are those of which only one says that they
//! are totally reflected.

use std::{hint::black_box, time::Instant};

use glam::{DVec3, Vec3};
use murano_optics::{RefractionTable, snell};

const COUNT: usize = 1 << 20;
const RUNS: usize = 9;

/// Directions of incidence on the plane y = 0, from above.
fn directions() -> Vec<DVec3> {
    // Steps of the golden ratio and of the square root of two fill the square evenly and in no order that a cache knows.
    let fraction = |step: f64, k: usize| (step * k as f64).fract();
    let direction = |k: usize| {
        let (u, angle) =
            (fraction(0.618_033_988_749_895, k), std::f64::consts::TAU * fraction(0.414_213_562_373_095, k));
        let cosine = u * u;
        let sine = (1.0 - cosine * cosine).sqrt();
        DVec3::new(sine * angle.cos(), -cosine, sine * angle.sin())
    };
    (0..COUNT).map(direction).collect()
}

/// Nanoseconds a direction, the best of some runs.
fn time<T: Copy, R>(directions: &[T], refract: impl Fn(T) -> R) -> f64 {
    let run = || {
        let start = Instant::now();
        for &direction in directions {
            black_box(refract(black_box(direction)));
        }
        start.elapsed().as_secs_f64()
    };
    (0..RUNS).map(|_| run()).fold(f64::INFINITY, f64::min) * 1e9 / directions.len() as f64
}

fn report(name: &str, nanoseconds: f64, directions: &[DVec3], eta: f64, refract: impl Fn(DVec3) -> Option<DVec3>) {
    let (mut sum, mut worst, mut both, mut lost) = (0.0, 0.0_f64, 0, 0);
    for &i in directions {
        let exact = snell(i, DVec3::Y, eta);
        match refract(i) {
            Some(found) if !exact.tir => {
                let degrees = found.cross(exact.direction).length().atan2(found.dot(exact.direction)).to_degrees();
                (sum, worst, both) = (sum + degrees, worst.max(degrees), both + 1);
            }
            found => lost += usize::from(found.is_none() != exact.tir),
        }
    }
    let lost = 100.0 * lost as f64 / directions.len() as f64;
    println!(
        "{name:28} {nanoseconds:6.2} ns   mean {:9.2e}   max {worst:8.2e}   lost {lost:.3} %",
        sum / f64::from(both)
    );
}

fn main() {
    let directions = directions();
    let single: Vec<Vec3> = directions.iter().map(|direction| direction.as_vec3()).collect();
    for eta in [1.0 / 1.5, 1.5] {
        println!("eta = {eta:.4}");
        let exact = |i: DVec3| Some(snell(i, DVec3::Y, eta)).filter(|it| !it.tir).map(|it| it.direction);
        report("snell (f64, safe)", time(&directions, |i| snell(i, DVec3::Y, eta)), &directions, eta, exact);
        let double = |i: DVec3| {
            let c = -i.dot(DVec3::Y);
            let k = 1.0 - eta * eta * (1.0 - c * c);
            (k >= 0.0).then(|| eta * i + (eta * c - k.sqrt()) * DVec3::Y)
        };
        report("square root (f64)", time(&directions, double), &directions, eta, double);
        let eta_single = eta as f32;
        let plain = |i: Vec3| {
            let c = -i.dot(Vec3::Y);
            let k = 1.0 - eta_single * eta_single * (1.0 - c * c);
            (k >= 0.0).then(|| eta_single * i + (eta_single * c - k.sqrt()) * Vec3::Y)
        };
        report("square root (f32)", time(&single, plain), &directions, eta, |i| plain(i.as_vec3()).map(Vec3::as_dvec3));
        for entries in [64, 1024, 16384, 1 << 20] {
            let table = RefractionTable::new(eta, entries);
            let by = |i: DVec3| table.refract(i, DVec3::Y);
            report(&format!("table of {entries}"), time(&directions, by), &directions, eta, by);
            let raw = |i: DVec3| table.refract_raw(i, DVec3::Y);
            report("    not normalised", time(&directions, raw), &directions, eta, raw);
            let between = |i: DVec3| table.refract_interpolated(i, DVec3::Y);
            report("    interpolated", time(&directions, between), &directions, eta, between);
        }
    }
}
