//! The reference ray tracer held to an independent one and to closed forms.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

use glam::{DQuat, DVec3};
use murano_optics::{
    Ior,
    analytic::{self, Passage, Prism, Slab, Sphere, ThickLens},
};
use murano_reference::{
    Camera, Convex, Ellipsoid, GlassBody, Plane, Ray, Shape, Status, TwoInterfaces, World, trace_all, trace_two,
    two_interfaces,
};
use murano_tests::bench::{Distribution, ExrLayers, asset, shared};
use murano_tests::ground_truth::{body, clear_glass, index, number, text, vector};

const INDICES: [f64; 3] = [1.2, 1.5, 2.4];

/// Radians; exact for small angles too.
fn between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[test]
fn two_interfaces_agree_with_the_independent_tracer() {
    let Some(index) = index() else { return };
    for entry in index["refraction"].as_array().expect("a list") {
        let file = text(&entry["file"]);
        let Some(world) = body(text(&entry["mesh"]), number(&entry["ior"])) else { continue };
        let size = [0, 1].map(|axis| number(&entry["size"][axis]) as u32);
        let yfov = number(&entry["yfov_deg"]).to_radians();
        let camera = Camera::look_at(vector(&entry["eye"]), vector(&entry["target"]), yfov, size);
        let layers = ExrLayers::read(&shared(&format!("reference/{file}")).expect("what index.json lists"));
        let traced = two_interfaces(&world, &camera);

        let status = layers.channel("status.V").to_vec();
        let covered = status.iter().filter(|&&status| status != 0.0).count();
        let wrong =
            traced.iter().zip(&status).filter(|(path, status)| f32::from(path.status as u8) != **status).count();
        let angle_of = |name: &str, field: fn(&TwoInterfaces) -> DVec3| {
            let truth = layers.vectors(name);
            let both = traced.iter().zip(&truth).zip(&status);
            let left = both.filter(|((path, _), status)| path.status == Status::Left && **status == 1.0);
            Distribution::of(left.map(|((path, truth), _)| between(field(path), *truth).to_degrees()).collect())
        };
        let exit = angle_of("exit_direction", |path| path.exit);
        let inside = angle_of("t1", |path| path.t1);
        eprintln!(
            "{file}: wrong status {:.3} % of {covered}; exit direction in degrees: median {:.1e}, mean {:.1e}, p95 {:.1e}, \
             max {:.1e}; inside: median {:.1e}",
            100.0 * wrong as f64 / covered as f64,
            exit.p50,
            exit.mean,
            exit.p95,
            exit.max,
            inside.p50,
        );
        // Their directions are stored in f32. Pixels on the edge of a triangle or of total reflection may go either way.
        assert!(exit.p50 < 1e-4 && inside.p50 < 1e-4, "{file}: {exit}");
        assert!(exit.p95 < 0.01, "{file}: {exit}");
        assert!(wrong as f64 <= 0.002 * covered as f64, "{file}: {wrong} of {covered}");
    }
}

/// Rays from outside a ball of a radius towards it, evenly over its disc out to `widest` of the radius (a sunflower), from as
/// many sides.
fn rays(radius: f64, widest: f64) -> impl Iterator<Item = Ray> {
    const COUNT: u32 = 2000;
    const TURN: f64 = 2.399_963_229_728_653;
    (0..COUNT).map(move |k| {
        let (part, k) = ((f64::from(k) + 0.5) / f64::from(COUNT), f64::from(k));
        let height = 1.0 - 2.0 * part;
        let out = DVec3::from((height, (1.0 - height * height).sqrt() * (TURN * k).cos(), 0.0))
            + DVec3::Z * (1.0 - height * height).sqrt() * (TURN * k).sin();
        let [across, up] = [out.any_orthonormal_vector(), out.cross(out.any_orthonormal_vector())];
        let offset = widest * radius * (k * 0.618_033_988_749_895).fract().sqrt();
        let place = offset * ((7.0 * k).cos() * across + (7.0 * k).sin() * up);
        Ray { origin: 3.0 * radius * out + place, direction: -out }
    })
}

