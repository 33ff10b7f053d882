//! The closed forms against each other, against step-by-step refraction, and against identities of geometrical optics.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use murano_optics::{
    Ior,
    analytic::{BallLens, Ellipsoid, Passage, Prism, Slab, Sphere, ThickLens},
    snell,
};
use proptest::prelude::*;

fn ior(n: f64) -> Ior {
    Ior::new(n).expect("a legal index")
}

/// A unit vector, spread evenly over the sphere.
fn unit() -> impl Strategy<Value = DVec3> {
    (-1.0..=1.0, 0.0..TAU).prop_map(|(z, phi): (f64, f64)| {
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * phi.cos(), radius * phi.sin(), z)
    })
}

/// A ray from outside that meets the unit sphere, up to grazing.
fn ray() -> impl Strategy<Value = (DVec3, DVec3)> {
    (unit(), unit(), 0.0..0.999_999).prop_map(|(towards, direction, offset): (DVec3, DVec3, f64)| {
        let across = (towards - towards.dot(direction) * direction).normalize_or(direction.any_orthonormal_vector());
        (across * offset - direction * 3.0, direction)
    })
}

/// Checks a passage against Snell's law at both interfaces.
fn obeys_snell(passage: &Passage, direction: DVec3, ior: Ior, tolerance: f64) {
    let inside = snell(direction, passage.entry_normal, ior.eta_entering());
    assert!(inside.direction.abs_diff_eq(passage.inside, tolerance), "{} {}", inside.direction, passage.inside);
    assert!((passage.exit - passage.entry).normalize_or(passage.inside).abs_diff_eq(passage.inside, tolerance));
    let leaving = snell(passage.inside, -passage.exit_normal, ior.eta_leaving());
    assert_eq!(leaving.tir, passage.leaving.tir);
    // The square root at the second interface takes half of the digits near its critical angle.
    assert!(leaving.direction.abs_diff_eq(passage.leaving.direction, tolerance.sqrt()));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_sphere_obeys_snell_and_is_a_round_ellipsoid((origin, direction) in ray(), n in 1.0f64..4.0, radius in 0.1f64..10.0) {
        let sphere = Sphere { radius, ior: ior(n) };
        let round = Ellipsoid { semi_axes: DVec3::splat(radius), ior: ior(n) };
        let passage = sphere.passage(origin * radius, direction).expect("hits");
        let other = round.passage(origin * radius, direction).expect("hits");
        obeys_snell(&passage, direction, ior(n), 1e-9);
        prop_assert!(passage.entry.abs_diff_eq(other.entry, 1e-8 * radius));
        prop_assert!(passage.exit.abs_diff_eq(other.exit, 1e-8 * radius));
        prop_assert!((passage.exit.length() / radius - 1.0).abs() < 1e-9);
        let cos_t = -passage.inside.dot(passage.entry_normal);
        prop_assert!((passage.path_length() - 2.0 * radius * cos_t).abs() < 1e-9 * radius);
        let turned = passage.leaving.direction.angle_between(direction);
        let offset = origin.cross(direction).length() * radius;
        prop_assert!((turned - sphere.deviation(offset)).abs() < 1e-7);
    }

    #[test]
    fn the_ellipsoid_obeys_snell_and_light_retraces_its_path(
        (origin, direction) in ray(), n in 1.0f64..4.0, axes in prop::array::uniform3(0.2f64..5.0),
    ) {
        let semi_axes = DVec3::from_array(axes);
        let body = Ellipsoid { semi_axes, ior: ior(n) };
        let (origin, direction) = (origin * semi_axes, (direction * semi_axes).normalize());
        let passage = body.passage(origin, direction).expect("hits");
        obeys_snell(&passage, direction, ior(n), 1e-9);
        prop_assert!(((passage.entry / semi_axes).length() - 1.0).abs() < 1e-9);
        prop_assert!(((passage.exit / semi_axes).length() - 1.0).abs() < 1e-9);
        if !passage.leaving.tir && passage.leaving.cos_t > 1e-2 {
            let start = passage.exit + passage.leaving.direction * 10.0;
            let back = body.passage(start, -passage.leaving.direction).expect("hits");
            prop_assert!(back.exit.abs_diff_eq(passage.entry, 1e-6));
            prop_assert!(back.leaving.direction.abs_diff_eq(-direction, 1e-4));
        }
    }

    #[test]
    fn the_slab_obeys_snell_and_shifts(incidence in 0.0f64..1.5, azimuth in 0.0..TAU, n in 1.0f64..4.0, thickness in 0.0f64..2.0) {
        let slab = Slab { thickness, ior: ior(n) };
        let direction = DVec3::new(incidence.sin() * azimuth.cos(), -incidence.cos(), incidence.sin() * azimuth.sin());
        let origin = DVec3::new(0.3, 2.0, -0.7);
        let passage = slab.passage(origin, direction).expect("hits");
        obeys_snell(&passage, direction, ior(n), 1e-9);
        let shift = (passage.exit - origin).cross(direction).length();
        prop_assert!((shift - slab.lateral_shift(incidence)).abs() < 1e-9);
        prop_assert!((passage.exit.y + thickness).abs() < 1e-9);
    }

    #[test]
    fn the_prism_turns_as_two_refractions_do(theta_i in -1.5f64..1.5, apex in 0.05f64..2.0, n in 1.0f64..4.0) {
        // Apex up, light from -x; face normals lean upwards by half of the apex angle.
        let (sin, cos) = (apex / 2.0).sin_cos();
        let (front, back) = (DVec3::new(-cos, sin, 0.0), DVec3::new(cos, sin, 0.0));
        let up = DVec3::new(sin, cos, 0.0);
        let direction = -front * theta_i.cos() + up * theta_i.sin();
        let inside = snell(direction, front, 1.0 / n);
        let leaving = snell(inside.direction, -back, n);
        let prism = Prism { apex, ior: ior(n) };
        let meets_the_back = inside.direction.dot(back) > 0.0;
        match prism.deviation(theta_i) {
            None => prop_assert!(!meets_the_back || leaving.tir),
            Some(deviation) => {
                prop_assert!(meets_the_back && !leaving.tir);
                prop_assert!((leaving.direction.angle_between(direction) - deviation).abs() < 1e-6);
                prop_assert!(prism.minimum_deviation().is_none_or(|least| deviation >= least - 1e-9));
            }
        }
    }
}

