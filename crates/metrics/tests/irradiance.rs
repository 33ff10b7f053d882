//! Errors of irradiance maps against closed forms.

use murano_metrics::{
    MetricsError,
    irradiance::{
        IrradianceMap, RidgeSettings, encircled_energy_radius, energy_ratio, relative_l1, relative_l2, ridge_position,
    },
};
use proptest::prelude::*;

/// A map sampled at the texels' centres.
fn map(size: [u32; 2], texel_area: f64, irradiance: impl Fn(f64, f64) -> f64) -> IrradianceMap {
    let values = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x as f64 + 0.5, y as f64 + 0.5)));
    IrradianceMap::new(size, texel_area, values.map(|(x, y)| irradiance(x, y)).collect()).expect("a valid map")
}

fn gaussian(distance: f64, sigma: f64) -> f64 {
    (-0.5 * (distance / sigma).powi(2)).exp()
}

/// A bright line through (32, 32) whose normal stands at `angle`, moved along the normal by `shift` texels.
fn line(angle: f64, shift: f64) -> IrradianceMap {
    let (sin, cos) = angle.sin_cos();
    map([64, 64], 1.0, |x, y| 0.01 + gaussian((x - 32.0) * cos + (y - 32.0) * sin - shift, 1.2))
}

#[test]
fn energies_and_distances_by_hand() {
    let truth = IrradianceMap::new([2, 2], 0.25, vec![1.0, 2.0, 3.0, 4.0]).unwrap();
    let tested = IrradianceMap::new([2, 2], 0.25, vec![1.0, 1.0, 5.0, 4.0]).unwrap();
    assert_eq!(truth.flux(), 2.5);
    assert!((energy_ratio(&truth, &tested).unwrap() - 1.1).abs() < 1e-15);
    assert!((relative_l1(&truth, &tested).unwrap() - 0.3).abs() < 1e-15);
    assert!((relative_l2(&truth, &tested).unwrap() - (5.0_f64 / 30.0).sqrt()).abs() < 1e-15);
    let peak = tested.peak();
    assert_eq!((peak.irradiance, peak.texel), (5.0, [0, 1]));
    let [x, y] = truth.centroid().unwrap();
    assert!((x - 1.1).abs() < 1e-15 && (y - 1.2).abs() < 1e-15);
}

#[test]
fn coarser_texels_keep_the_flux() {
    let fine = map([12, 8], 0.04, |x, y| x + 10.0 * y);
    let coarse = fine.downsampled(4).unwrap();
    assert_eq!(coarse.size(), [3, 2]);
    assert!((coarse.texel_area() - 0.64).abs() < 1e-15);
    assert!((coarse.flux() / fine.flux() - 1.0).abs() < 1e-14);
    // The mean of a linear function over a block is its value in the block's middle.
    assert!((coarse.values()[4] - (6.0 + 10.0 * 6.0)).abs() < 1e-12);
    assert!((energy_ratio(&fine, &coarse).unwrap() - 1.0).abs() < 1e-14);

    let part = fine.cropped([3, 5], [2, 3]).unwrap();
    assert_eq!(part.values(), [3.5 + 55.0, 4.5 + 55.0, 3.5 + 65.0, 4.5 + 65.0, 3.5 + 75.0, 4.5 + 75.0]);
    assert!(matches!(fine.cropped([11, 0], [2, 1]), Err(MetricsError::Unfit { .. })));
    assert!(matches!(fine.cropped([0, 0], [0, 1]), Err(MetricsError::Unfit { .. })));
    assert!(matches!(fine.downsampled(3), Err(MetricsError::Unfit { .. })));
    assert!(matches!(fine.downsampled(0), Err(MetricsError::Unfit { .. })));
}

#[test]
fn encircled_energy_of_a_gaussian() {
    // The circle of radius r holds 1 - exp(-r^2 / 2 sigma^2). Texels smear sigma^2 by 1/12: 0.05 % at sigma 9.
    let (sigma, texel) = (9.0, 0.01);
    let spot = map([128, 128], texel * texel, |x, y| gaussian((x - 60.3).hypot(y - 66.8), sigma));
    for fraction in [0.1_f64, 0.5, 0.8, 0.95] {
        let expected = sigma * texel * (-2.0 * (1.0 - fraction).ln()).sqrt();
        for centre in [None, Some([60.3, 66.8])] {
            let found = encircled_energy_radius(&spot, fraction, centre).unwrap();
            assert!((found / expected - 1.0).abs() < 2e-3, "{fraction}: {found} {expected}");
        }
    }
}

