//! Refraction against closed forms, and against an independent ray tracer where its data are at hand. Errors are angles
//! between exit directions, in degrees.
//!
//! The outermost ring of the silhouette is left out everywhere (a covered pixel with an uncovered one among its eight
//! neighbours): there a triangulated outline differs from the true one by a part of a pixel, and grazing light turns
//! that into any angle.

use glam::{DVec3, DVec4};
use murano_optics::{
    Ior,
    analytic::{Ellipsoid, Passage, Prism, Slab, Sphere},
};
use murano_refraction::Method;
use murano_render::{Renderer, View};
use murano_scene::{Projection, look_along};
use murano_tests::bench::{
    Distribution, ExrLayers, asset, degrees_between, diameter, glass_body, gpu, inside_silhouette, pixel_ray, renderer,
    scalars, settings, shared, still, vectors,
};

const SIZE: [u32; 2] = [512, 512];
const STEPS: u32 = 5;
/// Of the status layer.
const LEFT: f64 = 1.0;
const REFLECTED: f64 = 2.0;

fn ior(n: f64) -> Ior {
    Ior::new(n).expect("an index of refraction")
}

/// What an exact ray does at a body's two interfaces.
type Truth<'a> = &'a dyn Fn(DVec3, DVec3) -> Option<Passage>;

/// What came of one method over several views.
#[derive(Default)]
struct Errors {
    /// Degrees, over pixels that left in truth and in the picture.
    exit: Distribution,
    /// Share of pixels of another status than in truth.
    wrong_status: f64,
}

/// Renders a body and compares every pixel inside its silhouette whose exact ray the truth knows.
fn measure(renderer: &mut Renderer, views: &[View], method: Method, truth: Truth) -> Errors {
    let mut degrees = Vec::new();
    let (mut wrong, mut pixels) = (0, 0);
    for view in views {
        let frame = renderer.render(&still(*view, SIZE, settings(method, STEPS))).expect("a picture");
        let aov = frame.aov.expect("asked for");
        let (status, exits) = (scalars(&aov, "status"), vectors(&aov, "exit_direction"));
        let covered: Vec<bool> = status.iter().map(|status| *status > 0.0).collect();
        for index in inside_silhouette(&covered, SIZE).iter().enumerate().filter(|(_, inside)| **inside).map(|(i, _)| i)
        {
            let (origin, direction) = pixel_ray(view, SIZE, index);
            let Some(passage) = truth(origin, direction) else { continue };
            let expected = if method == Method::Sir || !passage.leaving.tir { LEFT } else { REFLECTED };
            pixels += 1;
            if status[index] != expected {
                wrong += 1;
            } else if method == Method::Sir {
                degrees.push(degrees_between(exits[index], passage.inside));
            } else if expected == LEFT {
                degrees.push(degrees_between(exits[index], passage.leaving.direction));
            }
        }
    }
    assert!(pixels > 10_000 * views.len(), "only {pixels} pixels were compared");
    Errors { exit: Distribution::of(degrees), wrong_status: f64::from(wrong) / pixels as f64 }
}

/// One line of the report.
fn report(body: &str, n: f64, method: Method, errors: &Errors) {
    eprintln!("{body} n={n} {method}: {}, wrong status {:.4} %", errors.exit, 100.0 * errors.wrong_status);
}

/// Near and far, from the front, from above and from anywhere; the fields of view hold a ball of radius 1.
fn views() -> Vec<View> {
    let perspective = |eye: DVec3, yfov: f64| View::look_at(eye, DVec3::ZERO, yfov);
    vec![
        perspective(DVec3::new(0.0, 0.0, 3.0), 0.8),
        perspective(DVec3::new(-1.0, 1.6, 1.1), 1.25),
        perspective(DVec3::new(8.0, -5.0, 3.0), 0.25),
        View {
            world_from_view: look_along(DVec3::new(0.3, 4.0, 0.2), DVec3::new(-0.3, -4.0, -0.2)),
            projection: Projection::Orthographic { half_height: 1.1 },
            near: 1e-3,
        },
    ]
}

