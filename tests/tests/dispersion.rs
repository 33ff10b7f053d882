//! A body that disperses shows the sum of what it shows in each wavelength.

use glam::DVec3;
use murano_optics::{Ior, dispersed_ior, visible_spectrum};
use murano_refraction::{Method, Refraction};
use murano_render::{Frame, FrameRequest, Renderer, Stage, View, World};
use murano_scene::{FloorLevel, GlassBodies, Shot};
use murano_tests::bench::{asset, gpu, settings, still, vectors};

const SIZE: [u32; 2] = [96, 96];
const N_D: f64 = 1.5;
const DISPERSION: f32 = 2.0;

fn body(ior: f64, dispersion: f32) -> World {
    let mut shot = Shot::for_model(&asset("bumpy.glb"));
    shot.glass.bodies = GlassBodies::All;
    shot.glass.ior = Some(ior);
    shot.glass.dispersion = Some(dispersion);
    shot.floor.level = FloorLevel::Absent;
    Stage::open(shot).expect("the body in the studio").0
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
        let shown = layer(&all, "radiance");
        let worst = shown.iter().zip(&sum).map(|(a, b)| (*a - *b).abs().max_element() / (1.0 + b.max_element()));
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 1e-4, "{method}: {worst}");

        let plain = render(N_D, 0.0, refraction);
        assert!(layer(&all, "exit_direction") == layer(&plain, "exit_direction"), "paths are those of the d line");
        let coloured =
            |radiance: &DVec3| radiance.max_element() - radiance.min_element() > 0.2 * radiance.max_element();
        let count = |frame: &Frame| layer(frame, "radiance").iter().filter(|it| coloured(it)).count();
        assert!(
            count(&all) > 2 * count(&plain) + 20,
            "{method}: {} and {} pixels of colour",
            count(&all),
            count(&plain)
        );
        let off = render(N_D, DISPERSION, Refraction { wavelengths: 1, ..refraction });
        assert!(off.rgba == plain.rgba, "one wavelength disperses nothing");
    }
}
