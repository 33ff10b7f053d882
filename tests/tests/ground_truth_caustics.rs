//! The reference photon tracer held to an independent one, to closed forms and to the conservation of energy.

use glam::{DVec3, Vec3};
use murano_metrics::irradiance::{IrradianceMap, relative_l1};
use murano_reference::{CausticMap, PhotonClass, PhotonTracing, Window, World, caustic_map, direct_irradiance};
use murano_scene::{Light, LightKind, PlacedLight, look_along};
use murano_tests::bench::{ExrLayers, shared};
use murano_tests::ground_truth::{body, index, number, text, vector};
use serde_json::Value;

fn quietly(_: usize, _: usize) {}

fn light(kind: LightKind, position: DVec3, direction: DVec3, intensity: f64) -> PlacedLight {
    PlacedLight {
        world_from_light: look_along(position, direction),
        light: Light { name: String::new(), kind, color: Vec3::ONE, intensity: intensity as f32, range: f32::INFINITY },
    }
}

fn tracing(photons: u64) -> PhotonTracing {
    PhotonTracing { photons, ..PhotonTracing::default() }
}

fn map_under(world: &World, light: &PlacedLight, window: Window, tracing: &PhotonTracing) -> CausticMap {
    caustic_map(world, light, window, tracing, &quietly).unwrap_or_else(|error| panic!("{error}"))
}

fn off(value: f64, truth: f64) -> f64 {
    (value / truth - 1.0).abs()
}

/// A caustic of the independent photon tracer, and what it is a caustic of.
struct Caustic {
    name: String,
    world: World,
    light: PlacedLight,
    window: Window,
    layers: ExrLayers,
    /// Watts.
    account: Value,
}

impl Caustic {
    /// `None` where its body is not at hand.
    fn of(entry: &Value) -> Option<Self> {
        let light = if text(&entry["light"]) == "point" {
            let place = vector(&entry["pos"]);
            light(LightKind::Point, place, -place, number(&entry["intensity_cd"]))
        } else {
            light(LightKind::Directional, DVec3::ZERO, vector(&entry["dir"]), number(&entry["irradiance_lux"]))
        };
        let half = number(&entry["half"]);
        Some(Self {
            name: text(&entry["file"]).trim_start_matches("caustics/").trim_end_matches(".exr").into(),
            world: body(text(&entry["mesh"]), number(&entry["ior"]))?,
            light,
            window: Window {
                centre: DVec3::Y * number(&entry["plane_y"]),
                half_u: half * vector(&entry["u"]),
                half_v: half * vector(&entry["v"]),
                size: [number(&entry["res"]) as u32; 2],
            },
            layers: ExrLayers::read(&shared(&format!("reference/{}", text(&entry["file"]))).expect("what it lists")),
            account: entry["account"]["budget_W"].clone(),
        })
    }

    fn all() -> Vec<Self> {
        let Some(index) = index() else { return Vec::new() };
        index["caustics"].as_array().expect("a list").iter().filter_map(Self::of).collect()
    }

    fn layer(&self, name: &str) -> IrradianceMap {
        let values = self.layers.channel(&format!("{name}.V"));
        IrradianceMap::from_f32(self.window.size, self.window.texel_area(), values).expect("irradiance")
    }

    fn watts(&self, name: &str) -> f64 {
        number(&self.account[name])
    }
}

/// The independent tracer's classes, and ours that they hold: it leaves in TT what is reflected off an outside later.
const LAYERS: [(&str, &[PhotonClass]); 4] = [
    ("TT", &[PhotonClass::TwoRefractions, PhotonClass::OutsideReflection]),
    ("R", &[PhotonClass::FirstReflection]),
    ("TTTT", &[PhotonClass::OtherRefractions]),
    ("INT", &[PhotonClass::InternalReflection]),
];

/// What the independent tracer gives up, by its account: part of a photon. It matters to what is reflected inside more than once.
const THEIR_LEAST_WEIGHT: f64 = 1e-3;

/// Relative L1 of a map that is fit to be compared.
const QUIET: f64 = 0.01;

/// The first channel of some classes.
fn map_of(window: &Window, irradiance: &[Vec<DVec3>; 5], classes: &[PhotonClass]) -> IrradianceMap {
    let texel = |texel: usize| classes.iter().map(|class| irradiance[*class as usize][texel].x).sum();
    IrradianceMap::new(window.size, window.texel_area(), (0..window.texels()).map(texel).collect()).expect("irradiance")
}