#[test]
fn a_sphere_refracts_as_its_closed_form() {
    let mut gpu = gpu();
    for n in [1.5, 1.2] {
        let mut renderer = renderer(gpu, glass_body(&asset("sphere.glb"), ior(n)));
        let sphere = Sphere { radius: 1.0, ior: ior(n) };
        let truth = |origin, direction| sphere.passage(origin, direction);
        // Newton is exact up to the mesh and the maps' texels; five bisections leave 1/32 of the depth range.
        // A ball reflects nothing totally, but the place where `dir` stops short may.
        for (method, mean, wrong) in [(Method::Sir, 0.05, 0.0), (Method::Dir, 1.0, 0.03), (Method::Newton, 0.05, 0.0)] {
            let errors = measure(&mut renderer, &views(), method, &truth);
            report("sphere", n, method, &errors);
            assert!(errors.exit.mean <= mean, "n={n} {method}: {} > {mean}", errors.exit);
            assert!(errors.wrong_status <= wrong, "n={n} {method}: {} > {wrong}", errors.wrong_status);
        }
        gpu = renderer.into_gpu();
    }
}

#[test]
fn an_ellipsoid_refracts_as_its_closed_form() {
    let minor = (1.0_f64 - 1.0 / 2.25).sqrt();
    let mut gpu = gpu();
    for n in [1.5, 1.2] {
        let mut renderer = renderer(gpu, glass_body(&asset("ellipsoid.glb"), ior(n)));
        let ellipsoid = Ellipsoid { semi_axes: DVec3::new(minor, 1.0, minor), ior: ior(n) };
        let truth = |origin, direction| ellipsoid.passage(origin, direction);
        for (method, mean, wrong) in [(Method::Sir, 0.05, 0.0), (Method::Dir, 1.0, 0.02), (Method::Newton, 0.05, 0.001)]
        {
            let errors = measure(&mut renderer, &views(), method, &truth);
            report("ellipsoid", n, method, &errors);
            assert!(errors.exit.mean <= mean, "n={n} {method}: {} > {mean}", errors.exit);
            assert!(errors.wrong_status <= wrong, "n={n} {method}: {} > {wrong}", errors.wrong_status);
        }
        gpu = renderer.into_gpu();
    }
}

/// The plate of `slab.glb`: rays that enter its top and leave its bottom, well within its 2 x 2.
fn through_the_plate(slab: &Slab, origin: DVec3, direction: DVec3) -> Option<Passage> {
    let top = DVec3::new(0.0, 0.2, 0.0);
    let mut passage = slab.passage(origin - top, direction)?;
    passage.entry += top;
    passage.exit += top;
    let within = |point: DVec3| point.x.abs() < 0.97 && point.z.abs() < 0.97;
    (within(passage.entry) && within(passage.exit)).then_some(passage)
}

#[test]
fn a_slab_lets_light_leave_as_it_came() {
    let mut renderer = renderer(gpu(), glass_body(&asset("slab.glb"), Ior::GLASS));
    let slab = Slab { thickness: 0.4, ior: Ior::GLASS };
    let truth = |origin, direction| through_the_plate(&slab, origin, direction);
    let face_on = View::look_at(DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO, 0.6);
    let tilted = View::look_at(DVec3::new(1.2, 2.6, 1.8), DVec3::ZERO, 0.7);
    for (name, view) in [("slab face-on", face_on), ("slab tilted", tilted)] {
        // Planes are exact in the map. Where light leaves within a texel of the outline, searches step beside it and stop
        // short: they guess right here, and say that they guess.
        for (method, wrong) in [(Method::Sir, 0.0), (Method::Dir, 0.005), (Method::Newton, 0.005)] {
            let errors = measure(&mut renderer, &[view], method, &truth);
            report(name, 1.5, method, &errors);
            assert!(errors.exit.max <= 1e-3, "{name} {method}: {}", errors.exit);
            assert!(errors.wrong_status <= wrong, "{name} {method}: {} > {wrong}", errors.wrong_status);
        }
    }
}

