//! Errors of irradiance maps: what a caustic carries, how it is spread, and where its bright curves lie.

mod encircled;
mod ridge;

pub use encircled::encircled_energy_radius;
pub use ridge::{RidgeError, RidgeSettings, ridge_position};

use crate::{
    MetricsError,
    error::{area, expect_len, expect_positive, expect_size},
    spread::expect_entries,
};

/// Irradiance (or illuminance) on square texels of a plane, row-major, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct IrradianceMap {
    size: [u32; 2],
    texel_area: f64,
    values: Vec<f64>,
}

impl IrradianceMap {
    /// A map of `size` (width, height) in W/m^2 or lux on texels of `texel_area` m^2.
    ///
    /// # Errors
    /// [`MetricsError::Empty`] without a texel, [`MetricsError::Length`] if there is not one value a texel,
    /// [`MetricsError::Range`] if the area is not finite and above zero, [`MetricsError::Entry`] if a value is negative
    /// or not finite.
    pub fn new(size: [u32; 2], texel_area: f64, values: Vec<f64>) -> Result<Self, MetricsError> {
        const WHAT: &str = "the irradiance map";
        if area(size) == 0 {
            return Err(MetricsError::Empty { what: WHAT, least: 1 });
        }
        expect_len(WHAT, values.len(), area(size))?;
        expect_positive("the area of a texel", texel_area)?;
        expect_entries(WHAT, &values, "finite and not negative", |value| value.is_finite() && value >= 0.0)?;
        Ok(Self { size, texel_area, values })
    }

    /// A map from the f32 values that a GPU or an image file holds.
    ///
    /// # Errors
    /// As [`IrradianceMap::new`].
    pub fn from_f32(size: [u32; 2], texel_area: f64, values: &[f32]) -> Result<Self, MetricsError> {
        Self::new(size, texel_area, values.iter().copied().map(f64::from).collect())
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The area of a texel, m^2.
    pub fn texel_area(&self) -> f64 {
        self.texel_area
    }

    /// The irradiance of each texel, row-major from the top left.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// All that arrives, W (or lumen).
    pub fn flux(&self) -> f64 {
        self.values.iter().sum::<f64>() * self.texel_area
    }

    /// The brightest texel; the first of equals.
    pub fn peak(&self) -> Peak {
        let mut index = 0;
        for (i, value) in self.values.iter().enumerate() {
            if *value > self.values[index] {
                index = i;
            }
        }
        let width = self.size[0] as usize;
        Peak { irradiance: self.values[index], texel: [(index % width) as u32, (index / width) as u32] }
    }

    /// The mean position of the flux in texels, centres at half-integers; none if the map is dark.
    pub fn centroid(&self) -> Option<[f64; 2]> {
        let mut sums = [0.0; 3];
        for (value, [x, y]) in self.values.iter().zip(self.centres()) {
            sums = [sums[0] + value, sums[1] + value * x, sums[2] + value * y];
        }
        (sums[0] > 0.0).then(|| [sums[1] / sums[0], sums[2] / sums[0]])
    }

    /// The part of the map that begins at texel `origin` and has `size` texels.
    ///
    /// # Errors
    /// [`MetricsError::Unfit`] if the part is empty or does not lie within the map.
    pub fn cropped(&self, origin: [u32; 2], size: [u32; 2]) -> Result<Self, MetricsError> {
        let within = |axis: usize| origin[axis].checked_add(size[axis]).is_some_and(|end| end <= self.size[axis]);
        if area(size) == 0 || !within(0) || !within(1) {
            let need = "a part must have a texel and lie within the map";
            return Err(MetricsError::Unfit { what: "a part of an irradiance map", size, need });
        }
        let [left, top] = origin.map(|n| n as usize);
        let [columns, rows] = size.map(|n| n as usize);
        let width = self.size[0] as usize;
        let values = (top..top + rows)
            .flat_map(|y| &self.values[y * width + left..y * width + left + columns])
            .copied()
            .collect();
        Ok(Self { size, texel_area: self.texel_area, values })
    }

    /// The map on texels of `factor` times the side: each is the mean of its block, so that no flux is lost.
    ///
    /// # Errors
    /// [`MetricsError::Unfit`] if `factor` does not divide both sides, or is zero; [crop](IrradianceMap::cropped) first.
    pub fn downsampled(&self, factor: u32) -> Result<Self, MetricsError> {
        if factor == 0 || self.size.iter().any(|side| side % factor != 0) {
            let need = "both sides must be multiples of the factor by which they shrink";
            return Err(MetricsError::Unfit { what: "an irradiance map", size: self.size, need });
        }
        let size = self.size.map(|side| side / factor);
        let [width, block] = [self.size[0] as usize, factor as usize];
        let mut values = vec![0.0; area(size)];
        for (index, value) in self.values.iter().enumerate() {
            values[index / width / block * size[0] as usize + index % width / block] += value;
        }
        let texels = (factor as f64).powi(2);
        for value in &mut values {
            *value /= texels;
        }
        Ok(Self { size, texel_area: self.texel_area * texels, values })
    }

    /// The texels' centres, in the order of the values.
    fn centres(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [width, height] = self.size;
        (0..height).flat_map(move |y| (0..width).map(move |x| [x as f64 + 0.5, y as f64 + 0.5]))
    }
}

/// The brightest texel of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Its irradiance.
    pub irradiance: f64,
    /// Its column and row.
    pub texel: [u32; 2],
}

/// The tested map's flux over the truth's.
///
/// The maps may differ in size and area of texel.
///
/// # Errors
/// [`MetricsError::Dark`] if the truth has no flux.
pub fn energy_ratio(truth: &IrradianceMap, tested: &IrradianceMap) -> Result<f64, MetricsError> {
    Ok(tested.flux() / lit(truth)?)
}

/// Sum of the absolute differences over the sum of the truth: 0 for equal maps, 2 for equal flux that lands apart.
///
/// # Errors
/// [`MetricsError::Size`] if the maps differ in size, [`MetricsError::Dark`] if the truth has no flux.
pub fn relative_l1(truth: &IrradianceMap, tested: &IrradianceMap) -> Result<f64, MetricsError> {
    expect_size("the tested map", tested.size, truth.size)?;
    lit(truth)?;
    let difference: f64 = truth.values.iter().zip(&tested.values).map(|(a, b)| (a - b).abs()).sum();
    Ok(difference / truth.values.iter().sum::<f64>())
}

/// Root of the sum of the squared differences over that of the squared truth; weighs the bright curves most.
///
/// # Errors
/// As [`relative_l1`].
pub fn relative_l2(truth: &IrradianceMap, tested: &IrradianceMap) -> Result<f64, MetricsError> {
    expect_size("the tested map", tested.size, truth.size)?;
    lit(truth)?;
    let difference: f64 = truth.values.iter().zip(&tested.values).map(|(a, b)| (a - b).powi(2)).sum();
    Ok((difference / truth.values.iter().map(|a| a * a).sum::<f64>()).sqrt())
}

/// The truth's flux, which must not be zero.
fn lit(truth: &IrradianceMap) -> Result<f64, MetricsError> {
    let flux = truth.flux();
    if flux > 0.0 { Ok(flux) } else { Err(MetricsError::Dark { what: "the map of the truth" }) }
}
