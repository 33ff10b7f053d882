//! The visible spectrum in a few wavelengths, and what each adds to linear RGB.

use crate::FRAUNHOFER_D;

/// Ends of the visible spectrum, nanometres: beyond them the eye sees less than a hundredth of its best.
const VISIBLE: [f64; 2] = [410.0, 690.0];

/// A wavelength that stands for a band of the spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralSample {
    /// Nanometres.
    pub wavelength: f64,
    /// What of white light's linear RGB (Rec. 709) the band makes: not negative, and 1 over all bands in each channel.
    pub weight: [f64; 3],
}

/// The visible spectrum in `count` bands of equal width, the shortest waves first; one band is the Fraunhofer d line, 0 counts as 1.
///
/// Weights are the CIE 1931 colour-matching functions (in the fits of Wyman, Sloan and Shirley, JCGT 2013) in Rec. 709
/// primaries; what lies outside of its gamut is cut off, and each channel scaled so that white stays white.
pub fn visible_spectrum(count: usize) -> Vec<SpectralSample> {
    if count <= 1 {
        return vec![SpectralSample { wavelength: FRAUNHOFER_D, weight: [1.0; 3] }];
    }
    let [shortest, longest] = VISIBLE;
    let width = (longest - shortest) / count as f64;
    let band = |index: usize| {
        // Every band integrated alike, so that their number changes no colour.
        const STEPS: u32 = 64;
        let start = shortest + index as f64 * width;
        let at = |step: u32| rec_709(start + (f64::from(step) + 0.5) / f64::from(STEPS) * width);
        let sum = (0..STEPS).map(at).fold([0.0; 3], |sum, rgb| add(sum, rgb.map(|value| value.max(0.0))));
        SpectralSample { wavelength: start + 0.5 * width, weight: sum }
    };
    let mut samples: Vec<SpectralSample> = (0..count).map(band).collect();
    let total = samples.iter().fold([0.0; 3], |total, sample| add(total, sample.weight));
    for sample in &mut samples {
        sample.weight = std::array::from_fn(|channel| sample.weight[channel] / total[channel]);
    }
    samples
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|channel| a[channel] + b[channel])
}

/// The response of linear Rec. 709 to light of one wavelength, of no particular scale.
fn rec_709(wavelength: f64) -> [f64; 3] {
    let lobe = |height: f64, peak: f64, left: f64, right: f64| {
        let distance = wavelength - peak;
        let scaled = distance * if distance < 0.0 { left } else { right };
        height * (-0.5 * scaled * scaled).exp()
    };
    let x =
        lobe(1.056, 599.8, 0.0264, 0.0323) + lobe(0.362, 442.0, 0.0624, 0.0374) + lobe(-0.065, 501.1, 0.0490, 0.0382);
    let y = lobe(0.821, 568.8, 0.0213, 0.0247) + lobe(0.286, 530.9, 0.0613, 0.0322);
    let z = lobe(1.217, 437.0, 0.0845, 0.0278) + lobe(0.681, 459.0, 0.0385, 0.0725);
    [
        3.240_625_5 * x - 1.537_208 * y - 0.498_628_6 * z,
        -0.968_930_7 * x + 1.875_756_1 * y + 0.041_517_5 * z,
        0.055_710_1 * x - 0.204_021_1 * y + 1.056_995_9 * z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_and_nothing_is_negative() {
        for count in 0..=32 {
            let samples = visible_spectrum(count);
            assert_eq!(samples.len(), count.max(1));
            let sum = samples.iter().fold([0.0; 3], |sum, sample| add(sum, sample.weight));
            assert!(sum.iter().all(|channel| (channel - 1.0).abs() < 1e-12), "{count}: {sum:?}");
            assert!(samples.iter().flat_map(|sample| sample.weight).all(|weight| weight >= 0.0));
            assert!(samples.is_sorted_by(|a, b| a.wavelength < b.wavelength));
        }
    }

    #[test]
    fn long_waves_are_red_and_short_ones_blue() {
        let strongest = |sample: &SpectralSample| {
            (0..3).max_by(|&a, &b| sample.weight[a].total_cmp(&sample.weight[b])).unwrap_or_default()
        };
        assert_eq!(visible_spectrum(3).iter().map(strongest).collect::<Vec<_>>(), [2, 1, 0]);
        let fine = visible_spectrum(28);
        let at = |wavelength: f64| strongest(&fine[((wavelength - VISIBLE[0]) / 10.0) as usize]);
        assert_eq!([460.0, 540.0, 640.0].map(at), [2, 1, 0]);
    }
}