/// The largest angle between exit directions, radians; asserts that the rest agrees to rounding.
fn worst_angle(world: &World, rays: impl Iterator<Item = Ray>, passage: impl Fn(&Ray) -> Option<Passage>) -> f64 {
    let mut worst = 0.0_f64;
    let (mut left, mut reflected) = (0, 0);
    for ray in rays {
        let path = trace_two(world, &ray);
        let Some(truth) = passage(&ray) else {
            assert_eq!(path.status, Status::NoGlass, "{ray:?}");
            continue;
        };
        assert!(path.p1.distance(truth.entry) < 1e-12 && path.n1.distance(truth.entry_normal) < 1e-12, "{ray:?}");
        // Rays that graze the surface come out elsewhere for the least rounding: the square root of it, at worst.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(near(path.p2.distance(truth.exit), 0.0) && near(path.n2.distance(truth.exit_normal), 0.0), "{ray:?}");
        assert!(near(between(path.t1, truth.inside), 0.0) && near(path.path_length, truth.path_length()), "{ray:?}");
        if truth.leaving.tir {
            reflected += 1;
            assert_eq!((path.status, path.exit), (Status::TotallyReflected, DVec3::ZERO), "{ray:?}");
        } else {
            left += 1;
            assert_eq!(path.status, Status::Left, "{ray:?}");
            worst = worst.max(between(path.exit, truth.leaving.direction));
        }
    }
    eprintln!("{left} rays left, {reflected} were totally reflected; worst exit direction {worst:.1e} rad");
    assert!(left > 300);
    worst
}

fn ellipsoid(radii: DVec3, ior: f64) -> World {
    World::of_body(GlassBody::clear(Shape::Ellipsoid(Ellipsoid { centre: DVec3::ZERO, radii }), ior))
}

/// Radians.
const EXACT: f64 = 1e-9;

#[test]
fn closed_shapes_refract_as_their_closed_forms_do() {
    let radii = DVec3::new(0.7, 1.1, 0.9);
    for n in INDICES {
        let ior = Ior::new(n).unwrap();
        let sphere = Sphere { radius: 0.8, ior };
        let worst = worst_angle(&ellipsoid(DVec3::splat(0.8), n), rays(0.8, 1.02), |ray| {
            sphere.passage(ray.origin, ray.direction)
        });
        assert!(worst < EXACT, "sphere of {n}: {worst}");

        let closed = analytic::Ellipsoid { semi_axes: radii, ior };
        let worst = worst_angle(&ellipsoid(radii, n), rays(1.1, 1.0), |ray| closed.passage(ray.origin, ray.direction));
        assert!(worst < EXACT, "ellipsoid of {n}: {worst}");

        let slab = Slab { thickness: 0.3, ior };
        let world = World::of_body(GlassBody::clear(Shape::Convex(Convex::slab(0.3)), n));
        let down = rays(1.0, 1.0).filter(|ray| ray.direction.y < -0.05 && ray.origin.y > 0.0);
        let worst = worst_angle(&world, down, |ray| slab.passage(ray.origin, ray.direction));
        assert!(worst < EXACT, "slab of {n}: {worst}");
    }
}

/// Faces that meet at the z axis, and the direction in which light of an angle of incidence meets the first.
fn wedge(apex: f64) -> (Convex, impl Fn(f64) -> DVec3) {
    let first = DQuat::from_rotation_z(-0.5 * apex) * DVec3::NEG_X;
    let second = DQuat::from_rotation_z(0.5 * apex) * DVec3::X;
    let faces = [first, second].map(|normal| Plane { normal, offset: 0.0 }).to_vec();
    // Positive angles come from the side of the base, below.
    (Convex { faces }, move |incidence| DQuat::from_rotation_z(incidence) * -first)
}

