//! A body that disperses shows the sum of what it shows in each wavelength.

use glam::DVec3;
use murano_optics::{Ior, dispersed_ior, visible_spectrum};
use murano_refraction::{Method, Refraction};
use murano_render::{Frame, FrameRequest, Renderer, Stage, View, World};
use murano_scene::{Environment, FloorLevel, GlassBodies, Shot};
use murano_tests::bench::{asset, gpu, scalars, settings, still, vectors};

const SIZE: [u32; 2] = [96, 96];
const N_D: f64 = 1.5;
const DISPERSION: f32 = 2.0;

fn body(ior: f64, dispersion: f32) -> World {
    let mut shot = Shot::for_model(&asset("bumpy.glb"));
    shot.glass.bodies = GlassBodies::All;
    shot.glass.ior = Some(ior);
    shot.glass.dispersion = Some(dispersion);
    shot.floor.level = FloorLevel::Absent;
    let (mut world, _) = Stage::open(shot).expect("the body");
    // Colours so far apart that no footprint reaches from one to the next.
    let pixels = (0..32u16).map(|i| [i % 8, (i + 3) % 5, i / 8].map(|value| 0.2 + f32::from(value))).collect();
    world.environment = Some(Environment { width: 8, height: 4, pixels });
    world
}

fn render(ior: f64, dispersion: f32, refraction: Refraction) -> Frame {
    let request = FrameRequest { aov: true, ..still(view(), SIZE, refraction) };
    let mut renderer = Renderer::new(gpu(), body(ior, dispersion)).expect("a body");
    renderer.render(&request).unwrap_or_else(|error| panic!("{error}"))
}

fn view() -> View {
    View::look_at(DVec3::new(1.0, 1.2, 4.0), DVec3::ZERO, 0.6)
}

fn layer(frame: &Frame, name: &str) -> Vec<DVec3> {
    vectors(frame.aov.as_ref().expect("asked for"), name)
}

/// Mean and median of the relative difference of what a frame shows through its glass.
fn difference(frame: &Frame, expected: &[DVec3]) -> (f64, f64) {
    let shown = layer(frame, "radiance");
    let glass = scalars(frame.aov.as_ref().expect("asked for"), "status");
    let mut off: Vec<f64> = (0..shown.len())
        .filter(|&pixel| glass[pixel] > 0.0)
        .map(|pixel| (shown[pixel] - expected[pixel]).abs().max_element() / (0.05 + expected[pixel].max_element()))
        .collect();
    off.sort_by(f64::total_cmp);
    (off.iter().sum::<f64>() / off.len() as f64, off[off.len() / 2])
}

#[test]
fn wavelengths_add_up_to_the_picture() {
    for (method, wavelengths) in [(Method::Layers, 8), (Method::Newton, 3)] {
        let refraction = Refraction { wavelengths, ..settings(method, 5) };
        let all = render(N_D, DISPERSION, refraction);
        let n_d = Ior::new(N_D).expect("legal");
        let mut sum = vec![DVec3::ZERO; all.rgba.len() / 4];
        for sample in visible_spectrum(wavelengths as usize) {
            let ior = dispersed_ior(n_d, f64::from(DISPERSION), sample.wavelength).get();
            let one = render(ior, 0.0, refraction);
            for (sum, radiance) in sum.iter_mut().zip(layer(&one, "radiance")) {
                *sum += DVec3::from(sample.weight) * radiance;
            }
        }
        // All waves are filtered over the footprint of the d line, which is not theirs where it crosses an edge.
        let (mean, median) = difference(&all, &sum);
        eprintln!("{method}: mean {mean:.5}, median {median:.6}");
        assert!(mean < 0.004 && median < 1e-4, "{method}: mean {mean}, median {median}");

        let plain = render(N_D, 0.0, refraction);
        assert!(layer(&all, "exit_direction") == layer(&plain, "exit_direction"), "paths are those of the d line");
        let (changed, _) = difference(&all, &layer(&plain, "radiance"));
        assert!(changed > 0.02, "{method}: dispersion changes the picture by {changed}");
        let off = render(N_D, DISPERSION, Refraction { wavelengths: 1, ..refraction });
        assert!(off.rgba == plain.rgba, "one wavelength disperses nothing");
    }
}
