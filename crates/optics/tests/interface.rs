//! Snell and Fresnel against what must hold whatever the code says: reversibility, energy, known values.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use murano_optics::{
    Ior, critical_clamp, fresnel_dielectric, fresnel_unpolarised, pair_transmittance, reflected, snell,
};
use proptest::prelude::*;

/// A unit vector, spread evenly over the sphere.
fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..=1.0, 0.0..std::f64::consts::TAU).prop_map(|(z, phi): (f64, f64)| {
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
    })
}

/// A normal and a direction towards it.
fn incidence() -> impl Strategy<Value = (DVec3, DVec3)> {
    (unit(), unit()).prop_map(|(i, n)| if i.dot(n) > 0.0 { (i, -n) } else { (i, n) })
}

/// Reflected and transmitted flux from the amplitudes of the electric field (Hecht, Optics, section 4.6).
fn fluxes_from_amplitudes(theta_i: f64, theta_t: f64, n_i: f64, n_t: f64) -> (DVec2, DVec2) {
    let (cos_i, cos_t) = (theta_i.cos(), theta_t.cos());
    let across = n_i * cos_i + n_t * cos_t;
    let along = n_t * cos_i + n_i * cos_t;
    let reflected = DVec2::new((n_i * cos_i - n_t * cos_t) / across, (n_t * cos_i - n_i * cos_t) / along);
    let transmitted = DVec2::new(2.0 * n_i * cos_i / across, 2.0 * n_i * cos_i / along);
    (reflected * reflected, transmitted * transmitted * (n_t * cos_t) / (n_i * cos_i))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn snells_law_holds((i, n) in incidence(), eta in 0.25f64..4.0) {
        let refracted = snell(i, n, eta);
        let sin_i = i.cross(n).length();
        prop_assert!((refracted.direction.length() - 1.0).abs() < 1e-12);
        prop_assert!(refracted.direction.dot(i.cross(n)).abs() < 1e-12, "leaves the plane of incidence");
        if refracted.tir {
            prop_assert!(eta * sin_i > 1.0 - 1e-12);
            prop_assert!((refracted.direction.dot(n) + i.dot(n)).abs() < 1e-12);
            prop_assert_eq!(refracted.cos_t, 0.0);
        } else {
            prop_assert!((refracted.direction.cross(n).length() - eta * sin_i).abs() < 1e-12);
            prop_assert!((refracted.direction.dot(n) + refracted.cos_t).abs() < 1e-12);
        }
    }

    #[test]
    fn light_retraces_its_path((i, n) in incidence(), eta in 0.25f64..4.0) {
        let there = snell(i, n, eta);
        if !there.tir && there.cos_t > 1e-3 {
            let back = snell(-there.direction, -n, 1.0 / eta);
            prop_assert!(back.tir || back.direction.abs_diff_eq(-i, 1e-6));
            prop_assert!(!back.tir || i.dot(n) > -1e-6, "only a grazing ray may fail to come back");
        }
        prop_assert!(reflected(reflected(i, n), n).abs_diff_eq(i, 1e-12));
    }

    #[test]
    fn equal_media_change_nothing((i, n) in incidence()) {
        let refracted = snell(i, n, 1.0);
        prop_assert!(!refracted.tir && refracted.direction.abs_diff_eq(i, 1e-12));
        prop_assert!(fresnel_unpolarised(-i.dot(n), 1.0) < 1e-20);
    }

    #[test]
    fn energy_is_kept(theta_i in 0.0..FRAC_PI_2, n in 1.0f64..4.0) {
        let theta_t = (theta_i.sin() / n).asin();
        for (theta_i, theta_t, n_i, n_t) in [(theta_i, theta_t, 1.0, n), (theta_t, theta_i, n, 1.0)] {
            let (reflected, transmitted) = fluxes_from_amplitudes(theta_i, theta_t, n_i, n_t);
            prop_assert!((reflected + transmitted).abs_diff_eq(DVec2::ONE, 1e-9));
            prop_assert!(fresnel_dielectric(theta_i.cos(), n_i / n_t).abs_diff_eq(reflected, 1e-6));
        }
    }

    #[test]
    fn reflectance_is_a_fraction_and_total_beyond_the_critical_angle(cos_i in -0.5f64..1.5, eta in 0.25f64..4.0) {
        let reflectance = fresnel_dielectric(cos_i, eta);
        prop_assert!(reflectance.min_element() >= 0.0 && reflectance.max_element() <= 1.0);
        let c = cos_i.clamp(0.0, 1.0);
        let beyond = eta * (1.0 - c * c).sqrt() > 1.0 + 1e-9;
        prop_assert!(!beyond || reflectance == DVec2::ONE);
    }

    #[test]
    fn the_critical_clamp_is_continuous_and_on_the_surface((i, n) in incidence(), eta in 1.01f64..4.0) {
        let clamped = critical_clamp(i, n, eta);
        prop_assert!((clamped.length() - 1.0).abs() < 1e-12);
        let refracted = snell(i, n, eta);
        if refracted.tir {
            prop_assert!(clamped.dot(n).abs() < 1e-12);
            let tangent = (i - i.dot(n) * n).normalize();
            let at_critical = tangent / eta - n * (1.0 - 1.0 / (eta * eta)).sqrt() * (1.0 + 1e-12);
            prop_assert!(snell(at_critical, n, eta).direction.abs_diff_eq(clamped, 1e-4));
        } else {
            prop_assert_eq!(clamped, refracted.direction);
        }
    }
}

