//! Where the bright curves of a caustic lie.
//!
//! A ridge is where irradiance is largest *across* a curve, though it may change along it: a fold of the light, the
//! rim of a cusp, a focal line. It is found as Steger (1998, "An unbiased detector of curvilinear structures") finds
//! lines: in the map smoothed by a Gaussian, along the eigenvector n of the Hessian's most negative eigenvalue, the
//! maximum lies at about t n from the texel's centre, and the texel holds a ridge point if that lies within it. He takes
//! t from the second-order Taylor polynomial of the map E; here it is that of log E, which has its maximum in the same
//! place and is exact for the Gaussian profile that a thin line takes on when smoothed:
//!
//! ```text
//! t = (g . n) E / ((g . n)^2 - E n^T H n)        g gradient, H Hessian of E; texels
//! ```
//!
//! Smoothing moves the ridge of a fold, which is bright on
//! one side only, into the light; as both maps are smoothed alike, their difference is not moved.

use serde::Serialize;

use super::{IrradianceMap, lit};
use crate::{
    MetricsError,
    error::{expect_positive, expect_size},
    spread::quantile_of_sorted,
};

/// How many scales from the border a ridge point of the truth must lie: nearer, the ridge is bent by the map's mirror
/// image.
const BORDER: f64 = 2.0;

/// What counts as a ridge, and as the same ridge in the other map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RidgeSettings {
    /// Standard deviation of the Gaussian that smooths both maps, texels. Photon noise makes no ridges if it spans a
    /// few texels; ridges closer than about two of it merge.
    pub scale: f64,
    /// Only the brightest texels of the smoothed map that together hold this share of its flux can be ridges.
    pub flux_share: f64,
    /// A ridge point of the truth without one of the tested map within this distance, texels, is missed.
    pub reach: f64,
}

impl Default for RidgeSettings {
    /// A scale of 1.5 texels, half of the flux, a reach of 8 texels.
    fn default() -> Self {
        Self { scale: 1.5, flux_share: 0.5, reach: 8.0 }
    }
}

/// How far the ridges of a map lie from the truth's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RidgeError {
    /// Ridge points of the truth, less those within two scales of the map's border.
    pub points: usize,
    /// Fraction of them for which the tested map has no ridge within reach. These are in no other figure.
    pub missed: f64,
    /// Mean distance of the others to the nearest ridge of the tested map, texels; NaN if all are missed.
    pub mean: f64,
    /// The distance that 95 % of the others do not exceed, texels; NaN if all are missed.
    pub p95: f64,
}

/// Measures how far the ridges of the tested map lie from the truth's, texels.
///
/// The distance of a ridge point of the truth is to the nearest of the short segments, one to each ridge point of the
/// tested map, that run along its ridge: how densely the texels happen to sample a ridge does not matter.
///
/// # Errors
/// [`MetricsError::Size`] if the maps differ in size, [`MetricsError::Range`] if a setting is out of range,
/// [`MetricsError::Dark`] if the truth has no flux, [`MetricsError::NoRidge`] if it has no ridge.
pub fn ridge_position(
    truth: &IrradianceMap,
    tested: &IrradianceMap,
    settings: RidgeSettings,
) -> Result<RidgeError, MetricsError> {
    expect_size("the tested map", tested.size(), truth.size())?;
    expect_positive("the scale of a ridge", settings.scale)?;
    expect_positive("the reach to a ridge", settings.reach)?;
    if settings.scale > f64::from(truth.size()[0].max(truth.size()[1])) {
        let need = "at most the longer side of the map, in texels";
        return Err(MetricsError::Range { what: "the scale of a ridge", value: settings.scale, need });
    }
    let share = settings.flux_share;
    if !(share > 0.0 && share <= 1.0) {
        let need = "above 0, at most 1";
        return Err(MetricsError::Range { what: "the ridges' share of the flux", value: share, need });
    }
    lit(truth)?;
    let inside = |point: &RidgePoint| point.border_distance(truth.size()) >= BORDER * settings.scale;
    let expected: Vec<RidgePoint> = ridge_points(truth, settings).into_iter().flatten().filter(inside).collect();
    if expected.is_empty() {
        return Err(MetricsError::NoRidge);
    }
    let found = ByTexel { points: ridge_points(tested, settings), size: tested.size().map(|n| n as usize) };
    let mut distances: Vec<f64> =
        expected.iter().filter_map(|point| found.distance(point.position, settings.reach)).collect();
    distances.sort_by(f64::total_cmp);
    Ok(RidgeError {
        points: expected.len(),
        missed: 1.0 - distances.len() as f64 / expected.len() as f64,
        mean: distances.iter().sum::<f64>() / distances.len() as f64,
        p95: quantile_of_sorted(&distances, 0.95),
    })
}

