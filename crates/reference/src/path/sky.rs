//! The environment as a source of light: directions drawn in proportion to what comes from there.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use murano_scene::Environment;

/// Most cells around the horizon and from zenith to nadir; a finer image is drawn from by cells of several texels.
const MOST_CELLS: [usize; 2] = [1024, 512];

/// Distant light with the distribution by which it is sampled.
pub(super) struct Sky<'a> {
    environment: Option<&'a Environment>,
    cells: [usize; 2],
    /// Running sums of cells' shares in their row, row after row; each row ends in 1.
    columns: Vec<f64>,
    /// Running sums of rows' shares, ending in 1; empty where no light comes from anywhere.
    rows: Vec<f64>,
}

impl<'a> Sky<'a> {
    pub fn new(environment: Option<&'a Environment>) -> Self {
        let mut sky = Self { environment, cells: [0, 0], columns: Vec::new(), rows: Vec::new() };
        let Some(image) = environment.filter(|image| image.width > 0 && image.height > 0) else { return sky };
        let sides = [image.width as usize, image.height as usize];
        sky.cells = [sides[0].min(MOST_CELLS[0]), sides[1].min(MOST_CELLS[1])];
        let across = tents(sides[0], sky.cells[0]);
        let down = tents(sides[1], sky.cells[1]);
        let mut total = 0.0;
        for (row, texel_rows) in down.iter().enumerate() {
            let mut sum = 0.0;
            for texel_columns in &across {
                for &(y, share_y) in texel_rows {
                    let y = y.clamp(0, sides[1] as i64 - 1) as usize;
                    for &(x, share_x) in texel_columns {
                        let x = x.rem_euclid(sides[0] as i64) as usize;
                        sum += share_x * share_y * luminance(image.pixels[y * sides[0] + x].map(f64::from));
                    }
                }
                sky.columns.push(sum);
            }
            let first = row * sky.cells[0];
            normalise(&mut sky.columns[first..]);
            total += sum * sky.band(row);
            sky.rows.push(total);
        }
        if total > 0.0 {
            normalise(&mut sky.rows);
        } else {
            sky.rows.clear();
        }
        sky
    }

    /// Radiance that comes from a unit direction.
    pub fn radiance(&self, direction: DVec3) -> DVec3 {
        self.environment.map_or(DVec3::ZERO, |environment| DVec3::from_array(environment.sample(direction)))
    }

    /// A direction and its density over solid angle; none from a black sky.
    pub fn sample(&self, [u, v]: [f64; 2]) -> Option<(DVec3, f64)> {
        if self.rows.is_empty() {
            return None;
        }
        let (row, down) = draw(&self.rows, v);
        let (column, across) = draw(self.row(row), u);
        let [top, bottom] = [row, row + 1].map(|edge| (PI * edge as f64 / self.cells[1] as f64).cos());
        let y = (top + down * (bottom - top)).clamp(-1.0, 1.0);
        let phi = TAU * ((column as f64 + across) / self.cells[0] as f64 - 0.5);
        let level = (1.0 - y * y).sqrt();
        Some((DVec3::new(level * phi.cos(), y, level * phi.sin()), self.cell_density(row, column)))
    }

    /// The density with which [`Sky::sample`] draws a direction.
    pub fn density(&self, direction: DVec3) -> f64 {
        if self.rows.is_empty() {
            return 0.0;
        }
        let cell = |share: f64, cells: usize| ((share * cells as f64) as usize).min(cells - 1);
        let column = cell(0.5 + direction.z.atan2(direction.x) / TAU, self.cells[0]);
        let row = cell(direction.y.clamp(-1.0, 1.0).acos() / PI, self.cells[1]);
        self.cell_density(row, column)
    }

    fn cell_density(&self, row: usize, column: usize) -> f64 {
        let solid_angle = TAU / self.cells[0] as f64 * self.band(row);
        share(&self.rows, row) * share(self.row(row), column) / solid_angle
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.columns[row * self.cells[0]..][..self.cells[0]]
    }

    /// Height of a row of cells on the unit sphere.
    fn band(&self, row: usize) -> f64 {
        let edge = |row: usize| (PI * row as f64 / self.cells[1] as f64).cos();
        edge(row) - edge(row + 1)
    }
}