#[test]
fn a_prism_deviates_and_reflects_as_its_closed_form_says() {
    for n in INDICES {
        for apex in [0.4, 0.8, 1.2] {
            let prism = Prism { apex, ior: Ior::new(n).unwrap() };
            let (convex, incident) = wedge(apex);
            let world = World::of_body(GlassBody::clear(Shape::Convex(convex), n));
            let (mut left, mut reflected, mut least) = (0, 0, f64::INFINITY);
            for step in -150..=150 {
                let theta = f64::from(step) * 0.01;
                let direction = incident(theta);
                let entry = DVec3::NEG_Y + DVec3::NEG_X * (0.5 * apex).tan();
                let path = trace_two(&world, &Ray { origin: entry - direction, direction });
                match prism.deviation(theta) {
                    Some(deviation) => {
                        left += 1;
                        assert_eq!(path.status, Status::Left, "n {n}, apex {apex}, incidence {theta}");
                        let turned = between(direction, path.exit);
                        assert!((turned - deviation.abs()).abs() < EXACT, "n {n}, apex {apex}, incidence {theta}");
                        assert!(path.exit.y <= direction.y, "towards the base");
                        least = least.min(turned);
                    }
                    // Light that runs away from the second face never meets it.
                    None if path.status == Status::TotallyReflected => reflected += 1,
                    None => assert_eq!(path.status, Status::NoExit, "n {n}, apex {apex}, incidence {theta}"),
                }
            }
            let minimum = prism.minimum_deviation();
            eprintln!(
                "n {n}, apex {apex}: {left} left, {reflected} totally reflected, least deviation {least:.6}, {minimum:?}"
            );
            if let Some(minimum) = minimum {
                assert!((0.0..1e-4).contains(&(least - minimum + EXACT)), "least {least}, closed form {minimum}");
            } else {
                assert_eq!(left, 0);
            }
        }
    }
}

/// Angles of exit between a mesh and the closed form of its surface over a picture, radians; and the part of the pixels of one
/// of them that the other has too.
fn mesh_errors(name: &str, eye: DVec3, passage: impl Fn(&Ray) -> Option<Passage>) -> (Distribution, f64) {
    let camera = Camera::look_at(eye, DVec3::ZERO, 0.7, [192, 192]);
    let traced = two_interfaces(&clear_glass(&asset(name), 1.5), &camera);
    let mut angles = Vec::new();
    let (mut equal, mut covered) = (0, 0);
    for (pixel, path) in traced.iter().enumerate() {
        let truth = passage(&camera.pixel_ray(pixel)).filter(|truth| !truth.leaving.tir);
        covered += usize::from(truth.is_some());
        if let (Some(truth), Status::Left) = (truth, path.status) {
            equal += 1;
            angles.push(between(path.exit, truth.leaving.direction));
        }
    }
    let errors = Distribution::of(angles);
    eprintln!(
        "{name}: {equal} of {covered}; exit direction in rad: median {:.1e}, p95 {:.1e}, max {:.1e}",
        errors.p50, errors.p95, errors.max
    );
    (errors, equal as f64 / covered as f64)
}

/// Triangles lie below the curved surface by up to 1e-4 of the sphere's radius, 3e-4 of the ellipsoid's: by so much a ray is
/// off, and its angle by a few times that, without bound towards the outline.
#[test]
fn meshes_refract_as_their_closed_forms_do_within_their_discretisation() {
    let eye = DVec3::new(1.0, 2.0, 4.0);
    let sphere = Sphere { radius: 1.0, ior: Ior::GLASS };
    let (errors, equal) = mesh_errors("sphere.glb", eye, |ray| sphere.passage(ray.origin, ray.direction));
    assert!(errors.p50 < 1e-4 && errors.p95 < 1e-3 && errors.max < 0.01 && equal == 1.0);

    let minor = (1.0_f64 - 1.0 / 2.25).sqrt();
    let closed = analytic::Ellipsoid { semi_axes: DVec3::new(minor, 1.0, minor), ior: Ior::GLASS };
    let (errors, equal) = mesh_errors("ellipsoid.glb", eye, |ray| closed.passage(ray.origin, ray.direction));
    assert!(errors.p50 < 3e-4 && errors.p95 < 2e-3 && errors.max < 0.05 && equal == 1.0);
}