#[test]
fn n_of_one_changes_nothing() {
    let direction = DVec3::new(0.1, -0.9, 0.2).normalize();
    let origin = DVec3::new(0.05, 3.0, -0.5);
    let passages = [
        Sphere { radius: 1.0, ior: Ior::AIR }.passage(origin, direction),
        Ellipsoid { semi_axes: DVec3::new(1.0, 0.5, 2.0), ior: Ior::AIR }.passage(origin, direction),
        Slab { thickness: 0.4, ior: Ior::AIR }.passage(origin, direction),
    ];
    for passage in passages {
        let passage = passage.expect("hits");
        assert!(passage.leaving.direction.abs_diff_eq(direction, 1e-12));
        assert!((passage.exit - origin).cross(direction).length() < 1e-12);
    }
    assert!(Prism { apex: 1.0, ior: Ior::AIR }.deviation(0.3).expect("passes").abs() < 1e-12);
}

#[test]
fn rays_that_miss_or_start_inside_have_no_passage() {
    let sphere = Sphere { radius: 1.0, ior: Ior::GLASS };
    let ellipsoid = Ellipsoid { semi_axes: DVec3::new(1.0, 2.0, 3.0), ior: Ior::GLASS };
    let nan = DVec3::NAN;
    for (origin, direction) in [
        (DVec3::new(4.0, 0.0, -5.0), DVec3::Z),
        (DVec3::ZERO, DVec3::Z),
        (DVec3::new(0.0, 0.0, 5.0), DVec3::Z),
        (DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO),
        (nan, DVec3::Z),
        (DVec3::new(0.0, 0.0, 5.0), nan),
    ] {
        assert_eq!(sphere.passage(origin, direction), None);
        assert_eq!(ellipsoid.passage(origin, direction), None);
    }
    let slab = Slab { thickness: 1.0, ior: Ior::GLASS };
    assert_eq!(slab.passage(DVec3::Y, DVec3::X), None);
    assert_eq!(slab.passage(DVec3::NEG_Y, DVec3::NEG_Y), None);
    assert_eq!(slab.passage(DVec3::Y, nan), None);
}

