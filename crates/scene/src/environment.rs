//! Distant light from an equirectangular image.
//!
//! Direction `d` maps to `u = 0.5 + atan2(d.z, d.x) / 2 pi` and `v = acos(d.y) / pi`, v downwards from +Y, texel centres
//! at half-integers.

use std::f64::consts::PI;
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::{Path, PathBuf};

use exr::prelude::{MetaData, read_first_rgba_layer_from_file};
use glam::DVec3;
use image::{ImageFormat, ImageReader, Limits};

/// Largest width and height accepted, texels.
const MAX_SIDE: u32 = 32768;
/// Most texels accepted: 3 GiB of RGB.
const MAX_TEXELS: u64 = 1 << 28;
/// OpenEXR's first four bytes.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Irradiance is so smooth that no wider image changes it.
const IRRADIANCE_WIDTH: u32 = 1024;

/// Light from infinitely far away, by direction; linear Rec.709 radiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// Texels around the horizon.
    pub width: u32,
    /// Texels from zenith to nadir.
    pub height: u32,
    /// `width * height` texels, row 0 at the zenith, finite and not negative.
    pub pixels: Vec<[f32; 3]>,
}

/// Why an environment could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum EnvironmentError {
    /// The file does not exist or cannot be opened.
    #[error("environment {} cannot be opened: {source}; check the path, or use \"none\" or the built-in one", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The file is no Radiance .hdr and no OpenEXR image that can be decoded.
    #[error("environment {} does not decode: {problem}; convert it to an equirectangular Radiance .hdr", path.display())]
    Undecodable {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        problem: String,
    },
    /// A texel is NaN or infinite.
    #[error("environment {}: the texel at column {x}, row {y} is NaN or infinite; repair it in an image editor", path.display())]
    NonFinite {
        /// The file.
        path: PathBuf,
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl Environment {
    /// Reads a Radiance `.hdr` or an OpenEXR image; its content decides which. Any aspect ratio is stretched over the
    /// sphere. Negative values, which some filters leave behind, become zero.
    ///
    /// # Errors
    /// [`EnvironmentError`] if the file is missing, does not decode, is larger than 32768 texels a side, or holds a NaN
    /// or an infinity.
    pub fn load(path: &Path) -> Result<Self, EnvironmentError> {
        let missing = |source| EnvironmentError::Missing { path: path.to_owned(), source };
        let mut file = BufReader::new(File::open(path).map_err(missing)?);
        let is_exr = file.fill_buf().map_err(missing)?.starts_with(&EXR_MAGIC);
        let decoded = if is_exr { decode_exr(path) } else { decode_hdr(file) };
        decoded.map_err(|problem| EnvironmentError::Undecodable { path: path.to_owned(), problem })?.checked(path)
    }

    /// Decodes a Radiance `.hdr` held in memory; `name` stands for its path in messages. Otherwise as [`Self::load`].
    ///
    /// # Errors
    /// [`EnvironmentError`] if it does not decode, is larger than 32768 texels a side, or holds a NaN or an infinity.
    pub fn from_hdr(bytes: &[u8], name: &Path) -> Result<Self, EnvironmentError> {
        decode_hdr(Cursor::new(bytes))
            .map_err(|problem| EnvironmentError::Undecodable { path: name.to_owned(), problem })?
            .checked(name)
    }

    /// Refuses texels that are no numbers and raises negative ones to zero.
    fn checked(mut self, path: &Path) -> Result<Self, EnvironmentError> {
        if let Some(texel) = self.pixels.iter().position(|texel| !texel.iter().all(|value| value.is_finite())) {
            let (x, y) = (texel as u32 % self.width, texel as u32 / self.width);
            return Err(EnvironmentError::NonFinite { path: path.to_owned(), x, y });
        }
        for value in self.pixels.as_flattened_mut() {
            *value = value.max(0.0);
        }
        Ok(self)
    }

    /// Radiance from a unit direction: bilinear, around the horizon without a seam, held at the poles.
    pub fn sample(&self, direction: DVec3) -> [f64; 3] {
        let (width, height) = (i64::from(self.width), i64::from(self.height));
        let x = (0.5 + direction.z.atan2(direction.x) / (2.0 * PI)) * f64::from(self.width) - 0.5;
        let y = direction.y.clamp(-1.0, 1.0).acos() / PI * f64::from(self.height) - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let (right_share, bottom_share) = (x - left, y - top);
        let texel = |dx: i64, dy: i64| {
            let column = (left as i64 + dx).rem_euclid(width);
            let row = (top as i64 + dy).clamp(0, height - 1);
            self.pixels[(row * width + column) as usize]
        };
        let corners = [
            (texel(0, 0), (1.0 - right_share) * (1.0 - bottom_share)),
            (texel(1, 0), right_share * (1.0 - bottom_share)),
            (texel(0, 1), (1.0 - right_share) * bottom_share),
            (texel(1, 1), right_share * bottom_share),
        ];
        std::array::from_fn(|channel| corners.iter().map(|(color, share)| f64::from(color[channel]) * share).sum())
    }

    /// Spherical-harmonics coefficients of irradiance over pi (Ramamoorthi and Hanrahan 2001, equations 7 to 10): the
    /// radiance leaving a white diffuse surface of unit normal `n` is
    ///
    /// `c0 + c1 n.y + c2 n.z + c3 n.x + c4 n.x n.y + c5 n.y n.z + c6 (3 n.z^2 - 1) + c7 n.x n.z + c8 (n.x^2 - n.y^2)`
    ///
    /// per channel. The cosine lobe's coefficients and the basis functions' constants are multiplied in.
    pub fn irradiance_sh(&self) -> [[f64; 3]; 9] {
        let mut reduced = None;
        while reduced.as_ref().unwrap_or(self).width > IRRADIANCE_WIDTH {
            reduced = Some(reduced.as_ref().unwrap_or(self).halved());
        }
        reduced.as_ref().unwrap_or(self).project_irradiance()
    }

    /// The polynomial of [`Environment::irradiance_sh`]: irradiance over pi at a unit normal.
    pub fn evaluate_sh(coefficients: &[[f64; 3]; 9], normal: DVec3) -> [f64; 3] {
        let basis = polynomials(normal);
        std::array::from_fn(|channel| (0..9).map(|k| coefficients[k][channel] * basis[k]).sum())
    }

    /// The image and its reductions to half the size, down to one texel; `(width, height, texels)` each. A reduced
    /// texel is the mean radiance over its solid angle, so every level holds the same energy.
    pub fn mip_chain(&self) -> Vec<(u32, u32, Vec<[f32; 3]>)> {
        let mut levels = Vec::new();
        let mut level = self.clone();
        while level.width.max(level.height) > 1 {
            let next = level.halved();
            levels.push((level.width, level.height, level.pixels));
            level = next;
        }
        levels.push((level.width, level.height, level.pixels));
        levels
    }

    fn project_irradiance(&self) -> [[f64; 3]; 9] {
        // Cosine lobe over pi: 1, 2/3, 1/4 by degree; squared basis constants, once for projecting, once for evaluating.
        const COSINE: [f64; 9] = [1.0, 2.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0, 0.25, 0.25, 0.25, 0.25, 0.25];
        const SQUARED_BASIS: [f64; 9] =
            [1.0 / 4.0, 3.0 / 4.0, 3.0 / 4.0, 3.0 / 4.0, 15.0 / 4.0, 15.0 / 4.0, 5.0 / 16.0, 15.0 / 4.0, 15.0 / 16.0];
        let mut sums = [[0.0; 3]; 9];
        let around: Vec<(f64, f64)> = (0..self.width)
            .map(|x| (2.0 * PI * ((f64::from(x) + 0.5) / f64::from(self.width) - 0.5)).sin_cos())
            .collect();
        for (y, row) in self.pixels.chunks_exact(self.width as usize).enumerate() {
            let solid_angle = 2.0 * PI / f64::from(self.width)
                * band(y as f64 / f64::from(self.height), (y + 1) as f64 / f64::from(self.height));
            let (sin_theta, cos_theta) = (PI * (y as f64 + 0.5) / f64::from(self.height)).sin_cos();
            for (texel, &(sin_phi, cos_phi)) in row.iter().zip(&around) {
                let basis = polynomials(DVec3::new(sin_theta * cos_phi, cos_theta, sin_theta * sin_phi));
                for (sum, value) in sums.iter_mut().zip(basis) {
                    for channel in 0..3 {
                        sum[channel] += f64::from(texel[channel]) * value * solid_angle;
                    }
                }
            }
        }
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum = sum.map(|value| value * COSINE[k] * SQUARED_BASIS[k] / PI);
        }
        sums
    }

    /// The image at half the size, rounded down, at least 1.
    fn halved(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let columns = overlaps(self.width, width, |from, to| to - from);
        let rows = overlaps(self.height, height, band);
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for row in &rows {
            for column in &columns {
                let mut mean = [0.0; 3];
                for &(y, row_share) in row {
                    for &(x, column_share) in column {
                        let texel = self.pixels[y * self.width as usize + x];
                        for channel in 0..3 {
                            mean[channel] += f64::from(texel[channel]) * row_share * column_share;
                        }
                    }
                }
                pixels.push(mean.map(|value| value as f32));
            }
        }
        Self { width, height, pixels }
    }
}