#[test]
fn flat_meshes_refract_exactly() {
    let slab = clear_glass(&asset("slab.glb"), 1.5);
    let prism = clear_glass(&asset("prism.glb"), 1.5);
    let closed = Prism { apex: 60.0_f64.to_radians(), ior: Ior::GLASS };
    let mut compared = 0;
    for step in -60..=60 {
        let theta = f64::from(step) * 0.01;
        let direction = DVec3::new(theta.sin(), -theta.cos(), 0.0);
        let path = trace_two(&slab, &Ray { origin: -2.0 * direction, direction });
        assert!(path.status == Status::Left && between(path.exit, direction) < EXACT, "incidence {theta}");
        let slab = Slab { thickness: 0.4, ior: Ior::GLASS };
        let shift = direction.cross(path.p2 - path.p1).length();
        // Corners are stored in f32.
        assert!((shift - slab.lateral_shift(theta.abs())).abs() < 1e-7, "{shift} at {theta}");

        // Into the left face of the equilateral prism, through its middle.
        let normal = DQuat::from_rotation_z(-30.0_f64.to_radians()) * DVec3::NEG_X;
        let direction = DQuat::from_rotation_z(theta) * -normal;
        let middle = DVec3::new(-0.3, 1.2 * 3.0_f64.sqrt() / 12.0, 0.1);
        let path = trace_two(&prism, &Ray { origin: middle - direction, direction });
        if path.n2.y < 0.0 {
            // Met the base.
            continue;
        }
        compared += 1;
        if let Some(deviation) = closed.deviation(theta) {
            assert_eq!(path.status, Status::Left, "incidence {theta}");
            assert!((between(direction, path.exit) - deviation).abs() < 1e-6, "incidence {theta}");
        } else {
            assert_eq!(path.status, Status::TotallyReflected, "incidence {theta}");
        }
    }
    assert!(compared > 50, "{compared} rays met the second face");
}

/// Distance beyond a height at which a ray that ran down along -y at a distance from the axis crosses it.
fn focus_below(world: &World, off_axis: f64, height: f64) -> f64 {
    let chain = trace_all(world, &Ray { origin: DVec3::new(off_axis, 5.0, 0.0), direction: DVec3::NEG_Y }, 8);
    assert_eq!((chain.status, chain.bounces), (Status::Left, 2));
    let along = -chain.origin.x / chain.exit.x;
    height - (chain.origin.y + along * chain.exit.y)
}

#[test]
fn lenses_focus_where_the_lensmaker_says() {
    for n in INDICES {
        let lens = ThickLens { front_radius: 1.0, back_radius: -1.0, thickness: 2.0, ior: Ior::new(n).unwrap() };
        let focus = focus_below(&ellipsoid(DVec3::ONE, n), 1e-4, -1.0);
        // Spherical aberration grows with the square of the distance from the axis.
        assert!((focus - lens.back_focal_distance()).abs() < 1e-6, "ball of {n}: {focus}");
    }
    let world = clear_glass(&asset("lens.glb"), 1.5);
    let half = 1.2 - (1.2_f64 * 1.2 - 0.8 * 0.8).sqrt() + 0.06;
    let lens = ThickLens { front_radius: 1.2, back_radius: -1.2, thickness: 2.0 * half, ior: Ior::GLASS };
    let focus = focus_below(&world, 0.02, -half);
    eprintln!("lens.glb: back focal distance {focus}, closed form {}", lens.back_focal_distance());
    assert!((focus / lens.back_focal_distance() - 1.0).abs() < 0.01, "{focus}");

    // Descartes' ellipsoid has no aberration at all: its far focus, whatever the ray.
    let stigmatic = analytic::Ellipsoid::stigmatic(1.0, Ior::GLASS).unwrap();
    let axes = stigmatic.semi_axes;
    let world = ellipsoid(DVec3::new(axes.x, axes.z, axes.y), 1.5);
    for k in 1..=20 {
        let path =
            trace_two(&world, &Ray { origin: DVec3::new(0.035 * f64::from(k), 5.0, 0.0), direction: DVec3::NEG_Y });
        let along = -path.p1.x / path.t1.x;
        let crossing = path.p1.y + along * path.t1.y;
        assert!((crossing + 1.0 / 1.5).abs() < 1e-12, "ray {k} crosses at {crossing}");
    }
}

/// A right-angled isosceles prism with legs of 1 along +x and +y from the origin, unbounded along z.
fn right_angle_prism() -> World {
    let slanted = DVec3::new(1.0, 1.0, 0.0).normalize();
    let faces = vec![
        Plane { normal: DVec3::NEG_X, offset: 0.0 },
        Plane { normal: DVec3::NEG_Y, offset: 0.0 },
        Plane { normal: slanted, offset: FRAC_1_SQRT_2 },
    ];
    World::of_body(GlassBody::clear(Shape::Convex(Convex { faces }), 1.5))
}

