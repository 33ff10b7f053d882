//! Errors of pictures against values known by hand or measured by other programs.

use murano_metrics::{
    MetricsError,
    images::{DEFAULT_PIXELS_PER_DEGREE, Picture, flicker, flicker_against, flip, rmse, ssim},
};
use proptest::prelude::*;

const PPD: f32 = DEFAULT_PIXELS_PER_DEGREE;

fn picture(size: [u32; 2], pixel: impl Fn(u32, u32) -> [u8; 3]) -> Picture {
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    Picture::new(size, pixels).expect("one entry a pixel")
}

fn uniform(rgb: [u8; 3]) -> Picture {
    picture([32, 32], |_, _| rgb)
}

/// Ramps of three kinds, and the same with a regular disturbance of at most 11 levels.
fn pair() -> [Picture; 2] {
    let ramps = |x: u32, y: u32| [x * 4, y * 5, (x * x + 3 * y * y) / 8].map(|v| (v % 256) as u8);
    let disturbed =
        |x: u32, y: u32| ramps(x, y).map(|v| (i32::from(v) + ((x * 7 + y * 13) % 23) as i32 - 11).clamp(0, 255) as u8);
    [picture([64, 48], ramps), picture([64, 48], disturbed)]
}

#[test]
fn equal_pictures_have_no_error() {
    let [a, _] = pair();
    assert_eq!(rmse(&a, &a).unwrap(), 0.0);
    assert!((ssim(&a, &a).unwrap() - 1.0).abs() < 1e-12);
    let map = flip(&a, &a, PPD).unwrap();
    assert_eq!(map.mean, 0.0);
    assert_eq!(map.map, vec![0.0; 64 * 48]);
}

#[test]
fn rmse_of_uniform_pictures_is_their_difference() {
    assert_eq!(rmse(&uniform([0; 3]), &uniform([255; 3])).unwrap(), 1.0);
    // One of three channels off by 51/255 = 0.2.
    let found = rmse(&uniform([0; 3]), &uniform([51, 0, 0])).unwrap();
    assert!((found - 0.2 / 3.0_f64.sqrt()).abs() < 1e-15, "{found}");
}

#[test]
fn ssim_of_uniform_pictures_is_the_luminance_term() {
    // (2 a b + C1) / (a^2 + b^2 + C1), as neither varies; C1 = 1e-4.
    let (a, b) = (0.2, 0.6);
    let expected = (2.0 * a * b + 1e-4) / (a * a + b * b + 1e-4);
    let found = ssim(&uniform([51; 3]), &uniform([153; 3])).unwrap();
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
}

/// scikit-image 0.26: `structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
/// data_range=1)` of the Rec.709 lumas; NumPy; NVIDIA's own `flip-evaluator`, which sums in f32 in another order.
#[test]
fn other_programs_agree() {
    let [a, b] = pair();
    let found = ssim(&a, &b).unwrap();
    assert!((found - 0.7775896173588766).abs() < 1e-12, "ssim {found}");
    let found = rmse(&a, &b).unwrap();
    assert!((found - 0.025694769161575464).abs() < 1e-15, "rmse {found}");
    let found = flip(&a, &b, PPD).unwrap().mean;
    assert!((found - 0.0288925189524889).abs() < 1e-4, "flip {found}");
    for (a, b, expected) in [([0; 3], [255; 3], 0.9673951268196106), ([255, 0, 0], [0, 255, 0], 0.986678957939148)] {
        let found = flip(&uniform(a), &uniform(b), PPD).unwrap().mean;
        assert!((found - expected).abs() < 1e-4, "flip of {a:?} and {b:?}: {found}");
    }
}

#[test]
fn flip_sees_a_small_spot_where_it_is() {
    let a = uniform([128; 3]);
    let b = picture([32, 32], |x, y| if x == 20 && y == 9 { [255; 3] } else { [128; 3] });
    let map = flip(&a, &b, PPD).unwrap();
    let brightest = (0..map.map.len()).max_by(|&i, &j| map.map[i].total_cmp(&map.map[j])).unwrap();
    assert_eq!((brightest % 32, brightest / 32), (20, 9));
    // The same spot in a picture half as fine spreads over more of what the viewer sees.
    assert!(flip(&a, &b, PPD / 2.0).unwrap().mean != map.mean);
}

#[test]
fn linear_radiance_is_clamped_and_encoded() {
    let shown = Picture::from_linear([2, 1], &[[0.5, 0.0, 8.0], [0.107, 0.001, -1.0]], 2.0).unwrap();
    // 2 x 0.5 is white; 0.214 encodes to 0.5; 0.002 lies on the linear part, 12.92 x 0.002 x 255 = 6.6.
    assert_eq!(shown.rgb(), [[255, 0, 255], [127, 7, 0]]);
    let broken = Picture::from_linear([1, 1], &[[0.0, f32::NAN, 0.0]], 1.0).unwrap_err();
    assert!(matches!(broken, MetricsError::Entry { index: 0, .. }));
    assert!(matches!(Picture::from_linear([1, 1], &[[0.0; 3]], 0.0), Err(MetricsError::Range { .. })));
}

