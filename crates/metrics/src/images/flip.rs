//! FLIP and flicker.

use std::borrow::Borrow;

use serde::Serialize;

use super::Picture;
use crate::{
    MetricsError,
    error::{expect_positive, expect_size},
};

/// Pixels per degree of a 0.7 m wide 4K display at 0.7 m, the distance for which FLIP's figures are usually given.
pub const DEFAULT_PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// How different a viewer finds two pictures that are flipped between, pixel by pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct FlipMap {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Mean over the pixels, 0 (equal) to 1.
    pub mean: f64,
    /// One value a pixel, 0 to 1, row-major from the top left.
    pub map: Vec<f32>,
}

/// FLIP (Andersson et al. 2020) by NVIDIA's implementation.
///
/// `pixels_per_degree` says how finely the viewer sees; [`DEFAULT_PIXELS_PER_DEGREE`] if nothing is known.
///
/// # Errors
/// [`MetricsError::Size`] if the pictures differ in size, [`MetricsError::Range`] if `pixels_per_degree` is not finite
/// and above zero.
pub fn flip(truth: &Picture, tested: &Picture, pixels_per_degree: f32) -> Result<FlipMap, MetricsError> {
    expect_size("the tested picture", tested.size(), truth.size())?;
    expect_positive("pixels per degree", f64::from(pixels_per_degree))?;
    let [width, height] = truth.size();
    let [a, b] =
        [truth, tested].map(|picture| nv_flip::FlipImageRgb8::with_data(width, height, picture.rgb().as_flattened()));
    let map = nv_flip::flip(a, b, pixels_per_degree).to_vec();
    Ok(FlipMap { size: truth.size(), mean: mean(&map), map })
}

fn mean(map: &[f32]) -> f64 {
    map.iter().copied().map(f64::from).sum::<f64>() / map.len() as f64
}

/// Change from frame to frame of a sequence: mean FLIP of each pair of consecutive frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flicker {
    /// Mean over the pairs.
    pub mean: f64,
    /// The worst pair.
    pub max: f64,
    /// One value a pair, in order: one fewer than frames.
    pub pairs: Vec<f64>,
}

impl Flicker {
    fn of(pairs: Vec<f64>) -> Result<Self, MetricsError> {
        if pairs.is_empty() {
            return Err(MetricsError::Empty { what: "the sequence of frames", least: 2 });
        }
        let (sum, max) = (pairs.iter().sum::<f64>(), pairs.iter().copied().fold(0.0, f64::max));
        Ok(Self { mean: sum / pairs.len() as f64, max, pairs })
    }
}

/// Frame-to-frame FLIP of a sequence, motion included.
///
/// Only two frames are held at a time, so that a long sequence can be rendered or read as it is measured.
///
/// # Errors
/// [`MetricsError::Empty`] with fewer than two frames, and as [`flip`].
pub fn flicker<P: Borrow<Picture>>(
    frames: impl IntoIterator<Item = P>,
    pixels_per_degree: f32,
) -> Result<Flicker, MetricsError> {
    let mut frames = frames.into_iter();
    let mut previous = frames.next();
    let mut pairs = Vec::new();
    for frame in frames {
        if let Some(previous) = &previous {
            pairs.push(flip(previous.borrow(), frame.borrow(), pixels_per_degree)?.mean);
        }
        previous = Some(frame);
    }
    Flicker::of(pairs)
}

/// Flicker of a sequence beside that of the truth's sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RelativeFlicker {
    /// Change from frame to frame of the truth: motion.
    pub truth: Flicker,
    /// Change from frame to frame of the tested sequence: motion and flicker.
    pub tested: Flicker,
    /// Change that the truth does not show: per pair, the mean over the pixels of how far the tested sequence's FLIP
    /// exceeds the truth's in the same pixel. Zero for a sequence that is wrong but steady.
    pub excess: Flicker,
}

/// Frame-to-frame FLIP of a sequence relative to that of the truth's sequence.
///
/// # Errors
/// [`MetricsError::Length`] if the sequences differ in length, and as [`flicker`].
pub fn flicker_against<P: Borrow<Picture>, Q: Borrow<Picture>>(
    truth: impl IntoIterator<Item = P>,
    tested: impl IntoIterator<Item = Q>,
    pixels_per_degree: f32,
) -> Result<RelativeFlicker, MetricsError> {
    let (mut truth, mut tested) = (truth.into_iter(), tested.into_iter());
    let [mut of_truth, mut of_tested, mut excess] = [const { Vec::new() }; 3];
    let mut previous: Option<(P, Q)> = None;
    for frame in 0.. {
        let now = match (truth.next(), tested.next()) {
            (Some(a), Some(b)) => (a, b),
            (None, None) => break,
            (a, b) => {
                let expected = frame + usize::from(a.is_some()) + truth.count();
                let found = frame + usize::from(b.is_some()) + tested.count();
                return Err(MetricsError::Length { what: "the tested sequence", expected, found });
            }
        };
        expect_size("the tested sequence", now.1.borrow().size(), now.0.borrow().size())?;
        if let Some(before) = &previous {
            let a = flip(before.0.borrow(), now.0.borrow(), pixels_per_degree)?;
            let b = flip(before.1.borrow(), now.1.borrow(), pixels_per_degree)?;
            let over: Vec<f32> = a.map.iter().zip(&b.map).map(|(a, b)| (b - a).max(0.0)).collect();
            of_truth.push(a.mean);
            of_tested.push(b.mean);
            excess.push(mean(&over));
        }
        previous = Some(now);
    }
    Ok(RelativeFlicker { truth: Flicker::of(of_truth)?, tested: Flicker::of(of_tested)?, excess: Flicker::of(excess)? })
}
