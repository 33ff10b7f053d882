//! Structural similarity.

use super::Picture;
use crate::{MetricsError, error::expect_size};

/// Side of the window, pixels: no picture may be smaller.
pub const SSIM_WINDOW: usize = 11;

/// Standard deviation of the window's weights, pixels.
const SIGMA: f64 = 1.5;
/// K1 and K2 of the paper, squared, for values in 0..1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity of the lumas of two pictures, 1 for equal ones (Wang et al. 2004, equation 13).
///
/// As in the paper, windows are Gaussian (11 x 11, sigma 1.5) and lie within the picture. Luma is that of Rec.709,
/// from the displayed channels. Written here because the libraries at hand measure something else under the name:
/// unweighted windows side by side, or sums in place of variances, which changes what C2 means.
///
/// # Errors
/// [`MetricsError::Size`] if the pictures differ in size, [`MetricsError::Unfit`] if they are smaller than the window.
pub fn ssim(truth: &Picture, tested: &Picture) -> Result<f64, MetricsError> {
    expect_size("the tested picture", tested.size(), truth.size())?;
    let size = truth.size().map(|n| n as usize);
    if size.iter().any(|&side| side < SSIM_WINDOW) {
        let need = "structural similarity needs both sides to be at least 11";
        return Err(MetricsError::Unfit { what: "a picture", size: truth.size(), need });
    }
    let (a, b) = (luma(truth), luma(tested));
    let of =
        |f: &dyn Fn(f64, f64) -> f64| windowed(&a.iter().zip(&b).map(|(&a, &b)| f(a, b)).collect::<Vec<_>>(), size);
    let (mean_a, mean_b) = (of(&|a, _| a), of(&|_, b| b));
    let (square_a, square_b, product) = (of(&|a, _| a * a), of(&|_, b| b * b), of(&|a, b| a * b));
    let similarity = (0..mean_a.len()).map(|i| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (variance_a, variance_b) = (square_a[i] - ma * ma, square_b[i] - mb * mb);
        let covariance = product[i] - ma * mb;
        (2.0 * ma * mb + C1) * (2.0 * covariance + C2) / ((ma * ma + mb * mb + C1) * (variance_a + variance_b + C2))
    });
    Ok(similarity.sum::<f64>() / mean_a.len() as f64)
}

/// Rec.709 luma in 0..1.
fn luma(picture: &Picture) -> Vec<f64> {
    let weighted = |[r, g, b]: [f64; 3]| (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0;
    picture.rgb().iter().map(|pixel| weighted(pixel.map(f64::from))).collect()
}

/// The weighted mean in each window that lies within the picture, row-major: rows first, then columns.
fn windowed(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    let weights = weights();
    let inner = width + 1 - SSIM_WINDOW;
    let dot = |at: &dyn Fn(usize) -> f64| weights.iter().enumerate().map(|(k, w)| w * at(k)).sum::<f64>();
    let mut rows = Vec::with_capacity(inner * height);
    for row in values.chunks_exact(width) {
        rows.extend(row.windows(SSIM_WINDOW).map(|window| dot(&|k| window[k])));
    }
    (0..(height + 1 - SSIM_WINDOW) * inner).map(|i| dot(&|k| rows[i + k * inner])).collect()
}

fn weights() -> [f64; SSIM_WINDOW] {
    let raw: [f64; SSIM_WINDOW] = std::array::from_fn(|k| {
        let x = k as f64 - (SSIM_WINDOW / 2) as f64;
        (-x * x / (2.0 * SIGMA * SIGMA)).exp()
    });
    let sum: f64 = raw.iter().sum();
    raw.map(|w| w / sum)
}
