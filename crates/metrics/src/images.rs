//! Errors of pictures as they are displayed.
//!
//! ```text
//! linear radiance --exposure, clamp, sRGB--> Picture --+--> rmse, ssim
//!                                                      +--> flip (NVIDIA's reference implementation) --> flicker
//! ```

mod flip;
mod ssim;

pub use flip::{DEFAULT_PIXELS_PER_DEGREE, Flicker, FlipMap, RelativeFlicker, flicker, flicker_against, flip};
pub use ssim::{SSIM_WINDOW, ssim};

use crate::{
    MetricsError,
    error::{area, expect_len, expect_positive, expect_size},
};

/// An opaque picture of 8-bit sRGB, row-major, row 0 at the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    size: [u32; 2],
    rgb: Vec<[u8; 3]>,
}

impl Picture {
    /// A picture of `size` (width, height) from its pixels.
    ///
    /// # Errors
    /// [`MetricsError::Length`] if there is not one entry a pixel, [`MetricsError::Unfit`] if a side is zero or the
    /// bytes would not be counted by 32 bits.
    pub fn new(size: [u32; 2], rgb: Vec<[u8; 3]>) -> Result<Self, MetricsError> {
        let bytes = u64::from(size[0]) * u64::from(size[1]) * 3;
        if bytes == 0 || bytes > u64::from(u32::MAX) {
            let need = "give sides of at least 1 and fewer than 2^32 / 3 pixels";
            return Err(MetricsError::Unfit { what: "a picture", size, need });
        }
        expect_len("the picture", rgb.len(), area(size))?;
        Ok(Self { size, rgb })
    }

    /// A picture from RGBA bytes; alpha is left out, as the program's pictures are opaque.
    ///
    /// # Errors
    /// As [`Picture::new`].
    pub fn from_rgba8(size: [u32; 2], rgba: &[u8]) -> Result<Self, MetricsError> {
        expect_len("the picture's RGBA bytes", rgba.len(), area(size).saturating_mul(4))?;
        Self::new(size, rgba.chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
    }

    /// A picture from linear Rec.709 radiance: each channel times `exposure`, clamped to 0..1, encoded as sRGB
    /// (IEC 61966-2-1) and rounded to 8 bits.
    ///
    /// There is no tone map, so that what differs is not compressed: choose the exposure by the truth, and give the
    /// same to both pictures.
    ///
    /// # Errors
    /// As [`Picture::new`]; [`MetricsError::Range`] if the exposure is not finite and above zero, and
    /// [`MetricsError::Entry`] if a channel is not finite, which a clamp would hide.
    pub fn from_linear(size: [u32; 2], radiance: &[[f32; 3]], exposure: f32) -> Result<Self, MetricsError> {
        expect_positive("the exposure", f64::from(exposure))?;
        if let Some((index, pixel)) =
            radiance.iter().enumerate().find(|(_, pixel)| !pixel.iter().all(|c| c.is_finite()))
        {
            let value = pixel.iter().copied().find(|c| !c.is_finite()).map_or(f64::NAN, f64::from);
            return Err(MetricsError::Entry { what: "the radiance", index, value, need: "finite" });
        }
        Self::new(size, radiance.iter().map(|pixel| pixel.map(|c| srgb_byte(c * exposure))).collect())
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`MetricsError::Png`] if the encoder refuses it.
    pub fn to_png(&self) -> Result<Vec<u8>, MetricsError> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        let refused = |error: png::EncodingError| MetricsError::Png { size: self.size, reason: error.to_string() };
        let mut writer = encoder.write_header().map_err(refused)?;
        writer.write_image_data(self.rgb.as_flattened()).map_err(refused)?;
        writer.finish().map_err(refused)?;
        Ok(file)
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The pixels, row-major from the top left.
    pub fn rgb(&self) -> &[[u8; 3]] {
        &self.rgb
    }
}

/// The transfer function of sRGB (IEC 61966-2-1) of a channel clamped to 0..1, in 255ths.
fn srgb_byte(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let encoded = if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

/// Root of the mean square difference of the displayed channels, each in 0..1.
///
/// # Errors
/// [`MetricsError::Size`] if the pictures differ in size.
pub fn rmse(truth: &Picture, tested: &Picture) -> Result<f64, MetricsError> {
    expect_size("the tested picture", tested.size, truth.size)?;
    let channels = truth.rgb.as_flattened().iter().zip(tested.rgb.as_flattened());
    // Whole numbers, so the sum is exact: 255^2 times fewer than 2^32 channels fits.
    let sum: u64 = channels.map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    Ok((sum as f64 / (truth.rgb.len() * 3) as f64).sqrt() / 255.0)
}