/// Distance of each of the faces of `prism.glb` from its middle, metres: the inradius of its section.
const PRISM_INRADIUS: f64 = 0.346_410_161_513_775_5;

/// The prism of `prism.glb`, lit along its principal section: rays that enter its left face and meet its right one.
fn through_the_prism(prism: &Prism, origin: DVec3, direction: DVec3) -> Option<Passage> {
    let lean = 0.5 * prism.apex;
    let left = DVec4::new(-lean.cos(), lean.sin(), 0.0, PRISM_INRADIUS);
    let right = DVec4::new(lean.cos(), lean.sin(), 0.0, PRISM_INRADIUS);
    let base = DVec4::new(0.0, -1.0, 0.0, PRISM_INRADIUS);
    let meets =
        |plane: DVec4, from: DVec3, along: DVec3| (plane.w - plane.truncate().dot(from)) / plane.truncate().dot(along);
    let well_on = |point: DVec3, others: [DVec4; 2]| {
        point.z.abs() < 0.77 && others.iter().all(|plane| plane.truncate().dot(point) < plane.w - 0.02)
    };
    let heading = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);

    let entry = origin + direction * meets(left, origin, direction);
    if !well_on(entry, [right, base]) {
        return None;
    }
    // Measured from the inward normal, positive towards the apex: light from the side of the base.
    let theta_i = direction.y.atan2(direction.x) + lean;
    let inside = heading(prism.ior.refraction_angle(theta_i) - lean);
    let exit = entry + inside * meets(right, entry, inside);
    if !well_on(exit, [left, base]) {
        return None;
    }
    let deviation = prism.deviation(theta_i);
    let leaving = murano_optics::Refracted {
        direction: heading(theta_i - lean - deviation.unwrap_or(0.0)),
        tir: deviation.is_none(),
        cos_t: 0.0,
    };
    Some(Passage { entry, entry_normal: left.truncate(), inside, exit, exit_normal: right.truncate(), leaving })
}

#[test]
fn a_prism_deviates_as_its_closed_form() {
    let prism = Prism { apex: 60_f64.to_radians(), ior: Ior::GLASS };
    let symmetric = prism.symmetric_incidence().expect("glass of 1.5 passes it").to_degrees();
    let mut renderer = renderer(gpu(), glass_body(&asset("prism.glb"), prism.ior));
    let truth = |origin, direction| through_the_prism(&prism, origin, direction);
    // Minimum deviation; steeper; below 27.9 degrees of incidence the second face reflects totally.
    for incidence in [symmetric, 60.0, 35.0, 20.0] {
        let angle = (incidence - 30.0).to_radians();
        let direction = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let view = View {
            world_from_view: look_along(-4.0 * direction, direction),
            projection: Projection::Orthographic { half_height: 0.85 },
            near: 1e-3,
        };
        for method in [Method::Dir, Method::Newton] {
            let errors = measure(&mut renderer, &[view], method, &truth);
            report(&format!("prism at {incidence:.1} degrees"), 1.5, method, &errors);
            if prism.deviation(incidence.to_radians()).is_some() {
                assert!(errors.exit.count > 0 && errors.exit.max <= 1e-3, "{method}: {}", errors.exit);
            }
            assert_eq!(errors.wrong_status, 0.0, "{incidence} {method}");
        }
    }
}

/// A picture of the independent ray tracer.
struct Reference {
    name: String,
    n: f64,
    view: View,
    layers: ExrLayers,
}