#[test]
fn rgba_loses_its_alpha() {
    let shown = Picture::from_rgba8([2, 1], &[1, 2, 3, 255, 4, 5, 6, 0]).unwrap();
    assert_eq!(shown.rgb(), [[1, 2, 3], [4, 5, 6]]);
    assert!(Picture::from_rgba8([2, 1], &[0; 7]).is_err());
}

#[test]
fn a_png_holds_the_pixels() {
    let [a, _] = pair();
    let file = a.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (64, 48, png::ColorType::Rgb));
    assert_eq!(bytes, a.rgb().as_flattened());
}

#[test]
fn flicker_is_change_between_frames() {
    let still = vec![uniform([40; 3]); 4];
    let steady = flicker(&still, PPD).unwrap();
    assert_eq!((steady.mean, steady.max, steady.pairs.len()), (0.0, 0.0, 3));

    let mut blinking = still.clone();
    blinking[2] = uniform([200; 3]);
    let found = flicker(&blinking, PPD).unwrap();
    let step = flip(&still[0], &blinking[2], PPD).unwrap().mean;
    assert_eq!(found.max, step);
    // FLIP is symmetric: into the blink and out of it are two equal steps of three pairs.
    assert!((found.mean - 2.0 * step / 3.0).abs() < 1e-6);
}

#[test]
fn flicker_against_the_truth_forgives_motion_and_steady_error() {
    let truth: Vec<_> =
        (0..3).map(|t| picture([32, 32], |x, _| if x < 8 + 4 * t { [220; 3] } else { [30; 3] })).collect();
    let own = flicker_against(&truth, &truth, PPD).unwrap();
    assert!(own.truth.mean > 0.0);
    assert_eq!((own.excess.mean, own.excess.max), (0.0, 0.0));

    let mut flickering = truth.clone();
    flickering[1] = uniform([120; 3]);
    let found = flicker_against(&truth, &flickering, PPD).unwrap();
    assert!(found.excess.max > 0.1, "{found:?}");
    assert_eq!(found.truth, own.truth);

    let dark = vec![uniform([0; 3]); 3];
    assert_eq!(flicker_against(&truth, &dark, PPD).unwrap().excess.max, 0.0);
}

#[test]
fn wrong_input_is_refused() {
    let (a, b) = (uniform([0; 3]), picture([31, 32], |_, _| [0; 3]));
    assert!(matches!(rmse(&a, &b), Err(MetricsError::Size { .. })));
    assert!(matches!(ssim(&a, &b), Err(MetricsError::Size { .. })));
    assert!(matches!(flip(&a, &b, PPD), Err(MetricsError::Size { .. })));
    assert!(matches!(flip(&a, &a, f32::NAN), Err(MetricsError::Range { .. })));
    assert!(matches!(flicker(std::slice::from_ref(&a), PPD), Err(MetricsError::Empty { least: 2, .. })));
    let sequences = flicker_against([&a, &a, &a], [&a], PPD);
    assert!(matches!(sequences, Err(MetricsError::Length { expected: 3, found: 1, .. })));
    assert!(matches!(flicker_against([&a, &a], [&a, &b], PPD), Err(MetricsError::Size { .. })));
    assert!(matches!(Picture::new([0, 3], Vec::new()), Err(MetricsError::Unfit { .. })));
    assert!(matches!(Picture::new([2, 2], vec![[0; 3]; 3]), Err(MetricsError::Length { .. })));
    let small = picture([10, 40], |_, _| [0; 3]);
    assert!(matches!(ssim(&small, &small), Err(MetricsError::Unfit { .. })));
    // FLIP has no least size.
    let pixel = picture([1, 1], |_, _| [9; 3]);
    assert_eq!(flip(&pixel, &pixel, PPD).unwrap().mean, 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// Errors are bounded and do not depend on which picture is called the truth.
    #[test]
    fn errors_are_bounded_and_symmetric(bytes in prop::collection::vec(any::<u8>(), 2 * 13 * 12 * 4)) {
        let (first, second) = bytes.split_at(13 * 12 * 4);
        let (a, b) = (Picture::from_rgba8([13, 12], first).unwrap(), Picture::from_rgba8([13, 12], second).unwrap());
        prop_assert_eq!(rmse(&a, &b).unwrap(), rmse(&b, &a).unwrap());
        prop_assert!((0.0..=1.0).contains(&rmse(&a, &b).unwrap()));
        let (there, back) = (ssim(&a, &b).unwrap(), ssim(&b, &a).unwrap());
        prop_assert!((there - back).abs() < 1e-12 && (-1.0..=1.0).contains(&there));
        let map = flip(&a, &b, PPD).unwrap();
        prop_assert!(map.map.iter().all(|value| (0.0..=1.0).contains(value)));
    }
}
