//! The studio environment: a room of matte walls and floor, lit by softboxes and strip lights, seen from its middle.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::implicit::smooth_step;
use super::radiance_hdr;
use super::trig::sin_cos;

const WIDTH: usize = 512;
const HEIGHT: usize = 256;
/// Rays a texel side, so that grids and joints are filtered.
const SAMPLES: usize = 4;

/// The room, metres from the eye: half its width and depth, floor and ceiling heights.
const WALL: f64 = 5.5;
const FLOOR: f64 = -1.6;
const CEILING: f64 = 4.6;

/// A rectangular light that faces the eye.
struct Softbox {
    centre: DVec3,
    /// Half width and half height, metres.
    half: [f64; 2],
    /// Radiance, linear RGB.
    radiance: DVec3,
    /// Columns and rows of its grid.
    cells: [f64; 2],
    /// Share of the half size over which it fades at its edge.
    fade: f64,
}

/// The equirectangular picture as a Radiance HDR file. Direction d is at u = 0.5 + atan2(d.z, d.x) / 2 pi,
/// v = acos(d.y) / pi downwards.
pub fn studio_hdr() -> Vec<u8> {
    let lights = lights();
    let mut pixels = Vec::with_capacity(WIDTH * HEIGHT);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            pixels.push(texel(&lights, x, y));
        }
    }
    radiance_hdr::encode(WIDTH, &pixels)
}

fn texel(lights: &[Softbox], x: usize, y: usize) -> Vec3 {
    let mut sum = DVec3::ZERO;
    for j in 0..SAMPLES {
        for i in 0..SAMPLES {
            let within = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
            let (sin_azimuth, cos_azimuth) = sin_cos(TAU * ((x as f64 + within(i)) / WIDTH as f64 - 0.5));
            let (sin_polar, cos_polar) = sin_cos(PI * (y as f64 + within(j)) / HEIGHT as f64);
            let direction = DVec3::new(sin_polar * cos_azimuth, cos_polar, sin_polar * sin_azimuth);
            sum += radiance(lights, direction);
        }
    }
    (sum / (SAMPLES * SAMPLES) as f64).as_vec3()
}

fn lights() -> Vec<Softbox> {
    let light = |centre: [f64; 3], half: [f64; 2], radiance: [f64; 3], cells: [f64; 2], fade: f64| Softbox {
        centre: DVec3::from_array(centre),
        half,
        radiance: DVec3::from_array(radiance),
        cells,
        fade,
    };
    vec![
        // Warm key with a grid and cool fill, on the side that characters face.
        light([2.8, 2.9, 3.0], [1.15, 0.85], [12.5, 10.2, 7.4], [4.0, 3.0], 0.06),
        light([-4.0, 1.5, 1.9], [0.95, 1.25], [2.9, 3.9, 5.2], [1.0, 1.0], 0.5),
        // Overhead bank.
        light([0.0, 4.2, -0.6], [1.5, 0.55], [6.4, 6.2, 6.0], [5.0, 1.0], 0.08),
        // Vertical strips behind, which a glass body draws out along its rim.
        light([-2.7, 1.1, -4.3], [0.13, 1.7], [6.4, 8.8, 12.0], [1.0, 1.0], 0.3),
        light([3.1, 1.1, -4.0], [0.17, 1.7], [12.0, 8.8, 5.6], [1.0, 1.0], 0.3),
        light([4.7, 1.0, -1.0], [0.10, 1.5], [7.0, 6.8, 6.4], [1.0, 1.0], 0.3),
        light([-4.8, 1.0, -1.4], [0.10, 1.5], [6.0, 6.6, 7.2], [1.0, 1.0], 0.3),
        // A slim bar high on the far wall.
        light([0.2, 3.1, -4.6], [1.5, 0.07], [5.4, 5.6, 6.0], [6.0, 1.0], 0.3),
    ]
}

fn radiance(lights: &[Softbox], direction: DVec3) -> DVec3 {
    let mut seen = room(lights, direction);
    for light in lights {
        let cover = light.cover(direction);
        seen = seen * (1.0 - cover) + light.radiance * light.brightness(direction) * cover;
    }
    seen
}