#[test]
fn grazing_and_central_rays_are_finite_for_every_index() {
    for n in [1.0, 1.5, 2.5, 4.0].map(ior) {
        let bodies = (Sphere { radius: 1.0, ior: n }, Ellipsoid { semi_axes: DVec3::ONE, ior: n });
        for offset in [0.0, 1e-300, 1e-12, 1.0 - 1e-12, 1.0] {
            let origin = DVec3::new(offset, 0.0, -2.0);
            for passage in [bodies.0.passage(origin, DVec3::Z), bodies.1.passage(origin, DVec3::Z)] {
                let passage = passage.expect("touches");
                assert!(passage.exit.is_finite() && passage.path_length() <= 2.0 + 1e-12);
                assert!((passage.leaving.direction.length() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn an_ellipsoid_of_eccentricity_one_over_n_focuses_to_its_far_focus() {
    assert_eq!(Ellipsoid::stigmatic(2.0, Ior::AIR), None);
    for n in [1.33, 1.5, 2.5].map(ior) {
        let body = Ellipsoid::stigmatic(2.0, n).expect("n > 1");
        let focus = DVec3::Z * (2.0 / n.get());
        for step in 0..100 {
            let offset = body.semi_axes.x * f64::from(step) / 100.0;
            let passage = body.passage(DVec3::new(offset, 0.0, -5.0), DVec3::Z).expect("hits");
            assert!((focus - passage.entry).cross(passage.inside).length() < 1e-12, "offset {offset}");
        }
    }
}

#[test]
fn a_flat_ellipsoid_reflects_totally_and_a_sphere_never() {
    let rays = (0..200).map(|step| DVec3::new(f64::from(step) * 0.005, 0.0, -9.0));
    let flat = Ellipsoid { semi_axes: DVec3::new(1.0, 1.0, 3.0), ior: Ior::GLASS };
    assert!(rays.clone().filter_map(|o| flat.passage(o, DVec3::Z)).any(|passage| passage.leaving.tir));
    let sphere = Sphere { radius: 1.0, ior: Ior::GLASS };
    assert!(rays.filter_map(|o| sphere.passage(o, DVec3::Z)).all(|passage| !passage.leaving.tir));
}

#[test]
fn the_slab_transmits_what_textbooks_say() {
    let slab = Slab { thickness: 0.01, ior: Ior::GLASS };
    assert!((slab.transmittance(0.0) - 0.96 * 0.96).abs() < 1e-15);
    assert!(slab.transmittance(FRAC_PI_2) < 1e-12);
    assert_eq!(slab.lateral_shift(0.0), 0.0);
}

#[test]
fn the_prism_has_its_minimum_where_light_passes_symmetrically() {
    let apex = PI / 3.0;
    let prism = Prism { apex, ior: Ior::GLASS };
    let least = prism.minimum_deviation().expect("passes");
    assert!((least.to_degrees() - 37.180_755_8).abs() < 1e-6);
    assert!((f64::midpoint(apex, least).sin() / (apex / 2.0).sin() - 1.5).abs() < 1e-12);
    let at = prism.symmetric_incidence().expect("passes");
    assert!((prism.deviation(at).expect("passes") - least).abs() < 1e-12);
    for step in [-1e-3, 1e-3] {
        assert!(prism.deviation(at + step).expect("passes") > least);
    }
    // Beyond twice the critical angle no light passes both faces.
    let blunt = Prism { apex: 2.0 * Ior::GLASS.critical_angle() + 1e-9, ior: Ior::GLASS };
    assert_eq!(blunt.minimum_deviation(), None);
    assert!((-15..=15).all(|tenth| blunt.deviation(f64::from(tenth) * 0.1).is_none()));
}

/// Where a ray parallel to the axis (+z) at a small height crosses the axis, and its slope, by refraction at spheres.
fn trace_lens(lens: &ThickLens, height: f64) -> (f64, f64) {
    let vertices =
        [(0.0, lens.front_radius, lens.ior.eta_entering()), (lens.thickness, lens.back_radius, lens.ior.eta_leaving())];
    let (mut point, mut direction) = (DVec3::new(height, 0.0, -1.0), DVec3::Z);
    for (vertex, radius, eta) in vertices {
        let centre = DVec3::Z * (vertex + radius);
        let from = point - centre;
        let (b, c) = (from.dot(direction), from.length_squared() - radius * radius);
        let root = (b * b - c).sqrt();
        // The crossing near the vertex, of the two there are.
        let distance = if radius > 0.0 { -b - root } else { -b + root };
        point += direction * distance;
        direction = snell(direction, (point - centre) / radius, eta).direction;
    }
    (point.z - point.x * direction.z / direction.x, direction.x / direction.z)
}

#[test]
fn thick_lenses_focus_where_rays_cross() {
    for (front, back, thickness, n) in [
        (0.1, -0.1, 0.02, 1.5),
        (0.1, -0.05, 0.03, 1.7),
        (0.05, 0.2, 0.01, 2.0),
        (-0.1, 0.1, 0.01, 1.5),
        (0.3, -0.3, 0.6, 1.5),
    ] {
        let lens = ThickLens { front_radius: front, back_radius: back, thickness, ior: ior(n) };
        let height = 1e-6;
        let (crossing, slope) = trace_lens(&lens, height);
        assert!((-height / slope / lens.focal_length() - 1.0).abs() < 1e-6, "{lens:?}");
        assert!(
            (crossing - thickness - lens.back_focal_distance()).abs() < 1e-6 * lens.focal_length().abs(),
            "{lens:?}"
        );
    }
    let window =
        ThickLens { front_radius: f64::INFINITY, back_radius: f64::INFINITY, thickness: 0.01, ior: Ior::GLASS };
    assert_eq!((window.power(), window.focal_length()), (0.0, f64::INFINITY));
}

#[test]
fn a_ball_is_a_thick_lens() {
    for n in [1.2, 1.5, 1.9].map(ior) {
        let ball = BallLens::new(0.3, n, 1.0);
        let lens = ThickLens { front_radius: 0.3, back_radius: -0.3, thickness: 0.6, ior: n };
        assert!((ball.paraxial_focus() - lens.focal_length()).abs() < 1e-12);
        assert!((ball.paraxial_focus() - 0.3 - lens.back_focal_distance()).abs() < 1e-12);
    }
    assert_eq!(BallLens::new(0.3, Ior::AIR, 1.0).paraxial_focus(), f64::INFINITY);
}

#[test]
fn the_ball_lands_rays_where_the_sphere_sends_them() {
    for n in [1.0, 1.33, 1.5, 2.5].map(ior) {
        for distance in [1.0, 1.5, 4.0] {
            let ball = BallLens::new(1.0, n, distance);
            for step in 0..100 {
                let height = f64::from(step) / 100.0;
                let passage = ball.sphere.passage(DVec3::new(height, 0.0, -3.0), DVec3::Z).expect("hits");
                let (exit, leaving) = (passage.exit, passage.leaving.direction);
                let crossing = (leaving.z > 0.0).then(|| exit.x + leaving.x * (distance - exit.z) / leaving.z);
                match (ball.landing(height), crossing) {
                    (Some(landing), Some(crossing)) => {
                        assert!((landing - crossing).abs() < 1e-9 * (1.0 + landing.abs()), "{landing} {crossing}");
                    }
                    (landing, crossing) => assert_eq!(landing, crossing),
                }
            }
        }
    }
}

#[test]
fn near_the_focus_landings_vanish_with_the_cube_of_the_height() {
    let mut ball = BallLens::new(1.0, Ior::GLASS, 1.0);
    ball.distance = ball.paraxial_focus();
    let [near, far] = [0.01, 0.02].map(|height| ball.landing(height).expect("lands"));
    assert!((far / near - 8.0).abs() < 0.01);
}

#[test]
fn irradiance_integrates_to_the_flux() {
    for (n, distance) in [(1.5, 1.2), (1.5, 2.0), (1.5, 4.0), (1.33, 3.0), (2.5, 1.1)] {
        let ball = BallLens::new(1.0, ior(n), distance);
        for (inner, outer) in [(0.02, 0.05), (0.2, 0.3), (0.6, 1.1)] {
            let steps = 500;
            let width = (outer - inner) / f64::from(steps);
            let integral: f64 = (0..steps)
                .map(|step| inner + (f64::from(step) + 0.5) * width)
                .map(|radius| ball.irradiance(radius) * TAU * radius * width)
                .sum();
            let flux = ball.flux_within(outer, 200_000) - ball.flux_within(inner, 200_000);
            // The square-root singularity of a fold inside the interval converges slowly.
            assert!((integral - flux).abs() < 2e-2 * flux.max(0.02), "{n} {distance} {inner}: {integral} {flux}");
        }
    }
}

#[test]
fn no_more_light_arrives_than_meets_the_ball() {
    let ball = BallLens::new(0.5, Ior::GLASS, 1.0);
    let everything = ball.flux_within(f64::INFINITY, 10_000);
    // One interface of n = 1.5 reflects 9.18 % of diffuse light, which is what a ball sees of parallel light.
    let once = PI * 0.25 * (1.0 - 0.0918);
    assert!(everything < once && everything > once * (1.0 - 0.0918), "{everything}");
    assert!(ball.flux_within(0.1, 10_000) < everything);
    let clear = BallLens::new(0.5, Ior::AIR, 1.0);
    assert!((clear.flux_within(f64::INFINITY, 10_000) - PI * 0.25).abs() < 1e-9);
}

#[test]
fn without_refraction_the_ball_casts_no_caustic() {
    let clear = BallLens::new(0.5, Ior::AIR, 1.0);
    for radius in [0.0, 1e-9, 0.1, 0.499] {
        assert!((clear.irradiance(radius) - 1.0).abs() < 1e-9, "{radius}");
    }
    assert_eq!(clear.irradiance(0.6), 0.0);
}

#[test]
fn the_axis_is_bright_where_rays_cross_it() {
    // A weak ball close to the plane: only the central ray reaches the axis, T / (1 - L/f)^2.
    let weak = BallLens::new(1.0, ior(1.2), 1.05);
    let central = (1.0f64 - (0.2f64 / 2.2).powi(2)).powi(2) / (1.0 - 1.05 / weak.paraxial_focus()).powi(2);
    assert!((weak.irradiance(0.0) - central).abs() < 1e-12);
    assert!((weak.irradiance(1e-4) / central - 1.0).abs() < 1e-6);
    // A stronger one sends a whole cone of rays through one point of the axis.
    let strong = BallLens::new(1.0, Ior::GLASS, 1.4);
    assert_eq!(strong.irradiance(0.0), f64::INFINITY);
    assert!(strong.irradiance(1e-4) > 10.0 * strong.irradiance(0.1));
}