#[test]
fn total_reflection_turns_light_in_a_right_angled_prism() {
    let world = right_angle_prism();
    // Through a leg: once reflected by the slanted face, out of the other leg.
    let ray = Ray { origin: DVec3::new(-1.0, 0.3, 0.0), direction: DVec3::X };
    assert_eq!(trace_two(&world, &ray).status, Status::TotallyReflected);
    let chain = trace_all(&world, &ray, 8);
    assert_eq!((chain.status, chain.bounces), (Status::Left, 3));
    assert!(between(chain.exit, DVec3::NEG_Y) < EXACT && chain.origin.distance(DVec3::new(0.7, 0.0, 0.0)) < 1e-12);
    assert!((chain.path_length - 1.0).abs() < 1e-12);

    // Through the slanted face: back where it came from, tilted or not, by two reflections.
    for tilt in [-0.04, 0.0, 0.04] {
        let direction = DQuat::from_rotation_z(tilt) * DVec3::new(-1.0, -1.0, 0.0).normalize();
        let entry = DVec3::new(0.7, 0.3, 0.0);
        let chain = trace_all(&world, &Ray { origin: entry - direction, direction }, 8);
        assert_eq!((chain.status, chain.bounces), (Status::Left, 4), "tilt {tilt}");
        assert!(between(chain.exit, -direction) < EXACT, "tilt {tilt}");
        // Mirrored at both legs the way is straight, from the slanted face to its image.
        let inside = (tilt.sin() / 1.5).asin();
        assert!((chain.path_length - 2.0 * FRAC_PI_4.cos() / inside.cos()).abs() < 1e-12, "tilt {tilt}");
    }

    // Cut short, it is still inside, on its way down.
    let chain = trace_all(&world, &ray, 2);
    assert_eq!((chain.status, chain.bounces), (Status::TotallyReflected, 2));
    assert!(between(chain.exit, DVec3::NEG_Y) < EXACT);
}

#[test]
fn chains_go_through_every_body_in_their_way() {
    let at = |centre: DVec3| GlassBody::clear(Shape::Ellipsoid(Ellipsoid { centre, radii: DVec3::ONE }), 1.5);
    let one = ellipsoid(DVec3::ONE, 1.5);
    for ray in rays(1.0, 0.999) {
        let (two, chain) = (trace_two(&one, &ray), trace_all(&one, &ray, 8));
        assert_eq!((chain.status, chain.bounces), (Status::Left, 2));
        assert_eq!((chain.origin, chain.exit, chain.path_length), (two.p2, two.exit, two.path_length));
    }

    let row = World { bodies: vec![at(DVec3::ZERO), at(DVec3::NEG_X * 2.5)], opaque: None };
    let through = trace_all(&row, &Ray { origin: DVec3::X * 4.0, direction: DVec3::NEG_X }, 8);
    assert_eq!((through.status, through.bounces), (Status::Left, 4));
    assert!((through.path_length - 4.0).abs() < 1e-12 && between(through.exit, DVec3::NEG_X) < EXACT);

    // Light inside denser matter: beyond the critical angle a bubble is a mirror.
    let bubble = ellipsoid(DVec3::ONE, 1.0 / 1.5);
    for (off_axis, status) in [(0.66, Status::Left), (0.67, Status::TotallyReflected)] {
        let ray = Ray { origin: DVec3::new(off_axis, 3.0, 0.0), direction: DVec3::NEG_Y };
        assert_eq!(trace_two(&bubble, &ray).status, status, "{off_axis} off the axis");
    }
    let ray = Ray { origin: DVec3::new(0.8, 3.0, 0.0), direction: DVec3::NEG_Y };
    let mirrored = trace_all(&bubble, &ray, 8);
    assert_eq!((mirrored.status, mirrored.bounces, mirrored.path_length), (Status::Left, 1, 0.0));
    let turned = PI - 2.0 * 0.8_f64.asin();
    assert!((between(mirrored.exit, DVec3::NEG_Y) - turned).abs() < EXACT);
}