/// Radiance of the matte room: what the softboxes throw on the point that `direction` meets.
fn room(lights: &[Softbox], direction: DVec3) -> DVec3 {
    let distance = |from: f64, to: f64, slope: f64| if slope > 0.0 { to / slope } else { from / slope };
    let reach = DVec3::new(
        distance(-WALL, WALL, direction.x),
        distance(FLOOR, CEILING, direction.y),
        distance(-WALL, WALL, direction.z),
    );
    let nearest = reach.min_element();
    let point = direction * nearest;
    let axis = (0..3).find(|&i| reach[i] == nearest).unwrap_or(1);
    let normal = -DVec3::AXES[axis] * direction[axis].signum();
    let albedo = match axis {
        1 if direction.y < 0.0 => floor_albedo(point),
        1 => DVec3::splat(0.30),
        _ => wall_albedo(point, axis),
    };
    let mut irradiance = DVec3::splat(0.34) + DVec3::new(0.05, 0.04, 0.03) * (point.y - FLOOR);
    for light in lights {
        irradiance += light.irradiance(point, normal);
    }
    // Corners receive less of what the room itself scatters.
    let height = smooth_step(0.0, 1.4, point.y - FLOOR);
    let corner = if axis == 1 { 1.0 } else { 0.72 + 0.28 * height };
    albedo * irradiance * corner / PI
}

/// Calm, a little darker towards the walls.
fn floor_albedo(point: DVec3) -> DVec3 {
    let edge = smooth_step(WALL - 2.5, WALL + 0.5, point.x.abs().max(point.z.abs()));
    DVec3::new(0.47, 0.46, 0.45) * (1.0 - 0.25 * edge)
}

/// Panels of 1.1 x 0.9 metres with dark joints, every other one a shade lighter.
fn wall_albedo(point: DVec3, axis: usize) -> DVec3 {
    let along = if axis == 0 { point.z } else { point.x };
    let (column, row) = (along / 1.1, (point.y - FLOOR) / 0.9);
    let joint = |x: f64, width: f64| smooth_step(0.0, width, 0.5 - (x - x.floor() - 0.5).abs());
    let joints = joint(column, 0.025 / 1.1).min(joint(row, 0.025 / 0.9));
    let odd = (column.floor() + row.floor()).rem_euclid(2.0);
    DVec3::new(0.54, 0.56, 0.60) * (0.88 + 0.12 * odd) * (0.45 + 0.55 * joints)
}

impl Softbox {
    /// Unit directions of its width, its height and its face.
    fn frame(&self) -> [DVec3; 3] {
        let face = -self.centre.normalize();
        let right = DVec3::Y.cross(face).normalize();
        [right, face.cross(right), face]
    }

    /// Where a direction meets its plane, in half sizes from the centre.
    fn place(&self, direction: DVec3) -> Option<[f64; 2]> {
        let [right, up, face] = self.frame();
        let slope = direction.dot(face);
        (slope < -1e-6).then(|| {
            let point = direction * (self.centre.dot(face) / slope) - self.centre;
            [point.dot(right) / self.half[0], point.dot(up) / self.half[1]]
        })
    }

    /// Share of the direction that the softbox hides: 1 inside, 0 outside.
    fn cover(&self, direction: DVec3) -> f64 {
        let Some([s, t]) = self.place(direction) else { return 0.0 };
        let shorter = self.half[0].min(self.half[1]);
        let side = |x: f64, half: f64| 1.0 - smooth_step(1.0 - self.fade * shorter / half, 1.0, x.abs());
        side(s, self.half[0]) * side(t, self.half[1])
    }

    /// Brightness across its face: the lamp shines stronger in the middle, the bars of the grid are dark.
    fn brightness(&self, direction: DVec3) -> f64 {
        let Some([s, t]) = self.place(direction) else { return 0.0 };
        let hot = 1.0 - 0.25 * (s * s + t * t).min(2.0);
        let bar = |x: f64, cells: f64| {
            let cell = f64::midpoint(x, 1.0) * cells;
            // The outermost bars are the rim itself.
            let inner = cell > 0.5 && cell < cells - 0.5;
            let near = (cell - cell.round()).abs();
            if inner { smooth_step(0.03, 0.09, near) } else { 1.0 }
        };
        hot * (0.06 + 0.94 * bar(s, self.cells[0]) * bar(t, self.cells[1]))
    }

    /// Irradiance at a point of the room, taking the softbox as a small Lambertian source.
    fn irradiance(&self, point: DVec3, normal: DVec3) -> DVec3 {
        let towards = self.centre - point;
        let square = towards.length_squared();
        let direction = towards / square.sqrt();
        let leaving = (-direction).dot(self.frame()[2]).max(0.0);
        let arriving = direction.dot(normal).max(0.0);
        let area = 4.0 * self.half[0] * self.half[1];
        self.radiance * 0.8 * area * leaving * arriving / (square + area)
    }
}
