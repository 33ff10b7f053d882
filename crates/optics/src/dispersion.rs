//! Dispersion: the index of refraction by wavelength.

use crate::Ior;

/// Wavelength of the Fraunhofer C line (hydrogen, red), nanometres.
pub const FRAUNHOFER_C: f64 = 656.27;
/// Wavelength of the Fraunhofer d line (helium, yellow), at which an index is given, nanometres.
pub const FRAUNHOFER_D: f64 = 587.56;
/// Wavelength of the Fraunhofer F line (hydrogen, blue), nanometres.
pub const FRAUNHOFER_F: f64 = 486.13;

/// Shortest wavelength that Cauchy's two-term formula is asked for, nanometres.
const SHORTEST: f64 = 100.0;

/// Index of refraction at a wavelength in nanometres (KHR_materials_dispersion, after Cauchy):
/// max(n_d + (n_d - 1) dispersion / 20 (523655 / lambda^2 - 1.5168), 1).
///
/// `n_d` is the index at [`FRAUNHOFER_D`]; `dispersion` is 20 over the Abbe number, negative counts as 0. Wavelengths
/// below 100 nm count as 100 nm.
pub fn dispersed_ior(n_d: Ior, dispersion: f64, wavelength: f64) -> Ior {
    let wavelength = wavelength.max(SHORTEST);
    let spread = (n_d.get() - 1.0) * dispersion.max(0.0) / 20.0;
    let n = n_d.get() + spread * (523_655.0 / (wavelength * wavelength) - 1.5168);
    Ior::new(n.max(1.0)).unwrap_or(n_d)
}

/// Abbe number (n_d - 1) / (n_F - n_C) of a dispersion; infinite if there is none.
pub fn abbe_number(dispersion: f64) -> f64 {
    if dispersion > 0.0 { 20.0 / dispersion } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_between_the_lines_is_the_abbe_number() {
        for (n, dispersion) in [(1.5, 0.36), (1.9, 1.0), (2.42, 0.5)] {
            let n_d = Ior::new(n).expect("legal");
            let [n_c, n_f] = [FRAUNHOFER_C, FRAUNHOFER_F].map(|line| dispersed_ior(n_d, dispersion, line).get());
            let abbe = (n - 1.0) / (n_f - n_c);
            assert!((abbe / abbe_number(dispersion) - 1.0).abs() < 1e-3, "{abbe}");
            assert!((dispersed_ior(n_d, dispersion, FRAUNHOFER_D).get() - n).abs() < 1e-5);
        }
    }

    #[test]
    fn without_dispersion_every_wavelength_is_refracted_alike() {
        for wavelength in [380.0, 550.0, 780.0] {
            assert_eq!(dispersed_ior(Ior::GLASS, 0.0, wavelength), Ior::GLASS);
            assert_eq!(dispersed_ior(Ior::AIR, 1.0, wavelength), Ior::AIR);
        }
    }

    #[test]
    fn hostile_numbers_give_an_index() {
        for dispersion in [-1.0, 0.0, 1e3, f64::MAX, f64::INFINITY, f64::NAN] {
            for wavelength in [-1.0, 0.0, 1e-300, 550.0, f64::INFINITY, f64::NAN] {
                let n = dispersed_ior(Ior::GLASS, dispersion, wavelength).get();
                assert!(n.is_finite() && n >= 1.0, "{dispersion} {wavelength}: {n}");
            }
        }
    }

    #[test]
    fn shorter_waves_bend_more() {
        let indices: Vec<f64> =
            (38..78).map(|ten| dispersed_ior(Ior::GLASS, 0.5, f64::from(ten) * 10.0).get()).collect();
        assert!(indices.windows(2).all(|pair| pair[0] > pair[1]));
    }
}