/// The nine real spherical harmonics up to degree 2 without their constants, in the order of Ramamoorthi and Hanrahan.
fn polynomials(d: DVec3) -> [f64; 9] {
    [1.0, d.y, d.z, d.x, d.x * d.y, d.y * d.z, 3.0 * d.z * d.z - 1.0, d.x * d.z, d.x * d.x - d.y * d.y]
}

/// Solid angle per radian of azimuth between two heights of the image, `v` in 0..1 downwards.
fn band(from: f64, to: f64) -> f64 {
    (PI * from).cos() - (PI * to).cos()
}

/// For each of `reduced` intervals, the `full` intervals it overlaps and their shares of it, which sum to 1.
fn overlaps(full: u32, reduced: u32, measure: impl Fn(f64, f64) -> f64) -> Vec<Vec<(usize, f64)>> {
    (0..reduced)
        .map(|i| {
            let (from, to) = (f64::from(i) / f64::from(reduced), f64::from(i + 1) / f64::from(reduced));
            let first = i * full / reduced;
            let end = ((i + 1) * full).div_ceil(reduced);
            let total = measure(from, to);
            (first..end)
                .map(|k| {
                    let low = (f64::from(k) / f64::from(full)).max(from);
                    let high = (f64::from(k + 1) / f64::from(full)).min(to);
                    (k as usize, measure(low, high) / total)
                })
                .collect()
        })
        .collect()
}

fn decode_hdr(file: impl BufRead + Seek) -> Result<Environment, String> {
    let mut reader = ImageReader::with_format(file, ImageFormat::Hdr);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(12 * MAX_TEXELS);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| error.to_string())?.into_rgb32f();
    let (width, height) = image.dimensions();
    Ok(Environment { width, height, pixels: image.into_raw().as_chunks::<3>().0.to_vec() })
}

fn decode_exr(path: &Path) -> Result<Environment, String> {
    let meta = MetaData::read_from_file(path, false).map_err(|error| error.to_string())?;
    for header in &meta.headers {
        let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        if width.max(height) > u64::from(MAX_SIDE) || width * height > MAX_TEXELS {
            return Err(format!("{width}x{height} texels are too many"));
        }
    }
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| Environment {
            width: size.width() as u32,
            height: size.height() as u32,
            pixels: vec![[0.0; 3]; size.area()],
        },
        |environment, place, (r, g, b, _): (f32, f32, f32, f32)| {
            let width = environment.width as usize;
            environment.pixels[place.y() * width + place.x()] = [r, g, b];
        },
    )
    .map_err(|error| error.to_string())?;
    Ok(image.layer_data.channel_data.pixels)
}