/// A point of a ridge.
#[derive(Clone, Copy)]
struct RidgePoint {
    /// Texels, centres at half-integers.
    position: [f64; 2],
    /// Unit direction along the ridge.
    along: [f64; 2],
}

impl RidgePoint {
    /// The distance to the border of a map of `size`.
    fn border_distance(&self, size: [u32; 2]) -> f64 {
        let [x, y] = self.position;
        x.min(y).min(f64::from(size[0]) - x).min(f64::from(size[1]) - y)
    }

    /// The distance to the segment that runs along the ridge one texel to each side.
    fn distance(&self, [x, y]: [f64; 2]) -> f64 {
        const HALF_LENGTH: f64 = 1.0;
        let (dx, dy) = (x - self.position[0], y - self.position[1]);
        let along = (dx * self.along[0] + dy * self.along[1]).clamp(-HALF_LENGTH, HALF_LENGTH);
        (dx - along * self.along[0]).hypot(dy - along * self.along[1])
    }
}

/// The ridge point of each texel of a map, if it has one.
fn ridge_points(map: &IrradianceMap, settings: RidgeSettings) -> Vec<Option<RidgePoint>> {
    // Curvature across a line that is thin against the scale is its irradiance over scale^2; far below that the map is
    // a plateau with noise, not a ridge.
    const LEAST_RELATIVE_CURVATURE: f64 = 0.1;
    // A little more than half, so that a ridge between two texels belongs to both, not by rounding to neither.
    const HALF_TEXEL: f64 = 0.55;
    let derivatives = Derivatives::of(map, settings.scale);
    let dimmest = dimmest_of_share(&derivatives.value, settings.flux_share);
    let least_curvature = LEAST_RELATIVE_CURVATURE / settings.scale.powi(2);
    let in_texel = |(index, centre): (usize, [f64; 2])| {
        let value = derivatives.value[index];
        let (gradient, [xx, xy, yy]) = (derivatives.gradient[index], derivatives.hessian[index]);
        let (curvature, across) = most_negative_curvature(xx, xy, yy);
        let bright = value > 0.0 && value >= dimmest;
        if !bright || -curvature < least_curvature * value {
            return None;
        }
        let slope = gradient[0] * across[0] + gradient[1] * across[1];
        let shift = across.map(|c| c * slope * value / (slope * slope - curvature * value));
        let position = [centre[0] + shift[0], centre[1] + shift[1]];
        let within = shift.iter().all(|s| s.abs() <= HALF_TEXEL);
        within.then_some(RidgePoint { position, along: [-across[1], across[0]] })
    };
    map.centres().enumerate().map(in_texel).collect()
}

/// The irradiance above which the brightest texels hold `share` of the flux.
fn dimmest_of_share(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let mut left = share * sorted.iter().sum::<f64>();
    for value in sorted {
        left -= value;
        if left <= 0.0 {
            return value;
        }
    }
    0.0
}

/// The smaller eigenvalue of the symmetric matrix (xx xy; xy yy), and its unit eigenvector.
fn most_negative_curvature(xx: f64, xy: f64, yy: f64) -> (f64, [f64; 2]) {
    let (mean, half_difference) = (0.5 * (xx + yy), 0.5 * (xx - yy));
    let radius = half_difference.hypot(xy);
    // The axis of the larger eigenvalue stands at half the angle of (half_difference, xy); the other is normal to it.
    let (sin, cos) = (0.5 * xy.atan2(half_difference)).sin_cos();
    (mean - radius, [-sin, cos])
}

/// A map smoothed by a Gaussian, and its derivatives in texels. The map is mirrored at its border, which so makes no
/// ridge of its own.
struct Derivatives {
    value: Vec<f64>,
    gradient: Vec<[f64; 2]>,
    hessian: Vec<[f64; 3]>,
}