#[test]
fn known_values() {
    // Hecht, Optics: glass of n = 1.5.
    assert!((fresnel_unpolarised(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
    assert!((fresnel_unpolarised(1.0, 1.5) - 0.04).abs() < 1e-15);
    assert!(fresnel_dielectric(0.5, 1.0 / 1.5).abs_diff_eq(DVec2::new(0.176_572, 0.001_802), 1e-6));
    for n in [1.33, 1.5, 2.5, 4.0].map(|n| Ior::new(n).expect("legal")) {
        assert!(fresnel_dielectric(n.brewster_angle().cos(), n.eta_entering()).y < 1e-30);
        assert_eq!(fresnel_dielectric(0.0, n.eta_entering()), DVec2::ONE);
        let just_beyond = n.critical_angle() + 1e-9;
        assert_eq!(fresnel_dielectric(just_beyond.cos(), n.eta_leaving()), DVec2::ONE);
    }
}

#[test]
fn the_pair_knows_that_the_first_interface_polarises() {
    let brewster = fresnel_dielectric(Ior::GLASS.brewster_angle().cos(), Ior::GLASS.eta_entering());
    // Along the plane all passes both interfaces; across it, what is left after each.
    let expected = 0.5 * (1.0 + (1.0 - brewster.x).powi(2));
    assert!((pair_transmittance(brewster, brewster) - expected).abs() < 1e-15);
    let naive = (1.0 - 0.5 * brewster.x).powi(2);
    assert!(pair_transmittance(brewster, brewster) > naive);
    assert_eq!(pair_transmittance(DVec2::ZERO, DVec2::ZERO), 1.0);
    assert_eq!(pair_transmittance(DVec2::ONE, DVec2::ZERO), 0.0);
}

#[test]
fn hostile_inputs_give_unit_directions() {
    let grazing = [0.0, 1e-300, 1e-160, 1e-16, 1e-8].map(|c: f64| DVec3::new((1.0 - c * c).sqrt(), 0.0, -c));
    let facing_away = [1e-300, 1e-9, 0.1, 0.7, 1.0].map(|c: f64| DVec3::new((1.0 - c * c).sqrt(), 0.0, c));
    let parallel = [DVec3::NEG_Z, DVec3::NEG_Z * (1.0 + 1e-15)];
    for i in grazing.into_iter().chain(facing_away).chain(parallel) {
        for n in [1.0, 1.0 + 1e-15, 1.5, 2.5, 4.0] {
            for eta in [n, 1.0 / n] {
                let refracted = snell(i, DVec3::Z, eta);
                assert!((refracted.direction.length() - 1.0).abs() < 1e-12, "{i} {eta}: {refracted:?}");
                assert!((0.0..=1.0).contains(&refracted.cos_t));
                assert!((critical_clamp(i, DVec3::Z, eta).length() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_normal_that_faces_away_does_not_turn_light_back() {
    for cos in [1e-6, 0.05, 0.3] {
        let i = DVec3::new((1.0f64 - cos * cos).sqrt(), 0.0, cos);
        let refracted = snell(i, DVec3::Z, 1.0 / 1.5);
        let grazing = snell(DVec3::X, DVec3::Z, 1.0 / 1.5);
        assert!(refracted.direction.z < 0.0 && refracted.direction.x > 0.0);
        assert!(refracted.direction.angle_between(grazing.direction) < cos);
    }
}

#[test]
fn zero_vectors_pass() {
    for eta in [0.5, 1.0, 1.5] {
        for (i, n) in [(DVec3::ZERO, DVec3::Z), (DVec3::X, DVec3::ZERO), (DVec3::ZERO, DVec3::ZERO)] {
            let refracted = snell(i, n, eta);
            assert_eq!((refracted.direction, refracted.tir), (i, false));
            assert_eq!(critical_clamp(i, n, eta), i);
        }
    }
}
