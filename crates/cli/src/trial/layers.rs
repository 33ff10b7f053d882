//! A frame's output variables by name.

use anyhow::{Context, Result};
use glam::DVec3;
use murano_render::Aov;

fn planes<'a>(aov: &'a Aov, name: &str, channels: usize) -> Result<&'a [Vec<f32>]> {
    let layer = aov.layers.iter().find(|layer| layer.name == name && layer.planes.len() == channels);
    Ok(&layer.with_context(|| format!("the frame lacks its layer `{name}`"))?.planes)
}

/// A layer of one channel, an entry a pixel.
///
/// # Errors
/// If there is none of that name.
pub(super) fn scalars<'a>(aov: &'a Aov, name: &str) -> Result<&'a [f32]> {
    Ok(&planes(aov, name, 1)?[0])
}

/// A layer of three channels, an entry a pixel.
///
/// # Errors
/// If there is none of that name.
pub(super) fn vectors(aov: &Aov, name: &str) -> Result<Vec<DVec3>> {
    let planes = planes(aov, name, 3)?;
    let vector = |pixel: usize| DVec3::from_array([0, 1, 2].map(|channel| f64::from(planes[channel][pixel])));
    Ok((0..planes[0].len()).map(vector).collect())
}