impl Derivatives {
    fn of(map: &IrradianceMap, scale: f64) -> Self {
        let [g, g1, g2] = gaussian_derivatives(scale);
        let size = map.size().map(|n| n as usize);
        let correlate = |columns: &[f64], rows: &[f64]| {
            correlate_columns(&correlate_rows(map.values(), size[0], columns), size[0], rows)
        };
        let (x, y) = (correlate(&g1, &g), correlate(&g, &g1));
        let (xx, xy, yy) = (correlate(&g2, &g), correlate(&g1, &g1), correlate(&g, &g2));
        Self {
            value: correlate(&g, &g),
            gradient: x.into_iter().zip(y).map(|(x, y)| [x, y]).collect(),
            hessian: xx.into_iter().zip(xy).zip(yy).map(|((xx, xy), yy)| [xx, xy, yy]).collect(),
        }
    }
}

/// Weights of a Gaussian mean and of its first two derivatives, to four standard deviations, for correlation with the
/// samples about a texel; they differentiate polynomials of second degree exactly.
fn gaussian_derivatives(scale: f64) -> [Vec<f64>; 3] {
    let reach = (4.0 * scale).ceil().max(1.0);
    let x: Vec<f64> = (0..=2 * reach as usize).map(|k| k as f64 - reach).collect();
    let raw: Vec<f64> = x.iter().map(|x| (-0.5 * (x / scale).powi(2)).exp()).collect();
    let total: f64 = raw.iter().sum();
    let g: Vec<f64> = raw.iter().map(|w| w / total).collect();
    let moment = |kernel: &[f64], power: i32| kernel.iter().zip(&x).map(|(w, x)| w * x.powi(power)).sum::<f64>();
    let variance = moment(&g, 2);
    let g1: Vec<f64> = g.iter().zip(&x).map(|(w, x)| w * x / variance).collect();
    let bulge: Vec<f64> = g.iter().zip(&x).map(|(w, x)| w * (x * x - variance)).collect();
    let norm = 2.0 / moment(&bulge, 2);
    [g, g1, bulge.iter().map(|w| w * norm).collect()]
}

/// Correlates each row with an odd kernel.
fn correlate_rows(values: &[f64], width: usize, kernel: &[f64]) -> Vec<f64> {
    let mut result = Vec::with_capacity(values.len());
    let mut extended = vec![0.0; width + kernel.len() - 1];
    for row in values.chunks_exact(width) {
        for (x, value) in extended.iter_mut().enumerate() {
            *value = row[mirrored(x, kernel.len() / 2, width)];
        }
        let dot = |window: &[f64]| window.iter().zip(kernel).map(|(value, weight)| value * weight).sum::<f64>();
        result.extend(extended.windows(kernel.len()).map(dot));
    }
    result
}

/// Correlates each column with an odd kernel.
fn correlate_columns(values: &[f64], width: usize, kernel: &[f64]) -> Vec<f64> {
    let height = values.len() / width;
    let mut result = vec![0.0; values.len()];
    for (y, target) in result.chunks_exact_mut(width).enumerate() {
        for (k, weight) in kernel.iter().enumerate() {
            let row = &values[mirrored(y + k, kernel.len() / 2, height) * width..][..width];
            for (sum, value) in target.iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
    }
    result
}

/// Which of `count` entries, mirrored again and again at both ends, stands at `index - before`.
fn mirrored(index: usize, before: usize, count: usize) -> usize {
    let position = (index as isize - before as isize).rem_euclid(2 * count as isize) as usize;
    position.min(2 * count - 1 - position)
}

/// The ridge points of a map, each in the place of its texel.
struct ByTexel {
    points: Vec<Option<RidgePoint>>,
    size: [usize; 2],
}

impl ByTexel {
    /// The distance from a position to the nearest ridge, if that is within reach.
    fn distance(&self, position: [f64; 2], reach: f64) -> Option<f64> {
        // A point lies up to a little more than half a texel from its texel's centre, and its segment reaches one beyond.
        let steps = (reach.ceil() as usize).saturating_add(2);
        let [x, y]: [usize; 2] = std::array::from_fn(|axis| (position[axis] as usize).min(self.size[axis] - 1));
        let columns = x.saturating_sub(steps)..x.saturating_add(steps).saturating_add(1).min(self.size[0]);
        (y.saturating_sub(steps)..y.saturating_add(steps).saturating_add(1).min(self.size[1]))
            .flat_map(|v| &self.points[v * self.size[0]..][columns.clone()])
            .flatten()
            .map(|point| point.distance(position))
            .filter(|distance| *distance <= reach)
            .reduce(f64::min)
    }
}