/// Rec.709.
pub(super) fn luminance(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// For each cell, the texels that bilinear interpolation shows in it (some beyond the border), with their weights.
fn tents(texels: usize, cells: usize) -> Vec<Vec<(i64, f64)>> {
    // Integral of a tent of half-width 1 from its left end to x.
    let integral = |x: f64| {
        let x = x.clamp(-1.0, 1.0);
        if x < 0.0 { 0.5 * (1.0 + x) * (1.0 + x) } else { 1.0 - 0.5 * (1.0 - x) * (1.0 - x) }
    };
    (0..cells)
        .map(|cell| {
            let [left, right] = [cell, cell + 1].map(|edge| edge as f64 * texels as f64 / cells as f64);
            let first = (left - 0.5).floor() as i64;
            let last = (right - 0.5).ceil() as i64;
            (first..=last)
                .map(|texel| {
                    let centre = texel as f64 + 0.5;
                    (texel, integral(right - centre) - integral(left - centre))
                })
                .collect()
        })
        .collect()
}

/// Makes running sums end in 1; a row without light is drawn from evenly.
fn normalise(sums: &mut [f64]) {
    let count = sums.len() as f64;
    let Some(&total) = sums.last() else { return };
    for (index, sum) in sums.iter_mut().enumerate() {
        *sum = if total > 0.0 { *sum / total } else { (index + 1) as f64 / count };
    }
}

fn share(sums: &[f64], index: usize) -> f64 {
    sums[index] - if index > 0 { sums[index - 1] } else { 0.0 }
}

/// The interval that a number in [0, 1) falls into, and where in it.
fn draw(sums: &[f64], u: f64) -> (usize, f64) {
    let index = sums.partition_point(|&sum| sum <= u).min(sums.len() - 1);
    let from = if index > 0 { sums[index - 1] } else { 0.0 };
    let width = sums[index] - from;
    (index, if width > 0.0 { ((u - from) / width).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;

    fn uneven(width: u32, height: u32) -> Environment {
        let mut sampler = Sampler::new(3, 0, 0);
        let mut texel = || {
            let bright = if sampler.unit() < 0.1 { 40.0 } else { 0.5 };
            let [a, b] = sampler.pair();
            [bright * a as f32, bright * b as f32, 0.1]
        };
        let pixels = (0..width * height).map(|_| texel()).collect();
        Environment { width, height, pixels }
    }

    #[test]
    fn sampled_and_stated_density_agree_and_are_whole() {
        for size in [[16, 8], [7, 5], [1, 1], [1030, 3]] {
            let image = uneven(size[0], size[1]);
            let sky = Sky::new(Some(&image));
            let mut sampler = Sampler::new(1, 0, 0);
            let samples = 20_000;
            let mut solid_angle = 0.0;
            for _ in 0..samples {
                let (direction, density) = sky.sample(sampler.pair()).unwrap();
                assert!((direction.length() - 1.0).abs() < 1e-12);
                // Of a direction on the border of two cells, either is right.
                let stated = sky.density(direction);
                assert!((stated / density - 1.0).abs() < 1e-9 || sky.density(0.999_999 * direction) == stated);
                solid_angle += density.recip() / f64::from(samples);
            }
            // The estimate of 4 pi has a spread of its own, the wider the more uneven the sky.
            assert!((solid_angle / (4.0 * PI) - 1.0).abs() < 0.1, "{size:?}: {solid_angle}");
        }
    }

    #[test]
    fn flux_of_the_sky_is_that_of_its_texels() {
        let image = uneven(64, 32);
        let sky = Sky::new(Some(&image));
        let truth = image.irradiance_sh()[0].map(|c| 4.0 * PI * c);
        let mut sampler = Sampler::new(1, 0, 0);
        let mut sum = DVec3::ZERO;
        let samples = 40_000;
        for _ in 0..samples {
            let (direction, density) = sky.sample(sampler.pair()).unwrap();
            sum += sky.radiance(direction) / density / f64::from(samples);
        }
        // Texels against bilinear interpolation of them, and the noise of drawing by luminance.
        assert!((sum / DVec3::from_array(truth) - 1.0).abs().max_element() < 0.02, "{sum} {truth:?}");
    }

    #[test]
    fn a_black_sky_is_not_sampled() {
        assert!(Sky::new(None).sample([0.5, 0.5]).is_none());
        let black = Environment { width: 4, height: 2, pixels: vec![[0.0; 3]; 8] };
        assert!(Sky::new(Some(&black)).sample([0.5, 0.5]).is_none());
    }
}
