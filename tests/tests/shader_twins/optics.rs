//! `lib::optics` against the functions of the same names in murano_optics.

use glam::{DVec2, DVec3, Vec3, Vec4};
use murano_optics as twin;

use crate::{
    SLACK, U,
    harness::{Random, assert_close, assert_finite, assert_near, run, xyz},
};

const ROOT: &str = "tests::optics";

/// Equal media, nearly equal ones, water, glass, diamond, and what KHR_materials_ior allows at most in practice; into
/// the medium and out of it.
const ETAS: [f32; 14] =
    [1.0, 1.000_001, 0.999_999, 1.33, 0.751_879_7, 1.5, 0.666_666_7, 2.0, 0.5, 2.5, 0.4, 4.0, 0.25, 1.1];

/// Cosines of incidence: head-on, ordinary, grazing, parallel, from behind.
const COSINES: [f32; 12] = [1.0, 0.999_999_9, 0.9, 0.5, 0.1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 0.0, -0.3];

/// An interface and a direction that meets it at an angle whose cosine is close to `cos_i`.
fn meeting(random: &mut Random, cos_i: f32) -> (Vec3, Vec3) {
    let n = random.direction();
    let along = n.any_orthonormal_vector();
    ((along * (1.0 - cos_i * cos_i).max(0.0).sqrt() - n * cos_i).normalize(), n)
}

fn interfaces() -> Vec<[Vec4; 2]> {
    let mut random = Random(1);
    let mut cases = Vec::new();
    for eta in ETAS {
        for cos_i in COSINES {
            for _ in 0..8 {
                let (i, n) = meeting(&mut random, cos_i);
                cases.push([i.extend(eta), n.extend(cos_i)]);
            }
        }
        let critical = (1.0 - (eta * eta).recip()).max(0.0).sqrt();
        for offset in [-1e-3, -1e-5, -1e-7, 0.0, 1e-7, 1e-5, 1e-3] {
            let (i, n) = meeting(&mut random, critical + offset);
            cases.push([i.extend(eta), n.extend(critical + offset)]);
        }
        for (i, n) in [
            (Vec3::ZERO, Vec3::Y),
            (Vec3::X, Vec3::ZERO),
            (Vec3::ZERO, Vec3::ZERO),
            (Vec3::X, Vec3::X),
            (Vec3::X, -Vec3::X),
            (Vec3::X, Vec3::Y),
            (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.6, 0.0, 0.8)),
        ] {
            cases.push([i.extend(eta), n.extend(0.5)]);
        }
    }
    for _ in 0..10_000 {
        let (i, n) = (random.direction(), random.direction());
        cases.push([i.extend(random.between(0.25, 4.0)), n.extend(random.between(0.0, 1.0))]);
    }
    cases
}

/// The square of the cosine of refraction, and how far off f32 may find it if its cosine of incidence is off by `error`.
fn cos_t_squared(cos_i: f64, eta: f64, error: f64) -> (f64, f64) {
    let (media, angle) = (1.0 - eta * eta, (eta * cos_i).powi(2));
    let k = media + angle;
    (k, SLACK * (2.0 * eta * eta * cos_i * error + U * (3.0 * media.abs() + 4.0 * angle + k.abs())))
}

/// How far off the root of a number may be that is itself off by `error`.
fn root_error(k: f64, error: f64) -> f64 {
    let k = k.max(0.0);
    (k + error).sqrt() - (k - error).max(0.0).sqrt() + 4.0 * U * k.sqrt()
}

#[test]
fn directions_obey_snell_as_in_f64() {
    let cases = interfaces();
    let outputs = run(ROOT, "interface_laws", cases.as_flattened(), cases.len(), 4);
    let mut worst = 0.0_f64;
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, input, output);
        let (i, n, eta) = (xyz(input[0]), xyz(input[1]), f64::from(input[0].w));
        let what = || format!("case {index}, i = {i}, n = {n}, eta = {eta}");
        assert_close(xyz(output[2]), twin::reflected(i, n), SLACK * 8.0 * U, what);
        let cos_i = (-i.dot(n)).clamp(0.0, 1.0);
        let (k, k_error) = cos_t_squared(cos_i, eta, 3.0 * U);
        let truth = twin::snell(i, n, eta);
        let tir = output[1].w == 1.0;
        if i == DVec3::ZERO || n == DVec3::ZERO {
            assert_eq!((xyz(output[0]), xyz(output[1]), tir), (i, i, false), "{}", what());
            continue;
        }
        for row in [0, 1] {
            assert_near(xyz(output[row]).length(), 1.0, SLACK * 6.0 * U, what);
        }
        // Before it is made unit; short only where a ray leaves along the normal between nearly equal media.
        let length = (eta * (i - i.dot(n) * n) - truth.cos_t * n).length();
        let root = root_error(k, k_error);
        let tolerance = (SLACK * U * (8.0 * eta + 8.0) + root) / length.max(1e-300);
        // The clamp is continuous where total reflection sets in.
        if tolerance < 0.5 {
            assert_close(xyz(output[1]), twin::critical_clamp(i, n, eta), 2.0 * tolerance + root, what);
        }
        if tir != truth.tir {
            assert!(k.abs() <= k_error, "{}: total reflection at k = {k:e}", what());
            continue;
        }
        assert_near(f64::from(output[0].w), truth.cos_t, if tir { 0.0 } else { root + 4.0 * U }, what);
        if truth.tir {
            assert_close(xyz(output[0]), truth.direction, SLACK * 8.0 * U, what);
        } else if tolerance < 0.5 {
            assert_close(xyz(output[0]), truth.direction, tolerance, what);
            if k > 0.01 {
                worst = worst.max(xyz(output[0]).distance(truth.direction));
            }
        }
    }
    // Well away from the critical angle nothing is amplified: a bound that needs no analysis.
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn reflectances_are_fresnels_as_in_f64() {
    let cases = interfaces();
    let outputs = run(ROOT, "interface_laws", cases.as_flattened(), cases.len(), 4);
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        let (eta, cos_i) = (f64::from(input[0].w), f64::from(input[1].w));
        let what = || format!("case {index}, cos_i = {cos_i}, eta = {eta}");
        let c = cos_i.clamp(0.0, 1.0);
        let (k, k_error) = cos_t_squared(c, eta, 0.0);
        let root = root_error(k, k_error);
        let cos_t = k.max(0.0).sqrt();
        let truth = twin::fresnel_dielectric(cos_i, eta);
        // An amplitude is a ratio at most 1, so its square is off by twice the amplitude's error.
        let error = |denominator: f64| 2.0 * ((1.0 + eta) * root / denominator.max(1e-300) + SLACK * 6.0 * U).min(1.0);
        let [across, along] = [error(eta * c + cos_t), error(c + eta * cos_t)];
        assert_near(f64::from(output[3].x), truth.x, across, what);
        assert_near(f64::from(output[3].y), truth.y, along, what);
        assert_near(f64::from(output[2].w), twin::fresnel_unpolarised(cos_i, eta), across.max(along), what);
        assert!((0.0..=1.0 + 1e-6).contains(&output[3].x) && (0.0..=1.0 + 1e-6).contains(&output[3].y), "{}", what());
        let [first, second] = [input[0], input[1]].map(|row| DVec2::new(row.x.abs().into(), row.y.abs().into()));
        assert_near(f64::from(output[3].z), twin::pair_transmittance(first, second), SLACK * 4.0 * U, what);
    }
}