fn references(body: &str) -> Vec<Reference> {
    let Some(index) = shared("reference/index.json") else { return Vec::new() };
    let text = std::fs::read_to_string(index).expect("index.json is readable");
    let index: serde_json::Value = serde_json::from_str(&text).expect("index.json is JSON");
    let point = |value: &serde_json::Value| {
        DVec3::from_array(std::array::from_fn(|axis| value[axis].as_f64().expect("three numbers")))
    };
    let entries = index["refraction"].as_array().expect("a list of pictures").iter();
    entries
        .filter(|entry| entry["mesh"].as_str() == Some(&format!("{body}.glb")))
        .map(|entry| {
            let file = entry["file"].as_str().expect("a file name");
            Reference {
                name: body.into(),
                n: entry["ior"].as_f64().expect("an index"),
                view: View::look_at(
                    point(&entry["eye"]),
                    point(&entry["target"]),
                    entry["yfov_deg"].as_f64().expect("an angle").to_radians(),
                ),
                layers: ExrLayers::read(&shared(&format!("reference/{file}")).expect("what index.json lists")),
            }
        })
        .collect()
}

/// What is allowed against a [`Reference`]: mean degrees of a method over pixels that left in both; of those that end on exact
/// triangles also the share of wrong statuses.
struct Allowed {
    n: f64,
    dir: f64,
    newton: f64,
    /// `walk` and `layers`, which differ only beyond the second interface.
    walk: [f64; 2],
}

impl Allowed {
    /// The same mean, and almost no wrong status, whatever the mesh.
    fn exact(&self) -> [f64; 2] {
        [self.walk[0], 1e-4]
    }
}

/// The first interface is exact in the renderer: position, normal and first direction agree with the ray tracer to the
/// rounding of f32. What the methods make of the second is bounded by what was measured, plus a fifth.
fn compare_with_the_ray_tracer(body: &str, folder: &str, allowed: [Allowed; 2]) {
    let mut gpu = None;
    for reference in references(body) {
        let model = shared(&format!("{folder}/{body}.glb")).expect("the body of a reference picture");
        let world = glass_body(&model, ior(reference.n));
        let mut renderer = renderer(gpu.take().unwrap_or_else(murano_tests::bench::gpu), world);
        let diameter = diameter(renderer.world());
        let bounds = allowed.iter().find(|allowed| allowed.n == reference.n).expect("a bound for every picture");
        first_interface_agrees(&mut renderer, &reference, diameter);
        for (method, [most, most_wrong]) in [
            (Method::Sir, [f64::INFINITY, 1.0]),
            (Method::Dir, [bounds.dir, 1.0]),
            (Method::Newton, [bounds.newton, 1.0]),
            (Method::Walk, bounds.walk),
            (Method::Layers, bounds.walk),
            (Method::Exact, bounds.exact()),
        ] {
            let errors = against(&mut renderer, &reference, method);
            report(&reference.name, reference.n, method, &errors);
            assert!(errors.exit.mean <= most, "{body} n={} {method}: {}, at most {most}", reference.n, errors.exit);
            let wrong = errors.wrong_status;
            assert!(wrong <= most_wrong, "{body} n={} {method}: status {wrong}, at most {most_wrong}", reference.n);
        }
        gpu = Some(renderer.into_gpu());
    }
}

fn first_interface_agrees(renderer: &mut Renderer, reference: &Reference, diameter: f64) {
    let size = reference.layers.size;
    let frame = renderer.render(&still(reference.view, size, settings(Method::Sir, STEPS))).expect("a picture");
    let aov = frame.aov.expect("asked for");
    let ours: Vec<bool> = scalars(&aov, "status").iter().map(|status| *status > 0.0).collect();
    let theirs: Vec<bool> = reference.layers.channel("status.V").iter().map(|status| *status > 0.0).collect();
    let same = ours.iter().zip(&theirs).filter(|(a, b)| a == b).count() as f64 / ours.len() as f64;
    assert!(same >= 0.998, "{}: {same} of the pixels agree on what is covered", reference.name);

    let both: Vec<usize> = (0..ours.len()).filter(|i| ours[*i] && theirs[*i]).collect();
    let errors = |layer: &str, error: fn(DVec3, DVec3) -> f64| {
        let (a, b) = (vectors(&aov, layer), reference.layers.vectors(layer));
        Distribution::of(both.iter().map(|i| error(a[*i], b[*i])).collect())
    };
    let p1 = errors("p1", DVec3::distance);
    let (n1, t1) = (errors("n1", degrees_between), errors("t1", degrees_between));
    eprintln!(
        "{} n={}: covered alike {same:.5}; p1 metres {p1}; n1 degrees {n1}; t1 degrees {t1}",
        reference.name, reference.n
    );
    assert!(p1.p50 < 1e-5 * diameter, "{}: p1 {p1}", reference.name);
    assert!(n1.p50 < 1e-3 && t1.p50 < 1e-3, "{}: n1 {n1}, t1 {t1}", reference.name);
}