#[test]
fn encircled_energy_is_exact_within_a_texel() {
    // A single texel of side 2: pi r^2 = half of its area while the circle lies within it.
    let point = map([5, 5], 4.0, |x, y| f64::from(x == 2.5 && y == 2.5));
    let found = encircled_energy_radius(&point, 0.5, None).unwrap();
    assert!((found - 2.0 * (0.5 / std::f64::consts::PI).sqrt()).abs() < 1e-9, "{found}");
    // All of it is held by the circle through its corners.
    let found = encircled_energy_radius(&point, 1.0, None).unwrap();
    assert!((found - 2.0_f64.sqrt()).abs() < 1e-6, "{found}");
    // A uniform disc of radius 20 about a corner of texels holds a quarter within half of the radius.
    let disc = map([64, 64], 1.0, |x, y| f64::from((x - 32.0).hypot(y - 32.0) < 20.0));
    let found = encircled_energy_radius(&disc, 0.25, Some([32.0, 32.0])).unwrap();
    assert!((found / 10.0 - 1.0).abs() < 5e-3, "{found}");
}

#[test]
fn the_ridge_of_a_shifted_line_is_off_by_the_shift() {
    for degrees in [0.0_f64, 17.0, 45.0, 90.0, 133.0] {
        for shift in [0.0, 0.3, 1.0, 2.7] {
            let angle = degrees.to_radians();
            let error = ridge_position(&line(angle, 0.0), &line(angle, shift), RidgeSettings::default()).unwrap();
            // The second-order polynomial of a Gaussian is not the Gaussian: a few hundredths of a texel.
            assert!((error.mean - shift).abs() < 0.05, "{degrees} degrees, {shift}: {error:?}");
            assert!((error.p95 - shift).abs() < 0.15, "{degrees} degrees, {shift}: {error:?}");
            assert!(error.points >= 50, "{error:?}");
            assert!(error.missed < 0.05, "{error:?}");
        }
    }
}

#[test]
fn the_ridge_of_a_gaussian_line_is_exact() {
    // The logarithm of a Gaussian is a parabola; a parabola through the Gaussian itself would be 0.03 texels off.
    let line = |at: f64| map([64, 32], 1.0, |x, _| gaussian(x - at, 1.2));
    for shift in [0.1, 0.25, 0.4, 0.5] {
        let error = ridge_position(&line(31.5), &line(31.5 + shift), RidgeSettings::default()).unwrap();
        assert!((error.mean - shift).abs() < 3e-3, "{shift}: {error:?}");
    }
}

#[test]
fn the_ridge_of_a_ring_moves_with_its_radius() {
    let ring = |radius: f64| map([96, 96], 1.0, |x, y| gaussian((x - 48.0).hypot(y - 48.0) - radius, 1.0));
    let error = ridge_position(&ring(30.0), &ring(31.5), RidgeSettings::default()).unwrap();
    assert!((error.mean - 1.5).abs() < 0.05, "{error:?}");
    assert_eq!(error.missed, 0.0);
}

#[test]
fn a_map_has_its_own_ridges() {
    // Waves that cross: ridges that bend, end and meet, many of them on the border between texels.
    let waves = map([80, 80], 1.0, |x, y| (1.0 + (0.4 * x).sin() * (0.31 * y + 0.2 * x).cos()).powi(3));
    let error = ridge_position(&waves, &waves, RidgeSettings::default()).unwrap();
    assert!(error.points > 100 && error.missed == 0.0, "{error:?}");
    assert_eq!((error.mean, error.p95), (0.0, 0.0));
}

#[test]
fn a_fold_and_its_brightness_do_not_matter_its_place_does() {
    // The light of a fold: 1 / sqrt(distance) on one side (averaged over a texel), nothing on the other.
    let fold = |at: f64, power: f64| {
        let above = |x: f64| (x - at).max(0.0).sqrt();
        map([64, 32], 1.0, move |x, _| power * 2.0 * (above(x + 0.5) - above(x - 0.5)) * gaussian(x - at, 12.0))
    };
    let settings = RidgeSettings { flux_share: 0.6, ..RidgeSettings::default() };
    let same = ridge_position(&fold(30.2, 1.0), &fold(30.2, 7.0), settings).unwrap();
    assert!(same.mean < 1e-9 && same.missed == 0.0, "{same:?}");
    let moved = ridge_position(&fold(30.2, 1.0), &fold(31.2, 1.0), settings).unwrap();
    assert!((moved.mean - 1.0).abs() < 0.02, "{moved:?}");
}