#[test]
fn absorption_is_beer_lamberts_as_in_f64() {
    let mut random = Random(2);
    let mut cases = Vec::new();
    for sigma in [0.0, 1e-6, 1.0, 87.3, 1e6, 1e9] {
        for length in [0.0, -1.0, 1e-6, 0.5, 1.0, 1e6] {
            cases.push(Vec3::new(sigma, 0.0, 1.0).extend(length));
        }
    }
    for _ in 0..10_000 {
        let sigma = Vec3::from_array(std::array::from_fn(|_| random.magnitude(1e-6, 1e6)));
        cases.push(sigma.extend(random.magnitude(1e-6, 1e6)));
    }
    let outputs = run(ROOT, "absorption", &cases, cases.len(), 1);
    for (index, (input, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, &[*input], output);
        let truth = twin::beer_lambert(xyz(*input), f64::from(input.w));
        for channel in 0..3 {
            // WGSL allows exp 3 + 2 |x| units; below the smallest normal number there may be nothing.
            let depth = f64::from(input[channel]) * f64::from(input.w).max(0.0);
            let tolerance = SLACK * U * (6.0 + 6.0 * depth.min(1e4)) * truth[channel] + 1.2e-38;
            assert_near(f64::from(output[0][channel]), truth[channel], tolerance, || format!("case {index}, {input}"));
        }
    }
}

#[test]
fn directions_survive_octahedral_packing_as_in_f64() {
    let mut random = Random(3);
    let mut cases = Vec::new();
    for x in [-1.0, -1e-6, -0.0, 0.0, 1e-6, 1.0] {
        for y in [-1.0, -1e-6, -0.0, 0.0, 1e-6, 1.0] {
            cases.extend([-1.0, -1e-6, -0.0, 0.0, 1e-6, 1.0].map(|z| Vec3::new(x, y, z)));
        }
    }
    cases.extend((0..10_000).map(|_| random.direction()));
    // A direction's length does not matter.
    cases.extend((0..1_000).map(|_| random.direction() * random.magnitude(1e-6, 1e6)));
    let inputs: Vec<Vec4> = cases.iter().map(|direction| direction.extend(0.0)).collect();
    let outputs = run(ROOT, "octahedral", &inputs, inputs.len(), 2);
    for (index, (direction, output)) in cases.iter().zip(&outputs).enumerate() {
        assert_finite(index, &[inputs[index]], output);
        let direction = direction.as_dvec3();
        let wanted = direction.normalize_or(DVec3::Z);
        let angle = xyz(output[0]).cross(wanted).length();
        assert!(
            angle < 6.5e-5 && xyz(output[0]).dot(wanted) > 0.0,
            "case {index}, {direction}: off by {angle} radians"
        );
        assert_near(xyz(output[0]).length(), 1.0, SLACK * 4.0 * U, || format!("case {index}, {direction}"));
        // Both round to nearest; they differ by a unit at most, where the f32 quotient falls on the other side.
        let packed = twin::octahedral_pack(direction);
        if direction.abs().min_element() > 1e-3 * direction.length() {
            for (half, bits) in [(output[1].x, packed & 0xffff), (output[1].y, packed >> 16)] {
                let [found, wanted] = [half as u32, bits].map(|bits| i32::from(bits as u16 as i16));
                assert!((found - wanted).abs() <= 1, "case {index}, {direction}: {found}, not {wanted}");
            }
        }
        let unpacked = output[1].x as u32 | (output[1].y as u32) << 16;
        let again = twin::octahedral_unpack(unpacked);
        assert_close(xyz(output[0]), again, SLACK * 4.0 * U, || format!("case {index}, {unpacked:#x}"));
    }
}