/// Compares class by class, and says where they differ by more than a caustic may: energy in the window within 0.5 %, maps
/// within a relative L1 of 3 %. Our two halves tell the noise. To the energy's tolerance three standard deviations are added; maps are compared
/// over the smallest blocks of texels whose noise is at most 1 %, or over 4 x 4 blocks with twice their noise added. Classes
/// below 0.1 % of the light in the window are left out.
fn compare(caustic: &Caustic, photons: u64) -> Vec<String> {
    let mut wrong = Vec::new();
    let tracing = PhotonTracing { least_weight: THEIR_LEAST_WEIGHT, ..tracing(photons) };
    let map = map_under(&caustic.world, &caustic.light, caustic.window, &tracing);
    let account = &map.account;
    eprintln!(
        "{}: {} photons, {} rays; hit {:.5} W of {:.5}, first reflected {:.5} of {:.5}, pruned {:.1e} of {:.1e}, dropped {:.1e}, \
         imbalance {:.0e}",
        caustic.name,
        account.photons,
        account.rays,
        account.hit.x,
        caustic.watts("hit_mesh"),
        account.first_reflected.x,
        caustic.watts("first_reflected"),
        account.pruned.x,
        caustic.watts("pruned"),
        account.dropped.x,
        account.imbalance(),
    );
    assert!(account.imbalance() < 1e-12, "{} of the light is missing", account.imbalance());
    assert!(off(account.hit.x, caustic.watts("hit_mesh")) < 1e-3);
    for (name, classes) in LAYERS {
        let watts = caustic.watts(&format!("in_window_{name}"));
        if watts < 1e-3 * caustic.watts("in_window") {
            eprintln!("  {name}: left out, {watts:.1e} W");
            continue;
        }
        let truth = caustic.layer(&format!("E_{name}"));
        let ours = map_of(&map.window, &map.irradiance, classes);
        let [first, second] = map.halves.each_ref().map(|half| map_of(&map.window, half, classes));
        let errors = |block: u32| {
            let [truth, ours, first, second] =
                [&truth, &ours, &first, &second].map(|map| map.downsampled(block).expect("256 texels"));
            (relative_l1(&truth, &ours).expect("light"), 0.5 * relative_l1(&first, &second).expect("light"))
        };
        let energy = ours.flux() / watts - 1.0;
        let deviation = deviation_of_sum(&first, &second);
        let (texels, noise) = errors(1);
        eprint!(
            "  {name}: {:.6} W of {watts:.6}, {:+.3} % (deviation {:.3} %); relative L1 of texels {:.2} % (our noise {:.2} %)",
            ours.flux(),
            100.0 * energy,
            100.0 * deviation,
            100.0 * texels,
            100.0 * noise,
        );
        let (l1, noise, block) = [1, 2, 4, 8, 16, 32, 64]
            .map(|block| (errors(block).0, errors(block).1, block))
            .into_iter()
            .find(|(_, noise, _)| *noise <= QUIET)
            .unwrap_or((errors(64).0, errors(64).1, 64));
        eprintln!(", of blocks of {block}: {:.2} % ({:.2} %)", 100.0 * l1, 100.0 * noise);
        let loud = if noise > QUIET { 2.0 * noise } else { 0.0 };
        if energy.abs() > 0.005 + 3.0 * deviation {
            wrong.push(format!("{} {name}: energy off by {:.2} %", caustic.name, 100.0 * energy));
        }
        if l1 > 0.03 + loud {
            wrong.push(format!("{} {name}: relative L1 {:.2} % over blocks of {block}", caustic.name, 100.0 * l1));
        }
    }
    wrong
}

fn compare_all(photons: u64) {
    let wrong: Vec<String> = Caustic::all().iter().flat_map(|caustic| compare(caustic, photons)).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}

/// Relative standard deviation of the flux of the mean of two independent maps, taken from their differences over blocks that
/// are wide enough to err independently of each other.
fn deviation_of_sum(first: &IrradianceMap, second: &IrradianceMap) -> f64 {
    let [first, second] = [first, second].map(|map| map.downsampled(16).expect("a multiple of 16 texels"));
    let both = || first.values().iter().zip(second.values());
    let squares: f64 = both().map(|(a, b)| (0.5 * (a - b)).powi(2)).sum();
    squares.sqrt() / both().map(|(a, b)| 0.5 * (a + b)).sum::<f64>()
}

#[test]
fn caustics_agree_with_the_independent_tracer() {
    compare_all(1 << 18);
}

#[test]
#[ignore = "half an hour on two busy cores: as many photons as the independent tracer has"]
fn caustics_agree_with_the_independent_tracer_photon_for_photon() {
    compare_all(16_252_928);
}

#[test]
fn light_that_misses_the_body_agrees_with_the_independent_tracer() {
    for caustic in Caustic::all() {
        let direct = direct_irradiance(&caustic.world, &caustic.light, &caustic.window).expect("a window");
        let values = direct.iter().map(|texel| texel.x).collect();
        let ours = IrradianceMap::new(caustic.window.size, caustic.window.texel_area(), values).expect("irradiance");
        let truth = caustic.layer("E_direct");
        // Its texels are means over their area: where the shadow's edge crosses one, ours is either dark or lit.
        let bare = direct_irradiance(&World::default(), &caustic.light, &caustic.window).expect("a window");
        let mut edges = 0;
        for ((ours, truth), bare) in ours.values().iter().zip(truth.values()).zip(&bare) {
            if *truth == 0.0 || off(*truth, bare.x) < 1e-3 {
                assert!((ours - truth).abs() <= 1e-4 * bare.x, "{}: {ours} where there is {truth}", caustic.name);
            } else {
                edges += 1;
            }
        }
        let error = relative_l1(&truth, &ours).expect("light");
        eprintln!("{}: relative L1 {error:.1e}, {edges} texels on the shadow's edge", caustic.name);
        assert!(error <= 0.02 && edges < 2000, "{}: relative L1 {error}", caustic.name);
    }
}