#[test]
fn a_ridge_out_of_reach_is_missed() {
    let error = ridge_position(&line(0.0, 0.0), &line(0.0, 12.0), RidgeSettings::default()).unwrap();
    assert_eq!(error.missed, 1.0);
    assert!(error.mean.is_nan());
    let flat = map([64, 64], 1.0, |_, _| 1.0).cropped([0, 0], [64, 64]).unwrap();
    assert_eq!(ridge_position(&line(0.0, 0.0), &flat, RidgeSettings::default()).unwrap().missed, 1.0);
}

#[test]
fn noise_makes_few_ridges() {
    // A plateau with 5 % noise has no ridge: an error against it would mean nothing.
    let noise = |x: f64, y: f64| ((x * 12.9898 + y * 78.233).sin() * 43758.5453).fract();
    let plateau = map([64, 64], 1.0, |x, y| 1.0 + 0.05 * noise(x, y)).cropped([8, 8], [48, 48]).unwrap();
    assert!(matches!(ridge_position(&plateau, &plateau, RidgeSettings::default()), Err(MetricsError::NoRidge)));
}

#[test]
fn wrong_input_is_refused() {
    let (a, dark) = (map([4, 4], 1.0, |_, _| 1.0), map([4, 4], 1.0, |_, _| 0.0));
    let wide = map([5, 4], 1.0, |_, _| 1.0);
    assert!(matches!(relative_l1(&a, &wide), Err(MetricsError::Size { .. })));
    assert!(matches!(relative_l2(&a, &wide), Err(MetricsError::Size { .. })));
    assert!(matches!(ridge_position(&a, &wide, RidgeSettings::default()), Err(MetricsError::Size { .. })));
    for refused in [energy_ratio(&dark, &a), relative_l1(&dark, &a), encircled_energy_radius(&dark, 0.5, None)] {
        assert!(matches!(refused, Err(MetricsError::Dark { .. })));
    }
    assert!(matches!(encircled_energy_radius(&a, 1.5, None), Err(MetricsError::Range { .. })));
    assert!(matches!(encircled_energy_radius(&a, 0.5, Some([f64::NAN, 0.0])), Err(MetricsError::Range { .. })));
    for scale in [0.0, 1e9, f64::NAN] {
        let settings = RidgeSettings { scale, ..RidgeSettings::default() };
        assert!(matches!(ridge_position(&a, &a, settings), Err(MetricsError::Range { .. })));
    }
    let far = RidgeSettings { reach: f64::MAX, ..RidgeSettings::default() };
    assert_eq!(ridge_position(&line(0.0, 0.0), &line(0.0, 12.0), far).unwrap().missed, 0.0);
    assert!(matches!(IrradianceMap::new([2, 1], 1.0, vec![1.0, -1.0]), Err(MetricsError::Entry { index: 1, .. })));
    assert!(matches!(IrradianceMap::from_f32([1, 1], 1.0, &[f32::NAN]), Err(MetricsError::Entry { .. })));
    assert!(matches!(IrradianceMap::new([1, 1], 0.0, vec![1.0]), Err(MetricsError::Range { .. })));
    assert!(matches!(IrradianceMap::new([0, 1], 1.0, Vec::new()), Err(MetricsError::Empty { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A larger share of the flux needs no smaller circle, and scaling the light moves none.
    #[test]
    fn circles_grow_with_the_share(
        values in prop::collection::vec(0.0_f64..9.0, 30),
        shares in (0.05_f64..1.0, 0.05_f64..1.0),
        power in 0.01_f64..100.0,
    ) {
        prop_assume!(values.iter().sum::<f64>() > 0.1);
        let map = IrradianceMap::new([6, 5], 0.3, values.clone()).unwrap();
        let brighter = IrradianceMap::new([6, 5], 0.3, values.iter().map(|v| v * power).collect()).unwrap();
        let radius = |map: &IrradianceMap, share| encircled_energy_radius(map, share, Some([2.0, 3.1])).unwrap();
        let (low, high) = (shares.0.min(shares.1), shares.0.max(shares.1));
        prop_assert!(radius(&map, low) <= radius(&map, high) + 1e-12);
        prop_assert!((radius(&map, low) - radius(&brighter, low)).abs() < 1e-9);
    }
}