fn against(renderer: &mut Renderer, reference: &Reference, method: Method) -> Errors {
    let size = reference.layers.size;
    let frame = renderer.render(&still(reference.view, size, settings(method, STEPS))).expect("a picture");
    let aov = frame.aov.expect("asked for");
    let (status, exits) = (scalars(&aov, "status"), vectors(&aov, "exit_direction"));
    let expected = reference.layers.channel("status.V");
    let exact = reference.layers.vectors("exit_direction");
    let covered: Vec<bool> = status.iter().zip(expected).map(|(a, b)| *a > 0.0 && *b > 0.0).collect();
    let inside = inside_silhouette(&covered, size);
    let pixels: Vec<usize> = (0..covered.len()).filter(|i| inside[*i]).collect();
    let alike = |i: &&usize| status[**i] == f64::from(expected[**i]);
    let left = pixels.iter().filter(alike).filter(|i| status[**i] == LEFT);
    Errors {
        exit: Distribution::of(left.map(|i| degrees_between(exits[*i], exact[*i])).collect()),
        wrong_status: 1.0 - pixels.iter().filter(alike).count() as f64 / pixels.len() as f64,
    }
}

#[test]
fn the_sphere_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 0.28, newton: 0.0011, walk: [2e-5, 0.0] },
        Allowed { n: 1.5, dir: 0.68, newton: 0.0015, walk: [2e-5, 0.0] },
    ];
    compare_with_the_ray_tracer("sphere20k", "reference/meshes", allowed);
}

#[test]
fn the_torus_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 0.34, newton: 0.0038, walk: [2e-5, 0.0] },
        Allowed { n: 1.5, dir: 0.92, newton: 0.0073, walk: [2e-5, 0.0] },
    ];
    compare_with_the_ray_tracer("torus20k", "reference/meshes", allowed);
}

#[test]
fn the_bumpy_body_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 0.41, newton: 0.019, walk: [3e-5, 0.0] },
        Allowed { n: 1.5, dir: 1.1, newton: 0.023, walk: [2.2e-4, 0.0] },
    ];
    compare_with_the_ray_tracer("bumpy20k", "reference/meshes", allowed);
}

#[test]
fn the_bunny_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 2.0, newton: 0.41, walk: [4e-5, 4e-3] },
        Allowed { n: 1.5, dir: 3.3, newton: 0.74, walk: [1e-4, 5e-3] },
    ];
    compare_with_the_ray_tracer("bunny_69k", "data/paper", allowed);
}

#[test]
fn the_dragon_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 2.2, newton: 1.1, walk: [0.012, 3.5e-3] },
        Allowed { n: 1.5, dir: 4.2, newton: 1.9, walk: [0.015, 3.5e-3] },
    ];
    compare_with_the_ray_tracer("dragon_100k", "data/paper", allowed);
}

#[test]
fn the_armadillo_agrees_with_the_ray_tracer() {
    let allowed = [
        Allowed { n: 1.2, dir: 2.2, newton: 1.1, walk: [1.5e-4, 1.2e-3] },
        Allowed { n: 1.5, dir: 4.7, newton: 2.2, walk: [3.5e-4, 9e-4] },
    ];
    compare_with_the_ray_tracer("armadillo_346k", "data/paper", allowed);
}
